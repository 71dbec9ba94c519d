"""A mission as its model describes it, and the outcome of a fault specification.

A ``Mission`` has robots, obstacles, messages and goals. It never changes. Lengths are in distance
units, times in ticks (time intervals of the mission), energies in energy units. An ``Outcome`` has
the counts of one flight, goal by goal.

``starvation`` finds goals that cannot be met because an earlier goal keeps their robots elsewhere:
the first goal that claims the heading of a robot has it (docs/semantics.md, reactions).

Begin with ``Mission`` and ``Outcome``.

References
----------
Source paper, section III-B a).
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from itertools import accumulate
from operator import add
from typing import ClassVar, NamedTuple, TypeAlias

from mrsfi_runtime.model.fault_types import Field, Range, Units
from mrsfi_runtime.model.polygons import middle, off_segment

_BRIEF = 120  # letters of a requirement's text inside a sentence


@dataclass(frozen=True, slots=True)
class Coordinates:
    """A point; distances ignore ``z``."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


Offsets: TypeAlias = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Area:
    """A disc in the plane, or a polygon, which ``polygon`` makes.

    The ``radius`` of a polygon is the distance from its ``center`` to the farthest of its
    ``corners``.
    """

    id: str
    center: Coordinates
    radius: float
    corners: tuple[Coordinates, ...] = ()

    @property
    def offsets(self) -> Offsets:
        """The corners of a polygon, from its centre."""
        return tuple((each.x - self.center.x, each.y - self.center.y) for each in self.corners)


def polygon(id: str, corners: tuple[Coordinates, ...], center: Coordinates | None = None) -> Area:
    """Return a polygon by its corners, in order; its centre is a point inside, by default one."""
    area = Area(id, center or Coordinates(*middle(corners)), 0.0, corners)
    return replace(area, radius=max(math.sqrt(dx * dx + dy * dy) for dx, dy in area.offsets))


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor that takes ``samples_per_second`` samples each tick while it is active."""

    id: str
    name: str
    type: str
    energy_per_sample: float
    samples_per_second: int


@dataclass(frozen=True, slots=True)
class Battery:
    """An energy store; the batteries of a robot add up."""

    id: str
    name: str
    total_energy: float


@dataclass(frozen=True, slots=True)
class MotionSource:
    """A drive; the costs of a robot's drives add up."""

    id: str
    name: str
    energy_per_distance_unit: float


@dataclass(frozen=True, slots=True)
class IntProperty:
    """A user-defined whole number of a robot or server."""

    name: str
    value: int


@dataclass(frozen=True, slots=True)
class StringProperty:
    """A user-defined text of a robot or server."""

    name: str
    value: str


@dataclass(frozen=True, slots=True)
class DoubleProperty:
    """A user-defined number of a robot or server."""

    name: str
    value: float


def turn_width(turn_rate: float) -> float:
    """Return the diameter of a turning circle in units of the speed, for degrees a tick < 180."""
    return 1.0 / max(math.sin(0.5 * math.radians(turn_rate)), 1e-12)


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot with its nominal speed in distance units per tick.

    ``max_speed`` is the model's greatest speed, in the same unit; most models have none.
    ``turn_rate`` is the largest turn in a tick, in degrees; 180 turn at once. ``position_noise`` is
    the largest error of the reported position, in distance units, as ``radius``, that of its disc.
    """

    id: str
    name: str
    position: Coordinates
    speed: float
    sensors: tuple[Sensor, ...] = ()
    batteries: tuple[Battery, ...] = ()
    motion_sources: tuple[MotionSource, ...] = ()
    int_properties: tuple[IntProperty, ...] = ()
    string_properties: tuple[StringProperty, ...] = ()
    double_properties: tuple[DoubleProperty, ...] = ()
    max_speed: float | None = None
    turn_rate: float = 180.0
    position_noise: float = 0.0
    radius: float = 1.0

    @property
    def fastest(self) -> float:
        """The greatest speed that can be commanded, by default twice the nominal one."""
        return 2.0 * self.speed if self.max_speed is None else self.max_speed

    @property
    def total_energy(self) -> float:
        """Energy of all batteries at the start; ``sum`` rounds differently since Python 3.12."""
        return reduce(add, (battery.total_energy for battery in self.batteries), 0.0)

    @property
    def energy_per_distance_unit(self) -> float:
        """Energy that all motion sources together spend per distance unit."""
        return reduce(add, (each.energy_per_distance_unit for each in self.motion_sources), 0.0)


@dataclass(frozen=True, slots=True)
class Server:
    """A server; the collective intelligence runs on one."""

    id: str
    name: str
    int_properties: tuple[IntProperty, ...] = ()
    string_properties: tuple[StringProperty, ...] = ()
    double_properties: tuple[DoubleProperty, ...] = ()


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A disc that robots must not touch."""

    id: str
    area: Area


@dataclass(frozen=True, slots=True)
class MessageData:
    """One entry of a message body: POSITION, SPEED, ENERGY or a sensor type."""

    name: str
    type: str


@dataclass(frozen=True, slots=True)
class Message:
    """A message that a goal needs, from one robot or server (by ID) to another."""

    id: str
    sender: str
    receiver: str
    body: tuple[MessageData, ...]
    header: str = ""


@dataclass(frozen=True, slots=True)
class Terms:
    """The parameters of a task, under names that all tasks share.

    Robots, obstacles and ``sensor``, whose samples it counts, are named by ID; a point is an
    ``area`` of radius 0. ``trajectory`` is a path, ``route`` areas in a loop; ``tolerance``,
    ``fixed_distance`` and ``clearance`` are distances, ``period`` and ``deadline`` ticks.
    """

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()
    area: Area | None = None
    trajectory: tuple[Coordinates, ...] = ()
    sensor: str | None = None
    target_sample_number: int = 0
    tolerance: float = 0.0
    fixed_distance: float = 0.0
    clearance: float = 0.0
    period: int = 0
    deadline: int = 0
    route: tuple[Area, ...] = ()

    @property
    def areas(self) -> tuple[Area, ...]:
        """Its route, or its one area, or none."""
        return self.route or (() if self.area is None else (self.area,))

    @property
    def path(self) -> tuple[Coordinates, ...]:
        """The points of its trajectory, or the centres of its route, back to the first."""
        centers = tuple(area.center for area in self.route)
        return self.trajectory or centers + centers[:1]


@dataclass(frozen=True, slots=True)
class GoalTask:
    """The task of a goal's members; ``kernel.goal_tasks`` has a subclass for each kind.

    A task that ``keeps_robots`` steers them into its area forever. ``spares`` is the quantity of
    its margin, the distance from a violation.
    """

    keeps_robots: ClassVar[bool] = False
    spares: ClassVar[Range] = Range.X

    @property
    def name(self) -> str:
        """Name of its class in the metamodel."""
        return type(self).__name__

    def terms(self, goal: "Goal") -> Terms:
        """Return the terms of the task: the goal's members, and its attributes of these names."""
        own = {term: getattr(self, term) for term in Terms.__slots__ if hasattr(self, term)}
        return replace(Terms(goal.members), **own)


@dataclass(frozen=True, slots=True)
class Requirement:
    """A requirement of the team, by the ID that the team uses."""

    id: str
    text: str


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal of its members, which are robot IDs.

    ``required_members`` is how many of them must keep to the task; 0 stands for all. ``grace`` is
    for how many ticks in a row the rule of the task may be broken before the goal is violated.
    ``requirements`` are the IDs of those that are violated if the goal fails. ``severity`` is 1 to
    10, 0 if nobody has rated it; ``integrity_level`` is a name, such as ASIL B.
    """

    id: str
    name: str
    members: tuple[str, ...]
    task: GoalTask
    area: Area | None = None
    messages: tuple[Message, ...] = ()
    dependent_goals: tuple[str, ...] = ()
    required_members: int = 0
    grace: int = 0
    requirements: tuple[str, ...] = ()
    severity: int = 0
    integrity_level: str = ""
    rationale: str = ""

    @property
    def terms(self) -> Terms:
        """The terms of its task."""
        return self.task.terms(self)


@dataclass(frozen=True, slots=True)
class GoalDisc:
    """An area of a goal, wider by its tolerance; of a route, with its number from 1 on."""

    goal: Goal
    area: Area
    number: int = 0

    @property
    def label(self) -> str:
        """The ID of its goal, and its number in the route."""
        return f"{self.goal.id} {self.number}" if self.number else self.goal.id


@dataclass(frozen=True)
class Mission:
    """A mission of ``duration`` ticks, ``0 … duration - 1``."""

    name: str
    duration: int
    area: Area
    robots: tuple[Robot, ...]
    goals: tuple[Goal, ...]
    servers: tuple[Server, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    distance_unit: str = ""
    time_unit: str = ""
    energy_unit: str = ""
    requirements: tuple[Requirement, ...] = ()

    @cached_property
    def units(self) -> Units:
        """The units that its model names."""
        return Units(self.distance_unit, self.time_unit, self.energy_unit)

    @cached_property
    def robot_index(self) -> dict[str, int]:
        """Position of every robot by ID."""
        return {robot.id: index for index, robot in enumerate(self.robots)}

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """All sensors, robot by robot."""
        return tuple(sensor for robot in self.robots for sensor in robot.sensors)

    @cached_property
    def sensor_index(self) -> dict[str, int]:
        """Position of every sensor by ID in ``sensors``."""
        return {sensor.id: index for index, sensor in enumerate(self.sensors)}

    @cached_property
    def sensor_robot(self) -> tuple[int, ...]:
        """Index of the robot that carries each sensor, in the order of ``sensors``."""
        return tuple(i for i, robot in enumerate(self.robots) for _ in robot.sensors)

    @cached_property
    def obstacle_index(self) -> dict[str, int]:
        """Position of every obstacle by ID."""
        return {obstacle.id: index for index, obstacle in enumerate(self.obstacles)}

    @cached_property
    def goal_ids(self) -> tuple[str, ...]:
        """IDs of the goals in model order."""
        return tuple(goal.id for goal in self.goals)

    def name_of(self, goal: Goal) -> str:
        """Return the name of a goal, with its robots if several goals have the name."""
        name = goal.name or goal.id
        if sum(each.name == goal.name for each in self.goals) < 2 or not goal.name:
            return name
        robots = (self.robots[self.robot_index[each]] for each in goal.members)
        return f"{name} · {', '.join(robot.name or robot.id for robot in robots)}"

    def label_of(self, goal_id: str) -> str:
        """Return the name of a goal before its ID: ``AvoidCollision (g1)``."""
        return with_id(self.name_of(self.goals[self.goal_ids.index(goal_id)]), goal_id)

    def stakes_of(self, goal_id: str) -> str:
        """Return what a goal stands for: ``requirement R1 (No …), severity 8 of 10, ASIL B``."""
        goal, parts = self.goals[self.goal_ids.index(goal_id)], []
        for each in self.requirements:
            if each.id in goal.requirements:
                text = " ".join(each.text.split())
                text = text if len(text) <= _BRIEF else f"{text[: _BRIEF - 1]}…"
                parts.append(f"requirement {each.id} ({text})")
        parts += [f"severity {goal.severity} of 10"] * bool(goal.severity)
        return ", ".join((*parts, *filter(None, [goal.integrity_level])))

    @cached_property
    def goal_discs(self) -> tuple[GoalDisc, ...]:
        """The areas that the goals' tasks use, in model order; some tasks ignore their area."""
        return tuple(
            GoalDisc(goal, replace(area, radius=area.radius + terms.tolerance), number)
            for goal in self.goals
            for terms in (goal.terms,)
            for number, area in enumerate(terms.areas, 1 if terms.route else 0)
        )

    @cached_property
    def polygons(self) -> dict[Area, int]:
        """All polygons, each with the number of corners of those before it."""
        areas = [obstacle.area for obstacle in self.obstacles]
        for goal in self.goals:
            areas += (*goal.terms.areas, *filter(None, [goal.area]))
        found = [*dict.fromkeys(area for area in areas if area.corners)]
        before = accumulate((len(area.corners) for area in found), initial=0)
        return dict(zip(found, before, strict=False))

    @cached_property
    def message_goal(self) -> dict[str, tuple[Message, Goal]]:
        """Every message by ID, with the goal that contains it."""
        return {message.id: (message, goal) for goal in self.goals for message in goal.messages}

    @cached_property
    def elements(self) -> tuple[str, ...]:
        """IDs of robots, sensors, messages and obstacles: what a fault can strike."""
        by_kind = (self.robot_index, self.sensor_index, self.message_goal, self.obstacle_index)
        return tuple(dict.fromkeys(element for known in by_kind for element in known))

    @cached_property
    def touches(self) -> dict[tuple[str, str], tuple[tuple[Field, int], ...]]:
        """Cache of ``faults.touched``, by type and target of the fault."""
        return {}


def starvation(mission: Mission, goal: Goal) -> str:
    """Return, inside a sentence, which goals keep robots of a goal elsewhere; else nothing.

    It assumes the reactions of the tasks; regions may react differently.
    """
    wanted = _robots(mission, goal)
    held = []
    for holder in mission.goals[: mission.goals.index(goal)]:
        areas = holder.terms.areas
        if holder.task.keeps_robots and areas and _is_elsewhere(areas, goal.terms):
            kept = [each.name or each.id for each in _robots(mission, holder) if each in wanted]
            if kept:
                keeps = f"{mission.label_of(holder.id)}, which reacts first, keeps"
                word = "area" if len(areas) == 1 else "areas"
                named = " and ".join(area.id for area in areas)
                held.append(f"{keeps} {' and '.join(kept)} in {word} {named}")
    return f"as {' and '.join(held)}" if held else ""


def _robots(mission: Mission, goal: Goal) -> list[Robot]:
    """Return the robots that a goal steers: its sensor's, else its members."""
    sensor = goal.terms.sensor
    if sensor is not None:
        return [mission.robots[mission.sensor_robot[mission.sensor_index[sensor]]]]
    return [mission.robots[mission.robot_index[each]] for each in goal.members]


def _is_elsewhere(areas: tuple[Area, ...], terms: Terms) -> bool:
    """Return whether a place of a task is off all areas, and off the ways from one to the next."""
    discs = [(point, terms.tolerance) for point in terms.trajectory]
    discs += [(area.center, area.radius + terms.tolerance) for area in terms.areas]
    legs = [*zip(areas, areas[1:] + areas[:1], strict=True)]
    return any(
        all(_from_leg(a, b, point) > max(a.radius, b.radius) + reach for a, b in legs)
        for point, reach in discs
    )


def _from_leg(start: Area, end: Area, point: Coordinates) -> float:
    """Return the distance of a point from the segment between the centres of two areas."""
    x, y = start.center.x, start.center.y
    return off_segment(point.x - x, point.y - y, end.center.x - x, end.center.y - y)


def with_id(name: str, identifier: str) -> str:
    """Return a name before an ID: ``KAL (r3)``; the ID alone if there is no other name."""
    return f"{name} ({identifier})" if name not in {"", identifier} else identifier


COUNTED = ("believed", "true", "phantom", "masked", "missed")
"""The counts of each goal, in ticks, in the order of an outcome's attributes."""

RESULTS = (*COUNTED, "missed_since")
"""What is listed of each goal: its counts, and the tick from which on it was missed."""

Margin: TypeAlias = tuple[float, int]
"""The least distance of a goal from a violation, below 0 if violated, and its tick."""


class Repetition(NamedTuple):
    """The flights of a specification with external parts, of which the outcome is the median.

    ``n_late`` are the late ticks of all of them; ``broken`` has for each goal in how many of them
    it was truly violated or missed.
    """

    n_flights: int
    n_late: int
    broken: tuple[int, ...]


def wilson(k: float, n: float) -> tuple[float, float]:
    """Return the 95 % interval of a share of ``k`` in ``n`` trials, n > 0, by Wilson's score.

    References
    ----------
    E. B. Wilson, "Probable inference, the law of succession, and statistical inference", Journal of
    the American Statistical Association 22, 1927.
    """
    z = 1.96
    middle, off = k + z**2 / 2, z * math.sqrt(k * (n - k) / n + z**2 / 4)
    return max(0.0, (middle - off) / (n + z**2)), min(1.0, (middle + off) / (n + z**2))


def interval_in_words(k: int, n: int) -> str:
    """Return the interval as it follows a share: ``(95 %: 69 % to 94 %)``."""
    return "(95 %: {:.0f} % to {:.0f} %)".format(*(100 * end for end in wilson(k, n)))


@dataclass(frozen=True, slots=True)
class Outcome:
    """Violations per goal, each of shape ``(n_goals,)`` in model order, and effects of faults.

    Attributes
    ----------
    believed
        Ticks at which the collective intelligence believed the goal violated: the paper's
        measure.
    true
        Ticks at which it truly was.
    phantom
        Believed, not true.
    masked
        True, not believed.
    missed
        Ticks from the first one on at which the truth made certain that the goal cannot be met;
        0 if it was met.
    samples
        True samples of each goal; 0 for goals that gather none.
    applied
        For each timed fault, the number of ticks at which it was active.
    changed
        For each timed fault, the number of ticks at which it changed at least one value.
    digest
        SHA-256 over all of the above and the final true and believed states, as IEEE-754 bits.
    margins
        The closest approach of each goal to a true violation, in the unit of its task, and its
        tick; below 0 how far it was beyond its limit, at worst. ``None`` for a goal without a
        margin. ``None`` as a whole if not recorded.
    detection
        For each goal, the ticks since it was first truly violated or missed, and how many of these
        passed before the belief showed a violation. ``None`` as a whole if not recorded.
    repetition
        The flights with external parts; ``None`` without, or if not recorded. Equal outcomes may
        differ in it.
    """

    believed: tuple[int, ...]
    true: tuple[int, ...]
    phantom: tuple[int, ...]
    masked: tuple[int, ...]
    missed: tuple[int, ...]
    samples: tuple[int, ...]
    applied: tuple[int, ...]
    changed: tuple[int, ...]
    digest: str
    margins: tuple[Margin | None, ...] | None = None
    detection: tuple[tuple[int, int], ...] | None = None
    repetition: Repetition | None = field(default=None, compare=False)

    @property
    def depths(self) -> tuple[Margin | None, ...]:
        """How far each violated goal was beyond its limit, above 0, and when; else ``None``."""
        margins = self.margins or [None] * len(self.true)
        found = zip(margins, self.true, strict=True)
        return tuple((-it[0], it[1]) if it and n and it[0] < 0.0 else None for it, n in found)

    def missed_since(self, duration: int) -> tuple[int | None, ...]:
        """Return the tick from which on each goal was missed, ``None`` if it was met."""
        return tuple(duration - ticks if ticks else None for ticks in self.missed)

    def results(self, duration: int) -> dict[str, tuple[int | None, ...]]:
        """Return the results of each goal by the names in ``RESULTS``; None for "not missed"."""
        counts = [getattr(self, name) for name in COUNTED]
        return dict(zip(RESULTS, (*counts, self.missed_since(duration)), strict=True))


@dataclass(frozen=True, slots=True)
class FailedFlight:
    """The result of an evaluation whose mission code failed: the traceback as text."""

    traceback: str


Evaluated: TypeAlias = Outcome | FailedFlight  # the result of an evaluation
