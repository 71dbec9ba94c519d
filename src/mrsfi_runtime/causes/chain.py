"""How a fault comes to break a goal: the first differences that it makes, one after the other.

Both flights meet the same weather, so that every difference comes from the fault.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.causes.observed import KNOWN, SENT, Read, known, sent
from mrsfi_runtime.hosting.lockstep import Observer
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission

Observe: TypeAlias = Callable[[Specification, Observer], object]
"""Flies a specification while somebody looks on."""


class Change(NamedTuple):
    """A quantity that is another one.

    Attributes
    ----------
    owner
        ID of the robot, sensor, obstacle or goal that has it.
    quantity
        What it is; positions are in distance units, headings in degrees, activation is 0 or 1.
    found, otherwise
        With the fault, and without it.
    """

    owner: str
    quantity: str
    found: tuple[float, ...]
    otherwise: tuple[float, ...]

    @property
    def size(self) -> float:
        """How far both are apart, in the quantity's unit; headings at most 180."""
        if self.quantity == HEADING:
            turned = abs(self.found[0] - self.otherwise[0])
            return min(turned, 360.0 - turned)
        return math.dist(self.found, self.otherwise)


HEADING, POSITION, PROGRESS = "heading", "position", "progress"

_QUANTITIES = {
    "x": POSITION,
    "y": POSITION,
    "z": POSITION,
    "count": "samples",
    "active": "activation",
    "heading_x": HEADING,
    "heading_y": HEADING,
    "sent_speed": "speed",
}
"""By the field of a record; the others have the name of theirs."""


class First(NamedTuple):
    """The first tick at which something differs, and all that differs there."""

    tick: int
    changes: tuple[Change, ...]


class FirstVerdict(NamedTuple):
    """The first tick at which a verdict differs, and what it is there with the fault."""

    tick: int
    is_so: bool


class FirstVerdicts(NamedTuple):
    """The first verdicts on a goal that differ; ``None`` where none does.

    Attributes
    ----------
    goal
        ID of the goal.
    believed, true
        Whether it is violated.
    missed
        Whether it is certain to be missed.
    """

    goal: str
    believed: FirstVerdict | None
    true: FirstVerdict | None
    missed: FirstVerdict | None


@dataclass(frozen=True, slots=True)
class Chain:
    """The first differences that a fault makes; ``None`` where it makes none.

    Attributes
    ----------
    belief
        In what the collective intelligence believes.
    command
        In what is sent to the robots.
    truth
        In what robots and sensors do.
    verdicts
        In the verdicts on those goals on which any differs.
    """

    belief: First | None
    command: First | None
    truth: First | None
    verdicts: tuple[FirstVerdicts, ...]


class _Moment(NamedTuple):
    """A tick of a flight."""

    truth: Read
    belief: Read
    command: Read
    verdicts: tuple[tuple[int, ...], tuple[int, ...], tuple[bool, ...]]


@dataclass(slots=True)
class _Recording:
    """Observer that keeps what is compared of every tick."""

    moments: list[_Moment] = field(default_factory=list)

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        judged = (
            tuple(map(int, verdicts.is_believed)),
            tuple(map(int, verdicts.is_true)),
            tuple(ticks > 0 for ticks in verdicts.missed),
        )
        self.moments.append(_Moment(known(world), known(belief), sent(world, belief), judged))


def chains(observe: Observe, mission: Mission, specification: Specification) -> tuple[Chain, ...]:
    """Return the chain of each fault of a specification, against all of it but the fault.

    Parameters
    ----------
    observe
        Flies specifications of the mission, all in the same weather.
    mission, specification
        The mission, and the faults.
    """
    whole = _recorded(observe, specification)
    return tuple(
        _chain(mission, whole, _recorded(observe, without(specification, place)))
        for place in range(len(specification))
    )


def _recorded(observe: Observe, specification: Specification) -> list[_Moment]:
    recording = _Recording()
    observe(specification, recording)
    return recording.moments


def _chain(mission: Mission, flight: Sequence[_Moment], twin: Sequence[_Moment]) -> Chain:
    pairs = [*zip(flight, twin, strict=True)]
    names = _known_names(mission)
    verdicts = (
        FirstVerdicts(goal, *(_judged(pairs, kind, g) for kind in range(3)))
        for g, goal in enumerate(mission.goal_ids)
    )
    return Chain(
        belief=_first([(one.belief, other.belief) for one, other in pairs], names),
        command=_first(
            [(one.command, other.command) for one, other in pairs], _sent_names(mission)
        ),
        truth=_first([(one.truth, other.truth) for one, other in pairs], names),
        verdicts=tuple(each for each in verdicts if {*each[1:]} != {None}),
    )


def _judged(pairs: Sequence[tuple[_Moment, _Moment]], kind: int, goal: int) -> FirstVerdict | None:
    """Return where one of the three verdicts on a goal differs first."""
    verdicts = [(one.verdicts[kind][goal], other.verdicts[kind][goal]) for one, other in pairs]
    tick = _first_tick(verdicts)
    return None if tick is None else FirstVerdict(tick, bool(verdicts[tick][0]))


def _first_tick(pairs: Iterable[tuple[object, object]]) -> int | None:
    return next((tick for tick, (one, other) in enumerate(pairs) if one != other), None)


_Names: TypeAlias = list[tuple[str, tuple[str, ...]]]
"""Owner and fields of each record."""


def _known_names(mission: Mission) -> _Names:
    goals = [goal.id for goal in mission.goals]
    members = [goal.id for goal in mission.goals for _ in goal.members]
    robots, sensors, obstacles = (
        [each.id for each in some] for some in (mission.robots, mission.sensors, mission.obstacles)
    )
    owners = (robots, sensors, obstacles, goals, members)
    return [
        (owner, (PROGRESS,) * len(fields) if name in {"goals", "members"} else fields)
        for some, (name, fields) in zip(owners, KNOWN.items(), strict=True)
        for owner in some
    ]


def _sent_names(mission: Mission) -> _Names:
    commands = [(robot.id, SENT["commands"]) for robot in mission.robots]
    switches = [(sensor.id, SENT["switches"]) for sensor in mission.sensors]
    return [*commands, *switches, *switches]


def _first(pairs: Sequence[tuple[Read, Read]], names: _Names) -> First | None:
    tick = _first_tick(pairs)
    if tick is None:
        return None
    return First(tick, tuple(dict.fromkeys(_changes(*pairs[tick], names))))


def _changes(found: Read, otherwise: Read, names: _Names) -> Iterator[Change]:
    for (owner, fields), one, other in zip(names, found, otherwise, strict=True):
        by_quantity: dict[str, list[int]] = {}
        for k, name in enumerate(fields):
            by_quantity.setdefault(_QUANTITIES.get(name, name), []).append(k)
        for quantity, places in by_quantity.items():
            a, b = (tuple(each[k] for k in places) for each in (one, other))
            if a != b:
                if quantity == HEADING:
                    a, b = _degrees(a), _degrees(b)
                yield Change(owner, quantity, a, b)


def _degrees(heading: tuple[float, ...]) -> tuple[float, ...]:
    x, y = heading
    return (math.degrees(math.atan2(y, x)) % 360.0,)
