"""Missions with all nine tasks, and pools with all thirty fault types, drawn at random.

A *shape* is what compiled code depends on: how many robots, sensors, obstacles and goals there
are, who is a member of what, and which sampling rates occur. Everything else is drawn for it,
so that many missions share the one flight that was compiled for their shape.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

from m2t.generate import generate
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.fault_types import FaultType, Field, Mode
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.gate import Gate
from tests.support.fault_types import FAULT_TYPES
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
SENSOR_TYPES = ("GPS_POSITION", "DEPTH", "TEMPERATURE", "PRESSURE")
FIELDS = {"POSITION": "Coordinates", "SPEED": "Double", "ENERGY": "Double"}
RATES = (1, 2, 5, 40)
N_MESSAGES = 3

_XMI = 'xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI"'
_MISSION = f"""<?xml version="1.0" encoding="ASCII"?>
<mission:Mission {_XMI} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="drawn" duration="{{}}">
{{}}</mission:Mission>
"""
_FAULTS = f"""<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification {_XMI} xmlns:faults="http://mrsfi.org/faults/1.0" ID="pool">
{{}}</faults:FaultSpecification>
"""


_ODD_PLACES = (0.0, -0.0, 1e-9, 30.0, 1e10, -1e10)
_ODD_AMOUNTS = (0.0, 1e-9, 1.0, 1e6)
_ODD_ENERGIES = (0.0, 1e-9, 1e12)
_ODD_TURNS = (1e-9, 1e-3, 90.0, 179.9999999, 180.0)
_ODD_EXTENTS = (1e-9, 1.0, 30.0, 1e12)
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


def draw_mission(rng: Random, of: Shape, longest: int, shortest: int = 1) -> str:
    """Draw a mission of a shape, as the text of its model; its duration too, in ticks."""
    parts = _Parts(rng, of)
    text = [
        parts.area("missionArea", "whole"),
        *parts.robots(),
        '<servers ID="base" name=""/>',
        *parts.obstacles(),
        *(parts.goal(n, goal) for n, goal in enumerate(of.goals)),
    ]
    return _MISSION.format(rng.randint(shortest, longest), "".join(f"{part}\n" for part in text))


def draw_pool(rng: Random, of: Shape) -> str:
    """Draw a pool with one fault of every type, and triggers of every event, in XMI."""
    targets = {
        "message": [f"m{n}" for n in range(N_MESSAGES * len(of.goals))],
        "robot": of.robots,
        "sensor": [f"r0s{n}" for n in range(len(SENSOR_TYPES))],
        "obstacle": [f"o{n}" for n in range(of.n_obstacles)],
    }
    parts = []
    for n, (name, kind) in enumerate(FAULT_TYPES.items()):
        tag = name[0].lower() + name[1:]
        values = "".join(
            f' {parameter.name}="{int(value) if _is_whole(kind) else repr(value)}"'
            for parameter, value in zip(kind.parameters, _values(rng, kind), strict=True)
        )
        target = rng.choice(targets[kind.struck.value])
        parts.append(
            f'<faults ID="f{n}" name=""><{tag}{values}>'
            f'<affected{kind.struck.value.title()} href="mission.xmi#{target}"/></{tag}></faults>\n'
        )
    return _FAULTS.format("".join((*parts, *_triggers(rng, of))))


def _triggers(rng: Random, of: Shape) -> Iterator[str]:
    reachable = [n for n, goal in enumerate(of.goals) if goal.task in REACHABLE]
    robots = rng.sample(of.robots, min(3, len(of.robots)))
    some = rng.sample(range(len(of.goals)), min(3, len(of.goals)))
    found = [("VIOLATED", f'<goal href="mission.xmi#g{n}"/>', "") for n in some]
    found += [("REACHED", f'<goal href="mission.xmi#g{n}"/>', "") for n in reachable]
    for n, robot in enumerate(robots):
        x, y = rng.uniform(-60.0, 60.0), rng.uniform(-60.0, 60.0)
        area = f'<area ID="e{n}" radius="{rng.uniform(1.0, 80.0)!r}"><center x="{x!r}" y="{y!r}"/>'
        found.append(("ENTERED", f'<robot href="mission.xmi#{robot}"/>{area}</area>', ""))
    for _ in range(3):
        faults = " ".join(f"f{n}" for n in rng.sample(range(len(FAULT_TYPES)), 5))
        found.append(("EFFECT", "", f' faults="{faults}"'))
    at = f'<robot href="mission.xmi#{robots[0]}"/><at href="mission.xmi#whole"/>'
    found.append(("ENTERED", at, ""))
    for n, (event, content, more) in enumerate(found):
        lasts = rng.choice(("", "", ' duration="1"', f' duration="{rng.randint(2, 30)}"'))
        delay = rng.choice((0, 0, 1, 7))
        head = f'<triggers ID="t{n}" event="{event}" delay="{delay}"{lasts}{more}>'
        yield f"{head}{content}</triggers>\n"


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


def write(folder: Path, mission: str, pool: str) -> Path:
    """Write the models of a mission, and return their folder."""
    folder.mkdir(parents=True)
    (folder / "mission.xmi").write_text(mission)
    (folder / "faults.xmi").write_text(pool)
    return folder


def small_mission(folder: Path) -> MissionCode:
    """Return generated code of a mission of one goal, which compiles in a fraction of the time."""
    goal = GoalShape("StayWithinMissionArea", ("r0", "r1"))
    of = Shape(1, (SENSOR_TYPES, ("DEPTH",)), (goal,))
    rng = Random(1)
    models = write(folder / "models", draw_mission(rng, of, 40, 40), draw_pool(rng, of))
    generate(models, folder / "generated")
    return load_code(folder / "generated")


class _Parts:
    """Draws the elements of a mission, as text.

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

    def point(self, tag: str, robot: str = "") -> str:
        """Return a point; where a robot begins, if it is the position of one."""
        x, y = self._rng.choice((self._rng.choice(self._spots), self._place()))
        if robot:
            x, y = self._starts.setdefault(robot, (x, y))
        return f'<{tag} x="{x!r}" y="{y!r}"/>'

    def area(self, tag: str, name: str) -> str:
        radius = _number(self._rng, 1.0, 80.0, _ODD_EXTENTS)
        return f'<{tag} ID="{name}" radius="{radius!r}">{self.point("center")}</{tag}>'

    def robots(self) -> Iterator[str]:
        rng = self._rng
        rates = [RATES[n % len(RATES)] for n in range(sum(map(len, self._of.sensors)))]
        rng.shuffle(rates)
        for robot, kinds in zip(self._of.robots, self._of.sensors, strict=True):
            speed, distance, sample = (_number(rng, 0.0, 8.0, _ODD_AMOUNTS) for _ in range(3))
            energy = _number(rng, 0.0, rng.choice((500.0, 20_000.0)), _ODD_ENERGIES)
            sensors = "".join(
                f'<sensors ID="{robot}s{k}" name="" type="{kind}" energyPerSample="{sample!r}" '
                f'samplesPerSecond="{rates.pop()}"/>'
                for k, kind in enumerate(kinds)
            )
            more = _number(rng, 0.0, 8.0, _ODD_AMOUNTS)
            fastest = f' maxSpeed="{speed + more!r}"' if rng.random() < 0.5 else ""
            rate, off = _number(rng, 0.1, 60.0, _ODD_TURNS), _number(rng, 0.0, 5.0, _ODD_EXTENTS)
            turns = f' turnRate="{rate!r}"' if rng.random() < 0.5 else ""
            noise = f' positionNoise="{off!r}"' if rng.random() < 0.3 else ""
            yield (
                f'<robots ID="{robot}" name="" speed="{speed!r}"{fastest}{turns}{noise}>'
                f"{self.point('position', robot)}{sensors}"
                f'<batteries ID="{robot}b" name="" totalEnergy="{energy!r}"/><motionSources '
                f'ID="{robot}d" name="" energyPerDistanceUnit="{distance!r}"/></robots>'
            )

    def obstacles(self) -> Iterator[str]:
        for n in range(self._of.n_obstacles):
            yield f'<obstacles ID="o{n}">{self.area("area", f"oa{n}")}</obstacles>'

    def goal(self, n: int, goal: GoalShape) -> str:
        attributes, content = self._task(n, goal)
        area = self.area("area", f"ga{n}") if goal.task == "GatherSamples" else ""
        messages = "".join(self._message(f"m{N_MESSAGES * n + k}", goal) for k in range(N_MESSAGES))
        return (
            f'<goals ID="g{n}" name="" members="{" ".join(goal.members)}">{area}'
            f'<task xsi:type="mission:{goal.task}"{attributes}>{content}</task>{messages}</goals>'
        )

    def _message(self, name: str, goal: GoalShape) -> str:
        sender = self._rng.choice((*goal.members, "base"))
        receiver = goal.members[0] if sender == "base" else "base"
        every = (*FIELDS, *SENSOR_TYPES)
        body = "".join(
            f'<body name="{field}" type="{FIELDS.get(field, "Int")}"/>'
            for field in self._rng.sample(every, self._rng.choice((1, 3, len(every))))
        )
        return f'<messages ID="{name}" sender="{sender}" receiver="{receiver}">{body}</messages>'

    def _task(self, n: int, goal: GoalShape) -> tuple[str, str]:
        """Return attributes and content of a goal's task."""
        rng = self._rng
        attributes, content = "", ""
        if goal.task in ("Visit", "Track", "FixedDistanceBetweenRobots"):
            attributes = f' tolerance="{_number(rng, 1.0, 12.0, _ODD_EXTENTS)!r}"'
        if goal.task == "AvoidCollision":
            hazards = " ".join(f"o{k}" for k in range(self._of.n_obstacles))
            attributes = f' robots="{" ".join(goal.members)}" obstacles="{hazards}"'
        elif goal.task == "GatherSamples":
            target = rng.choice((0, 1, 5, 50))
            attributes = f' targetSampleNumber="{target}" sensor="{goal.sensor}"'
        elif goal.task == "Patrol":
            attributes = f' period="{rng.randint(1, 40)}"'
        elif goal.task == "Visit":
            attributes += f' deadline="{rng.randint(1, 70)}"'
            content = self.point("coordinates")
        elif goal.task == "Track":
            begin = rng.choice(("", goal.members[0]))
            content = "".join(self.point("trajectory", robot) for robot in (begin, "", ""))
        elif goal.task == "FixedDistanceBetweenRobots":
            attributes += f' fixedDistance="{_number(rng, 1.0, 80.0, _ODD_EXTENTS)!r}"'
        if goal.task in ("Patrol", "Stay"):
            content = self.area("area", f"ta{n}")
        return attributes, content
