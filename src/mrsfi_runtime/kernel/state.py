"""The state of a world, and the arithmetic that is allowed on it.

The simulation keeps one ``State``, the truth; the collective intelligence keeps another, its local
state or belief. Goal predicates read either. All records hold only integers and floats, and refer
to each other by index, so that compiled code can store the same fields in arrays.

Functions of the kernel are written once and run interpreted or compiled; ``kernel`` marks them. A
marked function, and each function that it calls, uses only the common subset: loops, comparisons,
``+ - * / // %``, ``min max abs round``, ``math.sqrt``, integer operations, records with attributes,
other marked functions. No ``**`` on floats, no ``math.hypot``, no ``random``, no new containers:
they differ between the interpreter and a compiler, or do not compile at all.

No verdict depends on the last bit of a sum. Checks treat a value within a billionth of a limit as
equal to it (``excess``); reactions keep a larger distance from limits.

Begin with ``State``. ``COLUMNS`` lists its changing columns, in the order of digests and of
recorded moments.
"""

import struct
from array import array
from collections.abc import Callable, Mapping, MutableSequence
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any, TypeGuard, TypeVar, get_args, get_type_hints

from mrsfi_runtime.model.fault_types import Field

Function = TypeVar("Function", bound=Callable[..., Any])


def kernel(function: Function) -> Function:
    """Mark a function as part of the world's kernel and return it unchanged."""
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function


def is_kernel(value: object) -> TypeGuard[FunctionType]:
    """Return whether a value is a function of the kernel, or marked as one."""
    return isinstance(value, FunctionType) and bool(getattr(value, "__kernel__", False))


N_MEMORY = 8  # numbers that a region can store


def no_memory() -> MutableSequence[float]:
    """Return ``N_MEMORY`` zeros."""
    return array("d", bytes(8 * N_MEMORY))


@dataclass(slots=True)
class MissionState:
    """The mission: ticks are ``0 … duration - 1``; the area is a disc."""

    seed: int
    tick: int
    duration: int
    x: float
    y: float
    radius: float


@dataclass(slots=True)
class RobotState:
    """A robot: position, speed in units per tick, energy left; then constants.

    No command exceeds ``max_speed``. Its sensors are ``n_sensors`` from ``first_sensor`` on;
    ``gps`` is its position sensor, or -1.
    """

    x: float
    y: float
    z: float
    speed: float
    energy: float
    nominal_speed: float
    max_speed: float
    energy_per_distance: float
    first_sensor: int
    n_sensors: int
    gps: int


@dataclass(frozen=True, slots=True)
class TraitState:
    """Turn rate, position noise and size of a robot.

    ``turn_x`` and ``turn_y`` are the unit vector that it can turn to from 0 degrees in a tick, to
    the left; ``turn_y`` is 0 if it turns at once. ``turn_width`` is the diameter of its turning
    circle in units of its speed, 1 if it turns at once. ``position_noise`` is a distance,
    ``radius`` that of its disc.
    """

    turn_x: float
    turn_y: float
    turn_width: float
    position_noise: float
    radius: float


@dataclass(frozen=True, slots=True)
class ScopeState:
    """How far a member of a goal can be from an obstacle that it has to avoid, and move in a tick.

    Two members are of no concern to each other beyond the sum of both reaches.
    """

    reach: float
    step: float


@dataclass(slots=True)
class WakeState:
    """Where a robot or an obstacle was a tick ago, and how far it can have moved since.

    One that is farther away has jumped in belief. In truth nothing does: the reach is infinite.
    """

    x: float
    y: float
    reach: float = 0.0


@dataclass(slots=True)
class SensorState:
    """A sensor: valid samples so far, activation (0 or 1), samples per tick, energy per sample.

    ``first_chance`` and ``n_chances`` locate its cumulative chances in ``State.chances``.
    """

    robot: int
    count: int
    active: int
    rate: float
    cost: float
    nominal_rate: float
    nominal_cost: float
    first_chance: int
    n_chances: int


@dataclass(slots=True)
class ObstacleState:
    """An obstacle: its position in this state, its radius, and its position in the model.

    For a polygon, these are the position of its centre, and the radius of its ``AreaState``.
    """

    x: float
    y: float
    radius: float
    model_x: float
    model_y: float


@dataclass(slots=True)
class GoalState:
    """A goal: parameters of its task and the progress made.

    ``x``, ``y``, ``radius`` are the area or point of the task, ``distance`` is the fixed distance
    or the clearance to keep. Members, hazards and waypoints are ranges of lists in ``State``; a
    hazard is an obstacle's index. ``memory`` are numbers, 0 at the start, that user-defined regions
    can store.
    """

    task: int
    x: float
    y: float
    radius: float
    first_member: int
    n_members: int
    first_hazard: int
    n_hazards: int
    first_waypoint: int
    n_waypoints: int
    sensor: int
    target: int
    tolerance: float
    distance: float
    period: int
    deadline: int
    count: int = 0
    seen: int = 0
    sampled_x: float = 0.0
    sampled_y: float = 0.0
    memory: MutableSequence[float] = field(default_factory=no_memory)


@dataclass(slots=True)
class MemberState:
    """A robot as member of a goal, and its own progress.

    ``since`` is the tick at which it was last inside the goal's area (-1: not yet),
    ``reached`` whether it has been there (0 or 1), ``waypoint`` the next point to head for, or the
    next area of its route.
    """

    robot: int
    since: int = -1
    reached: int = 0
    waypoint: int = 0


@dataclass(frozen=True, slots=True)
class AreaState:
    """An area of a goal or an obstacle; of a point, the tolerance is the radius.

    A polygon has ``n_corners`` corners in ``State.corners``, as offsets from its centre, which is
    ``depth`` inside. Its radius is the distance of the farthest corner. A disc has none.
    """

    x: float
    y: float
    radius: float
    first_corner: int
    n_corners: int
    depth: float


@dataclass(frozen=True, slots=True)
class RouteState:
    """The areas that a member of a goal is to be in: ``n_areas`` from ``first_area`` on."""

    first_area: int
    n_areas: int


@dataclass(slots=True)
class GraceState:
    """The grace of a goal: for how many ticks in a row its rule may be broken, and has been so far.

    ``first`` is the place in ``State.latest`` of its margins of the last ``n_ticks`` + 1 ticks; -1
    if they are not needed.
    """

    n_ticks: int
    first: int
    n_broken: int = 0


@dataclass(slots=True)
class PointState:
    """A point of a trajectory."""

    x: float
    y: float


@dataclass(frozen=True, slots=True)
class DirectionState:
    """A unit vector."""

    x: float
    y: float


@dataclass(slots=True)
class CommandState:
    """The last command of a robot: a unit heading and a speed.

    ``sent_speed`` is the speed sent to the robot, which a fault may have forged.
    ``heading_claimed`` and ``speed_claimed`` are 1 if a goal commanded them in this tick.
    """

    heading_x: float
    heading_y: float
    speed: float
    sent_speed: float
    heading_claimed: int
    speed_claimed: int


@dataclass(slots=True)
class WishState:
    """When a robot evaded last, and the heading that a later goal was denied then; 0, 0 if none."""

    tick: int = -2
    x: float = 0.0
    y: float = 0.0


@dataclass(slots=True)
class SwitchState:
    """The last command of a sensor (0 or 1), and whether a goal gave it in this tick."""

    active: int
    claimed: int


@dataclass(slots=True)
class HeardState:
    """What was last heard of an element, as ``mrsfi_runtime.monitors`` keeps it for regions.

    It is the belief of the last tick, before the first one that of the model. ``in_a_row`` are
    for how many ticks something that a region counts has been so, ``alarm`` for how many ticks an
    alarm about the robot lasts.
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    speed: float = 0.0
    energy: float = 0.0
    count: int = 0
    alarm: int = 0
    in_a_row: MutableSequence[float] = field(default_factory=no_memory)


@dataclass(slots=True)
class MapState:
    """The map of ``kernel.neighbours``: its lower left corner, its resolution, and what is wrong.

    A cell lists the obstacles whose edge is within ``reach`` of it along both axes.
    ``is_wrong`` is 1 if the believed position of an obstacle may differ from the model's; code
    that moves an obstacle must set it. ``was_wrong`` is 1 if it was so a tick ago. ``displaced`` is
    the last tick at which a robot's position may be false in belief, or may have jumped since the
    tick before, ``misled`` that at which another property may be; in truth none is.
    """

    x: float
    y: float
    cells_per_unit: float
    reach: float
    is_wrong: int
    was_wrong: int = 0
    displaced: int = -1
    misled: int = -1


@dataclass(frozen=True, slots=True)
class MappedState:
    """An obstacle listed in a map cell, and the least distance from the cell to its edge."""

    obstacle: int
    gap: float


@dataclass(slots=True)
class ChartedState:
    """A robot in the grid of ``kernel.neighbours``, with its position when it was sorted."""

    robot: int
    x: float
    y: float


@dataclass(slots=True)
class GapState:
    """The least gap, at most ``limit``, that the check of AvoidCollision found in a tick.

    It is the margin. Only of more than ``FEW`` members is it found so, and in truth: in belief,
    ``limit`` stays below 0, which asks for none.
    """

    limit: float = -1.0
    least: float = 0.0
    tick: int = -1


@dataclass(slots=True, kw_only=True)
class LookupState:
    """Scratch space for neighbour queries. Not part of the state: never recorded or hashed.

    It is valid for the members from ``first_member`` on. Each of them, except ``n_strays``
    ``strays``, is within ``slack`` along either axis of the position at which it was sorted.

    ``heads`` has the index in ``charted`` at which each bucket of the grid begins, ``buckets`` the
    bucket of each member. If ``is_listed``, the robots that may be within ``reach`` of a robot are
    ``n_listed`` entries of ``listed`` from ``first_listed`` on. ``asked`` is the reach of the last
    query, ``nearby`` its result.
    """

    first_member: int = -1
    reach: float = 0.0
    asked: float = 0.0
    slack: float = 0.0
    is_listed: int = 0
    n_strays: int = 0
    cells_per_unit: float = 1.0
    n_buckets: int
    stride: int
    heads: list[int]
    buckets: list[int]
    charted: list[ChartedState]
    nearby: list[int]
    strays: list[int]
    first_listed: list[int]
    n_listed: list[int]
    listed: list[int]


@dataclass(slots=True, kw_only=True)
class State:
    """The state of a world: the truth of the simulation, or the belief of the CI.

    Tuples are constant tables, the same in every state of a mission; digests and records leave
    them out. ``traits`` has one entry per robot, ``scopes`` and ``routes`` one per member, whose
    areas are in ``areas``; ``outlines`` has the area of each obstacle in the model. ``directions``
    are the unit vectors of whole degrees. ``required`` has for each goal how many members must keep
    to the rule of its task, ``apart`` the greatest distance of two centres at which robots can be
    too near for it, ``longest`` how far one of its members can have moved in a tick. ``cells`` has
    the index in ``mapped`` at which the obstacles of each map cell begin.

    The following change, but are never recorded or hashed: ``wakes`` has an entry per robot, then
    one per obstacle; ``wishes`` one per robot; ``grace``, empty unless a goal has some, one per
    goal, whose ``latest`` margins follow; ``aims``, empty unless a robot has noise, how many
    waypoints each member has surely passed; ``gaps`` has one per goal; ``calm``, empty unless its
    use is allowed, the tick before which no member of an AvoidCollision goal has to be looked at,
    or, negative, before which it stays awake; ``quiet`` likewise, for each goal the tick before
    which it is surely kept, and nothing has to react for it, unless the belief is misled;
    ``heard``, an entry per robot, sensor and obstacle, empty where no code of a team runs.
    ``lookup`` is scratch space.
    """

    mission: MissionState
    robots: list[RobotState] = field(default_factory=list)
    sensors: list[SensorState] = field(default_factory=list)
    obstacles: list[ObstacleState]
    goals: list[GoalState] = field(default_factory=list)
    members: list[MemberState] = field(default_factory=list)
    hazards: list[int] = field(default_factory=list)
    waypoints: list[PointState] = field(default_factory=list)
    traits: tuple[TraitState, ...]
    areas: tuple[AreaState, ...] = ()
    routes: tuple[RouteState, ...] = ()
    scopes: tuple[ScopeState, ...] = ()
    outlines: tuple[AreaState, ...] = ()
    corners: tuple[PointState, ...] = ()
    chances: tuple[int, ...] = ()
    directions: tuple[DirectionState, ...]
    required: tuple[int, ...] = ()
    apart: tuple[float, ...] = ()
    longest: tuple[float, ...] = ()
    commands: list[CommandState] = field(default_factory=list)
    switches: list[SwitchState] = field(default_factory=list)
    wakes: list[WakeState] = field(default_factory=list)
    wishes: list[WishState] = field(default_factory=list)
    map: MapState
    cells: tuple[int, ...]
    mapped: tuple[MappedState, ...]
    lookup: LookupState
    grace: list[GraceState] = field(default_factory=list)
    aims: list[int] = field(default_factory=list)
    latest: list[float] = field(default_factory=list)
    gaps: list[GapState] = field(default_factory=list)
    calm: list[int] = field(default_factory=list)
    quiet: list[int] = field(default_factory=list)
    heard: list[HeardState] = field(default_factory=list)


_HINTS = get_type_hints(State)
COLUMNS: Mapping[str, tuple[str, ...]] = {
    name: tuple(hint for hint in get_type_hints(get_args(_HINTS[name])[0]) if hint != "memory")
    for name in ("robots", "sensors", "obstacles", "goals", "members", "commands", "switches")
}
"""Columns of the lists of a state whose records change in a flight, list after list."""

PROPERTIES: Mapping[Field, tuple[str, tuple[str, ...]]] = {
    Field.POSITION: ("robots", ("x", "y", "z")),
    Field.SPEED: ("robots", ("speed",)),
    Field.ENERGY: ("robots", ("energy",)),
    Field.COUNT: ("sensors", ("count",)),
    Field.RATE: ("sensors", ("rate",)),
    Field.COST: ("sensors", ("cost",)),
    Field.OBSTACLE: ("obstacles", ("x", "y")),
}
"""List and columns of a state that hold each property of which the belief can differ."""


def state_bytes(state: State) -> bytes:
    """Return all that changes in a state as bytes: IEEE-754 doubles, record after record, −0 as 0.

    The memory of the goals comes last, unless it is all 0, as in missions that do not use it.
    Compiled flights are packed alike (``engine.compiled.layout.packed``).
    """
    values = [
        float(getattr(record, column)) + 0.0
        for name, columns in COLUMNS.items()
        for record in getattr(state, name)
        for column in columns
    ]
    memory = [number + 0.0 for goal in state.goals for number in goal.memory]
    if any(memory):
        values += memory
    return struct.pack(f"<{len(values)}d", *values)


TOLERANCE = 1e-9  # share of a limit, or of a distance unit, below which differences count as 0
RESERVE = 0.001  # share of a limit that reactions leave unused: of an area's radius, and of energy


@kernel
def excess(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, >= 0; negative if it falls short of it.

    It is 0 where the two differ by no more than ``TOLERANCE`` × limit.
    """
    difference = value - limit
    return 0.0 if abs(difference) <= TOLERANCE * limit else difference
