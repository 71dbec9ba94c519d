"""How a fault comes to break a goal: the first differences that it makes, one after the other.

Both flights have the same mission seed, so that every difference comes from the fault.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

from mrsfi_runtime.causes.cause_set import without
from mrsfi_runtime.engine.recording import Part, Record, Recording, Records
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission

POSITION, HEADING, PROGRESS, MEMORY = "position", "heading", "progress", "memory"

Quantities: TypeAlias = Mapping[str, tuple[str, ...]]
"""Fields of a record, by what they say together."""

KNOWN: Mapping[str, Quantities] = MappingProxyType(
    {
        "robots": {POSITION: ("x", "y", "z"), "speed": ("speed",), "energy": ("energy",)},
        "sensors": {
            "samples": ("count",),
            "activation": ("active",),
            "rate": ("rate",),
            "cost": ("cost",),
        },
        "obstacles": {POSITION: ("x", "y")},
        "goals": {PROGRESS: ("count", "seen", "sampled_x", "sampled_y"), MEMORY: ("memory",)},
        "members": {PROGRESS: ("since", "reached", "waypoint")},
    }
)
"""Quantities of a true or local state, by the list whose records have them."""

SENT: Mapping[str, Quantities] = MappingProxyType(
    {
        "commands": {HEADING: ("heading_x", "heading_y"), "speed": ("sent_speed",)},
        "switches": {"activation": ("active",)},
    }
)
"""Those of the local state that say what was sent."""

FORGED: Mapping[str, Quantities] = MappingProxyType({"sensors": {"activation": ("active",)}})
"""Those of the true state that do: a forged activation shows in these only, a tick later."""


class Change(NamedTuple):
    """A quantity of a robot, sensor, obstacle or goal that differs, with the fault and without.

    Positions are in distance units, headings in degrees, activation is 0 or 1, ``memory[k]`` is a
    number that a goal remembers.
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

    Whether it is believed or truly violated, and whether it is certain to be missed.
    """

    goal: str
    believed: FirstVerdict | None
    true: FirstVerdict | None
    missed: FirstVerdict | None


@dataclass(frozen=True, slots=True)
class Chain:
    """The first differences that a fault makes; ``None`` where it makes none.

    In what is believed, in what is sent to the robots, in what robots and sensors do, and in the
    verdicts on those goals on which any differs.
    """

    belief: First | None
    command: First | None
    truth: First | None
    verdicts: tuple[FirstVerdicts, ...]


def chain_as_json(chain: Chain) -> dict[str, Any]:
    """Return a chain as plain values."""
    firsts = {"belief": chain.belief, "command": chain.command, "truth": chain.truth}
    return {
        **{
            name: None if first is None else _first_as_json(first) for name, first in firsts.items()
        },
        "verdicts": {
            each.goal: {
                name: None if verdict is None else verdict._asdict()
                for name, verdict in zip(each._fields[1:], each[1:], strict=True)
            }
            for each in chain.verdicts
        },
    }


def _first_as_json(first: First) -> dict[str, Any]:
    changes = [change._asdict() | {"size": change.size} for change in first.changes]
    return {"tick": first.tick, "changes": changes}


def chains(record: Record, mission: Mission, specification: Specification) -> tuple[Chain, ...]:
    """Return the chain of each fault of a specification, against all of it but the fault."""
    whole = record(specification)
    return tuple(
        chain(mission, whole, record(without(specification, place)))
        for place in range(len(specification))
    )


def chain(mission: Mission, flight: Recording, twin: Recording) -> Chain:
    """Return the first differences between a flight and that without one of its faults."""
    owners = _owners(mission)
    truths, beliefs = ((flight[side], twin[side]) for side in ("world", "belief"))
    return Chain(
        belief=_first(owners, _pairs(*beliefs, KNOWN)),
        command=_first(owners, _pairs(*beliefs, SENT) + _pairs(*truths, FORGED)),
        truth=_first(owners, _pairs(*truths, KNOWN)),
        verdicts=tuple(_verdicts(mission, flight, twin)),
    )


_JUDGED = ("is_believed", "is_true", "missed")
"""What is judged of a goal, in the order of ``FirstVerdicts``."""


def _verdicts(mission: Mission, flight: Recording, twin: Recording) -> Iterator[FirstVerdicts]:
    pairs = [(flight[name] > 0, twin[name] > 0) for name in _JUDGED]
    for g, goal in enumerate(mission.goal_ids):
        judged = [_judged(found[:, g], otherwise[:, g]) for found, otherwise in pairs]
        if any(judged):
            yield FirstVerdicts(goal, *judged)


def _judged(found: Records, otherwise: Records) -> FirstVerdict | None:
    """Return where a verdict differs first."""
    tick = _first_tick(found, otherwise)
    return None if tick is None else FirstVerdict(tick, bool(found[tick]))


def _first_tick(found: Records, otherwise: Records) -> int | None:
    """Return the first tick at which any value differs."""
    differs = found != otherwise
    if not differs.any():
        return None
    return int(differs.reshape(len(differs), -1).any(axis=1).argmax())


class _Pair(NamedTuple):
    """A list of records in both flights, shape ``(n_ticks, n_records)``, and what counts there."""

    name: str
    quantities: Quantities
    found: Part
    otherwise: Part


def _pairs(found: Part, otherwise: Part, lists: Mapping[str, Quantities]) -> list[_Pair]:
    return [
        _Pair(name, quantities, found[name], otherwise[name]) for name, quantities in lists.items()
    ]


def _owners(mission: Mission) -> Mapping[str, tuple[str, ...]]:
    """Return the IDs of those whose quantities are in each list."""
    robots, sensors, obstacles, goals = (
        tuple(each.id for each in some)
        for some in (mission.robots, mission.sensors, mission.obstacles, mission.goals)
    )
    return {
        "robots": robots,
        "sensors": sensors,
        "obstacles": obstacles,
        "goals": goals,
        "members": tuple(goal.id for goal in mission.goals for _ in goal.members),
        "commands": robots,
        "switches": sensors,
    }


def _first(owners: Mapping[str, tuple[str, ...]], pairs: Sequence[_Pair]) -> First | None:
    ticks = (
        _first_tick(pair.found[field], pair.otherwise[field])
        for pair in pairs
        for fields in pair.quantities.values()
        for field in fields
    )
    first = min((tick for tick in ticks if tick is not None), default=None)
    if first is None:
        return None
    changes = (change for pair in pairs for change in _changes(owners[pair.name], pair, first))
    return First(first, tuple(dict.fromkeys(changes)))


def _changes(owners: Sequence[str], pair: _Pair, tick: int) -> Iterator[Change]:
    read = {
        quantity: [_read(records[tick], fields) for records in (pair.found, pair.otherwise)]
        for quantity, fields in pair.quantities.items()
    }
    for place, owner in enumerate(owners):
        for quantity, (found, otherwise) in read.items():
            if found[place] != otherwise[place]:
                yield from _told(owner, quantity, found[place], otherwise[place])


def _read(records: Records, fields: Sequence[str]) -> list[tuple[Any, ...]]:
    """Return fields of each record as plain numbers."""
    return [*zip(*(records[field].tolist() for field in fields), strict=True)]


def _told(
    owner: str, quantity: str, found: tuple[Any, ...], otherwise: tuple[Any, ...]
) -> Iterator[Change]:
    if quantity == HEADING:
        yield Change(owner, quantity, _degrees(found), _degrees(otherwise))
    elif quantity == MEMORY:
        for place, (one, other) in enumerate(zip(*found, *otherwise, strict=True)):
            if one != other:
                yield Change(owner, f"{quantity}[{place}]", (one,), (other,))
    else:
        yield Change(owner, quantity, found, otherwise)


def _degrees(heading: tuple[float, ...]) -> tuple[float, ...]:
    x, y = heading
    return (math.degrees(math.atan2(y, x)) % 360.0,)
