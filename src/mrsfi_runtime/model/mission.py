"""A mission as its model describes it, and what the evaluation of a fault specification counts.

A ``Mission`` has robots, obstacles, messages and goals. Nothing of it changes while it runs.
Lengths are in distance units, times in ticks (one tick is one time interval of the mission),
energies in energy units. An ``Outcome`` has the counts of one flight, goal by goal.

``starvation`` finds goals that cannot be met since a goal that reacts first keeps their robots
elsewhere: the first goal that claims the heading of a robot has it (docs/semantics.md, reactions).

Begin with ``Mission`` and ``Outcome``.

References
----------
Source paper, section III-B a).
"""

from dataclasses import dataclass, replace
from functools import cached_property, reduce
from math import hypot
from operator import add
from typing import ClassVar, TypeAlias

from mrsfi_runtime.model.fault_types import Field, Range, Units

ROBOT_RADIUS = 1.0  # robots are discs of this radius, in distance units


@dataclass(frozen=True, slots=True)
class Coordinates:
    """A point; ``z`` is carried but plays no part in distances."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True, slots=True)
class Area:
    """A disc in the plane."""

    id: str
    center: Coordinates
    radius: float


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


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot with its nominal speed in distance units per tick.

    ``max_speed`` is the greatest speed that the model names, in the same unit; most name none.
    ``turn_rate`` is how far it turns in a tick, in degrees; 180 are at once.
    ``position_noise`` is how far off the position may be that it reports, in distance units.
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

    @property
    def fastest(self) -> float:
        """The greatest speed that anybody can command, in distance units per tick.

        It is twice the nominal one where the model names none.
        """
        return 2.0 * self.speed if self.max_speed is None else self.max_speed

    @property
    def total_energy(self) -> float:
        """Energy of all batteries at the start; ``sum`` rounds otherwise since Python 3.12."""
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
    """What a task is about, in words that all tasks share.

    Robots, obstacles and ``sensor``, whose samples it counts, are named by ID; a point is an
    ``area`` of radius 0. ``trajectory`` is a path, ``tolerance`` and ``fixed_distance`` are
    distances, ``period`` and ``deadline`` ticks.
    """

    robots: tuple[str, ...]
    obstacles: tuple[str, ...] = ()
    area: Area | None = None
    trajectory: tuple[Coordinates, ...] = ()
    sensor: str | None = None
    target_sample_number: int = 0
    tolerance: float = 0.0
    fixed_distance: float = 0.0
    period: int = 0
    deadline: int = 0


@dataclass(frozen=True, slots=True)
class GoalTask:
    """What the members of a goal have to do; ``kernel.goal_tasks`` has a subclass for each kind.

    One that ``keeps_robots`` steers them into its area for ever. ``spares`` is what its
    margin is measured in, by how much a goal is not violated.
    """

    keeps_robots: ClassVar[bool] = False
    spares: ClassVar[Range] = Range.X

    @property
    def name(self) -> str:
        """Name of its class in the metamodel."""
        return type(self).__name__

    def terms(self, goal: "Goal") -> Terms:
        """Return what the task is about: the goal's members, and what of its own is so named."""
        own = {term: getattr(self, term) for term in Terms.__slots__ if hasattr(self, term)}
        return replace(Terms(goal.members), **own)


@dataclass(frozen=True, slots=True)
class Goal:
    """A goal: what its members (robot IDs) are to achieve."""

    id: str
    name: str
    members: tuple[str, ...]
    task: GoalTask
    area: Area | None = None
    messages: tuple[Message, ...] = ()
    dependent_goals: tuple[str, ...] = ()

    @property
    def terms(self) -> Terms:
        """What its task is about."""
        return self.task.terms(self)


@dataclass(frozen=True, slots=True)
class GoalDisc:
    """A disc that a goal is about, in distance units."""

    goal: Goal
    x: float
    y: float
    radius: float


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
        """Return what a goal is called; where several are called so, with its robots."""
        name = goal.name or goal.id
        if sum(each.name == goal.name for each in self.goals) < 2 or not goal.name:
            return name
        robots = (self.robots[self.robot_index[each]] for each in goal.members)
        return f"{name} · {', '.join(robot.name or robot.id for robot in robots)}"

    def label_of(self, goal_id: str) -> str:
        """Return the name of a goal before its ID: ``AvoidCollision (g1)``."""
        goal = self.goals[self.goal_ids.index(goal_id)]
        return with_id(replace(goal, name=self.name_of(goal)))

    @cached_property
    def goal_discs(self) -> tuple[GoalDisc, ...]:
        """The discs that the goals' tasks read, in model order; not every task reads its area."""
        return tuple(
            GoalDisc(goal, area.center.x, area.center.y, area.radius + goal.terms.tolerance)
            for goal in self.goals
            if (area := goal.terms.area) is not None
        )

    @cached_property
    def message_goal(self) -> dict[str, tuple[Message, Goal]]:
        """Every message by ID, with the goal that contains it."""
        return {message.id: (message, goal) for goal in self.goals for message in goal.messages}

    @cached_property
    def touches(self) -> dict[tuple[str, str], tuple[tuple[Field, int], ...]]:
        """What ``faults.touched`` has found until now, by type and target of the fault."""
        return {}


def starvation(mission: Mission, goal: Goal) -> str:
    """Say, as a sentence goes on, which goals keep robots of one elsewhere, if any do.

    So the tasks react; regions may do otherwise.
    """
    wanted = _robots(mission, goal)
    held = []
    for holder in mission.goals[: mission.goals.index(goal)]:
        area = holder.terms.area
        if holder.task.keeps_robots and area is not None and _is_elsewhere(area, goal.terms):
            kept = [each.name or each.id for each in _robots(mission, holder) if each in wanted]
            if kept:
                told = f"{mission.label_of(holder.id)}, which reacts first, keeps"
                held.append(f"{told} {' and '.join(kept)} in area {area.id}")
    return f"as {' and '.join(held)}" if held else ""


def _robots(mission: Mission, goal: Goal) -> list[Robot]:
    """Return the robots that a goal steers: that of its sensor, or else its members."""
    sensor = goal.terms.sensor
    if sensor is not None:
        return [mission.robots[mission.sensor_robot[mission.sensor_index[sensor]]]]
    return [mission.robots[mission.robot_index[each]] for each in goal.members]


def _is_elsewhere(area: Area, terms: Terms) -> bool:
    discs = [(point, terms.tolerance) for point in terms.trajectory]
    if terms.area is not None:
        discs.append((terms.area.center, terms.area.radius + terms.tolerance))
    return any(
        hypot(point.x - area.center.x, point.y - area.center.y) > area.radius + reach
        for point, reach in discs
    )


Element: TypeAlias = Robot | Sensor | Obstacle | Goal
"""What has an ID, and may have a name."""


def with_id(element: Element) -> str:
    """Return the name of an element before its ID: ``KAL (r3)``; the ID alone if it has no name."""
    name = "" if isinstance(element, Obstacle) else element.name
    return f"{name} ({element.id})" if name not in {"", element.id} else element.id


COUNTED = ("believed", "true", "phantom", "masked", "missed")
"""What is counted in ticks for each goal, in the order of an outcome's attributes."""

RESULTS = (*COUNTED, "missed_since")
"""What is listed of each goal: its counts, and the tick from which on it was missed."""

Margin: TypeAlias = tuple[float, int]
"""By how much a goal was not violated when it was nearest to it, and the tick of that."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """Violations per goal, each of shape ``(n_goals,)`` in model order, and what faults did.

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
        Ticks from the one on at which it was certain, from the truth alone, that the goal's
        purpose is not met; 0 where it was met.
    samples
        Samples counted towards each goal, in truth; 0 for goals that gather none.
    applied
        For each timed fault, at how many ticks it was active.
    changed
        For each timed fault, at how many ticks it changed at least one value.
    digest
        SHA-256 over all of the above and the final true and believed states, as IEEE-754 bits.
    margins
        How far each goal was from being truly violated when it was nearest to it, in the unit of
        its task, and the tick of that; ``None`` for a goal of which that cannot be said. ``None``
        as a whole if not recorded.
    detection
        Ticks from the first one on at which each goal was truly violated or missed, and how many of
        these passed before the belief showed a violation. ``None`` as a whole if not recorded.
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

    def missed_since(self, duration: int) -> tuple[int | None, ...]:
        """Return from which tick on each goal was certain to be missed, ``None`` if it was met."""
        return tuple(duration - ticks if ticks else None for ticks in self.missed)

    def results(self, duration: int) -> dict[str, tuple[int | None, ...]]:
        """Return the results of each goal by the names in ``RESULTS``; None for "not missed"."""
        counts = [getattr(self, name) for name in COUNTED]
        return dict(zip(RESULTS, (*counts, self.missed_since(duration)), strict=True))


@dataclass(frozen=True, slots=True)
class FailedFlight:
    """What comes of an evaluation whose mission code failed: the traceback as text."""

    traceback: str


Evaluated: TypeAlias = Outcome | FailedFlight  # what comes of an evaluation
