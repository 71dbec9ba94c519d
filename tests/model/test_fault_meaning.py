"""What ``faults.ecore`` says of fault types, and every way in which it can say it wrong."""

from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, read_metamodels
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode, Parameter, Range, Struck
from tests.support.cli import edit
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_fault_type,
    add_feature,
    attribute,
    copy_metamodels,
    meaning,
    parameter,
)

SPEED_OFFSET = meaning(mode="INCREMENT", property="SPEED")


@pytest.fixture
def faults(tmp_path: Path) -> Path:
    """Return the file of the fault types, in a folder with both metamodels."""
    return copy_metamodels(tmp_path)


def error(faults: Path) -> str:
    with pytest.raises(ModelError) as caught:
        read_metamodels(faults.parent)
    return str(caught.value)


def test_a_type_of_a_known_mode_is_read_from_the_metamodel_alone(faults: Path) -> None:
    add_fault_type(
        faults,
        "DrawnCount",
        "SensorFault",
        meaning(mode="RANDOM", property="COUNT")
        + parameter("MOST", "EInt", range="COUNT", role="HIGHEST")
        + parameter("LEAST", "EInt", range="COUNT", role="LOWEST", search="false"),
    )

    assert read_metamodels(faults.parent).fault_types["DrawnCount"] == FaultType(
        "DrawnCount",
        Mode.RANDOM,
        Struck.SENSOR,
        (Field.COUNT,),
        (
            Parameter("LEAST", Range.COUNT, evolves=False, is_integer=True),
            Parameter("MOST", Range.COUNT, is_integer=True),
        ),
    )


def test_a_subclass_means_what_it_inherits_unless_it_says_otherwise(faults: Path) -> None:
    add_classes(
        faults,
        a_class("Drift", "#//IncrementSpeed", attribute("remark")),
        a_class("Sag", "#//Drift", meaning(mode="DECREMENT", property="SPEED")),
    )

    types = read_metamodels(faults.parent).fault_types

    assert types["Drift"].mode is Mode.INCREMENT
    assert types["Sag"].mode is Mode.DECREMENT
    assert (
        types["Sag"].parameters
        == types["Drift"].parameters
        == (Parameter("VAL", Range.SPEED, is_integer=True),)
    )


def test_a_type_may_inherit_its_meaning_from_an_abstract_class(faults: Path) -> None:
    said = SPEED_OFFSET + parameter("BY", range="SPEED")
    add_classes(
        faults,
        a_class("Offset", "#//RobotFault", said).replace("name=", 'abstract="true" name=', 1),
    )
    add_fault_type(faults, "WheelSlip", "Offset", "")

    kind = read_metamodels(faults.parent).fault_types["WheelSlip"]

    assert (kind.mode, kind.struck, kind.properties) == (
        Mode.INCREMENT,
        Struck.ROBOT,
        (Field.SPEED,),
    )
    assert [known.name for known in kind.parameters] == ["BY"]


WRONG = {
    "an empty annotation": (
        "RobotFault",
        meaning(mode="STOP", property="MOTION") + meaning(),
        "'Odd' says nothing; expected details with a key and a value; delete it",
    ),
    "no annotation": ("RobotFault", "", "'Odd' says no mode; expected an annotation of source"),
    "unknown mode": (
        "RobotFault",
        meaning(mode="JAM", property="SPEED"),
        "'Odd' has mode 'JAM'; expected one of DELAY, BLOCK",
    ),
    "no mode": (
        "RobotFault",
        meaning(property="SPEED"),
        "'Odd' has mode ''; expected one of DELAY, BLOCK",
    ),
    "unknown property": (
        "RobotFault",
        meaning(mode="ZERO", property="COLOUR"),
        "'Odd' has property 'COLOUR'; expected one of POSITION, SPEED",
    ),
    "no property": (
        "RobotFault",
        meaning(mode="ZERO"),
        "'Odd' of mode ZERO touches no property; expected SPEED, ENERGY, COUNT, RATE, COST",
    ),
    "property of another mode": (
        "RobotFault",
        meaning(mode="STOP", property="SPEED"),
        "'Odd' of mode STOP touches SPEED; expected MOTION",
    ),
    "two properties": (
        "RobotFault",
        meaning(mode="ZERO", property="SPEED ENERGY"),
        "'Odd' of mode ZERO touches SPEED and ENERGY; expected SPEED, ENERGY",
    ),
    "property out of reach": (
        "SensorFault",
        meaning(mode="STOP", property="MOTION"),
        "'Odd' of mode STOP touches property MOTION, but refers to one sensor",
    ),
    "delay of no message": (
        "RobotFault",
        meaning(mode="DELAY") + parameter("BY", range="TICKS"),
        "'Odd' of mode DELAY touches no property, but refers to one robot",
    ),
    "unknown key of a class": (
        "RobotFault",
        meaning(mode="STOP", property="MOTION", colour="red"),
        "'Odd' has the key 'colour'; expected mode, property, each once",
    ),
    "a key twice": (
        "RobotFault",
        meaning(mode="STOP", property="MOTION").replace("property", "mode"),
        "'Odd' has the key 'mode'; expected mode, property, each once",
    ),
    "two supertypes of what is struck": (
        "RobotFault #//SensorFault",
        meaning(mode="ZERO", property="RATE"),
        "'Odd' inherits from 2 of MessageFault, RobotFault, SensorFault, ObstacleFault",
    ),
    "nothing struck": (
        "FaultType",
        meaning(mode="ZERO", property="RATE"),
        "'Odd' inherits from 0 of MessageFault, RobotFault, SensorFault, ObstacleFault",
    ),
    "a parameter without range": (
        "RobotFault",
        SPEED_OFFSET + attribute("BY", "EDouble"),
        "'BY' of Odd is a number without a range; every number of a fault type is a parameter",
    ),
    "a range without name": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", search="true"),
        "'BY' of Odd is a number without a range",
    ),
    "unknown range": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="LENGTH"),
        "'BY' has range 'LENGTH'; expected one of TICKS, PERCENT",
    ),
    "range of another property": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="ENERGY"),
        "'Odd' has parameter BY of range ENERGY; expected SPEED, that of its property",
    ),
    "range of another mode": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="PERCENT"),
        "'Odd' has parameter BY as its percentage; mode INCREMENT takes value",
    ),
    "unknown role": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED", role="MEAN"),
        "'BY' has role 'MEAN'; expected LOWEST, HIGHEST, or none",
    ),
    "no switch": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED", search="no"),
        "'BY' has search 'no'; expected true or false",
    ),
    "unknown key of a parameter": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED", mode="STOP"),
        "'BY' has the key 'mode'; expected range, role, search, each once",
    ),
    "a parameter is missing": (
        "RobotFault",
        SPEED_OFFSET,
        "'Odd' lacks the value that mode INCREMENT takes; add a parameter",
    ),
    "one of two is missing": (
        "RobotFault",
        meaning(mode="RANDOM", property="SPEED") + parameter("LOW", range="SPEED", role="LOWEST"),
        "'Odd' lacks the highest value that mode RANDOM takes",
    ),
    "a parameter too many": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED") + parameter("MORE", range="SPEED"),
        "'Odd' has parameter MORE as its value; mode INCREMENT takes value; delete it",
    ),
    "a parameter where none is": (
        "RobotFault",
        meaning(mode="STOP", property="MOTION") + parameter("BY", range="SPEED"),
        "'Odd' has parameter BY as its value; mode STOP takes no parameter",
    ),
    "a bound of nothing": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED") + attribute("TO_MAX", "EDouble"),
        "'TO_MAX' of Odd is a number without a range",
    ),
    "a bound in words": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED") + attribute("BY_MAX"),
        "'BY_MAX' bounds a parameter; expected one EInt or EDouble",
    ),
    "a text with a range": (
        "RobotFault",
        SPEED_OFFSET + parameter("BY", range="SPEED") + parameter("WHY", "EString", range="SPEED"),
        "'WHY' has the source 'http://mrsfi.org/meaning'; expected",
    ),
    "an own effect on nothing": (
        "RobotFault",
        meaning(mode="OWN"),
        "'Odd' of mode OWN touches no property; expected some of: POSITION, SPEED, ENERGY; or",
    ),
    "an own effect on a command": (
        "RobotFault",
        meaning(mode="OWN", property="MOTION"),
        "'Odd' of mode OWN touches MOTION; expected some of: POSITION, SPEED, ENERGY; or COUNT",
    ),
    "an own effect on an activation": (
        "SensorFault",
        meaning(mode="OWN", property="COUNT ACTIVATION"),
        "'Odd' of mode OWN touches COUNT and ACTIVATION; expected some of",
    ),
    "an own effect on two elements": (
        "MessageFault",
        meaning(mode="OWN", property="SPEED COUNT"),
        "'Odd' of mode OWN touches SPEED and COUNT; expected some of",
    ),
    "an own effect out of reach": (
        "SensorFault",
        meaning(mode="OWN", property="SPEED"),
        "'Odd' of mode OWN touches property SPEED, but refers to one sensor",
    ),
    "an own effect with nine parameters": (
        "RobotFault",
        meaning(mode="OWN", property="SPEED")
        + "".join(parameter(f"P{number}", range="SHARE") for number in range(9)),
        "'Odd' has 9 parameters; mode OWN takes at most 8",
    ),
    "an own effect with a role": (
        "RobotFault",
        meaning(mode="OWN", property="SPEED") + parameter("P", range="SPEED", role="LOWEST"),
        "'Odd' has parameter P with a role; mode OWN has none",
    ),
    "another source of ours": (
        "RobotFault",
        meaning(mode="STOP", property="MOTION")
        + '<eAnnotations source="http://mrsfi.org/colour"/>',
        "'Odd' has the source 'http://mrsfi.org/colour'; expected http://mrsfi.org/meaning",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_said_wrong_is_named_with_file_line_and_class(faults: Path, name: str) -> None:
    parent, content, expected = WRONG[name]
    add_fault_type(faults, "Odd", parent, content)
    line = faults.read_text(encoding="utf-8").index('name="Odd"')
    n_lines = faults.read_text(encoding="utf-8")[:line].count("\n") + 1

    message = error(faults)

    (found,) = [said for said in message.split("\n") if expected in said]
    assert found.startswith(f"{faults}:{n_lines}: ")


def test_a_type_that_no_fault_can_hold_is_refused(faults: Path) -> None:
    add_classes(faults, a_class("Odd", "#//RobotFault", meaning(mode="STOP", property="MOTION")))

    assert "'Odd' is contained in no feature of Fault" in error(faults)


def test_a_fault_has_no_feature_for_many_fault_types(faults: Path) -> None:
    edit(faults, 'name="stopRobot" eType', 'name="stopRobot" upperBound="-1" eType')

    assert "'stopRobot' holds many fault types" in error(faults)


@pytest.mark.parametrize(("file", "class_name"), [(FAULTS_FILE, "Fault"), (MISSION_FILE, "Robot")])
def test_a_meaning_of_what_is_no_fault_type_is_refused(
    faults: Path, file: str, class_name: str
) -> None:
    path = faults.parent / file
    add_feature(path, class_name, attribute("odd", "EDouble", "", meaning(range="SPEED")))

    message = error(faults)

    assert f"{path}:" in message
    assert "eStructuralFeatures 'odd' has the source 'http://mrsfi.org/meaning'" in message
