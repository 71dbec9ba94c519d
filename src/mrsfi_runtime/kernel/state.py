"""The state of a world, and the arithmetic that is allowed on it.

The simulation keeps one ``State``, the truth; the collective intelligence keeps another, its local
state or belief. Goal predicates read either. All records hold only integers and floats, and refer
to each other by index, so that compiled code can lay the same fields out in arrays.

Functions of the kernel are written once and run interpreted or compiled; ``kernel`` marks them. A
marked function, and all that it calls, keeps to the common subset: loops, comparisons,
``+ - * / // %``, ``min max abs round``, ``math.sqrt``, integer work, records with attributes,
other marked functions. No ``**`` on floats, no ``math.hypot``, no ``random``, no container built
on the way: those differ between the interpreter and a compiler, or do not compile at all.

No verdict depends on the last bit of a sum. Checks take what differs from a limit by less than a
billionth of it for equal (``excess``); reactions keep farther away from limits than that.

Begin with ``State``. ``COLUMNS`` names what changes in it, in the order of a digest and of a
recorded moment.
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


N_MEMORY = 8  # numbers that are remembered for whoever writes a region


def no_memory() -> MutableSequence[float]:
    """Return as many zeros."""
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
    """A robot: position, speed in units per tick, energy left; then what never changes.

    No command makes it faster than ``max_speed``. Its sensors are those from ``first_sensor`` on,
    ``n_sensors``; ``gps`` is its position sensor, or -1.
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
    """What else a robot is like: how far it turns in a tick, how far it misjudges its position.

    ``turn_x`` and ``turn_y`` are the direction to which it can turn from that of 0 degrees, to the
    left; ``turn_y`` is 0 if it turns at once. ``position_noise`` is a distance.
    """

    turn_x: float
    turn_y: float
    position_noise: float


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
    """An obstacle, where it is known to be, and where the model puts it."""

    x: float
    y: float
    radius: float
    model_x: float
    model_y: float


@dataclass(slots=True)
class GoalState:
    """A goal: parameters of its task and the progress made.

    ``x``, ``y``, ``radius`` are the area or point of the task. Members, hazards and
    waypoints are ranges of lists in ``State``; a hazard is an obstacle's index. ``memory`` are
    numbers, 0 at the start, for what a team's own regions have to remember.
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
    ``reached`` whether it has been there (0 or 1), ``waypoint`` the next point to head for.
    """

    robot: int
    since: int = -1
    reached: int = 0
    waypoint: int = 0


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
    """What a robot was last told: a unit heading and a speed.

    ``sent_speed`` is what left for the robot, which a fault may have forged. ``heading_claimed``
    and ``speed_claimed`` say whether a goal has spoken this tick.
    """

    heading_x: float
    heading_y: float
    speed: float
    sent_speed: float
    heading_claimed: int
    speed_claimed: int


@dataclass(slots=True)
class SwitchState:
    """What a sensor was last told (0 or 1), and whether a goal has spoken this tick."""

    active: int
    claimed: int


@dataclass(slots=True)
class MapState:
    """The map of ``kernel.neighbours``: its lower left corner, and how fine it is.

    A cell lists the obstacles whose edge is within ``reach`` of it along both axes.
    ``is_wrong`` is 1 while an obstacle may be believed elsewhere than where the model puts it;
    whoever moves an obstacle sets it.
    """

    x: float
    y: float
    cells_per_unit: float
    reach: float
    is_wrong: int


@dataclass(frozen=True, slots=True)
class MappedState:
    """An obstacle on a cell of the map, and how near to its edge a point of the cell can be."""

    obstacle: int
    gap: float


@dataclass(slots=True)
class ChartedState:
    """A robot in the grid of ``kernel.neighbours``, and where it was when it was sorted in."""

    robot: int
    x: float
    y: float


@dataclass(slots=True, kw_only=True)
class LookupState:
    """Room in which ``kernel.neighbours`` looks robots up; nothing in it is known.

    What is found there holds for the members from ``first_member`` on, as far as each but for
    ``n_strays`` ``strays`` is no more than ``slack`` along either axis from where it was sorted in.

    A grid, how fine, and its buckets: ``heads`` tells where each bucket's robots begin in
    ``charted``, ``buckets`` has that of each member. If ``is_listed``, the robots that may be
    within ``reach`` of a robot are ``n_listed`` in ``listed`` from ``first_listed`` on. ``asked``
    is the reach wanted last, ``nearby`` are the robots found last.
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
    """All that is known: by the simulation the truth, by the collective intelligence a belief.

    Tuples are tables that nobody writes to, the same in every state of a mission; digests and
    records leave them out. ``traits`` has one of each robot, ``directions`` are the unit vectors
    of whole degrees. ``cells`` tells where the obstacles of
    each cell of the map begin in ``mapped``. ``lookup`` is no knowledge: robots are found there.
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
    chances: tuple[int, ...] = ()
    directions: tuple[DirectionState, ...]
    commands: list[CommandState] = field(default_factory=list)
    switches: list[SwitchState] = field(default_factory=list)
    map: MapState
    cells: tuple[int, ...]
    mapped: tuple[MappedState, ...]
    lookup: LookupState


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
"""Where a state has what may be believed otherwise than it is: the list, and the columns there."""


def state_bytes(state: State) -> bytes:
    """Return all that changes in a state as bytes: IEEE-754 doubles, record after record, −0 as 0.

    Last comes what goals remember, unless it is all 0, as in missions that do without. Compiled
    flights are packed alike (``engine.compiled.layout.packed``).
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


TOLERANCE = 1e-9  # share of a limit, or of a distance unit, below which a difference is none
RESERVE = 0.001  # share of a limit that reactions leave unused: of an area's radius, and of energy


@kernel
def excess(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, >= 0; negative if it falls short of it.

    It is 0 where the two differ by no more than ``TOLERANCE`` × limit.
    """
    difference = value - limit
    return 0.0 if abs(difference) <= TOLERANCE * limit else difference
