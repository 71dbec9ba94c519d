"""Effect audit: every fault of a pool alone, what it changed, and what became of each goal."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from mrsfi_runtime.analysis.other_values import N_STEPS, other_values
from mrsfi_runtime.analysis.reasons import Comparison, Differences, Twin, in_words, reason_of
from mrsfi_runtime.engine.flights import Engine, FailedFlight
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Fault, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import Target, describe, touched

COUNTS = ("believed", "true", "missed")
"""Counts of a goal in ticks; a fault that changes one of them changes the goal."""

Changed: TypeAlias = frozenset[int]
"""Goals, by index, that a fault changed."""


@dataclass(frozen=True, slots=True)
class OtherValues:
    """Values that a fault could have, and what these would change.

    Attributes
    ----------
    values
        By parameter.
    n_seeds
        By goal: of how many seeds they change it; goals that they change in none are left out.
    """

    values: dict[str, float]
    n_seeds: dict[str, int]


@dataclass(frozen=True, slots=True)
class AuditRow:
    """What one fault did alone.

    Attributes
    ----------
    fault
        The fault.
    touched
        Properties it touches, in words.
    outcome
        What the flight in the first seed found; ``applied`` and ``changed`` have one entry.
    n_seeds
        By goal: in how many seeds the fault changed it; goals that it never changed are left out.
    reason
        Why no goal changed in the first seed; empty where one did.
    reasons
        Why no goal changed, and in how many seeds that is why; the most frequent first.
    n_tried
        Where no goal changed in the first seed: how many other values were tried there.
    others
        For every goal the nearest of them that changed it there.
    """

    fault: Fault
    touched: tuple[str, ...]
    outcome: Outcome
    n_seeds: dict[str, int]
    reason: str = ""
    reasons: tuple[tuple[str, int], ...] = ()
    n_tried: int = 0
    others: tuple[OtherValues, ...] = ()


@dataclass(slots=True)
class _Seen:
    """What one fault alone did in seed after seed."""

    outcomes: list[Outcome] = field(default_factory=list)
    changed: list[Changed] = field(default_factory=list)
    silent: dict[int, Differences] = field(default_factory=dict)


def audit(
    engine: Engine, start: int, finish: int, n_seeds: int = 1, *, tries_values: bool = False
) -> tuple[AuditRow, ...]:
    """Fly every fault of the mission's pool alone over one window, with the pool's values.

    A fault changes a goal where one of its counts is other than in the flight without faults in
    the same seed. Where it changes none, both flights are compared tick by tick.

    Parameters
    ----------
    engine
        Evaluates; its own seed is the first.
    start, finish
        Window of every fault, in ticks.
    n_seeds
        Mission seeds in which every fault flies, one after the other.
    tries_values
        Whether to fly what changes no goal in the first seed with other values.
    """
    seeds = range(engine.seed, engine.seed + n_seeds)
    alone = [(TimedFault(fault.id, start, finish, fault.values),) for fault in engine.code.pool]
    seen = [_Seen() for _ in alone]
    for seed in seeds:
        _fly(engine, seed, alone, seen)
    return tuple(
        _row(engine, seeds, specification, of_fault, tries_values=tries_values)
        for specification, of_fault in zip(alone, seen, strict=True)
    )


def _fly(engine: Engine, seed: int, alone: Sequence[Specification], seen: Sequence[_Seen]) -> None:
    """Fly every fault alone in one seed, those that change nothing again beside the twin."""
    twin = Twin()
    without = engine.evaluate((), seed, observer=twin)
    for specification, of_fault, outcome in zip(
        alone, seen, _outcomes(engine, alone, seed), strict=True
    ):
        of_fault.outcomes.append(outcome)
        of_fault.changed.append(_changed(without, outcome))
        if not of_fault.changed[-1]:
            comparison = Comparison(twin)
            engine.evaluate(specification, seed, observer=comparison)
            n_targets = len(_targets(engine, specification))
            found = comparison.differences(n_targets, outcome.applied[0])
            of_fault.silent[seed] = found


def _outcomes(
    engine: Engine, specifications: Sequence[Specification], seed: int
) -> Iterator[Outcome]:
    """Yield outcomes; what fails is flown again, to fail here."""
    found = engine.evaluate_many(specifications, seed)
    for specification, outcome in zip(specifications, found, strict=True):
        yield engine.evaluate(specification, seed) if isinstance(outcome, FailedFlight) else outcome


def _changed(without: Outcome, outcome: Outcome) -> Changed:
    before, after = (
        zip(*(getattr(each, name) for name in COUNTS), strict=True) for each in (without, outcome)
    )
    pairs = zip(before, after, strict=True)
    return frozenset(goal for goal, (count, other) in enumerate(pairs) if count != other)


def _targets(engine: Engine, specification: Specification) -> tuple[Target, ...]:
    return touched(engine.code.mission, engine.code.pool[specification[0].fault])


def _row(
    engine: Engine,
    seeds: range,
    specification: Specification,
    seen: _Seen,
    *,
    tries_values: bool,
) -> AuditRow:
    mission = engine.code.mission
    kinds: dict[str, list[Differences]] = defaultdict(list)
    for found in seen.silent.values():
        kinds[reason_of(found)].append(found)
    is_silent = seeds[0] in seen.silent
    tries = is_silent and tries_values
    tried = _tried(engine, seeds[0], specification[0]) if tries else []
    return AuditRow(
        fault=engine.code.pool[specification[0].fault],
        touched=tuple(describe(mission, target) for target in _targets(engine, specification)),
        outcome=seen.outcomes[0],
        n_seeds=_n_seeds(mission, seen.changed),
        reason=in_words(mission, [seen.silent[seeds[0]]]) if is_silent else "",
        reasons=tuple(
            (in_words(mission, flights), len(flights))
            for flights in sorted(kinds.values(), key=len, reverse=True)
        ),
        n_tried=len(tried),
        others=_others(engine, seeds, tried) if tried else (),
    )


def _n_seeds(mission: Mission, changed: Iterable[Changed]) -> dict[str, int]:
    listed = list(changed)
    counts = (sum(goal in goals for goals in listed) for goal in range(len(mission.goals)))
    return {goal: n for goal, n in zip(mission.goal_ids, counts, strict=True) if n}


def _tried(engine: Engine, seed: int, timed: TimedFault) -> list[Specification]:
    """Return a fault with other values, those nearest to the pool's first."""
    mission, fault = engine.code.mission, engine.code.pool[timed.fault]
    paths = _paths(engine, seed, timed) if fault.kind.is_place else ()
    return [(timed._replace(values=values),) for values in other_values(mission, fault, paths)]


def _others(
    engine: Engine, seeds: range, tried: Sequence[Specification]
) -> tuple[OtherValues, ...]:
    """Return for every goal the nearest values that change it in the first seed."""
    mission = engine.code.mission
    without = {seed: engine.evaluate((), seed) for seed in seeds}
    nearest: dict[int, Specification] = {}
    for specification, outcome in zip(tried, _outcomes(engine, tried, seeds[0]), strict=True):
        for goal in _changed(without[seeds[0]], outcome):
            nearest.setdefault(goal, specification)
    found = []
    for specification in dict.fromkeys(nearest.values()):
        changed = [_changed(without[seed], engine.evaluate(specification, seed)) for seed in seeds]
        (timed,) = specification
        values = engine.code.pool[timed.fault].kind.named(timed.values)
        found.append(OtherValues(values, _n_seeds(mission, changed)))
    return tuple(found)


def _paths(engine: Engine, seed: int, timed: TimedFault) -> list[tuple[float, float]]:
    """Return where robots are without faults, at equal steps of a fault's window."""
    last = min(timed.finish, engine.code.mission.duration - 1) - timed.start
    ticks = {timed.start + last * step // N_STEPS for step in range(N_STEPS + 1)}
    places: list[tuple[float, float]] = []

    def watch(world: State, *_: object) -> None:
        if world.mission.tick in ticks:
            places.extend((robot.x, robot.y) for robot in world.robots)

    engine.evaluate((), seed, observer=watch)
    return places
