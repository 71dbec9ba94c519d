"""Trace how each fault of a cause set leads to broken goals.

A flight is compared with its twin without one fault. Both have the same mission seed, so every
difference comes from that fault. A ``Chain`` has the first differences in belief, commands, truth
and verdicts.

``chain`` compares two recordings and ``sentence`` describes the result. ``find_cause`` joins cause
set, chains and counts in several mission seeds.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from operator import itemgetter
from statistics import median
from typing import Any, NamedTuple, TypeAlias

from mrsfi_runtime.causes import cause_set
from mrsfi_runtime.causes.cause_set import Column, Counts, Flights, Places, Question
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Part, Record, Recording, Records
from mrsfi_runtime.model.fault_types import Field, Mode, Struck
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Mission, Outcome, with_id
from mrsfi_runtime.record.observers import NamedFault
from mrsfi_runtime.record.settings import following

POSITION, HEADING, PROGRESS, MEMORY = "position", "heading", "progress", "memory"

Quantities: TypeAlias = Mapping[str, tuple[str, ...]]
"""Fields of a record by the quantity that they form."""

KNOWN: Mapping[str, Quantities] = {
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
"""Quantities of a true or local state, by the list whose records have them."""


class Change(NamedTuple):
    """A quantity of a robot, sensor, obstacle or goal: its value with the fault, and without.

    Positions are in distance units, headings in degrees, activation is 0 or 1, ``memory[k]`` is a
    number in a goal's memory.
    """

    owner: str
    quantity: str
    found: tuple[float, ...]
    otherwise: tuple[float, ...]

    @property
    def size(self) -> float:
        """Distance of both values, in the quantity's unit; of headings at most 180."""
        if self.quantity == HEADING:
            turned = abs(self.found[0] - self.otherwise[0])
            return min(turned, 360.0 - turned)
        return math.dist(self.found, self.otherwise)


class First(NamedTuple):
    """The first tick with a difference, and all differences at it."""

    tick: int
    changes: tuple[Change, ...]


class FirstVerdict(NamedTuple):
    """The first tick at which a verdict differs, and the verdict with the fault."""

    tick: int
    is_so: bool


class FirstVerdicts(NamedTuple):
    """The first differences of the verdicts on a goal; ``None`` for no difference."""

    goal: str
    believed: FirstVerdict | None
    true: FirstVerdict | None
    missed: FirstVerdict | None


@dataclass(frozen=True, slots=True)
class Chain:
    """The first differences in belief, commands, truth and verdicts; ``None`` for no difference."""

    belief: First | None
    command: First | None
    truth: First | None
    verdicts: tuple[FirstVerdicts, ...]


def chain_as_json(chain: Chain) -> dict[str, Any]:
    """Return a chain as plain values."""
    firsts = {"belief": chain.belief, "command": chain.command, "truth": chain.truth}
    return {
        **{
            name: first
            and {
                "tick": first.tick,
                "changes": [each._asdict() | {"size": each.size} for each in first.changes],
            }
            for name, first in firsts.items()
        },
        "verdicts": {
            each.goal: {
                name: verdict and verdict._asdict()
                for name, verdict in zip(each._fields[1:], each[1:], strict=True)
            }
            for each in chain.verdicts
        },
    }


def chains(record: Record, mission: Mission, specification: Specification) -> tuple[Chain, ...]:
    """Return the chain of each fault: the whole specification against it without the fault."""
    whole = record(specification)
    twins = (record(cause_set.without(specification, place)) for place in range(len(specification)))
    return tuple(chain(mission, whole, twin) for twin in twins)


def chain(mission: Mission, flight: Recording, twin: Recording) -> Chain:
    """Return the first differences between a flight and its twin without one fault."""
    lists = ("robots", "sensors", "obstacles", "goals")
    owners = {name: [each.id for each in getattr(mission, name)] for name in lists}
    owners |= {"commands": owners["robots"], "switches": owners["sensors"]}
    owners["members"] = [goal.id for goal in mission.goals for _ in goal.terms.robots]
    truths, beliefs = ((flight[side], twin[side]) for side in ("world", "belief"))
    moved, switched = {HEADING: ("heading_x", "heading_y"), "speed": ("speed",)}, ("active",)
    sent = (
        (*truths, {"commands": moved}),
        (*beliefs, {"switches": {"activation": switched}}),
        (*truths, {"sensors": {"activation": switched}}),  # the only trace of a forged activation
    )
    return Chain(
        belief=_first(owners, (*beliefs, KNOWN)),
        command=_first(owners, *sent),
        truth=_first(owners, (*truths, KNOWN)),
        verdicts=tuple(_verdicts(mission, flight, twin)),
    )


def _verdicts(mission: Mission, flight: Recording, twin: Recording) -> Iterator[FirstVerdicts]:
    def first(name: str, g: int) -> FirstVerdict | None:
        found, otherwise = (recording[name][:, g] > 0 for recording in (flight, twin))
        tick = _first_tick(found, otherwise)
        return None if tick is None else FirstVerdict(tick, bool(found[tick]))

    for g, goal in enumerate(mission.goal_ids):
        judged = [first(name, g) for name in ("is_believed", "is_true", "missed")]
        if any(judged):
            yield FirstVerdicts(goal, *judged)


def _first_tick(found: Records, otherwise: Records) -> int | None:
    differs = found != otherwise
    if not differs.any():
        return None
    return int(differs.reshape(len(differs), -1).any(axis=1).argmax())


def _first(
    owners: Mapping[str, Sequence[str]], *compared: tuple[Part, Part, Mapping[str, Quantities]]
) -> First | None:
    """Return the first differences of quantities, in parts of both flights."""
    pairs = [
        (name, quantities, found[name], otherwise[name])
        for found, otherwise, lists in compared
        for name, quantities in lists.items()
    ]
    first: int | None = None
    for _, quantities, found, otherwise in pairs:
        for field in (each for fields in quantities.values() for each in fields):
            tick = _first_tick(found[field][:first], otherwise[field][:first])
            first = first if tick is None else tick
    if first is None:
        return None
    changes = (
        change
        for name, quantities, found, otherwise in pairs
        for change in _changes(owners[name], quantities, found[first], otherwise[first])
    )
    return First(first, tuple(dict.fromkeys(changes)))


def _changes(
    owners: Sequence[str], quantities: Quantities, found: Records, otherwise: Records
) -> Iterator[Change]:
    for place, owner in enumerate(owners):
        for quantity, fields in quantities.items():
            of, without = (
                tuple(records[field][place].tolist() for field in fields)
                for records in (found, otherwise)
            )
            if quantity == MEMORY:
                for k, (one, other) in enumerate(zip(*of, *without, strict=True)):
                    if one != other:
                        yield Change(owner, f"{quantity}[{k}]", (one,), (other,))
            elif of != without:
                turned = map(_degrees, (of, without))
                yield Change(owner, quantity, *(turned if quantity == HEADING else (of, without)))


def _degrees(heading: tuple[float, ...]) -> tuple[float, ...]:
    x, y = heading
    return (math.degrees(math.atan2(y, x)) % 360.0,)


def sentence(mission: Mission, fault: NamedFault, chain: Chain) -> str:
    """Describe what a fault did, and the first differences in belief, commands, truth and goals."""
    parts = [words for _, words in _differences(mission, chain)]
    parts += [part for verdicts in chain.verdicts for part in _verdict(mission, verdicts)]
    waits = "" if fault.trigger is None else f", {fault.trigger.words}"
    window = f"from tick {fault.timed.start} to {fault.timed.finish}{waits}"
    done = f"{fault.name} ({fault.fault.type}) {_deed(mission, fault)} {window}"
    return ". ".join((done, *(parts or ["Nothing differs at any tick"]))) + "."


def _deed(mission: Mission, fault: NamedFault) -> str:
    kind = fault.fault.kind
    is_forged = {Field.MOTION, Field.ACTIVATION} & {*kind.properties}
    deed = "forged" if is_forged else "falsified"
    if kind.mode in {Mode.DELAY, Mode.BLOCK}:
        deed = "held back"
    return f"{deed} {struck(mission, fault)}"


def struck(mission: Mission, fault: NamedFault) -> str:
    """Return what a fault touches: ``the position of KAL (r3) in message m8``."""
    where = f" in message {fault.fault.target}" if fault.fault.kind.struck is Struck.MESSAGE else ""
    what = (_of(mission, *each.split(" ", 1)) for each in fault.touched)
    return f"{' and '.join(what) or 'nothing'}{where}"


def _of(mission: Mission, owner: str, quantity: str) -> str:
    """Return a quantity of a robot, sensor, obstacle or goal, with its owner's name and ID."""
    named: tuple[Any, ...] = (*mission.robots, *mission.sensors, *mission.goals)
    name = next((each.name for each in named if each.id == owner), "")
    return f"the {quantity} of {with_id(name, owner)}"


def effects(mission: Mission, chain: Chain) -> tuple[str, str]:
    """Return the first change of belief or commands in words, and the other changes, by tick.

    A text is empty if the fault caused no such change.
    """
    inside = _differences(mission, replace(chain, truth=None))
    local = min(inside, key=itemgetter(0), default=(0, ""))
    others = sorted(_differences(mission, chain), key=itemgetter(0))
    return local[1], ". ".join(words for tick, words in others if (tick, words) != local)


def _differences(mission: Mission, chain: Chain) -> Iterator[tuple[int, str]]:
    firsts = {"believed": chain.belief, "commanded": chain.command, "true": chain.truth}
    for side, first in firsts.items():
        if first is not None:
            yield first.tick, f"At tick {first.tick}, {changed(mission, first, side)}"


def changed(mission: Mission, first: First, side: str) -> str:
    """Return the first change: ``the true speed of KAL (r3) was 4 instead of 2``.

    Of several, it is the first in the order of robots, sensors, obstacles and goals. Values have
    four significant digits, counts all. If these show no difference, its size follows: ``the true
    heading of r2 was 90 degrees, which is 1e-14 off``.
    """
    change, units = first.changes[0], mission.units
    unit = {POSITION: units.distance, "energy": units.energy, HEADING: "degrees"}
    found, otherwise = (
        f"{_value(value)} {unit.get(change.quantity, '')}".rstrip()
        for value in (change.found, change.otherwise)
    )
    is_small = found == otherwise
    apart = f", which is {change.size:.2g} off" if is_small else f" instead of {otherwise}"
    return f"{_of(mission, change.owner, f'{side} {change.quantity}')} was {found}{apart}"


def _value(value: tuple[float, ...]) -> str:
    if len(value) == 1 and value[0] == int(value[0]):
        return f"{value[0]:.0f}"
    words = [f"{float(f'{each:.4g}'):.15g}" for each in value]
    return f"({', '.join(words)})" if len(words) > 1 else words[0]


def _verdict(mission: Mission, first: FirstVerdicts) -> Iterator[str]:
    goal = mission.label_of(first.goal)
    words = (
        ("was violated in belief", "was violated in belief only without this fault"),
        ("was truly violated", "was truly violated only without this fault"),
        ("failed", "had failed only without this fault"),
    )
    by_tick: dict[int, list[str]] = {}
    for (so, not_so), verdict in zip(words, first[1:], strict=True):
        if verdict is not None:
            by_tick.setdefault(verdict.tick, []).append(so if verdict.is_so else not_so)
    for tick in sorted(by_tick):
        yield f"At tick {tick}, {goal} {' and '.join(by_tick[tick])}"


N_SEEDS = 20
"""Mission seeds in which a cause set is flown, the campaign's first among them."""


class Robustness(NamedTuple):
    """A count in several mission seeds, and the number of seeds in which it is above 0."""

    median: float
    least: int
    most: int
    n_violated: int


@dataclass(frozen=True, slots=True)
class Cause:
    """The cause of a specification's violations.

    ``places`` are the cause set: the faults without which the violations would not occur.
    ``counts`` are under all faults, ``fault_free`` under none, ``kept`` under the set, all by
    ``columns``. ``outcome`` and ``chains`` are of the set in the first mission seed,
    ``robustness`` is of the set in ``N_SEEDS`` mission seeds.
    """

    specification: Specification
    columns: tuple[Column, ...]
    counts: Counts
    fault_free: Counts
    places: Places
    kept: Counts
    outcome: Outcome
    chains: tuple[Chain, ...]
    robustness: tuple[Robustness, ...]

    @property
    def faults(self) -> Specification:
        """The cause set as a specification."""
        return cause_set.chosen(self.specification, self.places)

    def sentences(self, mission: Mission, faults: Sequence[NamedFault]) -> tuple[str, ...]:
        """Return what each fault of the set did, in words; ``faults`` are the specification's."""
        chains = zip(self.places, self.chains, strict=True)
        return tuple(sentence(mission, faults[place], chain) for place, chain in chains)


def find_cause(
    flights: Flights, engine: Engine, specification: Specification, keep: float
) -> Cause | None:
    """Find the cause of a specification's violations; ``None`` if there are none.

    The engine records flights in the first mission seed. A cause set keeps a share of every count,
    above 0, at most 1. Code of the mission that fails is an ``EvaluationError``.
    """
    with flights.on(cause_set.ALL_OR_NONE):
        counts, fault_free = flights.counts(specification), flights.counts(())
    if not any(counts):
        return None
    with flights.on("cause set"):
        least = cause_set.floor(counts, keep, range(len(counts)))
        places = Question(flights, specification, least).minimum()
        cause = cause_set.chosen(specification, places)
    with flights.on("chains"):
        flights.spend(len(cause) + 1 if cause else 0)
        record = partial(engine.record, seed=flights.mission_seeds[0])
        linked = chains(record, engine.code.mission, cause) if cause else ()
    with flights.on("other mission seeds"):
        seeds = following(flights.mission_seeds[0], N_SEEDS)
        firm = robustness([flights.counts(cause, seed) for seed in seeds])
    return Cause(
        specification=specification,
        columns=flights.columns,
        counts=counts,
        fault_free=fault_free,
        places=places,
        kept=flights.counts(cause),
        outcome=flights.outcome(cause),
        chains=linked,
        robustness=firm,
    )


def robustness(by_seed: Sequence[Counts]) -> tuple[Robustness, ...]:
    """Return the robustness of each column, from counts by mission seed."""
    return tuple(
        Robustness(median(counts), min(counts), max(counts), sum(map(bool, counts)))
        for counts in zip(*by_seed, strict=True)
    )
