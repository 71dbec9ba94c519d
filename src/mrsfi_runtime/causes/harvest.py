"""What a search has left unexplained: the flights after it that tell all the ways goals break.

The evaluations of a search show that goals break, under many faults at a time. So each fault is
flown alone, in varied forms; then random specifications are drawn and reduced, as by ``cover``. If
nothing is known to break a goal by a measure, and evaluations do, these are reduced first. What is
found is flown in more mission seeds; a search by ``cover`` has done all until here. The least that
breaks each goal is shrunk to its mildest form, which takes flights beyond those of the harvest.
"""

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from random import Random
from typing import NamedTuple, Self

from mrsfi_runtime.causes.counts import Column, EvaluateIn, Prober
from mrsfi_runtime.causes.mildest import N_SEEDS as N_MILD
from mrsfi_runtime.causes.mildest import Mildest, mildest
from mrsfi_runtime.causes.probing import N_ALONE, Probing
from mrsfi_runtime.causes.ways import Way, least, ways
from mrsfi_runtime.causes.weakness import (
    MEASURES,
    Known,
    Weakness,
    Yardstick,
    columns,
    dated,
    detected,
    flown_with,
    in_seeds,
    yardstick_of,
)
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, Margin, Mission, Outcome
from mrsfi_runtime.record import database
from mrsfi_runtime.record.settings import COVERING, following
from mrsfi_runtime.record.store import CampaignStore, RecordedFlight
from mrsfi_runtime.search.space import SearchSpace

N_SEEDS = 5
"""Mission seeds, the campaign's first among them, in which a weakness is looked at."""

MOST = 1000
"""Flights that a harvest takes at most, however many its search took."""

KEPT = "weaknesses"
"""Key of what a record keeps of weaknesses."""

_SHARE_ALONE = 0.4  # of the flights, at most, for what single faults do
_N_EVALUATIONS = 20  # that break a column, and are looked at if nothing else is known to
_N_PAIR = 3  # flights in another seed for a pair: both faults, and each


class Nearest(NamedTuple):
    """How near a goal ever came to being truly violated, and in which evaluation.

    A goal that was violated may have no margin: nothing then tells by how much.
    """

    margin: Margin | None
    evaluation: int


@dataclass(frozen=True, slots=True)
class Harvest:
    """What is known of a campaign, of its first mission seed.

    ``n_flights`` were taken for ``weaknesses`` after the search, beside those for the ``mildest``
    form of the least that breaks each goal. ``outcomes`` are of what did not fail; ``yardstick`` is
    ``None`` if nothing is known yet. ``nearest`` tells how near goals came that never truly broke.
    """

    known: Known
    weaknesses: tuple[Weakness, ...]
    n_flights: int
    outcomes: Mapping[Specification, Outcome]
    yardstick: Yardstick | None
    mildest: tuple[Mildest, ...] = ()
    nearest: Mapping[str, Nearest] = field(default_factory=dict)

    @property
    def ways(self) -> tuple[Way, ...]:
        """The weaknesses by goal and set of faults, numbered."""
        return ways(self.weaknesses, self.mildest)

    def with_seeds_of(self, found: Iterable[Way]) -> Self:
        """Return it with the weaknesses of some ways as these have them, in other mission seeds."""
        told = {(one.column, one.faults): one for way in found for one in way.by}
        some = (told.get((one.column, one.faults), one) for one in self.weaknesses)
        return replace(self, weaknesses=tuple(some))


def known_by(space: SearchSpace, store: CampaignStore) -> Harvest | None:
    """Return what a campaign knows already; ``None`` if nobody looked, or only at a part of it.

    One that covers knows all but other mission seeds by itself.
    """
    mission, seed = space.gate.mission, store.settings.mission_seed
    kept, flights = store.kept(KEPT, partial(_Kept.of, mission)), store.flights()
    if (
        kept is None
        or kept.n_evaluations != store.n_evaluations
        or len(flights) < max(kept.n_flights, 1)
    ):
        return _covered(space, store) if store.settings.algorithm == COVERING else None
    outcomes: dict[Specification, Evaluated | None] = {**_searched(store)}
    outcomes |= {each.specification: each.found for each in flights if each.mission_seed == seed}
    known, flown = Known(mission), _unfailed(outcomes)
    yardstick = Yardstick.of(mission, flown[()])
    for specification, outcome in outcomes.items():
        known.learn(specification, yardstick.broken(outcome))
    known.restore(kept.weaknesses, kept.n_kept)
    some = (*kept.weaknesses, *(each.weakness for each in kept.mildest))
    told = iter(detected(mission, store, some))
    found = tuple(islice(told, len(kept.weaknesses)))
    mild = tuple(replace(each, weakness=next(told)) for each in kept.mildest)
    near = _nearest(mission, store, found)
    return Harvest(known, found, kept.n_flights, flown, yardstick, mild, near)


def harvest(
    space: SearchSpace,
    store: CampaignStore,
    evaluate_many: EvaluateIn,
    record: Record,
    on_flown: Callable[[Known, int, int | None], None] = lambda *_: None,
) -> Harvest:
    """Find all the ways in which goals break, with flights that are recorded as they come.

    Of a campaign that was interrupted here, only what is missing is flown. ``on_flown`` is told
    what is known, how many flights were taken until now, and how many it may take, or ``None``
    for the mildest forms. If the mission's own code fails without faults, that is an
    ``EvaluationError``.
    """
    before = known_by(space, store)
    if before is not None and before.n_flights:
        return before
    mission, settings = space.gate.mission, store.settings
    prober, n_taken = _recorded(store, evaluate_many), 0
    most = min(MOST, store.n_evaluations * len(settings.mission_seeds))
    seeds = following(settings.mission_seed, N_SEEDS)

    def fly(
        specifications: Sequence[Specification], seed: int, limit: int | None = most
    ) -> Sequence[Evaluated]:
        nonlocal n_taken
        found = prober(specifications, seed)
        n_taken += len(specifications)
        on_flown(known, n_taken, limit)
        return found

    if before is not None:
        known, yardstick = before.known, before.yardstick
    else:
        known = Known(mission)
        (fault_free,) = prober([()], seeds[0])
        n_taken += 1
        yardstick = yardstick_of(mission, fault_free, seeds[0])
        known.learn((), yardstick.broken(fault_free))
        probing = _probing(space, store, known, yardstick, most)
        while turn := probing.turn()[: _affordable(known, most - n_taken)]:
            for each, flown in zip(turn, fly(turn, seeds[0]), strict=True):
                known.learn(each, yardstick.broken(flown))
    weaknesses = known.weaknesses()
    left = max(0, most - n_taken)
    n_others = min(N_SEEDS - 1, left // len(flown_with(weaknesses)))
    found = in_seeds(mission, weaknesses, fly, seeds[: 1 + n_others])
    if yardstick is not None:
        found = dated(yardstick, found, record)
    n_flights, some = n_taken, [way.shown for way in least(ways(found))]
    go_on = partial(fly, limit=None)
    mild = mildest(space, known, some, go_on, record, seeds[:N_MILD]) if some else ()
    store.keep(KEPT, _Kept(store.n_evaluations, n_flights, known.n_kept, found, mild).text())
    ended = known_by(space, store)
    assert ended is not None
    return ended


class _Kept(NamedTuple):
    n_evaluations: int
    n_flights: int
    n_kept: Mapping[Column, int]
    weaknesses: tuple[Weakness, ...]
    mildest: tuple[Mildest, ...]

    def text(self) -> str:
        return database.canonical(
            {
                "numbers": [self.n_evaluations, self.n_flights],
                "kept": [[*column, n_kept] for column, n_kept in self.n_kept.items()],
                "weaknesses": [each.as_json() for each in self.weaknesses],
                "mildest": [each.as_json() for each in self.mildest],
            }
        )

    @classmethod
    def of(cls, mission: Mission, text: str) -> Self:
        """Return what a record says; a ValueError or TypeError if it makes no sense."""
        content = database.object_from_text(text)
        try:
            ((n_evaluations, n_flights),) = database.integers([content["numbers"]])
            n_kept = {Column(goal, kind): int(n) for goal, kind, n in content["kept"]}
            found = tuple(map(Weakness.from_json, content["weaknesses"]))
            mild = tuple(map(Mildest.from_json, content["mildest"]))
        except KeyError as error:
            raise ValueError(f"found {text[:60]}; expected what is known of weaknesses") from error
        told = {*n_kept, *(each.column for each in found)}
        if unknown := told.difference(columns(mission)):
            raise ValueError(f"found what breaks {min(unknown)}; expected a goal of the mission")
        return cls(n_evaluations, n_flights, n_kept, found, mild)


def _searched(store: CampaignStore) -> dict[Specification, Outcome | None]:
    """Return what a search by ``cover`` has flown, with nothing for what failed."""
    if store.settings.algorithm != COVERING:
        return {}
    failed: dict[Specification, Outcome | None] = {
        each.specification: None for each in store.failures()
    }
    return failed | {each.specification: each.outcome for each in store.evaluations()}


def _unfailed(flown: Mapping[Specification, Evaluated | None]) -> dict[Specification, Outcome]:
    return {each: outcome for each, outcome in flown.items() if isinstance(outcome, Outcome)}


def _covered(space: SearchSpace, store: CampaignStore) -> Harvest:
    from mrsfi_runtime.causes.cover import covered  # noqa: PLC0415 - brings DEAP

    searched = _searched(store)
    known, flown = covered(space, store.settings, searched), _unfailed(searched)
    yardstick = Yardstick.of(space.gate.mission, flown[()]) if () in flown else None
    found = detected(space.gate.mission, store, known.weaknesses())
    told = _nearest(space.gate.mission, store, found)
    return Harvest(known, found, 0, flown, yardstick, nearest=told)


def _nearest(
    mission: Mission, store: CampaignStore, weaknesses: Sequence[Weakness]
) -> Mapping[str, Nearest]:
    """Return how near goals ever came that nothing truly breaks, in the search."""
    broken = {each.column.goal for each in weaknesses if each.column.kind != MEASURES[0]}
    places = [place for place, goal in enumerate(mission.goal_ids) if goal not in broken]
    least, found = [math.inf] * len(mission.goal_ids), {}
    for evaluation, true, margins in store.margins() if places else ():
        for place in places:
            margin = margins[place]
            left = margin[0] if margin else -math.inf if true[place] else math.inf
            if left < least[place]:
                least[place] = left
                found[mission.goal_ids[place]] = Nearest(margin, evaluation)
    return found


def _affordable(known: Known, left: int) -> int:
    """Return how many flights may be next: what they find is to be flown in other seeds, too."""
    n_others = N_SEEDS - 1
    spare = left - n_others * (len(flown_with(known.weaknesses())) + _N_PAIR)
    return max(0, spare) // N_SEEDS


def _probing(
    space: SearchSpace, store: CampaignStore, known: Known, yardstick: Yardstick, most: int
) -> Probing:
    """Return what asks for flights: first what explains a column of which nothing is known."""
    left = {column: deque[int](maxlen=_N_EVALUATIONS) for column in known.sets}
    for each in store.flown(1):
        for column in yardstick.broken(each.outcome):
            left[column].append(each.index)

    def unexplained(column: Column) -> Specification | None:
        if known.sets[column] or not left[column]:
            return None
        return store.evaluation(left[column].pop()).specification

    n_alone = max(1, min(N_ALONE, int(_SHARE_ALONE * most / len(space.candidates))))
    rng = Random(store.settings.seed)
    return Probing(space, known, store.settings.faults, rng, n_alone, unexplained)


def _recorded(store: CampaignStore, evaluate_many: EvaluateIn) -> Prober[Evaluated]:
    """Return what flies what is not recorded, and records it."""

    def fly(missing: Sequence[Specification], seed: int) -> list[Evaluated]:
        flown: list[RecordedFlight] = []
        try:
            for specification, found in zip(missing, evaluate_many(missing, seed), strict=True):
                flown.append(RecordedFlight(seed, specification, found))
        finally:  # also what came before an interrupt
            store.append_flights(flown)
        return [each.found for each in flown]

    prober = Prober[Evaluated](fly, lambda _, __, flown: flown)
    for each in store.flights():
        prober.known[each.specification, each.mission_seed] = each.found
    return prober
