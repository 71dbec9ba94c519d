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
    file: str


_IN_MISSION = r"""
WellFormedXml | </robots> | </robot> | </robot> | mission.xmi
WellFormedXml | "ASCII" | "klingon" | klingon | mission.xmi
WellFormedXml | LEN | &ouml; | &ouml; | mission.xmi
KnownFeature | ID="b3" | ID="b3" colour="red" | b3 | batteries 'b3'
KnownFeature | duration="1000" | duration="1000" x="1" | duration | Mission '1000'
KnownFeature | <servers | <robotz ID="z"/>\n  <servers | robotz | robotz 'z'
KnownFeature | ID="b3" | ID="b3" xmi:label="red" | b3 | batteries 'b3'
NoText | <center/> | <center>here</center> | here | center of
RequiredFeature | speed="4.0" | - | ID="r2" | robots 'r2'
RequiredFeature | <task xsi:type="mission:StayWithinMissionArea"/> | - | ID="g2" | goals 'g2'
RequiredFeature | members="r2" | members="" | ID="g4" | goals 'g4'
RequiredFeature | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Track" tolerance="1.0"><trajectory/></task> | Track | task of goals 'g2'
SingleValue | <center/> | <center/><center/> | ID="a15" | missionArea 'a15'
SingleValue | sensor="s4" | sensor="s4 s6" | s4 s6 | task of goals 'g4'
ConcreteType | mission:StayWithinMissionArea | mission:GoalTask | mission:GoalTask
    task of goals 'g2'
ConcreteType | mission:StayWithinMissionArea | mission:Robot | mission:Robot | task of goals 'g2'
ConcreteType | mission:StayWithinMissionArea | mission:Dance | mission:Dance | task of goals 'g2'
ConcreteType | <task xsi:type="mission:StayWithinMissionArea"/> | <task/> | <task/>
    task of goals 'g2'
ContainedElement | <center/> | <center href="other.xmi#c"/> | other.xmi
    center of missionArea 'a15'
ContainedElement | ID="g2" | ID="g2" area="a1" | ID="g2" | goals 'g2'
NumberSyntax | duration="1000" | duration="1000.0" | duration | Mission '1000'
NumberSyntax | duration="1000" | duration="2147483648" | duration | Mission '1000'
NumberSyntax | speed="5.0" | speed="1_0.0" | ID="r1" | robots 'r1'
FiniteNumber | radius="150.0" | radius="NaN" | NaN | area 'a4'
NumberMagnitude | x="250.0" | x="1e200" | 1e200 | position of robots 'r1'
EnumLiteral | type="DEPTH" | type="DEBTH" | DEBTH | sensors 's6'
IdSyntax | ID="b1" | ID="1b" | 1b | batteries '1b'
ReservedId | ID="b1" | ID="Class" | Class | batteries 'Class'
UniqueId | ID="b6" | ID="r1" | Second battery of KAL | batteries 'r1'
UniqueId | <batteries ID="b1" name="First battery of LEN" totalEnergy="20000.0"/>\n    <batteries
    <batteries xmi:id="_1" ID="b1" name="b" totalEnergy="1.0"/>\n    <batteries xmi:id="_1"
    ID="b2" | batteries 'b2'
IdClash | ID="b6" | ID="S1" | S1 | batteries 'S1'
ResolvedReference | sender="r3" | sender="r9" | r9 | messages 'm2'
ResolvedReference | sensor="s4" | sensor="//@robots.7/@sensors.1" | @robots.7 | task of goals 'g4'
ReferenceType | sensor="s4" | sensor="b4" | sensor="b4" | task of goals 'g4'
UniqueReference | members="r2 r3 r1" | members="r2 r3 r2" | r2 r3 r2 | goals 'g1'
LocalReference | sender="r3" | sender="faults.xmi#f1" | faults.xmi#f1 | messages 'm2'
DurationInRange | duration="1000" | duration="0" | duration | Mission '1000'
DurationInRange | duration="1000" | duration="10000001" | duration | Mission '1000'
RadiusPositive | radius="50.0" | radius="0.0" | ID="a7" | area 'a7'
RadiusPositive | speed="5.0" | speed="5.0" radius="0.0" | ID="r1" | robots 'r1'
SpeedNotNegative | speed="5.0" | speed="-5.0" | -5.0 | robots 'r1'
SpeedNotNegative | speed="5.0" | speed="5.0" maxSpeed="-1" | ID="r1" | robots 'r1'
TurnRateInRange | speed="5.0" | speed="5.0" turnRate="0.0" | ID="r1" | robots 'r1'
TurnRateInRange | speed="5.0" | speed="5.0" turnRate="180.5" | ID="r1" | robots 'r1'
NoiseNotNegative | speed="5.0" | speed="5.0" positionNoise="-0.1" | ID="r1" | robots 'r1'
ClearanceNotNegative | "mission:AvoidCollision" | "mission:AvoidCollision" clearance="-0.5"
    mission:AvoidCollision | task of goals 'g1'
RadiusPositive | speed="4.0" | speed="4.0" radius="-2.5" | ID="r2" | robots 'r2'
EnergyNotNegative | energyPerSample="2.0" | energyPerSample="-2" | ID="s1" | sensors 's1'
EnergyNotNegative | totalEnergy="4000.0" | totalEnergy="-1" | b3 | batteries 'b3'
EnergyNotNegative | energyPerDistanceUnit="5.0" | energyPerDistanceUnit="-1" | ms1
    motionSources 'ms1'
SamplesPerSecondPositive | samplesPerSecond="5" | samplesPerSecond="0" | s1 | sensors 's1'
TargetSampleNumberNotNegative | Number="250" | Number="-1" | Number="-1" | task of goals 'g4'
RequiredMembersNotNegative | ID="g2" | ID="g2" requiredMembers="-1" | ID="g2" | goals 'g2'
SeverityInRange | ID="g2" | ID="g2" severity="0" | ID="g2" | goals 'g2'
SeverityInRange | ID="g2" | ID="g2" severity="11" | ID="g2" | goals 'g2'
PeriodPositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="0"><area ID="p" radius="1.0"/></task> | Patrol
    task of goals 'g2'
DeadlinePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="0"><coordinates/></task> | Visit | task of goals 'g2'
TolerancePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Track" tolerance="0"><trajectory/><trajectory x="1"/></task> | Track
    task of goals 'g2'
FixedDistancePositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="0"/> | FixedDistance
    task of goals 'g2'
MessageFieldName | name="SPEED" | name="SPEEED" | SPEEED | body 'SPEEED'
MessageFieldType | type="Int" | type="Integer" | Integer | body 'SPEED'
SenderIsNotReceiver | sender="r3" receiver="sv1" | sender="r3" receiver="r3" | receiver="r3"
    messages 'm2'
UniquePropertyName | <position
    <intProperties name="hull" value="1"/>\n<doubleProperties name="hull" value="2.0"/>\n<position
    doubleProperties | doubleProperties 'hull'
SpeedWithinMaximum | speed="4.0" | speed="4.0" maxSpeed="3.5" | ID="r2" | robots 'r2'
GoalDependsOnOthers | ID="g2" | ID="g2" dependentGoals="g1 g2" | ID="g2" | goals 'g2'
GraceNotNegative | ID="g2" | ID="g2" grace="-1" | ID="g2" | goals 'g2'
GraceInsideMission | ID="g2" | ID="g2" grace="1000" | ID="g2" | goals 'g2'
RequiredMembersAvailable | ID="g2" | ID="g2" requiredMembers="4" | ID="g2" | goals 'g2'
RequiredMembersCounted | ID="g1" | ID="g1" requiredMembers="2" | ID="g1" | goals 'g1'
AreaOrRoute | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="9"/> | Patrol | task of goals 'g2'
AreaOrRoute | "mission:StayWithinMissionArea"/>
    "mission:Patrol" period="9"><area ID="p" radius="9"/><route ID="q" radius="9"/></task>
    Patrol | task of goals 'g2'
RadiusPositive | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="9"><route ID="q" radius="0.0"/></task>
    Patrol | route 'q'
AreaInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="9"><route ID="q" radius="2000.5"/></task>
    Patrol | route 'q'
GatherSamplesArea
    <area ID="a4" radius="150.0">\n      <center x="-250.0" y="250.0" z="1.0"/>\n    </area>
    - | ID="g4" | goals 'g4'
SensorOfMember | sensor="s4" | sensor="s6" | sensor="s6" | task of goals 'g4'
PairOfMembers | <task xsi:type="mission:GatherSamples" targetSampleNumber="250" sensor="s4"/>
    <task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="9.0"/> | ID="g4" | goals 'g4'
IdWithoutSpaces | ID="b6" | ID="big battery" | big battery | batteries 'big battery'
AreaInsideMission | radius="45.0" | radius="1501.0" | 1501.0 | area 'a9'
RobotInsideMission | x="250.0" y="-250.0" | x="2000.0" y="1.0" | ID="r1" | robots 'r1'
RobotStartsClear | x="250.0" y="-250.0" | x="500.0" y="30.0" | ID="r1" | robots 'r1'
RobotStartsClear | x="250.0" y="-250.0" | x="250.0" y="251.0" | ID="r3" | robots 'r3'
RobotStartsClear | speed="4.0" | speed="4.0" radius="310.0" | ID="r2" | robots 'r2'
RobotHasBattery | <servers | <robots ID="r4" name="MAX" speed="1.0"/>\n  <servers | r4 | robots 'r4'
SenderIsMember | ID="m11" header="h" sender="r3" | ID="m11" header="h" sender="r1" | ID="m11"
    messages 'm11'
UniqueMessageField | name="ENERGY" type="Double"
    name="SPEED" type="Double" | name="SPEED" type="Double" | body 'SPEED'
FieldOfSender | name="DEPTH" | name="PRESSURE" | name="PRESSURE" | body 'PRESSURE'
AvoidCollisionMembers | members="r2 r3 r1" | members="r2 r3" | mission:AvoidCollision
    task of goals 'g1'
DeadlineInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="1000"><coordinates/></task> | Visit
    task of goals 'g2'
AsReactionsAssume | speed="4.0" | speed="4.0" turnRate="0.5" | ID="r2" | robots 'r2'
AsReactionsAssume | speed="4.0" | speed="4.0" positionNoise="75.5" | ID="r2" | robots 'r2'
FigureInsideMission | speed="4.0" | speed="40000.0" | ID="r2" | robots 'r2'
FigureInsideMission | "mission:AvoidCollision" | "mission:AvoidCollision" clearance="4000.5"
    mission:AvoidCollision | task of goals 'g1'
FigureInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Patrol" period="1001"><area ID="p" radius="9.0"/></task> | Patrol
    task of goals 'g2'
FigureInsideMission | <task xsi:type="mission:StayWithinMissionArea"/>
    <task xsi:type="mission:Visit" deadline="9" tolerance="4000.5"><coordinates/></task> | Visit
    task of goals 'g2'
AreaShape | <area ID="a9" radius="45.0"> | <area ID="a9"> | ID="a9" | area 'a9'
AreaShape | radius="45.0"> | radius="45.0"><corners/><corners x="9"/><corners y="9"/> | ID="a9"
    area 'a9'
AreaShape | radius="45.0"> | ><corners/><corners x="9"/> | ID="a9" | area 'a9'
AreaShape | radius="2000.0"> | ><corners/><corners x="9"/><corners y="9"/> | ID="a15"
    missionArea 'a15'
PolygonEdges | radius="45.0">
    ><corners x="1"/><corners x="9" y="9"/><corners x="9"/><corners y="9"/> | ID="a9" | area 'a9'
PolygonEdges | radius="45.0"> | ><corners/><corners/><corners x="9" y="9"/><corners x="500"/>
    ID="a9" | area 'a9'
PolygonCenter | radius="45.0"> | ><corners/><corners x="600"/><corners x="700" y="9"/> | ID="a9"
    area 'a9'
AreaInsideMission | radius="45.0">\n      <center x="500.0" z="1.0"/>
    ><corners/><corners x="1999" y="99"/><corners y="9"/> | ID="a9" | area 'a9'
RobotStartsClear | radius="45.0">\n      <center x="500.0" z="1.0"/>
    ><corners/><corners x="249.5" y="-249.9"/><corners x="300"/> | ID="r1" | robots 'r1'
"""

_IN_FAULTS = r"""
NoDocumentType | <faults:FaultSpecification | <!DOCTYPE x>\n<faults:FaultSpecification | <!DOCTYPE
    faults.xmi
RootElement | http://mrsfi.org/faults/1.0 | http://mrsfi.org/faults/9.9 | faults/9.9
    FaultSpecification 'fs'
RequiredFeature | <affectedMessage href="mission.xmi#m4"/> | - | blockMessage
    blockMessage of faults 'f2'
ContainedElement | href="mission.xmi#s2" | ID="s2" | ID="s2" | affectedSensor 's2'
FiniteNumber | DELAY="200.0" | DELAY="-inf" | -inf | delayMessage of faults 'f8'
IdSyntax | ID="f3" | ID="f;3" | f;3 | faults 'f;3'
IdSyntax | ID="f3" | ID="" | ID="" | faults ''
ResolvedReference | mission.xmi#m4 | mission.xmi#m44 | #m44
    affectedMessage of blockMessage of faults 'f2'
LocalReference | mission.xmi#m4 | http://example.org/mission.xmi#m4 | example.org
    affectedMessage of blockMessage of faults 'f2'
LocalReference | mission.xmi#m4 | ../other/mission.xmi#m4 | ../other
    affectedMessage of blockMessage of faults 'f2'
DelayNotNegative | DELAY="200.0" | DELAY="-1.0" | DELAY | delayMessage of faults 'f8'
DelayNotNegative | DELAY="200.0" | DELAY="3e9" | DELAY | delayMessage of faults 'f8'
DelayNotNegative | DURATION="5.0" | DURATION="5.0" BLOCK_DURATION_MIN="-2" | BLOCK_DURATION
    blockMessage of faults 'f2'
WindowNotNegative | ID="f2" | ID="f2" start="-1" finish="3" | ID="f2" | faults 'f2'
LikelihoodInRange | ID="f2" | ID="f2" likelihood="1.5" | ID="f2" | faults 'f2'
ExactlyOneFaultType | <activateSensor>
    <zeroSpeed><affectedMessage href="mission.xmi#m7"/></zeroSpeed>\n<activateSensor> | ID="f1"
    faults 'f1'
ExactlyOneFaultType | <faults ID="f1" | <faults ID="e" name="e"/><faults ID="f1" | ID="e"
    faults 'e'
RandomBoundsOrdered | LOWER_BOUND="11.0" | LOWER_BOUND="31.0" | 31.0
    randomSensorEnergyPerSample of faults 'f23'
SearchBoundsOrdered | DELAY="200.0" | DELAY="2" DELAY_MIN="9" DELAY_MAX="3" | DELAY
    delayMessage of faults 'f8'
WholeTicks | DELAY="200.0" | DELAY="2.5" | 2.5 | delayMessage of faults 'f8'
WindowComplete | ID="f2" | ID="f2" finish="0" | ID="f2" | faults 'f2'
WindowOrdered | ID="f2" | ID="f2" start="9" finish="8" | ID="f2" | faults 'f2'
FaultFieldCarried | #m8 | #m10 | decrementRemaining
    decrementRemainingEnergyCapacityReport of faults 'f4'
WindowInsideMission | ID="f2" | ID="f2" start="1000" finish="1001" | ID="f2" | faults 'f2'
DelayNotNegative | </faults:F | <triggers ID="t" event="EFFECT" delay="-1"/></faults:F | ID="t"
    triggers 't'
DurationInRange | </faults:F | <triggers ID="t" event="EFFECT" duration="0"/></faults:F | ID="t"
    triggers 't'
EnumLiteral | </faults:F | <triggers ID="t" event="HEARD"/></faults:F | ID="t" | triggers 't'
RequiredFeature | </faults:F | <triggers ID="t"/></faults:F | ID="t" | triggers 't'
TriggerInWindow | <faults ID="f1"
    <triggers ID="t" event="EFFECT" faults="f2"/>\n<faults trigger="t" ID="f1" | ID="f1"
    faults 'f1'
TriggerOfEvent | </faults:F | <triggers ID="t" event="REACHED" faults="f1"/></faults:F | ID="t"
    triggers 't'
TriggerOfEvent | </faults:F | <triggers ID="t" event="ENTERED"/></faults:F | ID="t" | triggers 't'
ReachableGoal | </faults:F
    <triggers ID="t" event="REACHED"><goal href="mission.xmi#g3"/></triggers></faults:F | ID="t"
    triggers 't'
TriggerCanHappen | </faults:F | <triggers ID="t" event="EFFECT"/></faults:F | ID="t" | triggers 't'
"""


END = "</faults:F"
_AT = '<at href="mission.xmi#a8"/>'
_AREAS = [
    (
        "TriggerOfEvent",
        f'event="ENTERED"><robot href="mission.xmi#r1"/><area ID="a" radius="1.0"/>{_AT}',
        "triggers 't'",
    ),
    (
        "TriggerOfEvent",
        f'event="VIOLATED"><goal href="mission.xmi#g3"/>{_AT}',
        "triggers 't'",
    ),
    (
        "ContainedElement",
        'event="ENTERED"><robot href="mission.xmi#r1"/><area href="mission.xmi#a8"/>',
        "area of triggers 't'",
    ),
]


def _broken(file: str, table: str) -> list[Broken]:
    return [Broken(*row, file) for row in rows(table)]


def _too_long(feature: str, old: str, place: str, element: str, most: int) -> Broken:
    new = f'{feature}="{"h" * (most + 1)}"'
    return Broken("StringLength", old, new, place, element, MISSION)


BROKEN = [
    *_broken(MISSION, _IN_MISSION),
    *_broken(FAULTS, _IN_FAULTS),
    Broken("FileSize", "<center/>", "<c>" * 200, "<c>", MISSION, MISSION),
    *(
        Broken(
            constraint, END, f'<triggers ID="t" {held}</triggers>{END}', 'ID="t"', element, FAULTS
        )
        for constraint, held, element in _AREAS
    ),
    _too_long("name", 'name="KAL"', 'ID="r3"', "robots 'r3'", 200),
    _too_long("header", 'header="h"', "hhh", "messages 'm1'", 2000),
]
