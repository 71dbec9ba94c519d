"""Missions of many shapes with all nine tasks, and fault pools with all thirty types."""

from dataclasses import replace
from pathlib import Path
from random import Random

from m2t.generate import generate
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.model.faults import Fault, FaultPool
from mrsfi_runtime.model.mission import Mission
from tests.support.fault_types import FAULT_TYPES
from tests.support.models.generation import write_mission

_ROBOT = """  <robots ID="r{n}" name="r{n}" speed="{speed}">
    <position x="{x}" y="{y}"/>
{sensors}    <batteries ID="b{n}" name="" totalEnergy="{energy}"/>
    <motionSources ID="d{n}" name="" energyPerDistanceUnit="{cost}"/>
  </robots>
"""
_SENSOR = """    <sensors ID="s{n}_{k}" name="" type="{kind}" energyPerSample="{cost}" \
samplesPerSecond="{rate}"/>
"""
_OBSTACLE = """  <obstacles ID="o{n}">
    <area ID="oa{n}" radius="{radius}">
      <center x="{x}" y="{y}"/>
    </area>
  </obstacles>
"""
_GOAL = """  <goals ID="g{n}" name="" members="{members}">
    <area ID="ga{n}" radius="{radius}"><center x="{x}" y="{y}"/></area>
    <task xsi:type="mission:{task}"{attributes}>{content}</task>
{messages}  </goals>
"""
_MESSAGE = """    <messages ID="m{g}_{n}" sender="r{n}" receiver="base">
      <body name="POSITION" type="Coordinates"/>
      <body name="SPEED" type="Double"/>
      <body name="ENERGY" type="Double"/>
    </messages>
"""
_MISSION = """<?xml version="1.0" encoding="ASCII"?>
<mission:Mission xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="fleet" duration="{duration}">
  <missionArea ID="whole" radius="400.0"/>
{robots}  <servers ID="base" name="base"/>
{obstacles}{goals}</mission:Mission>
"""


def fleet(folder: Path, seed: int, n_robots: int, duration: int, only: str = "") -> MissionCode:
    """Return generated code of a random mission with every task, and a pool with every type.

    Parameters
    ----------
    folder
        Where models and code are written.
    seed
        The same seed draws the same mission.
    only
        The one task that it has instead; it compiles in a fraction of the time.
    """
    rng = Random(seed)
    robots = [f"r{n}" for n in range(n_robots)]
    obstacles = [f"o{n}" for n in range(rng.randint(1, 4))]
    text = _MISSION.format(
        duration=duration,
        robots="".join(_robot(n, rng) for n in range(n_robots)),
        obstacles="".join(
            _OBSTACLE.format(n=n, radius=rng.uniform(5.0, 30.0), **_place(rng))
            for n in range(len(obstacles))
        ),
        goals="".join(
            _goal(n, task, robots, rng)
            for n, task in enumerate(_tasks(robots, obstacles, rng))
            if only in ("", task[0])
        ),
    )
    models = write_mission(folder, "fleet", text)
    generate(models, folder / "generated")
    code = load_code(folder / "generated")
    return replace(code, pool=pool_of_all_types(code.mission, rng))


def pool_of_all_types(mission: Mission, rng: Random) -> FaultPool:
    """Return a pool with one fault of every type, its target and values drawn."""
    targets = {
        "message": list(mission.message_goal),
        "robot": list(mission.robot_index),
        "sensor": list(mission.sensor_index),
        "obstacle": list(mission.obstacle_index),
    }
    return FaultPool(
        "all",
        tuple(
            Fault(
                f"f{n}",
                kind,
                rng.choice(targets[kind.struck.value]),
                tuple(sorted(float(rng.randint(1, 60)) for _ in kind.parameters)),
            )
            for n, kind in enumerate(FAULT_TYPES.values())
        ),
    )


def _place(rng: Random) -> dict[str, float]:
    return {"x": rng.uniform(-280.0, 280.0), "y": rng.uniform(-280.0, 280.0)}


def _robot(n: int, rng: Random) -> str:
    kinds = ("GPS_POSITION", "DEPTH") if n == 0 or rng.random() < 0.5 else ("DEPTH",)
    sensors = "".join(
        _SENSOR.format(n=n, k=k, kind=kind, cost=rng.uniform(0.0, 3.0), rate=rng.randint(1, 9))
        for k, kind in enumerate(kinds)
    )
    return _ROBOT.format(
        n=n,
        sensors=sensors,
        speed=rng.uniform(0.5, 6.0),
        energy=rng.uniform(500.0, 9000.0),
        cost=rng.uniform(0.1, 4.0),
        **_place(rng),
    )


def _tasks(robots: list[str], obstacles: list[str], rng: Random) -> list[tuple[str, str, str]]:
    """Return every task with its attributes and its content."""
    some = " ".join(rng.sample(obstacles, rng.randint(1, len(obstacles))))
    path = "".join(_point("trajectory", rng) for _ in range(4))
    tasks = [
        ("AvoidCollision", f' robots="{" ".join(robots)}" obstacles="{some}"', ""),
        ("StayWithinMissionArea", "", ""),
        ("SufficientEnergy", "", ""),
        ("GatherSamples", f' targetSampleNumber="{rng.randint(1, 80)}" sensor="s0_1"', ""),
        ("Patrol", ' period="40"', _area("patrolled", rng)),
        ("Visit", ' tolerance="9.0" deadline="60"', _point("coordinates", rng)),
        ("Track", ' tolerance="20.0"', path),
        ("Stay", "", _area("held", rng)),
    ]
    if len(robots) > 1:
        attributes = ' fixedDistance="50.0" tolerance="15.0"'
        tasks.append(("FixedDistanceBetweenRobots", attributes, ""))
    return tasks


def _point(tag: str, rng: Random) -> str:
    return f'<{tag} x="{rng.uniform(-280.0, 280.0)}" y="{rng.uniform(-280.0, 280.0)}"/>'


def _area(name: str, rng: Random) -> str:
    return f'<area ID="{name}" radius="60.0">{_point("center", rng)}</area>'


def _goal(n: int, task: tuple[str, str, str], robots: list[str], rng: Random) -> str:
    members = robots if len(robots) < 3 or n == 0 else rng.sample(robots, rng.randint(2, 3))
    if task[0] == "GatherSamples" and "r0" not in members:
        members = ["r0", *members]
    return _GOAL.format(
        n=n,
        members=" ".join(members),
        radius=90.0,
        task=task[0],
        attributes=task[1],
        content=task[2],
        messages="".join(_MESSAGE.format(g=n, n=robot[1:]) for robot in members),
        **_place(rng),
    )
