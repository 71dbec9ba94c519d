"""Missions with all nine tasks, and pools with all thirty fault types, drawn at random.

A *shape* is what compiled code depends on: how many robots, sensors, obstacles and goals there
are, who is a member of what, and which sampling rates occur. Everything else is drawn for it,
so that many missions share the one flight that was compiled for their shape.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from generated.metamodel import faults as f
from generated.metamodel import mission as m
from m2t.generate import generate
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode
from mrsfi_runtime.model.faults import Gate, TimedFault
from tests.support.fault_types import FAULT_TYPES
from tests.support.models import builder
from tests.support.triggers import REACHABLE, waiting

TASKS = (
    "AvoidCollision",
    "StayWithinMissionArea",
    "SufficientEnergy",
    "GatherSamples",
    "Patrol",
    "Visit",
    "Track",
    "Stay",
    "FixedDistanceBetweenRobots",
)
JOINT = ("AvoidCollision", "GatherSamples", "FixedDistanceBetweenRobots")
"""Tasks that are not judged member by member."""
SENSOR_TYPES = ("GPS_POSITION", "DEPTH", "TEMPERATURE", "PRESSURE")
FIELDS = {"POSITION": "Coordinates", "SPEED": "Double", "ENERGY": "Double"}
RATES = (1, 2, 5, 40)
N_MESSAGES = 3

_ODD_PLACES = (0.0, -0.0, 1e-9, 30.0, 1e10, -1e10)
_ODD_AMOUNTS = (0.0, 1e-9, 1.0, 1e6)
_ODD_ENERGIES = (0.0, 1e-9, 1e12)
_ODD_TURNS = (1e-9, 1e-3, 90.0, 179.9999999, 180.0)
_ODD_EXTENTS = (1e-9, 1.0, 30.0, 1e12)
_ODD_SIZES = (1e-9, 1.0, 30.0)
_ODD_VALUES = (0.0, 1e-9, 100.0, 1e12)


def _number(rng: Random, low: float, high: float, odd: tuple[float, ...]) -> float:
    """Return a uniform number, and now and then an odd one."""
    return rng.choice(odd) if rng.random() < 0.2 else rng.uniform(low, high)


@dataclass(frozen=True)
class GoalShape:
    """A goal's task and members; a sensor where samples are gathered."""

    task: str
    members: tuple[str, ...]
    sensor: str = ""


@dataclass(frozen=True)
class Shape:
    """What a flight is compiled for. ``sensors`` has the sensor types of each robot."""

    n_obstacles: int
    sensors: tuple[tuple[str, ...], ...]
    goals: tuple[GoalShape, ...]

    @property
    def robots(self) -> list[str]:
        """IDs of the robots."""
        return [f"r{n}" for n in range(len(self.sensors))]


def shape(n_robots: int, n_obstacles: int, repeated: tuple[str, ...] = (), seed: int = 0) -> Shape:
    """Return a shape with a goal of every task, and further ones, in an order of its own.

    Parameters
    ----------
    n_robots, n_obstacles
        How many there are. A single robot keeps no distance.
    repeated
        Tasks that occur once more.
    seed
        Decides the order of the goals and their members.
    """
    rng = Random(seed)
    sensors = tuple(
        ("GPS_POSITION", "DEPTH")[: rng.randint(0, 2)] if n else SENSOR_TYPES
        for n in range(n_robots)
    )
    tasks = [task for task in (*TASKS, *repeated) if n_robots > 1 or task != TASKS[-1]]
    rng.shuffle(tasks)
    goals = []
    for task in tasks:
        n_members = n_robots if task == "AvoidCollision" else min(rng.randint(2, 4), n_robots)
        members = rng.sample(range(n_robots), n_members)
        if task == "GatherSamples" and 0 not in members:
            members[0] = 0
        sensor = f"r0s{rng.randint(1, 3)}" if task == "GatherSamples" else ""
        goals.append(GoalShape(task, tuple(f"r{n}" for n in members), sensor))
    return Shape(n_obstacles, sensors, tuple(goals))


def draw_pool(rng: Random, of: Shape, mission: m.Mission) -> f.FaultSpecification:
    """Draw a pool with one fault of every type, and triggers of every event."""
    targets = {
        "message": [each for goal in mission.goals for each in goal.messages],
        "robot": [*mission.robots],
        "sensor": [*mission.robots[0].sensors],
        "obstacle": [*mission.obstacles],
    }
    faults = []
    for n, (name, kind) in enumerate(FAULT_TYPES.items()):
        values = {
            parameter.name: int(value) if _is_whole(kind) else value
            for parameter, value in zip(kind.parameters, _values(rng, kind), strict=True)
        }
        target = rng.choice(targets[kind.struck.value])
        faults.append(builder.fault(f"f{n}", name, target, **values))
    return builder.pool(faults, triggers=[*_triggers(rng, of, mission, faults)])


def _triggers(
    rng: Random, of: Shape, mission: m.Mission, faults: list[f.Fault]
) -> Iterator[f.Trigger]:
    goals = [*mission.goals]
    reachable = [goals[n] for n, goal in enumerate(of.goals) if goal.task in REACHABLE]
    robots = rng.sample([*mission.robots], min(3, len(of.robots)))
    some = rng.sample(goals, min(3, len(goals)))
    found: list[tuple[str, dict[str, Any]]] = [("VIOLATED", {"goal": goal}) for goal in some]
    found += [("REACHED", {"goal": goal}) for goal in reachable]
    for n, robot in enumerate(robots):
        at = builder.point(rng.uniform(-60.0, 60.0), rng.uniform(-60.0, 60.0))
        entered = builder.area(f"e{n}", rng.uniform(1.0, 80.0), at)
        found.append(("ENTERED", {"robot": robot, "area": entered}))
    found += [("EFFECT", {"faults": rng.sample(faults, 5)}) for _ in range(3)]
    found.append(("ENTERED", {"robot": robots[0], "at": mission.missionArea}))
    areas = [area for goal in goals for area in (goal.area, getattr(goal.task, "area", None))]
    areas = [*filter(None, areas), *(each.area for each in mission.obstacles)]
    found.append(("ENTERED", {"robot": robots[-1], "at": rng.choice(areas)}))
    for n, (event, about) in enumerate(found):
        lasts = rng.choice(({}, {}, {"duration": 1}, {"duration": rng.randint(2, 30)}))
        delay = rng.choice((0, 0, 1, 7))
        literal = getattr(f.TriggerEvent, event)
        yield f.Trigger(ID=f"t{n}", event=literal, delay=delay, **lasts, **about)


def draw_specification(rng: Random, code: MissionCode) -> tuple[TimedFault, ...]:
    """Draw timed faults of a pool, no two conflicting ones overlapping; at best twenty.

    Where the pool has triggers, about half of them wait for one.
    """
    last = code.mission.duration
    chosen: tuple[TimedFault, ...] = ()
    for _ in range(rng.randint(0, 20)):
        fault = rng.choice(code.pool.faults)
        start = rng.randint(0, last)
        finish = start + rng.randint(0, rng.choice((5, last)))
        values = rng.choice((fault.values, _values(rng, fault.kind)))
        try:
            longer = (*chosen, TimedFault(fault.id, start, finish, values))
            Gate(code.mission, code.pool).admitted(longer)
        except SpecificationError:
            continue
        chosen = longer
    return waiting(rng, chosen, code.pool)


def _is_whole(kind: FaultType) -> bool:
    """Return whether the metamodel has whole numbers for the values of a fault type."""
    is_speed = kind.properties == (Field.SPEED,) and kind.mode is not Mode.RANDOM
    return is_speed or kind.properties == (Field.RATE,)


def _values(rng: Random, kind: FaultType) -> tuple[float, ...]:
    """Return values for a fault of a type; the two of a random one in order."""
    if kind.mode in (Mode.DELAY, Mode.BLOCK) or _is_whole(kind):
        values = [float(rng.randint(0, 70)) for _ in kind.parameters]
    elif kind.properties in ((Field.POSITION,), (Field.OBSTACLE,)):
        values = [_number(rng, -100.0, 100.0, _ODD_PLACES) for _ in kind.parameters]
    else:
        values = [_number(rng, 0.0, 300.0, _ODD_VALUES) for _ in kind.parameters]
    return tuple(sorted(values) if kind.mode is Mode.RANDOM else values)


def small_mission(folder: Path) -> MissionCode:
    """Return generated code of a mission of one goal, which compiles in a fraction of the time."""
    goal = GoalShape("StayWithinMissionArea", ("r0", "r1"))
    of = Shape(1, (SENSOR_TYPES, ("DEPTH",)), (goal,))
    rng = Random(1)
    generate(write_drawn(folder / "models", rng, of, 40, 40), folder / "generated")
    return load_code(folder / "generated")


def write_drawn(folder: Path, rng: Random, of: Shape, longest: int, shortest: int = 1) -> Path:
    """Draw a mission of a shape, its duration in ticks too, and its pool; return their folder."""
    mission = _Parts(rng, of).mission()
    mission.duration = rng.randint(shortest, longest)
    for goal in mission.goals:
        if rng.random() < 0.4:
            goal.grace = min(rng.choice((0, 1, 2, 7, longest)), mission.duration - 1)
    return builder.write(folder, mission, draw_pool(rng, of, mission))


class _Parts:
    """Draws the elements of a mission.

    Half of all points are among a few spots, so that robots reach what they head for, and meet;
    half of all trajectories begin where one of their robots does.
    """

    def __init__(self, rng: Random, of: Shape) -> None:
        self._rng = rng
        self._of = of
        self._reach = rng.choice((60.0, 60.0 * len(of.sensors)))
        self._spots = [self._place() for _ in range(rng.randint(1, 4))]
        self._starts: dict[str, tuple[float, float]] = {}

    def _place(self) -> tuple[float, float]:
        x, y = (_number(self._rng, -self._reach, self._reach, _ODD_PLACES) for _ in range(2))
        return x, y

    def point(self, robot: str = "") -> m.Coordinates:
        """Return a point; where a robot begins, if it is the position of one."""
        x, y = self._rng.choice((self._rng.choice(self._spots), self._place()))
        if robot:
            x, y = self._starts.setdefault(robot, (x, y))
        return builder.point(x, y)

    def area(self, name: str) -> m.Area:
        radius = _number(self._rng, 1.0, 80.0, _ODD_EXTENTS)
        return builder.area(name, radius, self.point())

    def place(self, name: str) -> m.Area:
        """Return a disc or a polygon; a polygon winds around a point, either way."""
        rng = self._rng
        if rng.random() < 0.5:
            return self.area(name)
        at, far, n = self.point(), rng.choice((0.01, 30.0, 80.0)), rng.choice((3, 4, 5, 8, 64))
        way = rng.choice((1, -1)) * 2.0 * math.pi / n
        turns = [(k + rng.uniform(0.0, 0.4)) * way for k in range(n)]
        spots = [(rng.uniform(0.3, 1.0) * far, turn) for turn in turns]
        corners = [
            builder.point(at.x + away * math.cos(turn), at.y + away * math.sin(turn))
            for away, turn in spots
        ]
        return m.Area(ID=name, corners=corners, center=rng.choice((at, None)))

    def mission(self) -> m.Mission:
        whole, robots = self.area("whole"), {each.ID: each for each in self.robots()}
        base = m.Server(ID="base", name="")
        obstacles = [
            m.Obstacle(ID=f"o{n}", area=self.place(f"oa{n}")) for n in range(self._of.n_obstacles)
        ]
        goals = []
        for n, goal in enumerate(self._of.goals):
            members = [robots[each] for each in goal.members]
            task = getattr(m, goal.task)(**self._task(n, goal, members, robots, obstacles))
            more: dict[str, Any] = {}
            if goal.task == "GatherSamples":
                more = {"area": self.place(f"ga{n}")}
            elif goal.task not in JOINT and self._rng.random() < 0.5:
                more = {"requiredMembers": self._rng.randint(0, len(members))}
            messages = [
                self._message(f"m{N_MESSAGES * n + k}", members, base) for k in range(N_MESSAGES)
            ]
            goals.append(builder.goal(f"g{n}", task, members, messages=messages, **more))
        return m.Mission(
            name="drawn",
            missionArea=whole,
            robots=[*robots.values()],
            servers=[base],
            obstacles=obstacles,
            goals=goals,
        )

    def robots(self) -> Iterator[m.Robot]:
        rng = self._rng
        rates = [RATES[n % len(RATES)] for n in range(sum(map(len, self._of.sensors)))]
        rng.shuffle(rates)
        for robot, kinds in zip(self._of.robots, self._of.sensors, strict=True):
            speed, drive, sample = (_number(rng, 0.0, 8.0, _ODD_AMOUNTS) for _ in range(3))
            energy = _number(rng, 0.0, rng.choice((500.0, 20_000.0)), _ODD_ENERGIES)
            sensors = [
                builder.sensor(f"{robot}s{k}", kind, sample, rates.pop())
                for k, kind in enumerate(kinds)
            ]
            fastest = speed + _number(rng, 0.0, 8.0, _ODD_AMOUNTS)
            more = {"maxSpeed": fastest} if rng.random() < 0.5 else {}
            rate, off = _number(rng, 0.1, 60.0, _ODD_TURNS), _number(rng, 0.0, 5.0, _ODD_EXTENTS)
            more |= {"turnRate": rate} if rng.random() < 0.5 else {}
            more |= {"positionNoise": off} if rng.random() < 0.3 else {}
            wide = _number(rng, 0.1, 6.0, _ODD_SIZES)
            more |= {"radius": wide} if rng.random() < 0.5 else {}
            yield builder.robot(robot, self.point(robot), speed, energy, drive, sensors, **more)

    def _message(self, name: str, members: list[m.Robot], base: m.Server) -> m.Message:
        sender = self._rng.choice((*members, base))
        every = (*FIELDS, *SENSOR_TYPES)
        some = self._rng.sample(every, self._rng.choice((1, 3, len(every))))
        body = {field: FIELDS.get(field, "Int") for field in some}
        return builder.message(name, sender, members[0] if sender is base else base, **body)

    def _task(
        self,
        n: int,
        goal: GoalShape,
        members: list[m.Robot],
        robots: dict[str, m.Robot],
        obstacles: list[m.Obstacle],
    ) -> dict[str, Any]:
        """Return what a goal's task has."""
        rng = self._rng
        found: dict[str, Any] = {}
        if goal.task in ("Visit", "Track", "FixedDistanceBetweenRobots"):
            found = {"tolerance": _number(rng, 1.0, 12.0, _ODD_EXTENTS)}
        if goal.task == "AvoidCollision":
            found = {"robots": members, "obstacles": obstacles}
            gap = _number(rng, 0.0, 4.0, (*_ODD_SIZES, 0.0))
            found |= {"clearance": gap} if rng.random() < 0.5 else {}
        elif goal.task == "GatherSamples":
            (sensor,) = (each for each in robots["r0"].sensors if goal.sensor == each.ID)
            found = {"targetSampleNumber": rng.choice((0, 1, 5, 50)), "sensor": sensor}
        elif goal.task == "Patrol":
            found = {"period": rng.randint(1, 40)}
            n_areas = rng.choice((0, 0, 1, 2, 3))
            found["route"] = [self.place(f"ta{n}{letter}") for letter in "xyz"[:n_areas]]
        elif goal.task == "Visit":
            found |= {"deadline": rng.randint(1, 70), "coordinates": self.point()}
        elif goal.task == "Track":
            begin = rng.choice(("", goal.members[0]))
            found["trajectory"] = [self.point(robot) for robot in (begin, "", "")]
        elif goal.task == "FixedDistanceBetweenRobots":
            found["fixedDistance"] = _number(rng, 1.0, 80.0, _ODD_EXTENTS)
        if goal.task in ("Patrol", "Stay") and not found.get("route"):
            found["area"] = self.place(f"ta{n}")
        return found
