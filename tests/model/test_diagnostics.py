"""One broken model per constraint: the right file, line, element and words."""

from pathlib import Path
from typing import NamedTuple

import pytest

from m2t.diagnostics import CONSTRAINTS
from m2t.load import load_mission_folder
from m2t.validate import validate_folder
from mrsfi_runtime.errors import ModelError
from support_model import FAULTS, MISSION, copy_models, edit, line_of

G2_TASK = '<task xsi:type="mission:StayWithinMissionArea"/>'
G2_VISIT = '<task xsi:type="mission:Visit" deadline="{}"><coordinates/></task>'


class Broken(NamedTuple):
    """An edit of a flawless model, and the diagnostic that it has to cause.

    ``place`` is a fragment of the line that has to be named, after the edit.
    """

    constraint: str
    file: str
    old: str
    new: str
    place: str
    element: str
    message: str


BROKEN = [
    Broken("FileSize", MISSION, "<center/>", "<c>" * 200, "<c>", "mission.xmi", "nests more"),
    Broken(
        "WellFormedXml", MISSION, "</robots>", "</robot>", "</robot>", "mission.xmi", "mismatch"
    ),
    Broken(
        "WellFormedXml",
        MISSION,
        '"ASCII"',
        '"klingon"',
        "klingon",
        "mission.xmi",
        "save it as UTF-8",
    ),
    Broken("WellFormedXml", MISSION, "LEN", "&ouml;", "&ouml;", "mission.xmi", "undefined entity"),
    Broken(
        "NoDocumentType",
        FAULTS,
        "<faults:FaultSpecification",
        "<!DOCTYPE x>\n<faults:FaultSpecification",
        "<!DOCTYPE",
        "faults.xmi",
        "delete the <!DOCTYPE",
    ),
    Broken(
        "RootElement",
        FAULTS,
        "http://mrsfi.org/faults/1.0",
        "http://mrsfi.org/faults/9.9",
        "faults/9.9",
        "FaultSpecification 'fs'",
        "expected FaultSpecification of namespace http://mrsfi.org/faults/1.0",
    ),
    Broken(
        "KnownFeature",
        MISSION,
        'ID="b3"',
        'ID="b3" colour="red"',
        "b3",
        "batteries 'b3'",
        "'colour'",
    ),
    Broken(
        "KnownFeature",
        MISSION,
        'duration="1000"',
        'duration="1000" x="1"',
        "duration",
        "Mission '1000'",
        "no attribute 'x'; expected name, duration",
    ),
    Broken(
        "KnownFeature",
        MISSION,
        "<servers ",
        '<robotz ID="z"/>\n  <servers ',
        "robotz",
        "robotz 'z'",
        "unknown element of Mission '1000'; expected missionArea, robots",
    ),
    Broken(
        "KnownFeature",
        MISSION,
        'ID="b3"',
        'ID="b3" xmi:label="red"',
        "b3",
        "batteries 'b3'",
        "belongs to no model",
    ),
    Broken("NoText", MISSION, "<center/>", "<center>here</center>", "here", "center of", "'here'"),
    Broken(
        "RequiredFeature",
        MISSION,
        ' speed="4.0"',
        "",
        'ID="r2"',
        "robots 'r2'",
        "has no speed; expected one",
    ),
    Broken("RequiredFeature", MISSION, G2_TASK, "", 'ID="g2"', "goals 'g2'", "has no task"),
    Broken(
        "RequiredFeature",
        MISSION,
        'members="r2"',
        'members=""',
        'ID="g4"',
        "goals 'g4'",
        "has no members; expected at least 1",
    ),
    Broken(
        "RequiredFeature",
        MISSION,
        G2_TASK,
        '<task xsi:type="mission:Track" tolerance="1.0"><trajectory/></task>',
        "Track",
        "task of goals 'g2'",
        "has 1 trajectory; expected at least 2",
    ),
    Broken(
        "RequiredFeature",
        FAULTS,
        '<affectedMessage href="mission.xmi#m4"/>',
        "",
        "blockMessage",
        "blockMessage of faults 'f2'",
        "has no affectedMessage",
    ),
    Broken(
        "SingleValue",
        MISSION,
        "<center/>",
        "<center/><center/>",
        'ID="a15"',
        "missionArea 'a15'",
        "has 2 center; expected one",
    ),
    Broken(
        "SingleValue",
        MISSION,
        'sensor="s4"',
        'sensor="s4 s6"',
        "s4 s6",
        "task of goals 'g4'",
        "has 2 sensor; expected one",
    ),
    Broken(
        "ConcreteType",
        MISSION,
        "mission:StayWithinMissionArea",
        "mission:GoalTask",
        "mission:GoalTask",
        "task of goals 'g2'",
        "expected one of mission:AvoidCollision",
    ),
    Broken(
        "ConcreteType",
        MISSION,
        "mission:StayWithinMissionArea",
        "mission:Robot",
        "mission:Robot",
        "task of goals 'g2'",
        "xsi:type 'mission:Robot'",
    ),
    Broken(
        "ConcreteType",
        MISSION,
        "mission:StayWithinMissionArea",
        "mission:Dance",
        "mission:Dance",
        "task of goals 'g2'",
        "xsi:type 'mission:Dance'",
    ),
    Broken(
        "ConcreteType",
        MISSION,
        ' xsi:type="mission:StayWithinMissionArea"',
        "",
        "<task/>",
        "task of goals 'g2'",
        "has no xsi:type",
    ),
    Broken(
        "ContainedElement",
        MISSION,
        "<center/>",
        '<center href="other.xmi#c"/>',
        "other.xmi",
        "center of missionArea 'a15'",
        "'other.xmi#c'",
    ),
    Broken(
        "ContainedElement",
        MISSION,
        'ID="g2"',
        'ID="g2" area="a1"',
        'ID="g2"',
        "goals 'g2'",
        "expected an element <area>",
    ),
    Broken(
        "ContainedElement",
        FAULTS,
        'href="mission.xmi#s2"',
        'ID="s2"',
        'ID="s2"',
        "affectedSensor 's2'",
        "expected nothing but href",
    ),
    Broken(
        "NumberSyntax",
        MISSION,
        'duration="1000"',
        'duration="1000.0"',
        "duration",
        "Mission '1000'",
        "has duration '1000.0'; expected a whole number",
    ),
    Broken(
        "NumberSyntax",
        MISSION,
        'duration="1000"',
        'duration="2147483648"',
        "duration",
        "Mission '1000'",
        "32 bits",
    ),
    Broken(
        "NumberSyntax",
        MISSION,
        'speed="5.0"',
        'speed="1_0.0"',
        'ID="r1"',
        "robots 'r1'",
        "has speed '1_0.0'; expected a number",
    ),
    Broken("FiniteNumber", MISSION, 'radius="150.0"', 'radius="NaN"', "NaN", "area 'a4'", "'NaN'"),
    Broken(
        "FiniteNumber",
        FAULTS,
        'DELAY="200.0"',
        'DELAY="-inf"',
        "-inf",
        "delayMessage of faults 'f8'",
        "has DELAY '-inf'; expected a finite number",
    ),
    Broken(
        "NumberMagnitude",
        MISSION,
        'x="250.0"',
        'x="1e200"',
        "1e200",
        "position of robots 'r1'",
        "expected a number between",
    ),
    Broken(
        "EnumLiteral",
        MISSION,
        'type="DEPTH"',
        'type="DEBTH"',
        "DEBTH",
        "sensors 's6'",
        "expected one of GPS_POSITION, DEPTH, TEMPERATURE, PRESSURE",
    ),
    Broken(
        "StringLength",
        MISSION,
        'name="KAL"',
        f'name="{"K" * 201}"',
        'ID="r3"',
        "robots 'r3'",
        "has a name of 201 characters; expected at most 200",
    ),
    Broken(
        "StringLength",
        MISSION,
        'header="h"',
        f'header="{"h" * 2001}"',
        "hhh",
        "messages 'm1'",
        "has a header of 2,001 characters; expected at most 2,000",
    ),
    Broken("IdSyntax", MISSION, 'ID="b1"', 'ID="1b"', "1b", "batteries '1b'", "has ID '1b'"),
    Broken("IdSyntax", FAULTS, 'ID="f3"', 'ID="f;3"', "f;3", "faults 'f;3'", "has ID 'f;3'"),
    Broken("IdSyntax", FAULTS, 'ID="f3"', 'ID=""', 'ID=""', "faults ''", "has ID ''"),
    Broken("ReservedId", MISSION, 'ID="b1"', 'ID="Class"', "Class", "batteries 'Class'", "'Class'"),
    Broken(
        "UniqueId",
        MISSION,
        'ID="b6"',
        'ID="r1"',
        "Second battery of KAL",
        "batteries 'r1'",
        "has the ID of robots in line 6",
    ),
    Broken(
        "UniqueId",
        MISSION,
        '<batteries ID="b1" name="First battery of LEN" totalEnergy="20000.0"/>\n    <batteries',
        '<batteries xmi:id="_1" ID="b1" name="b" totalEnergy="1.0"/>\n    <batteries xmi:id="_1"',
        'ID="b2"',
        "batteries 'b2'",
        "has xmi:id '_1'",
    ),
    Broken(
        "IdClash",
        MISSION,
        'ID="b6"',
        'ID="S1"',
        "S1",
        "batteries 'S1'",
        "and sensors 's1' (line 8) both become 's1' in Python; rename one",
    ),
    Broken(
        "ResolvedReference",
        MISSION,
        'sender="r3"',
        'sender="r9"',
        "r9",
        "messages 'm2'",
        "refers to 'r9' as sender, which does not exist; expected the ID of a Station "
        "(r1, r2, r3, sv1)",
    ),
    Broken(
        "ResolvedReference",
        FAULTS,
        "mission.xmi#m4",
        "mission.xmi#m44",
        "#m44",
        "affectedMessage of blockMessage of faults 'f2'",
        "expected the ID of a Message (m1, m2",
    ),
    Broken(
        "ResolvedReference",
        MISSION,
        'sensor="s4"',
        'sensor="//@robots.7/@sensors.1"',
        "@robots.7",
        "task of goals 'g4'",
        "'//@robots.7/@sensors.1'",
    ),
    Broken(
        "ReferenceType",
        MISSION,
        'sensor="s4"',
        'sensor="b4"',
        'sensor="b4"',
        "task of goals 'g4'",
        "refers to 'b4' as sensor, which is a Battery; expected a Sensor",
    ),
    Broken(
        "UniqueReference",
        MISSION,
        'members="r2 r3 r1"',
        'members="r2 r3 r2"',
        "r2 r3 r2",
        "goals 'g1'",
        "names 'r2' twice in members",
    ),
    Broken(
        "LocalReference",
        FAULTS,
        "mission.xmi#m4",
        "http://example.org/mission.xmi#m4",
        "example.org",
        "affectedMessage of blockMessage of faults 'f2'",
        "expected mission.xmi#ID",
    ),
    Broken(
        "LocalReference",
        FAULTS,
        "mission.xmi#m4",
        "../other/mission.xmi#m4",
        "../other",
        "affectedMessage of blockMessage of faults 'f2'",
        "expected mission.xmi#ID",
    ),
    Broken(
        "LocalReference",
        MISSION,
        'sender="r3"',
        'sender="faults.xmi#f1"',
        "faults.xmi#f1",
        "messages 'm2'",
        "expected an element of this file",
    ),
    Broken(
        "DurationInRange",
        MISSION,
        'duration="1000"',
        'duration="0"',
        "duration",
        "Mission '1000'",
        "has duration '0'; expected 1 to 10,000,000",
    ),
    Broken(
        "DurationInRange",
        MISSION,
        'duration="1000"',
        'duration="10000001"',
        "duration",
        "Mission '1000'",
        "has duration '10000001'; expected 1 to 10,000,000",
    ),
    Broken(
        "RadiusPositive",
        MISSION,
        'radius="50.0"',
        'radius="0.0"',
        'ID="a7"',
        "area 'a7'",
        "expected a number above 0",
    ),
    Broken(
        "SpeedNotNegative",
        MISSION,
        'speed="5.0"',
        'speed="-5.0"',
        "-5.0",
        "robots 'r1'",
        "has speed '-5.0'; expected 0 or more",
    ),
    Broken(
        "EnergyNotNegative",
        MISSION,
        'energyPerSample="2.0"',
        'energyPerSample="-2"',
        'ID="s1"',
        "sensors 's1'",
        "has energyPerSample '-2'; expected 0 or more",
    ),
    Broken(
        "EnergyNotNegative",
        MISSION,
        'totalEnergy="4000.0"',
        'totalEnergy="-1"',
        "b3",
        "batteries 'b3'",
        "has totalEnergy '-1'",
    ),
    Broken(
        "EnergyNotNegative",
        MISSION,
        'energyPerDistanceUnit="5.0"',
        'energyPerDistanceUnit="-1"',
        "ms1",
        "motionSources 'ms1'",
        "has energyPerDistanceUnit '-1'",
    ),
    Broken(
        "SamplesPerSecondPositive",
        MISSION,
        'samplesPerSecond="5"',
        'samplesPerSecond="0"',
        "s1",
        "sensors 's1'",
        "has samplesPerSecond '0'; expected 1 or more",
    ),
    Broken(
        "TargetSampleNumberNotNegative",
        MISSION,
        'Number="250"',
        'Number="-1"',
        'Number="-1"',
        "task of goals 'g4'",
        "expected 0 or more",
    ),
    Broken(
        "PeriodPositive",
        MISSION,
        G2_TASK,
        '<task xsi:type="mission:Patrol" period="0"><area ID="p" radius="1.0"/></task>',
        "Patrol",
        "task of goals 'g2'",
        "has period '0'; expected 1 or more",
    ),
    Broken(
        "DeadlinePositive",
        MISSION,
        G2_TASK,
        G2_VISIT.format(0),
        "Visit",
        "task of goals 'g2'",
        "has deadline '0'; expected 1 or more",
    ),
    Broken(
        "TolerancePositive",
        MISSION,
        G2_TASK,
        '<task xsi:type="mission:Track" tolerance="0"><trajectory/><trajectory x="1"/></task>',
        "Track",
        "task of goals 'g2'",
        "has tolerance '0'; expected a number above 0",
    ),
    Broken(
        "FixedDistancePositive",
        MISSION,
        G2_TASK,
        '<task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="0"/>',
        "FixedDistance",
        "task of goals 'g2'",
        "has fixedDistance '0'; expected a number above 0",
    ),
    Broken(
        "DelayNotNegative",
        FAULTS,
        'DELAY="200.0"',
        'DELAY="-1.0"',
        "DELAY",
        "delayMessage of faults 'f8'",
        "has DELAY '-1.0'; expected 0 or more",
    ),
    Broken(
        "DelayNotNegative",
        FAULTS,
        'DURATION="5.0"',
        'DURATION="5.0" BLOCK_DURATION_MIN="-2"',
        "BLOCK_DURATION",
        "blockMessage of faults 'f2'",
        "has BLOCK_DURATION_MIN '-2'",
    ),
    Broken(
        "WindowNotNegative",
        FAULTS,
        'ID="f2"',
        'ID="f2" start="-1" finish="3"',
        'ID="f2"',
        "faults 'f2'",
        "has start '-1'; expected 0 or more",
    ),
    Broken(
        "MessageFieldName",
        MISSION,
        'name="SPEED"',
        'name="SPEEED"',
        "SPEEED",
        "body 'SPEEED'",
        "expected one of POSITION, SPEED, ENERGY, GPS_POSITION",
    ),
    Broken(
        "MessageFieldType",
        MISSION,
        'type="Int"',
        'type="Integer"',
        "Integer",
        "body 'SPEED'",
        "has type 'Integer'; expected one of Coordinates, Int, Double, String",
    ),
    Broken(
        "SenderIsNotReceiver",
        MISSION,
        'sender="r3" receiver="sv1"',
        'sender="r3" receiver="r3"',
        'receiver="r3"',
        "messages 'm2'",
        "is sent by 'r3' to itself",
    ),
    Broken(
        "UniquePropertyName",
        MISSION,
        "<position ",
        '<intProperties name="hull" value="1"/>\n<doubleProperties name="hull" value="2.0"/>\n'
        "<position ",
        "doubleProperties",
        "doubleProperties 'hull'",
        "is a property of robots 'r1' for the second time",
    ),
    Broken(
        "GoalDependsOnOthers",
        MISSION,
        'ID="g2"',
        'ID="g2" dependentGoals="g1 g2"',
        'ID="g2"',
        "goals 'g2'",
        "depends on itself",
    ),
    Broken(
        "GatherSamplesArea",
        MISSION,
        '<area ID="a4" radius="150.0">\n      <center x="-250.0" y="250.0" z="1.0"/>\n    </area>',
        "",
        'ID="g4"',
        "goals 'g4'",
        "has no area to gather samples in",
    ),
    Broken(
        "SensorOfMember",
        MISSION,
        'sensor="s4"',
        'sensor="s6"',
        'sensor="s6"',
        "task of goals 'g4'",
        "uses sensor 's6' of robot 'r3'; expected a sensor of a member (r2)",
    ),
    Broken(
        "PairOfMembers",
        MISSION,
        '<task xsi:type="mission:GatherSamples" targetSampleNumber="250" sensor="s4"/>',
        '<task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="9.0"/>',
        'ID="g4"',
        "goals 'g4'",
        "has one member; expected two or more",
    ),
    Broken(
        "ExactlyOneFaultType",
        FAULTS,
        "<activateSensor>",
        '<zeroSpeed><affectedMessage href="mission.xmi#m7"/></zeroSpeed>\n<activateSensor>',
        'ID="f1"',
        "faults 'f1'",
        "contains 2 fault types (ZeroSpeed, ActivateSensor); expected exactly one; delete",
    ),
    Broken(
        "ExactlyOneFaultType",
        FAULTS,
        '<faults ID="f1"',
        '<faults ID="e" name="e"/><faults ID="f1"',
        'ID="e"',
        "faults 'e'",
        "contains 0 fault types (none); expected exactly one; add one",
    ),
    Broken(
        "RandomBoundsOrdered",
        FAULTS,
        'LOWER_BOUND="11.0"',
        'LOWER_BOUND="31.0"',
        "31.0",
        "randomSensorEnergyPerSample of faults 'f23'",
        "LOWER_BOUND 31.0 above UPPER_BOUND 30.0",
    ),
    Broken(
        "SearchBoundsOrdered",
        FAULTS,
        'DELAY="200.0"',
        'DELAY="2" DELAY_MIN="9" DELAY_MAX="3"',
        "DELAY",
        "delayMessage of faults 'f8'",
        "has DELAY_MIN 9.0 above DELAY_MAX 3.0",
    ),
    Broken(
        "WholeTicks",
        FAULTS,
        'DELAY="200.0"',
        'DELAY="2.5"',
        "2.5",
        "delayMessage of faults 'f8'",
        "has DELAY 2.5; expected a whole number of ticks",
    ),
    Broken(
        "WindowComplete",
        FAULTS,
        'ID="f2"',
        'ID="f2" finish="0"',
        'ID="f2"',
        "faults 'f2'",
        "has finish but no start",
    ),
    Broken(
        "WindowOrdered",
        FAULTS,
        'ID="f2"',
        'ID="f2" start="9" finish="8"',
        'ID="f2"',
        "faults 'f2'",
        "starts at 9 and finishes at 8",
    ),
    Broken(
        "IdWithoutSpaces",
        MISSION,
        'ID="b6"',
        'ID="big battery"',
        "big battery",
        "batteries 'big battery'",
        "has the ID 'big battery' with spaces",
    ),
    Broken(
        "AreaInsideMission",
        MISSION,
        'radius="45.0"',
        'radius="1501.0"',
        "1501.0",
        "area 'a9'",
        "reaches beyond the mission area (radius 2000)",
    ),
    Broken(
        "RobotInsideMission",
        MISSION,
        'x="250.0" y="-250.0"',
        'x="2000.0" y="1.0"',
        'ID="r1"',
        "robots 'r1'",
        "starts outside the mission area (radius 2000)",
    ),
    Broken(
        "RobotStartsClear",
        MISSION,
        'x="250.0" y="-250.0"',
        'x="500.0" y="30.0"',
        'ID="r1"',
        "robots 'r1'",
        "starts in contact with obstacles 'o3'",
    ),
    Broken(
        "RobotStartsClear",
        MISSION,
        'x="250.0" y="-250.0"',
        'x="250.0" y="251.0"',
        'ID="r3"',
        "robots 'r3'",
        "starts in contact with robots 'r1'",
    ),
    Broken(
        "RobotHasBattery",
        MISSION,
        "<servers ",
        '<robots ID="r4" name="MAX" speed="1.0"/>\n  <servers ',
        "r4",
        "robots 'r4'",
        "has no energy to begin with",
    ),
    Broken(
        "SenderIsMember",
        MISSION,
        'ID="m11" header="h" sender="r3"',
        'ID="m11" header="h" sender="r1"',
        'ID="m11"',
        "messages 'm11'",
        "is sent by 'r1'; expected a member of the goal (r3)",
    ),
    Broken(
        "UniqueMessageField",
        MISSION,
        'name="ENERGY" type="Double"',
        'name="SPEED" type="Double"',
        'name="SPEED" type="Double"',
        "body 'SPEED'",
        "is reported twice",
    ),
    Broken(
        "FieldOfSender",
        MISSION,
        'name="DEPTH"',
        'name="PRESSURE"',
        'name="PRESSURE"',
        "body 'PRESSURE'",
        "of which 'r3' has no sensor; expected one of GPS_POSITION, DEPTH",
    ),
    Broken(
        "AvoidCollisionMembers",
        MISSION,
        'members="r2 r3 r1"',
        'members="r2 r3"',
        "mission:AvoidCollision",
        "task of goals 'g1'",
        "names r1; expected members of the goal",
    ),
    Broken(
        "DeadlineInsideMission",
        MISSION,
        G2_TASK,
        G2_VISIT.format(1000),
        "Visit",
        "task of goals 'g2'",
        "has deadline 1000 in a mission of 1000 ticks",
    ),
    Broken(
        "FaultFieldCarried",
        FAULTS,
        "#m8",
        "#m10",
        "decrementRemaining",
        "decrementRemainingEnergyCapacityReport of faults 'f4'",
        "falsifies ENERGY, but message 'm10' carries TEMPERATURE",
    ),
    Broken(
        "WindowInsideMission",
        FAULTS,
        'ID="f2"',
        'ID="f2" start="1000" finish="1001"',
        'ID="f2"',
        "faults 'f2'",
        "starts at 1000 in a mission of 1000 ticks and never acts",
    ),
]


def _label(broken: Broken) -> str:
    return f"{broken.constraint}-{broken.message[:30]}"


@pytest.mark.parametrize("broken", BROKEN, ids=_label)
def test_broken_model_is_reported_at_its_line(tmp_path: Path, broken: Broken) -> None:
    folder = copy_models(tmp_path)
    path = folder / broken.file
    edit(path, broken.old, broken.new)

    diagnostics = validate_folder(folder)

    found = [entry for entry in diagnostics if entry.constraint == broken.constraint]
    assert found, [str(entry) for entry in diagnostics]
    first = found[0]
    assert (first.path, first.line) == (path, line_of(path, broken.place))
    assert first.element.startswith(broken.element)
    assert broken.message in first.message
    assert first.severity == CONSTRAINTS[broken.constraint].severity
    assert str(first) == f"{path}:{first.line}: {first.message} [{broken.constraint}]"


def test_errors_stop_loading_with_all_of_them(tmp_path: Path) -> None:
    folder = copy_models(tmp_path)
    edit(folder / MISSION, 'x="250.0" y="-250.0"', 'x="2000.0" y="1.0"')
    edit(folder / MISSION, 'sensor="s4"', 'sensor="s6"')
    edit(folder / FAULTS, 'DELAY="200.0"', 'DELAY="2.5"')
    diagnostics = validate_folder(folder)

    with pytest.raises(ModelError) as caught:
        load_mission_folder(folder)

    errors = [str(entry) for entry in diagnostics if entry.severity == "error"]
    assert str(caught.value) == "\n".join(errors)
    assert [entry.constraint for entry in diagnostics] == [
        "RobotInsideMission",
        "SensorOfMember",
        "WholeTicks",
    ]


def test_warnings_do_not_stop_loading(tmp_path: Path) -> None:
    folder = copy_models(tmp_path)
    edit(folder / MISSION, 'x="250.0" y="-250.0"', 'x="2000.0" y="1.0"')

    assert load_mission_folder(folder).mission.robots[0].position.x == 2000.0


def test_missing_mission_is_reported(tmp_path: Path) -> None:
    (found,) = validate_folder(tmp_path)

    assert found.constraint == "ReadableFile"
    assert str(found).startswith(
        f"{tmp_path / MISSION}:1: mission.xmi cannot be read: No such file"
    )


def test_every_constraint_has_a_broken_model() -> None:
    covered = {broken.constraint for broken in BROKEN} | {"ReadableFile"}

    assert covered == set(CONSTRAINTS)


def test_all_defects_of_both_files_are_reported_at_once(tmp_path: Path) -> None:
    folder = copy_models(tmp_path)
    edit(folder / MISSION, 'speed="5.0"', 'speed="fast"')
    edit(folder / MISSION, 'type="DEPTH"', 'type="DEBTH"')
    edit(folder / FAULTS, "#m4", "#m44")

    found = [(entry.path.name, entry.constraint) for entry in validate_folder(folder)]

    assert found == [
        (MISSION, "NumberSyntax"),
        (MISSION, "EnumLiteral"),
        (FAULTS, "ResolvedReference"),
    ]


def test_flawless_models_have_no_diagnostics(tmp_path: Path) -> None:
    assert validate_folder(copy_models(tmp_path)) == ()
