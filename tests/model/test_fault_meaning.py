"""What ``faults.ecore`` says of fault types, and every way in which it can say it wrong."""

from pathlib import Path

import pytest

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, read_metamodels
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode, Parameter, Range, Struck
from tests.support.cli import edit
from tests.support.models.copies import line_of
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
from tests.support.tables import rows

SPEED_OFFSET = meaning(mode="INCREMENT", property="SPEED")


@pytest.fixture
def faults(tmp_path: Path) -> Path:
    """Return the file of the fault types, in a folder with both metamodels."""
    return copy_metamodels(tmp_path)


def error(faults: Path) -> str:
    with pytest.raises(ModelError) as caught:
        read_metamodels(faults.parent)
    return str(caught.value)


def test_a_type_of_a_known_mode_is_read_from_the_metamodel_alone(faults):
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


def test_a_subclass_means_what_it_inherits_unless_it_says_otherwise(faults):
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


def test_a_type_may_inherit_its_meaning_from_an_abstract_class(faults):
    said = SPEED_OFFSET + parameter("BY", range="SPEED")
    add_classes(
        faults,
        a_class("Offset", "#//RobotFault", said).replace("name=", 'abstract="true" name=', 1),
    )
    add_fault_type(faults, "FalseOdometer", "Offset", "")

    kind = read_metamodels(faults.parent).fault_types["FalseOdometer"]

    assert (kind.mode, kind.struck, kind.properties) == (
        Mode.INCREMENT,
        Struck.ROBOT,
        (Field.SPEED,),
    )
    assert [known.name for known in kind.parameters] == ["BY"]


WRONG = r"""
RobotFault | - | 'Odd' says no mode; expected an annotation of source
RobotFault | mode=JAM property=SPEED | 'Odd' has mode 'JAM'; expected one of DELAY, BLOCK
RobotFault | property=SPEED | 'Odd' says no mode; expected an annotation of source
RobotFault | mode=ZERO property=COLOUR
    'Odd' has property 'COLOUR'; expected one of POSITION, SPEED
RobotFault | mode=ZERO
    'Odd' of mode ZERO touches no property; expected SPEED, ENERGY, COUNT, RATE, COST
RobotFault | mode=STOP property=SPEED | 'Odd' of mode STOP touches SPEED; expected MOTION
RobotFault | mode=ZERO property=SPEED,ENERGY
    'Odd' of mode ZERO touches SPEED and ENERGY; expected SPEED, ENERGY
SensorFault | mode=STOP property=MOTION
    'Odd' of mode STOP touches property MOTION, but refers to one sensor
RobotFault | mode=DELAY; BY range=TICKS
    'Odd' of mode DELAY touches no property, but refers to one robot
RobotFault | mode=STOP property=MOTION colour=red
    'Odd' has the key 'colour'; expected mode, property, each once
RobotFault #//SensorFault | mode=ZERO property=RATE
    'Odd' inherits from 2 of MessageFault, RobotFault, SensorFault, ObstacleFault
FaultType | mode=ZERO property=RATE
    'Odd' inherits from 0 of MessageFault, RobotFault, SensorFault, ObstacleFault
RobotFault | mode=INCREMENT property=SPEED; BY search=true
    'BY' of Odd is a number without a range
RobotFault | mode=INCREMENT property=SPEED; BY range=LENGTH
    'BY' has range 'LENGTH'; expected one of TICKS, PERCENT
RobotFault | mode=INCREMENT property=SPEED; BY range=ENERGY
    'Odd' has parameter BY of range ENERGY; expected SPEED, that of its property
RobotFault | mode=INCREMENT property=SPEED; BY range=PERCENT
    'Odd' has parameter BY as its percentage; mode INCREMENT takes value
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED role=MEAN
    'BY' has role 'MEAN'; expected one of LOWEST, HIGHEST
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED search=no
    'BY' has search 'no'; expected one of true, false
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED mode=STOP
    'BY' has the key 'mode'; expected range, role, search, each once
RobotFault | mode=INCREMENT property=SPEED
    'Odd' lacks the value that mode INCREMENT takes; add a parameter
RobotFault | mode=RANDOM property=SPEED; LOW range=SPEED role=LOWEST
    'Odd' lacks the highest value that mode RANDOM takes
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED; MORE range=SPEED
    'Odd' has parameter MORE as its value; mode INCREMENT takes value; delete it
RobotFault | mode=STOP property=MOTION; BY range=SPEED
    'Odd' has parameter BY as its value; mode STOP takes no parameter
RobotFault | mode=OWN
    'Odd' of mode OWN touches no property; expected some of: POSITION, SPEED, ENERGY; or
RobotFault | mode=OWN property=MOTION
    'Odd' of mode OWN touches MOTION; expected some of: POSITION, SPEED, ENERGY; or COUNT
SensorFault | mode=OWN property=COUNT,ACTIVATION
    'Odd' of mode OWN touches COUNT and ACTIVATION; expected some of
MessageFault | mode=OWN property=SPEED,COUNT
    'Odd' of mode OWN touches SPEED and COUNT; expected some of
SensorFault | mode=OWN property=SPEED
    'Odd' of mode OWN touches property SPEED, but refers to one sensor
RobotFault | mode=OWN property=SPEED; P range=SPEED role=LOWEST
    'Odd' has parameter P with a role; mode OWN has none
"""
"""A parent, what the type says and what its parameters say, and what is found wrong with it."""

STOPS = meaning(mode="STOP", property="MOTION")
BY = parameter("BY", range="SPEED")
WRONG_TEXTS = [
    (STOPS + meaning(), "'Odd' says nothing; expected details with a key and a value; delete it"),
    (STOPS.replace('key="property" ', ""), "'Odd' has the key ''; expected mode, property"),
    (STOPS.replace("property", "mode"), "'Odd' has the key 'mode' again; expected each once"),
    (
        STOPS + '<eAnnotations source="http://mrsfi.org/colour"/>',
        "'Odd' has the source 'http://mrsfi.org/colour'; expected http://mrsfi.org/meaning",
    ),
    (
        SPEED_OFFSET + attribute("BY", "EDouble"),
        "'BY' of Odd is a number without a range; every number of a fault type is a parameter",
    ),
    (
        SPEED_OFFSET + BY + attribute("TO_MAX", "EDouble"),
        "'TO_MAX' of Odd is a number without a range",
    ),
    (
        SPEED_OFFSET + BY + attribute("BY_MAX"),
        "'BY_MAX' bounds a parameter; expected one EInt or EDouble",
    ),
    (
        SPEED_OFFSET + BY + parameter("WHY", "EString", range="SPEED"),
        "'WHY' has the source 'http://mrsfi.org/meaning'; expected",
    ),
    (
        meaning(mode="OWN", property="SPEED")
        + "".join(parameter(f"P{number}", range="SHARE") for number in range(9)),
        "'Odd' has 9 parameters; mode OWN takes at most 8",
    ),
]


def _said(text: str) -> str:
    """Return the elements of ``mode=… property=…; NAME range=…; …``."""
    kind, *parameters = text.split("; ")
    said = meaning(**_details(kind.split())) if kind else ""
    for name, *details in map(str.split, parameters):
        said += parameter(name, **_details(details))
    return said


def _details(words: list[str]) -> dict[str, str]:
    return {key: value.replace(",", " ") for key, value in (word.split("=") for word in words)}


@pytest.mark.parametrize(
    ("parent", "content", "expected"),
    [(parent, _said(text), expected) for parent, text, expected in rows(WRONG)]
    + [("RobotFault", *texts) for texts in WRONG_TEXTS],
    ids=lambda value: value if value.startswith("'") else "",
)
def test_what_is_said_wrong_is_named_with_file_line_and_class(faults, parent, content, expected):
    add_fault_type(faults, "Odd", parent, content)

    message = error(faults)

    (found,) = [said for said in message.split("\n") if expected in said]
    line = line_of(faults, 'name="Odd"')
    assert found.startswith(f"{faults}:{line}: ")


def test_keys_that_stand_there_again_are_named_in_their_order(faults):
    once = meaning(**dict.fromkeys("fbdaec", "x"))
    entries = once.partition(">")[2].removesuffix("</eAnnotations>")
    add_fault_type(faults, "Odd", "RobotFault", once.replace(entries, 2 * entries))

    assert [line.split("'")[3] for line in error(faults).split("\n")] == list("fbdaec")


@pytest.mark.parametrize(
    "said",
    [
        meaning(mode="JAM", property="SPEED") + BY,
        SPEED_OFFSET + parameter("BY", range="LENGTH"),
        SPEED_OFFSET + parameter("BY", range="SPEED", role="MEAN"),
    ],
)
def test_what_two_types_inherit_wrong_is_named_once(faults, said, approved):
    base = a_class("Offset", "#//RobotFault", said)
    add_classes(faults, base.replace("name=", 'abstract="true" name=', 1))
    for name in ("FalseOdometer", "Tailwind"):
        add_fault_type(faults, name, "Offset", "")

    approved(error(faults))
    assert "\n" not in error(faults)


def test_a_type_that_no_fault_can_hold_is_refused(faults, approved):
    add_classes(faults, a_class("Odd", "#//RobotFault", meaning(mode="STOP", property="MOTION")))

    approved(error(faults))


def test_a_fault_has_no_feature_for_many_fault_types(faults, approved):
    edit(faults, 'name="stopRobot" eType', 'name="stopRobot" upperBound="-1" eType')

    approved(error(faults))


@pytest.mark.parametrize(("file", "class_name"), [(FAULTS_FILE, "Fault"), (MISSION_FILE, "Robot")])
def test_a_meaning_of_what_is_no_fault_type_is_refused(faults, file, class_name, approved):
    path = faults.parent / file
    add_feature(path, class_name, attribute("odd", "EDouble", "", meaning(range="SPEED")))

    message = error(faults)

    assert f"{path}:" in message
    approved(message)
