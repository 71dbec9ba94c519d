"""Broken models: one edit of a flawless model for every constraint, and what it has to cause."""

from typing import NamedTuple

from tests.support.models.copies import FAULTS, MISSION
from tests.support.tables import rows


class Broken(NamedTuple):
    """An edit of a flawless model, and the diagnostic that it has to cause.

    ``place`` is a fragment of the line that has to be named, after the edit.
    """

    constraint: str
    old: str
    new: str
    place: str
    element: str
    message: str
    file: str


_IN_MISSION = r"""
WellFormedXml | </robots> | </robot> | </robot> | mission.xmi | mismatch
WellFormedXml | "ASCII" | "klingon" | klingon | mission.xmi | save it as UTF-8
WellFormedXml | LEN | &ouml; | &ouml; | mission.xmi | undefined entity
KnownFeature | ID="b3" | ID="b3" colour="red" | b3 | batteries 'b3' | 'colour'
KnownFeature | duration="1000" | duration="1000" x="1" | duration
    Mission '1000' | no attribute 'x'; expected name, duration
KnownFeature | <servers | <robotz ID="z"/>\n  <servers | robotz
    robotz 'z' | unknown element of Mission '1000'; expected missionArea, robots
KnownFeature | ID="b3" | ID="b3" xmi:label="red" | b3 | batteries 'b3' | belongs to no model
NoText | <center/> | <center>here</center> | here | center of | 'here'
RequiredFeature | speed="4.0" | - | ID="r2" | robots 'r2' | has no speed; expected one
RequiredFeature | <task xsi:type="mission:StayWithinMissionArea"/> | - | ID="g2"
    goals 'g2' | has no task
RequiredFeature | members="r2" | members="" | ID="g4"
    goals 'g4' | has no members; expected at least 1
RequiredFeature | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Track" tolerance="1.0"><trajectory/></task> | Track
    task of goals 'g2' | has 1 trajectory; expected at least 2
SingleValue | <center/> | <center/><center/> | ID="a15"
    missionArea 'a15' | has 2 center; expected one
SingleValue | sensor="s4" | sensor="s4 s6" | s4 s6 | task of goals 'g4' | has 2 sensor; expected one
ConcreteType | mission:StayWithinMissionArea | mission:GoalTask | mission:GoalTask
    task of goals 'g2' | expected one of mission:AvoidCollision
ConcreteType | mission:StayWithinMissionArea | mission:Robot | mission:Robot
    task of goals 'g2' | xsi:type 'mission:Robot'
ConcreteType | mission:StayWithinMissionArea | mission:Dance | mission:Dance
    task of goals 'g2' | xsi:type 'mission:Dance'
ConcreteType | <task xsi:type="mission:StayWithinMissionArea"/> | <task/> | <task/>
    task of goals 'g2' | has no xsi:type
ContainedElement | <center/> | <center href="other.xmi#c"/> | other.xmi
    center of missionArea 'a15' | 'other.xmi#c'
ContainedElement | ID="g2" | ID="g2" area="a1" | ID="g2" | goals 'g2' | expected an element <area>
NumberSyntax | duration="1000" | duration="1000.0" | duration
    Mission '1000' | has duration '1000.0'; expected a whole number
NumberSyntax | duration="1000" | duration="2147483648" | duration | Mission '1000' | 32 bits
NumberSyntax | speed="5.0" | speed="1_0.0" | ID="r1"
    robots 'r1' | has speed '1_0.0'; expected a number
FiniteNumber | radius="150.0" | radius="NaN" | NaN | area 'a4' | 'NaN'
NumberMagnitude | x="250.0" | x="1e200" | 1e200
    position of robots 'r1' | expected a number between
EnumLiteral | type="DEPTH" | type="DEBTH" | DEBTH
    sensors 's6' | expected one of GPS_POSITION, DEPTH, TEMPERATURE, PRESSURE
IdSyntax | ID="b1" | ID="1b" | 1b | batteries '1b' | has ID '1b'
ReservedId | ID="b1" | ID="Class" | Class | batteries 'Class' | 'Class'
UniqueId | ID="b6" | ID="r1" | Second battery of KAL
    batteries 'r1' | has the ID of robots in line 6
UniqueId | <batteries ID="b1" name="First battery of LEN" totalEnergy="20000.0"/>\n    <batteries
    <batteries xmi:id="_1" ID="b1" name="b" totalEnergy="1.0"/>\n    <batteries xmi:id="_1"
    ID="b2"
    batteries 'b2' | has xmi:id '_1'
IdClash | ID="b6" | ID="S1" | S1
    batteries 'S1' | and sensors 's1' (line 8) both become 's1' in Python; rename one
ResolvedReference | sender="r3" | sender="r9" | r9
    messages 'm2'
    refers to 'r9' as sender, which does not exist; expected the ID of a Station (r1, r2, r3, sv1)
ResolvedReference | sensor="s4" | sensor="//@robots.7/@sensors.1" | @robots.7
    task of goals 'g4' | '//@robots.7/@sensors.1'
ReferenceType | sensor="s4" | sensor="b4" | sensor="b4"
    task of goals 'g4' | refers to 'b4' as sensor, which is a Battery; expected a Sensor
UniqueReference | members="r2 r3 r1" | members="r2 r3 r2" | r2 r3 r2
    goals 'g1' | names 'r2' twice in members
LocalReference | sender="r3" | sender="faults.xmi#f1" | faults.xmi#f1
    messages 'm2' | expected an element of this file
DurationInRange | duration="1000" | duration="0" | duration
    Mission '1000' | has duration '0'; expected 1 to 10,000,000
DurationInRange | duration="1000" | duration="10000001" | duration
    Mission '1000' | has duration '10000001'; expected 1 to 10,000,000
RadiusPositive | radius="50.0" | radius="0.0" | ID="a7" | area 'a7' | expected a number above 0
SpeedNotNegative | speed="5.0" | speed="-5.0" | -5.0
    robots 'r1' | has speed '-5.0'; expected 0 or more
SpeedNotNegative | speed="5.0" | speed="5.0" maxSpeed="-1" | ID="r1"
    robots 'r1' | has maxSpeed '-1'; expected 0 or more
TurnRateInRange | speed="5.0" | speed="5.0" turnRate="0.0" | ID="r1"
    robots 'r1' | has turnRate '0.0'; expected above 0 to 180; correct it
TurnRateInRange | speed="5.0" | speed="5.0" turnRate="180.5" | ID="r1"
    robots 'r1' | has turnRate '180.5'; expected above 0 to 180; correct it
NoiseNotNegative | speed="5.0" | speed="5.0" positionNoise="-0.1" | ID="r1"
    robots 'r1' | has positionNoise '-0.1'; expected 0 or more
EnergyNotNegative | energyPerSample="2.0" | energyPerSample="-2" | ID="s1"
    sensors 's1' | has energyPerSample '-2'; expected 0 or more
EnergyNotNegative | totalEnergy="4000.0" | totalEnergy="-1" | b3
    batteries 'b3' | has totalEnergy '-1'
EnergyNotNegative | energyPerDistanceUnit="5.0" | energyPerDistanceUnit="-1" | ms1
    motionSources 'ms1' | has energyPerDistanceUnit '-1'
SamplesPerSecondPositive | samplesPerSecond="5" | samplesPerSecond="0" | s1
    sensors 's1' | has samplesPerSecond '0'; expected 1 or more
TargetSampleNumberNotNegative | Number="250" | Number="-1" | Number="-1"
    task of goals 'g4' | expected 0 or more
PeriodPositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="0"><area ID="p" radius="1.0"/></task> | Patrol
    task of goals 'g2' | has period '0'; expected 1 or more
DeadlinePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="0"><coordinates/></task> | Visit
    task of goals 'g2' | has deadline '0'; expected 1 or more
TolerancePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Track" tolerance="0"><trajectory/><trajectory x="1"/></task> | Track
    task of goals 'g2' | has tolerance '0'; expected a number above 0
FixedDistancePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="0"/> | FixedDistance
    task of goals 'g2' | has fixedDistance '0'; expected a number above 0
MessageFieldName | name="SPEED" | name="SPEEED" | SPEEED
    body 'SPEEED' | expected one of POSITION, SPEED, ENERGY, GPS_POSITION
MessageFieldType | type="Int" | type="Integer" | Integer
    body 'SPEED' | has type 'Integer'; expected one of Coordinates, Int, Double, String
SenderIsNotReceiver | sender="r3" receiver="sv1" | sender="r3" receiver="r3" | receiver="r3"
    messages 'm2' | is sent by 'r3' to itself
UniquePropertyName | <position
    <intProperties name="hull" value="1"/>\n<doubleProperties name="hull" value="2.0"/>\n<position
    doubleProperties
    doubleProperties 'hull' | is a property of robots 'r1' for the second time
SpeedWithinMaximum | speed="4.0" | speed="4.0" maxSpeed="3.5" | ID="r2"
    robots 'r2' | has speed 4.0 above maxSpeed 3.5; expected a nominal speed that it can reach
GoalDependsOnOthers | ID="g2" | ID="g2" dependentGoals="g1 g2" | ID="g2"
    goals 'g2' | depends on itself
GatherSamplesArea
    <area ID="a4" radius="150.0">\n      <center x="-250.0" y="250.0" z="1.0"/>\n    </area>
    - | ID="g4"
    goals 'g4' | has no area to gather samples in
SensorOfMember | sensor="s4" | sensor="s6" | sensor="s6"
    task of goals 'g4' | uses sensor 's6' of robot 'r3'; expected a sensor of a member (r2)
PairOfMembers | <task xsi:type="mission:GatherSamples" targetSampleNumber="250" sensor="s4"/>
    <task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="9.0"/> | ID="g4"
    goals 'g4' | has one member; expected two or more
IdWithoutSpaces | ID="b6" | ID="big battery" | big battery
    batteries 'big battery' | has the ID 'big battery' with spaces
AreaInsideMission | radius="45.0" | radius="1501.0" | 1501.0
    area 'a9' | reaches beyond the mission area (radius 2000.0)
RobotInsideMission | x="250.0" y="-250.0" | x="2000.0" y="1.0" | ID="r1"
    robots 'r1' | starts outside the mission area (radius 2000.0)
RobotStartsClear | x="250.0" y="-250.0" | x="500.0" y="30.0" | ID="r1"
    robots 'r1' | starts in contact with obstacles 'o3'
RobotStartsClear | x="250.0" y="-250.0" | x="250.0" y="251.0" | ID="r3"
    robots 'r3' | starts in contact with robots 'r1'
RobotHasBattery | <servers | <robots ID="r4" name="MAX" speed="1.0"/>\n  <servers | r4
    robots 'r4' | has no energy to begin with
SenderIsMember | ID="m11" header="h" sender="r3" | ID="m11" header="h" sender="r1" | ID="m11"
    messages 'm11' | is sent by 'r1'; expected a member of the goal (r3)
UniqueMessageField | name="ENERGY" type="Double"
    name="SPEED" type="Double" | name="SPEED" type="Double"
    body 'SPEED' | is reported twice
FieldOfSender | name="DEPTH" | name="PRESSURE" | name="PRESSURE"
    body 'PRESSURE' | of which 'r3' has no sensor; expected one of GPS_POSITION, DEPTH
AvoidCollisionMembers | members="r2 r3 r1" | members="r2 r3" | mission:AvoidCollision
    task of goals 'g1' | names r1; expected members of the goal
DeadlineInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="1000"><coordinates/></task> | Visit
    task of goals 'g2' | has deadline 1000 in a mission of 1000 ticks
AsReactionsAssume | speed="4.0" | speed="4.0" turnRate="90.0" | ID="r2"
    robots 'r2' | has turnRate 90.0, which the built-in reactions ignore
AsReactionsAssume | speed="4.0" | speed="4.0" positionNoise="0.5" | ID="r2"
    robots 'r2' | has positionNoise 0.5, which the built-in reactions ignore
FigureInsideMission | speed="4.0" | speed="40000.0" | ID="r2"
    robots 'r2' | has speed 40000.0 in a mission of an area 4000.0 wide; expected no more than that
FigureInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="1001"><area ID="p" radius="9.0"/></task> | Patrol
    task of goals 'g2' | has period 1001 in a mission of 1000 ticks
FigureInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="9" tolerance="4000.5"><coordinates/></task> | Visit
    task of goals 'g2' | has tolerance 4000.5
"""

_IN_FAULTS = r"""
NoDocumentType | <faults:FaultSpecification | <!DOCTYPE x>\n<faults:FaultSpecification | <!DOCTYPE
    faults.xmi | delete the <!DOCTYPE
RootElement | http://mrsfi.org/faults/1.0 | http://mrsfi.org/faults/9.9 | faults/9.9
    FaultSpecification 'fs' | expected FaultSpecification of namespace http://mrsfi.org/faults/1.0
RequiredFeature | <affectedMessage href="mission.xmi#m4"/> | - | blockMessage
    blockMessage of faults 'f2' | has no affectedMessage
ContainedElement | href="mission.xmi#s2" | ID="s2" | ID="s2"
    affectedSensor 's2' | expected nothing but href
FiniteNumber | DELAY="200.0" | DELAY="-inf" | -inf
    delayMessage of faults 'f8' | has DELAY '-inf'; expected a finite number
IdSyntax | ID="f3" | ID="f;3" | f;3 | faults 'f;3' | has ID 'f;3'
IdSyntax | ID="f3" | ID="" | ID="" | faults '' | has ID ''
ResolvedReference | mission.xmi#m4 | mission.xmi#m44 | #m44
    affectedMessage of blockMessage of faults 'f2' | expected the ID of a Message (m1, m2
LocalReference | mission.xmi#m4 | http://example.org/mission.xmi#m4 | example.org
    affectedMessage of blockMessage of faults 'f2' | expected mission.xmi#ID
LocalReference | mission.xmi#m4 | ../other/mission.xmi#m4 | ../other
    affectedMessage of blockMessage of faults 'f2' | expected mission.xmi#ID
DelayNotNegative | DELAY="200.0" | DELAY="-1.0" | DELAY
    delayMessage of faults 'f8' | has DELAY '-1.0'; expected 0 to 2,147,483,647
DelayNotNegative | DELAY="200.0" | DELAY="3e9" | DELAY
    delayMessage of faults 'f8' | has DELAY '3e9'; expected 0 to 2,147,483,647
DelayNotNegative | DURATION="5.0" | DURATION="5.0" BLOCK_DURATION_MIN="-2" | BLOCK_DURATION
    blockMessage of faults 'f2' | has BLOCK_DURATION_MIN '-2'
WindowNotNegative | ID="f2" | ID="f2" start="-1" finish="3" | ID="f2"
    faults 'f2' | has start '-1'; expected 0 or more
LikelihoodInRange | ID="f2" | ID="f2" likelihood="1.5" | ID="f2"
    faults 'f2' | has likelihood '1.5'; expected 0 to 1
ExactlyOneFaultType | <activateSensor>
    <zeroSpeed><affectedMessage href="mission.xmi#m7"/></zeroSpeed>\n<activateSensor> | ID="f1"
    faults 'f1' | contains 2 fault types (ZeroSpeed, ActivateSensor); expected exactly one; delete
ExactlyOneFaultType | <faults ID="f1" | <faults ID="e" name="e"/><faults ID="f1" | ID="e"
    faults 'e' | contains 0 fault types (none); expected exactly one; add one
RandomBoundsOrdered | LOWER_BOUND="11.0" | LOWER_BOUND="31.0" | 31.0
    randomSensorEnergyPerSample of faults 'f23' | LOWER_BOUND 31.0 above UPPER_BOUND 30.0
SearchBoundsOrdered | DELAY="200.0" | DELAY="2" DELAY_MIN="9" DELAY_MAX="3" | DELAY
    delayMessage of faults 'f8' | has DELAY_MIN 9.0 above DELAY_MAX 3.0
WholeTicks | DELAY="200.0" | DELAY="2.5" | 2.5
    delayMessage of faults 'f8' | has DELAY 2.5; expected a whole number of ticks
WindowComplete | ID="f2" | ID="f2" finish="0" | ID="f2" | faults 'f2' | has finish but no start
WindowOrdered | ID="f2" | ID="f2" start="9" finish="8" | ID="f2"
    faults 'f2' | starts at 9 and finishes at 8
FaultFieldCarried | #m8 | #m10 | decrementRemaining
    decrementRemainingEnergyCapacityReport of faults 'f4'
    falsifies ENERGY, but message 'm10' carries TEMPERATURE
WindowInsideMission | ID="f2" | ID="f2" start="1000" finish="1001" | ID="f2"
    faults 'f2' | starts at 1000 in a mission of 1000 ticks and never acts
DelayNotNegative | </faults:F | <triggers ID="t" event="EFFECT" delay="-1"/></faults:F | ID="t"
    triggers 't' | has delay '-1'; expected 0 to 2,147,483,647
DurationInRange | </faults:F | <triggers ID="t" event="EFFECT" duration="0"/></faults:F | ID="t"
    triggers 't' | has duration '0'; expected 1 to 10,000,000
EnumLiteral | </faults:F | <triggers ID="t" event="HEARD"/></faults:F | ID="t"
    triggers 't' | one of VIOLATED, REACHED, ENTERED, EFFECT
RequiredFeature | </faults:F | <triggers ID="t"/></faults:F | ID="t" | triggers 't' | has no event
TriggerInWindow | <faults ID="f1"
    <triggers ID="t" event="EFFECT" faults="f2"/>\n<faults trigger="t" ID="f1" | ID="f1"
    faults 'f1' | waits for trigger 't' and has no window in which to act
TriggerOfEvent | </faults:F | <triggers ID="t" event="REACHED" faults="f1"/></faults:F | ID="t"
    triggers 't' | is REACHED and has faults; expected goal, and nothing else; correct it
TriggerOfEvent | </faults:F | <triggers ID="t" event="ENTERED"/></faults:F | ID="t"
    triggers 't' | is ENTERED and has nothing; expected robot and area or at, and nothing else
ReachableGoal | </faults:F
    <triggers ID="t" event="REACHED"><goal href="mission.xmi#g3"/></triggers></faults:F | ID="t"
    triggers 't' | until goal 'g3' is reached, and SufficientEnergy has nothing to reach; expected
TriggerCanHappen | </faults:F | <triggers ID="t" event="EFFECT"/></faults:F | ID="t"
    triggers 't' | waits for no fault but those that wait for it, and never happens; expected
"""


END = "</faults:F"
_AT = '<at href="mission.xmi#a8"/>'
_AREAS = [
    (
        "TriggerOfEvent",
        f'event="ENTERED"><robot href="mission.xmi#r1"/><area ID="a" radius="1.0"/>{_AT}',
        "triggers 't'",
        "is ENTERED and has robot and area and at; expected robot and area or at, and nothing else",
    ),
    (
        "TriggerOfEvent",
        f'event="VIOLATED"><goal href="mission.xmi#g3"/>{_AT}',
        "triggers 't'",
        "is VIOLATED and has goal and at; expected goal, and nothing else",
    ),
    (
        "ContainedElement",
        'event="ENTERED"><robot href="mission.xmi#r1"/><area href="mission.xmi#a8"/>',
        "area of triggers 't'",
        "correct the href, or use <at href=...>, which refers to one",
    ),
]


def _broken(file: str, table: str) -> list[Broken]:
    return [Broken(*row, file) for row in rows(table)]


def _too_long(feature: str, old: str, place: str, element: str, most: int) -> Broken:
    new = f'{feature}="{"h" * (most + 1)}"'
    message = f"has a {feature} of {most + 1:,} characters; expected at most {most:,}"
    return Broken("StringLength", old, new, place, element, message, MISSION)


BROKEN = [
    *_broken(MISSION, _IN_MISSION),
    *_broken(FAULTS, _IN_FAULTS),
    Broken("FileSize", "<center/>", "<c>" * 200, "<c>", MISSION, "nests more", MISSION),
    *(
        Broken(constraint, END, f'<triggers ID="t" {held}</triggers>{END}', 'ID="t"', *told, FAULTS)
        for constraint, held, *told in _AREAS
    ),
    _too_long("name", 'name="KAL"', 'ID="r3"', "robots 'r3'", 200),
    _too_long("header", 'header="h"', "hhh", "messages 'm1'", 2000),
]
