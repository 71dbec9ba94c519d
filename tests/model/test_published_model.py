"""The committed models hold the figures of the paper's case study, one by one.

References
----------
Source paper, Figures 3 and 5, Tables I and II.
"""

import tomllib
from typing import Any

import pytest

from m2t.constraints.fault_rules import fault_types
from m2t.load import LoadedModels, load_mission_folder
from tests.support.models.copies import MODELS

ROBOTS = """
r1 LEN 250 -250 1 5 | s1 GPS_POSITION 2 5; s2 PRESSURE 2 5    | b1 20000; b2 80000 | ms1 5
r2 JEN -250 250 1 4 | s3 GPS_POSITION 2 5; s4 TEMPERATURE 2 5 | b3 4000; b4 60000  | ms2 5
r3 KAL 250 250 1 4  | s5 GPS_POSITION 2 5; s6 DEPTH 2 5       | b5 50000; b6 50000 | ms3 5
"""

AREAS = """
a15 0 0 0 2000
a7 0 500 1 50
a8 500 500 1 40
a9 500 0 1 45
a10 500 -500 1 25
a11 0 -500 1 30
a12 -500 -500 1 28
a13 -500 0 1 45
a14 -500 500 1 15
a1 600 -200 0 4
a2 -800 450 1 11
a3 0 0 0 1000
a4 -250 250 1 150
a5 250 250 1 150
a6 250 -250 1 150
"""

GOALS = """
g1 AvoidCollision r2,r3,r1 a1 AvoidCollision robots=r2,r3,r1 obstacles=o1,o2,o3,o4,o5,o6,o7,o8
g2 StayWithinMissionArea r2,r3,r1 a2 StayWithinMissionArea
g3 SufficientEnergy r2,r3,r1 a3 SufficientEnergy
g4 GatherSamples r2 a4 GatherSamples targetSampleNumber=250 sensor=s4
g5 GatherSamples r3 a5 GatherSamples targetSampleNumber=400 sensor=s6
g6 GatherSamples r1 a6 GatherSamples targetSampleNumber=500 sensor=s2
"""

MESSAGES = """
m1 g1 r2 sv1 POSITION:Coordinates
m2 g1 r3 sv1 POSITION:Coordinates
m3 g1 r1 sv1 POSITION:Coordinates
m4 g2 r2 sv1 POSITION:Coordinates
m5 g2 r3 sv1 POSITION:Coordinates
m6 g2 r1 sv1 POSITION:Coordinates
m7 g3 r2 sv1 POSITION:Coordinates SPEED:Int ENERGY:Double
m8 g3 r3 sv1 POSITION:Coordinates SPEED:Int ENERGY:Double
m9 g3 r1 sv1 POSITION:Coordinates SPEED:Int ENERGY:Double
m10 g4 r2 sv1 TEMPERATURE:Int
m11 g5 r3 sv1 DEPTH:Double
m12 g6 r1 sv1 PRESSURE:Double
"""

FAULTS = """
f1 ActivateSensor s2
f2 BlockMessage m4 BLOCK_DURATION=5
f3 DeactivateSensor s5
f4 DecrementRemainingEnergyCapacityReport m8 PERCENTAGE=10
f5 DecrementSampleRate m11 VAL=2
f6 DecrementSensorEnergyPerSample m9 PERCENTAGE=10
f7 DecrementSpeed m7 VAL=1
f8 DelayMessage m10 DELAY=200
f9 FixedObstacleCoordinates o5 NEW_X=200 NEW_Y=-450 NEW_Z=1
f10 FixedRemainingEnergyCapacityReport m8 FIXED_VAL=150
f11 FixedRobotCoordinates m2 NEW_X=1200 NEW_Y=-800 NEW_Z=1
f12 FixedSampleRate m8 FIXED_VAL=120
f13 FixedSensorEnergyPerSample m9 FIXED_VAL=10
f14 FixedSpeed m7 FIXED_VAL=50
f15 IncrementRemainingEnergyCapacityReport m8 PERCENTAGE=10
f16 IncrementSampleRate m11 VAL=25
f17 IncrementSensorEnergyPerSample m7 PERCENTAGE=22
f18 IncrementSpeed m7 VAL=10
f19 RandomObstacleCoordinates o2
f20 RandomRemainingEnergyCapacityReport m8 LOWER_BOUND=255 UPPER_BOUND=1000
f21 RandomRobotCoordinates m3
f22 RandomSampleRate m10 LOWER_BOUND=1 UPPER_BOUND=50
f23 RandomSensorEnergyPerSample m7 LOWER_BOUND=11 UPPER_BOUND=30
f24 RandomSpeed m8 LOWER_BOUND=-8 UPPER_BOUND=8
f25 StartRobot r3
f26 StopRobot r1
f27 ZeroRemainingEnergyCapacityReport m8
f28 ZeroSampleRate m12
f29 ZeroSensorEnergyPerSample m7
f30 ZeroSpeed m9
"""


@pytest.fixture(scope="module")
def models() -> LoadedModels:
    return load_mission_folder(MODELS)


def _rows(table: str) -> list[str]:
    return [" ".join(row.split()) for row in table.strip().splitlines()]


def _point(coordinates: Any) -> str:
    return f"{coordinates.x:g} {coordinates.y:g} {coordinates.z:g}"


def _ids(elements: Any) -> str:
    return ",".join(element.ID for element in elements)


def _robot_row(robot: Any) -> str:
    sensors = "; ".join(
        f"{sensor.ID} {sensor.type.name} {sensor.energyPerSample:g} {sensor.samplesPerSecond}"
        for sensor in robot.sensors
    )
    batteries = "; ".join(f"{battery.ID} {battery.totalEnergy:g}" for battery in robot.batteries)
    (drive,) = robot.motionSources
    return (
        f"{robot.ID} {robot.name} {_point(robot.position)} {robot.speed:g} | {sensors} | "
        f"{batteries} | {drive.ID} {drive.energyPerDistanceUnit:g}"
    )


def _task_row(task: Any) -> str:
    if task.eClass.name == "AvoidCollision":
        return f"AvoidCollision robots={_ids(task.robots)} obstacles={_ids(task.obstacles)}"
    if task.eClass.name == "GatherSamples":
        number = task.targetSampleNumber
        return f"GatherSamples targetSampleNumber={number} sensor={task.sensor.ID}"
    return str(task.eClass.name)


def _fault_row(fault: Any) -> str:
    assert fault.name == fault.ID
    (kind,) = fault_types(fault)
    target = ""
    values = []
    for feature in (
        *kind.eClass.eSuperTypes[0].eStructuralFeatures,
        *kind.eClass.eStructuralFeatures,
    ):
        value = kind.eGet(feature)
        if feature.name.startswith("affected"):
            target = value.ID
        elif kind.eIsSet(feature):
            values.append(f"{feature.name}={value:g}")
    return " ".join([fault.ID, kind.eClass.name, target, *values])


def test_mission_lasts_1000_ticks(models):
    assert (models.mission.name, models.mission.duration) == ("1000", 1000)
    assert _ids(models.mission.servers) == "sv1"


def test_robots(models):
    assert [_robot_row(robot) for robot in models.mission.robots] == _rows(ROBOTS)


def test_areas(models):
    mission = models.mission
    assert _ids(mission.obstacles) == "o1,o2,o3,o4,o5,o6,o7,o8"
    areas = [
        mission.missionArea,
        *(obstacle.area for obstacle in mission.obstacles),
        *(goal.area for goal in mission.goals),
    ]

    rows = [f"{area.ID} {_point(area.center)} {area.radius:g}" for area in areas]

    assert rows == _rows(AREAS)


def test_goals(models):
    rows = [
        f"{goal.ID} {goal.name} {_ids(goal.members)} {goal.area.ID} {_task_row(goal.task)}"
        for goal in models.mission.goals
    ]

    assert rows == _rows(GOALS)


def test_messages(models):
    rows = [
        " ".join(
            [message.ID, goal.ID, message.sender.ID, message.receiver.ID]
            + [f"{entry.name}:{entry.type}" for entry in message.body]
        )
        for goal in models.mission.goals
        for message in goal.messages
    ]

    assert rows == _rows(MESSAGES)
    assert {message.header for goal in models.mission.goals for message in goal.messages} == {"h"}


def test_pool_has_one_fault_of_each_type(models):
    assert models.faults.ID == "fs"
    assert [_fault_row(fault) for fault in models.faults.faults] == _rows(FAULTS)


@pytest.mark.parametrize(
    ("case", "fitness"),
    [("a", {"fitness": "weighted"}), ("b", {"fitness": "focused", "goals": ["g1", "g3"]})],
)
def test_case_studies_have_the_settings_of_the_paper(case, fitness):
    settings = tomllib.loads((MODELS / f"case_{case}.toml").read_text(encoding="utf-8"))

    assert settings == {
        "search": {
            "algorithm": "paper",
            "population": 20,
            "generations": 50,
            "faults": 20,
            "crossover": 0.7,
            "mutation": 0.7,
            "selection": "roulette",
            "seed": 1,
            "mission_seed": 1,
            **fitness,
        }
    }
