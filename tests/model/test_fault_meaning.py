"""What ``faults.ecore`` says of fault types, wrong ways to say it, and own effects."""

from dataclasses import replace
from pathlib import Path

import pytest

from m2t.generate import generate
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, read_metamodels
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import ModelError, SpecificationError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode, Parameter, Range, Struck
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.cli import MISSION, ROOT, edit
from tests.support.own_metamodels import (
    a_class,
    add_classes,
    add_fault_type,
    add_feature,
    attribute,
    copy_metamodels,
    meaning,
    metamodels_of,
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
RobotFault | -
RobotFault | mode=JAM property=SPEED
RobotFault | property=SPEED
RobotFault | mode=ZERO property=COLOUR
RobotFault | mode=ZERO
RobotFault | mode=STOP property=SPEED
RobotFault | mode=ZERO property=SPEED,ENERGY
SensorFault | mode=STOP property=MOTION
RobotFault | mode=DELAY; BY range=TICKS
RobotFault | mode=STOP property=MOTION colour=red
RobotFault #//SensorFault | mode=ZERO property=RATE
FaultType | mode=ZERO property=RATE
RobotFault | mode=INCREMENT property=SPEED; BY search=true
RobotFault | mode=INCREMENT property=SPEED; BY range=LENGTH
RobotFault | mode=INCREMENT property=SPEED; BY range=ENERGY
RobotFault | mode=INCREMENT property=SPEED; BY range=PERCENT
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED role=MEAN
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED search=no
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED mode=STOP
RobotFault | mode=INCREMENT property=SPEED
RobotFault | mode=RANDOM property=SPEED; LOW range=SPEED role=LOWEST
RobotFault | mode=INCREMENT property=SPEED; BY range=SPEED; MORE range=SPEED
RobotFault | mode=STOP property=MOTION; BY range=SPEED
RobotFault | mode=OWN
RobotFault | mode=OWN property=MOTION
SensorFault | mode=OWN property=COUNT,ACTIVATION
MessageFault | mode=OWN property=SPEED,COUNT
SensorFault | mode=OWN property=SPEED
RobotFault | mode=OWN property=SPEED; P range=SPEED role=LOWEST
"""


"""A parent, what the type says and what its parameters say."""


STOPS = meaning(mode="STOP", property="MOTION")


BY = parameter("BY", range="SPEED")


WRONG_TEXTS = {
    "nothing": STOPS + meaning(),
    "no key": STOPS.replace('key="property" ', ""),
    "a key again": STOPS.replace("property", "mode"),
    "another source": STOPS + '<eAnnotations source="http://mrsfi.org/colour"/>',
    "no range": SPEED_OFFSET + attribute("BY", "EDouble"),
    "a number more": SPEED_OFFSET + BY + attribute("TO_MAX", "EDouble"),
    "a bound of text": SPEED_OFFSET + BY + attribute("BY_MAX"),
    "a range of text": SPEED_OFFSET + BY + parameter("WHY", "EString", range="SPEED"),
    "nine parameters": meaning(mode="OWN", property="SPEED")
    + "".join(parameter(f"P{number}", range="SHARE") for number in range(9)),
}


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
    ("parent", "content"),
    [
        *(pytest.param(parent, _said(text), id=f"{parent} {text}") for parent, text in rows(WRONG)),
        *(pytest.param("RobotFault", text, id=name) for name, text in WRONG_TEXTS.items()),
    ],
)
def test_what_is_said_wrong_is_named_with_file_line_and_class(faults, parent, content, approved):
    add_fault_type(faults, "Odd", parent, content)

    approved(error(faults))


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


@pytest.fixture
def metamodels(tmp_path: Path) -> Path:
    """Return metamodels with a type whose effect is a team's own."""
    faults = copy_metamodels(tmp_path / "metamodels")
    add_fault_type(faults, "StuckSpeed", "MessageFault", meaning(mode="OWN", property="SPEED"))
    return faults.parent


def test_a_mission_whose_pool_has_no_fault_of_the_type_stays_as_it_was(tmp_path, metamodels):
    with metamodels_of(metamodels):
        generate(ROOT / "models" / MISSION, tmp_path / "generated")

    fresh, committed = (
        (folder / "fault_effects.py").read_bytes()
        for folder in (tmp_path / "generated", ROOT / "generated" / MISSION)
    )
    assert fresh == committed


def test_a_fault_whose_effect_the_mission_has_not_does_not_fly(metamodels, refused):
    code = load_code(ROOT / "generated" / MISSION)
    code = replace(code, mission=replace(code.mission, duration=5))
    stuck = Fault("stuck", read_metamodels(metamodels).fault_types["StuckSpeed"], "m8")
    engine = ReferenceEngine(code, 1)

    with refused(SpecificationError):
        engine.evaluate((TimedFault("stuck", 1, 3),), pool=FaultPool("own", (stuck,)))
