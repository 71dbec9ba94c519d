"""Find all minimal sets of faults that break goals: while searching, or after a search.

``Probing`` first flies each fault alone, in varied variants, because most weaknesses are one fault.
It then draws random specifications that contain no set known to break a column, and reduces those
that break it to a minimal set by ddmin. In a set of several faults it then replaces each by other
faults of the same robot or element, because such sets often break the goal, too. Each flight is
judged for all goals. The number of workers does not change what is found, because a turn asks for
as many flights as there are columns.

``Cover`` is a search algorithm made of that. ``harvest`` does it after any other search: it
first reduces evaluations of the search that break an unexplained column, repeats in more
mission seeds what it found, and shrinks the smallest set of each goal to its mildest variant.
The store records each flight, so an interrupted harvest flies only what is missing.
"""

import json
import math
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import islice
from random import Random
from typing import TYPE_CHECKING, NamedTuple, Self, TypeAlias

from mrsfi_runtime.causes import consequences, weakness
from mrsfi_runtime.causes.cause_set import Column, EvaluateIn, Prober, reduction
from mrsfi_runtime.causes.confirmation import Confirmation, confirmations
from mrsfi_runtime.causes.mildest import N_SEEDS as N_MILD
from mrsfi_runtime.causes.mildest import GoalWeakness, Mildest, goal_weaknesses, least, mildest
from mrsfi_runtime.causes.weakness import (
    MEASURES,
    Broken,
    FaultSet,
    Known,
    Weakness,
    Yardstick,
    faults_of,
)
from mrsfi_runtime.engine.recording import RecordMany
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, Margin, Mission, Outcome
from mrsfi_runtime.record import database
from mrsfi_runtime.record.settings import COVERING, CampaignSettings, following
from mrsfi_runtime.record.store import CampaignStore, RecordedFlight
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.space import SearchSpace, varied_fault, varied_specification

if TYPE_CHECKING:
    from mrsfi_runtime.search.loop import GenerationSummary

N_ALONE = 10
"""Variants in which each fault is flown alone before several are flown together."""

N_FEW = 5
"""The same, if none of them breaks anything."""

_N_TRIES = 100  # draws of known specifications until there seem to be no new ones


class Probing:
    """Proposes flights, turn by turn, and learns what they break.

    Each of the first ``n_alone`` turns has every fault alone, in a new variant; there are at most
    ``N_FEW`` if none breaks anything. Later turns have one specification for each column, and half
    as many faults alone, an eighth as long as none breaks anything. A specification is random or
    ``given``, of at most ``n_faults`` faults; or it leads from a set that was found to another one.
    ``Known.unexplained`` may give them: what was flown for one column often breaks another, too.
    """

    def __init__(
        self,
        space: SearchSpace,
        known: Known,
        n_faults: int,
        rng: Random,
        n_alone: int = N_ALONE,
        given: Callable[[Column], Specification | None] = lambda _: None,
    ) -> None:
        self._space = space
        self._known = known
        self._n_faults = n_faults
        self._given = given
        self._rng = rng
        self._n_first = n_alone
        self._n_turns = 0
        self._probes = {column: self._probe(column) for column in known.sets}
        self._wishes: dict[Column, Specification] = {}
        self._alone = self._faults_in_turn()

    def turn(self) -> list[Specification]:
        """Return the specifications to fly next; none if no new ones could be drawn."""
        for _ in range(self._n_first + 1):
            self._n_turns += 1
            if new := {weakness.form(each): each for each in self._wanted()}:
                return [*new.values()]
        return []

    def _wanted(self) -> Iterator[Specification]:
        wishes: list[Specification] = []
        n_alone = len(self._space.candidates)
        n_first = min(N_FEW, self._n_first) if self._known.is_harmless else self._n_first
        if self._n_turns > n_first:
            wishes = [wish for column in self._probes if (wish := self._wish(column))]
            n_alone = self._known.n_alone
        wanted = (*wishes, *(next(self._alone) for _ in range(n_alone)))
        return (each for each in wanted if weakness.form(each) not in self._known.flown)

    def _faults_in_turn(self) -> Iterator[Specification]:
        whole = [(0, self._space.duration - 1)]
        while True:
            for fault in self._space.candidates:
                for _ in range(_N_TRIES):
                    timed = (varied_fault(self._space, fault, whole, self._rng),)
                    if timed not in self._known.flown:
                        break
                yield timed

    def _wish(self, column: Column) -> Specification | None:
        """Return the specification that one column needs; ``None`` if all its draws are known."""
        probe = self._probes[column]
        wish = self._wishes.get(column)
        for _ in range(_N_TRIES):
            if wish is None:
                wish = next(probe)
            elif weakness.form(wish) in self._known.flown:
                wish = probe.send(self._known.flown[weakness.form(wish)])
            if wish and weakness.form(wish) not in self._known.flown:
                self._wishes[column] = wish
                return wish
        self._wishes[column] = wish or ()
        return None

    def _probe(self, column: Column) -> Generator[Specification, Broken, None]:
        def is_unknown(faults: FaultSet) -> bool:
            return not self._known.has_part_of(column, faults)

        space, most, rng = self._space, self._n_faults, self._rng
        while True:
            drawn = self._given(column) or varied_specification(space, most, rng, is_unknown)
            if column not in (yield drawn):
                self._known.n_kept[column] += 1
                continue
            found = deque((yield from self._reduced(column, drawn)))
            while found:
                found += yield from self._substituted(column, found.popleft())

    def _substituted(
        self, column: Column, minimal: Specification
    ) -> Generator[Specification, Broken, list[Specification]]:
        """Replace each fault of a minimal set by its kin, and return the minimal sets so found.

        A team that can do without one robot breaks when it loses two: any fault that loses the one
        with any that loses the other. So one set leads to the others.
        """
        found: list[Specification] = []
        n = len(faults_of(minimal))
        for timed in minimal if n > 1 else ():
            rest = tuple(each for each in minimal if each.fault != timed.fault)
            for kin in self._space.candidates[timed.fault].kin:
                faults, other = faults_of(rest) | {kin}, self._space.candidates[kin]
                if len(faults) < n or self._known.has_part_of(column, faults):
                    continue
                trigger = timed.trigger if timed.trigger in other.triggers else ""
                for values in other.landmarks:
                    new = timed._replace(fault=kin, values=values, trigger=trigger)
                    if any(self._space.clash(new, each) for each in rest):
                        break
                    tried = self._space.ordered((*rest, new))
                    if column in (yield tried):
                        found += yield from self._reduced(column, tried)
                        break
        return found

    def _reduced(
        self, column: Column, broken: Specification
    ) -> Generator[Specification, Broken, list[Specification]]:
        """Return what is minimal of a specification that breaks a column; none if known."""
        faults = tuple(dict.fromkeys(timed.fault for timed in broken))
        trials = reduction(tuple(range(len(faults))))
        trial = next(trials)
        left = frozenset(faults)
        while not self._known.has_part_of(column, left):
            kept = frozenset(faults[place] for place in trial)
            is_broken = column in (yield tuple(each for each in broken if each.fault in kept))
            left = kept if is_broken else left
            try:
                trial = trials.send(is_broken)
            except StopIteration:
                self._known.add(column, left)
                return [tuple(each for each in broken if each.fault in left)]
        return []


class Cover:
    """The search algorithm of the module; ``known`` has its results.

    It ends after the evaluations that the settings allow, when all bounds are as low as they
    require, or when no new specification could be drawn.
    """

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self._space = space
        self._most, self._until = settings.evaluations, settings.until
        self._rng = Random(settings.seed)
        self.known = Known(space, ends_by_bounds=settings.until is not None)
        self._probing = Probing(
            space, self.known, settings.faults, self._rng, given=self.known.unexplained
        )
        self._yardstick: Yardstick | None = None
        self._n_asked = 0
        self._n_generations = 0
        self._next: list[Specification] = [(), *self._probing.turn()][: self._most]

    @property
    def is_finished(self) -> bool:
        """Whether the search has ended."""
        return not self._next

    def ask(self) -> list[Specification]:
        """Return the specifications of the next turn."""
        return self._next

    def tell(self, scores: Sequence[Score]) -> "GenerationSummary":
        """Learn what the specifications break, and end the turn."""
        from mrsfi_runtime.search.loop import GenerationSummary  # noqa: PLC0415 - brings DEAP

        for specification, score in zip(self._next, scores, strict=True):
            if not specification and score.outcome is not None:
                self._yardstick = Yardstick.of(self._space.gate.mission, score.outcome)
            broken = self._yardstick.broken(score.outcome) if self._yardstick else frozenset()
            self.known.learn(specification, broken)
        first, self._n_asked = self._n_asked, self._n_asked + len(scores)
        fitness = [score.fitness for score in scores]
        self._n_generations += 1
        left = None if self._most is None else self._most - self._n_asked
        turn = self._probing.turn()[:left]
        bounds = map(self.known.bound, self.known.sets)
        self._next = [] if self._until is not None and max(bounds) <= self._until else turn
        population = range(first, self._n_asked)
        return GenerationSummary.of(self._n_generations - 1, len(scores), fitness, population)

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())


def covered(
    space: SearchSpace, settings: CampaignSettings, outcomes: Mapping[Specification, Outcome | None]
) -> Known:
    """Return the results of a search from recorded outcomes; ``None`` is a failed evaluation.

    The search may have ended within a turn.
    """
    search = Cover(space, settings)
    while not search.is_finished and all(each in outcomes for each in search.ask()):
        search.tell([Score(0.0, (), outcomes[each]) for each in search.ask()])
    return search.known


N_SEEDS = 5
"""Mission seeds, the campaign's first among them, in which a weakness is flown."""

MOST = 1000
"""Flights that a harvest takes at most, however many its search took."""

KEPT, ADVICE = "weaknesses", "monitors"
"""Keys under which a record keeps weaknesses, and the monitors to add."""

Progress: TypeAlias = Callable[[str, int, int, Known], None]
"""Receives a unit (flights, then bisections), how many are done, the most there can be, and
the knowledge so far."""

_N_EVALUATIONS = 20  # most evaluations to reduce of a column without weaknesses
_N_PAIR = 3  # flights in another seed for a pair: both faults, and each


class Nearest(NamedTuple):
    """The closest approach of a goal to a true violation, and its evaluation.

    ``margin`` is ``None`` if the goal was violated and has no margin.
    """

    margin: Margin | None
    evaluation: int

    @property
    def is_violated(self) -> bool:
        """Whether the goal was truly violated."""
        return self.margin is None or self.margin[0] < 0.0


@dataclass(frozen=True, slots=True)
class Harvest:
    """The weaknesses of a campaign, found in its first mission seed.

    ``n_flights`` were flown for ``weaknesses`` after the search; flights for ``mildest`` variants,
    of one weakness of each goal, are not counted. ``outcomes`` leaves out failed flights.
    ``yardstick`` is ``None`` before the flight without faults. ``nearest`` has the closest approach
    of each goal that no weakness truly breaks. ``elsewhere`` has the results of weaknesses in other
    worlds, by number; ``advice`` has the monitors to add, if they were sought.
    """

    known: Known
    weaknesses: tuple[Weakness, ...]
    n_flights: int
    outcomes: Mapping[Specification, Outcome]
    yardstick: Yardstick | None
    mildest: tuple[Mildest, ...] = ()
    nearest: Mapping[str, Nearest] = field(default_factory=dict)
    elsewhere: Mapping[int, tuple[Confirmation, ...]] = field(default_factory=dict)
    advice: consequences.Advice | None = None

    @property
    def goal_weaknesses(self) -> tuple[GoalWeakness, ...]:
        """The weaknesses by goal and set of faults, numbered."""
        found = goal_weaknesses(self.weaknesses, self.mildest)
        there, watched = self.elsewhere, self.advice.watched if self.advice else {}
        return tuple(
            replace(
                each,
                elsewhere=there.get(each.number, ()),
                monitored=watched.get(each.number),
            )
            for each in found
        )

    def with_seeds_of(self, found: Iterable[GoalWeakness]) -> Self:
        """Return it with weaknesses replaced by those that were flown in more mission seeds."""
        flown = {(one.column, one.faults): one for each in found for one in each.by}
        replaced = (flown.get((one.column, one.faults), one) for one in self.weaknesses)
        return replace(self, weaknesses=tuple(replaced))


def recorded_by(store: CampaignStore) -> frozenset[tuple[str, tuple[str, ...]]]:
    """Return goals and faults of the recorded weaknesses of a campaign, without its models."""
    kept = store.kept(KEPT, partial(_Kept.of, None))
    return frozenset((each.column.goal, each.faults) for each in (kept.weaknesses if kept else ()))


def known_by(space: SearchSpace, store: CampaignStore) -> Harvest | None:
    """Return the recorded weaknesses of a campaign; ``None`` before a finished harvest of it.

    A search by ``cover`` needs no harvest, but for other mission seeds.
    """
    found, flights = _known_by(space, store), store.flights_elsewhere()
    if found is None:
        return None
    results = confirmations(space, flights, found.goal_weaknesses) if flights else {}
    advice = store.kept(ADVICE, consequences.Advice.read)
    is_due = advice is not None and advice.n_evaluations == store.n_evaluations
    return replace(found, elsewhere=results, advice=advice if is_due else None)


def _known_by(space: SearchSpace, store: CampaignStore) -> Harvest | None:
    mission, seed = space.gate.mission, store.settings.mission_seed
    kept, flights = store.kept(KEPT, partial(_Kept.of, mission)), store.flights()
    if (
        kept is None
        or kept.n_evaluations != store.n_evaluations
        or len(flights) < max(kept.n_flights, 1)
    ):
        return _covered(space, store, flights) if store.settings.algorithm == COVERING else None
    outcomes: dict[Specification, Evaluated | None] = {**_searched(store)}
    outcomes |= {each.specification: each.found for each in flights if each.mission_seed == seed}
    until = store.settings.until
    known, flown = Known(space, ends_by_bounds=until is not None), _unfailed(outcomes)
    yardstick = Yardstick.of(mission, flown[()])
    for specification, outcome in outcomes.items():
        known.learn(specification, yardstick.broken(outcome))
    known.restore(kept.weaknesses, kept.counts)
    recorded = (*kept.weaknesses, *(each.weakness for each in kept.mildest))
    judged = iter(weakness.detected(mission, store, recorded, flights))
    found = tuple(islice(judged, len(kept.weaknesses)))
    mild = tuple(replace(each, weakness=next(judged)) for each in kept.mildest)
    near = _nearest(mission, store, found)
    return Harvest(known, found, kept.n_flights, flown, yardstick, mild, near)


def harvest(
    space: SearchSpace,
    store: CampaignStore,
    evaluate_many: EvaluateIn,
    record_many: RecordMany,
    on_progress: Progress = lambda *_: None,
) -> tuple[int, tuple[Weakness, ...]]:
    """Search for all weaknesses, and record each flight; return how many flew, and what was found.

    ``known_by`` reads all that is recorded of them. An interrupted harvest flies only what is
    missing. Code of the mission that fails without faults is an ``EvaluationError``.
    """
    before = known_by(space, store)
    if before is not None and before.n_flights:
        return before.n_flights, before.weaknesses
    mission, settings = space.gate.mission, store.settings
    prober, n_taken = _recorded(store, evaluate_many), 0
    most = min(MOST, store.n_evaluations * len(settings.mission_seeds))
    seeds = following(settings.mission_seed, N_SEEDS)

    def fly(specifications: Sequence[Specification], seed: int) -> Sequence[Evaluated]:
        nonlocal n_taken
        found = prober(specifications, seed)
        n_taken += len(specifications)
        on_progress("flights", n_taken, most, known)
        return found

    if before is not None:
        known, yardstick = before.known, before.yardstick
    else:
        known = Known(space)
        (fault_free,) = prober([()], seeds[0])
        n_taken += 1
        yardstick = weakness.yardstick_of(mission, fault_free, seeds[0])
        known.learn((), yardstick.broken(fault_free))
        probing = _probing(space, store, known, yardstick, most)
        while turn := _affordable(probing.turn(), known, most - n_taken, most):
            for each, flown in zip(turn, fly(turn, seeds[0]), strict=True):
                known.learn(each, yardstick.broken(flown))
    weaknesses = known.weaknesses()
    left = max(0, most - n_taken)
    n_others = min(N_SEEDS - 1, left // len(weakness.flown_with(weaknesses)))
    found = weakness.in_seeds(mission, weaknesses, fly, seeds[: 1 + n_others])
    if yardstick is not None:
        found = weakness.dated(yardstick, found, record_many)
    smallest = [each.shown for each in least(goal_weaknesses(found))]
    mild: tuple[Mildest, ...] = ()
    if smallest:
        mild = mildest(
            space,
            known,
            smallest,
            prober,
            record_many,
            seeds[:N_MILD],
            lambda n_done, n_all: on_progress("bisections", n_done, n_all, known),
        )
    to_protect = consequences.ladder(mission, space.gate.pool, goal_weaknesses(found))
    prober([rest for _, rest in consequences.closing(to_protect)], seeds[0])
    store.keep(KEPT, _Kept(store.n_evaluations, n_taken, known.counts, found, mild).text())
    return n_taken, found


class _Kept(NamedTuple):
    n_evaluations: int
    n_flights: int
    counts: Mapping[Column, tuple[int, int]]
    weaknesses: tuple[Weakness, ...]
    mildest: tuple[Mildest, ...]

    def text(self) -> str:
        return database.canonical(
            {
                "numbers": [self.n_evaluations, self.n_flights],
                "kept": [[*column, *counts] for column, counts in self.counts.items()],
                "weaknesses": [each.as_json() for each in self.weaknesses],
                "mildest": [each.as_json() for each in self.mildest],
            }
        )

    @classmethod
    def of(cls, mission: Mission | None, text: str) -> Self:
        """Return the content of a record; a ValueError or TypeError if it is invalid."""
        content = database.object_from_text(text)
        try:
            ((n_evaluations, n_flights),) = database.integers([content["numbers"]])
            rows = [(Column(*row[:2]), (*row[2:], 0)) for row in content["kept"]]
            counts = {column: (int(n), int(restarts)) for column, (n, restarts, *_) in rows}
            found = tuple(map(Weakness.from_json, content["weaknesses"]))
            mild = tuple(map(Mildest.from_json, content["mildest"]))
        except KeyError as error:
            raise ValueError(f"found {text[:60]}; expected the record of weaknesses") from error
        recorded = {*counts, *(each.column for each in found)}
        if mission and (unknown := recorded.difference(weakness.columns(mission))):
            raise ValueError(
                f"found a weakness of goal {min(unknown).goal!r}; expected a goal of the mission"
            )
        return cls(n_evaluations, n_flights, counts, found, mild)


def _searched(store: CampaignStore) -> dict[Specification, Outcome | None]:
    """Return the flights of a search by ``cover``; ``None`` stands for a failed one."""
    if store.settings.algorithm != COVERING:
        return {}
    failed: dict[Specification, Outcome | None] = {
        each.specification: None for each in store.failures()
    }
    return failed | {each.specification: each.outcome for each in store.evaluations()}


def _unfailed(flown: Mapping[Specification, Evaluated | None]) -> dict[Specification, Outcome]:
    return {each: outcome for each, outcome in flown.items() if isinstance(outcome, Outcome)}


def _covered(
    space: SearchSpace, store: CampaignStore, flights: Iterable[RecordedFlight]
) -> Harvest:
    store.require_repeatable()
    searched = _searched(store)
    known, flown = covered(space, store.settings, searched), _unfailed(searched)
    yardstick = Yardstick.of(space.gate.mission, flown[()]) if () in flown else None
    found = weakness.detected(space.gate.mission, store, known.weaknesses(), flights)
    nearest = _nearest(space.gate.mission, store, found)
    return Harvest(known, found, 0, flown, yardstick, nearest=nearest)


def _nearest(
    mission: Mission, store: CampaignStore, weaknesses: Sequence[Weakness]
) -> Mapping[str, Nearest]:
    """Return the closest approach, in the search, of goals that no weakness truly breaks."""
    broken = {each.column.goal for each in weaknesses if each.column.kind != MEASURES[0]}
    places = [place for place, goal in enumerate(mission.goal_ids) if goal not in broken]
    least, found = [math.inf] * len(mission.goal_ids), {}
    for evaluation, true, margins in store.margins() if places else ():
        for place in places:
            margin = margins[place]
            if margin and true[place] and not store.has_depths:
                margin = None
            left = margin[0] if margin else -math.inf if true[place] else math.inf
            if left < least[place]:
                least[place] = left
                found[mission.goal_ids[place]] = Nearest(margin, evaluation)
    return found


def _affordable(
    turn: Sequence[Specification], known: Known, left: int, most: int
) -> Sequence[Specification]:
    """Return the flights of a turn that may be next, if findings are to be flown in other seeds.

    These have half of all flights at most, because few flights should still find something.
    """
    reserved, n_others = most // 2, N_SEEDS - 1
    if left - reserved < N_SEEDS * len(turn):
        witnesses = weakness.flown_with(known.weaknesses(are_weighted=False))
        reserved = min(reserved, n_others * (len(witnesses) + _N_PAIR))
    return turn[: max(0, left - reserved) // N_SEEDS]


def _probing(
    space: SearchSpace, store: CampaignStore, known: Known, yardstick: Yardstick, most: int
) -> Probing:
    """Return what proposes flights, first those that explain columns without weaknesses.

    Flights of the harvest are explained only if no fault breaks a goal alone: else its few flights
    are worth more as random ones, which bound what is not found.
    """
    left = {column: deque[int](maxlen=_N_EVALUATIONS) for column in known.sets}
    for each in store.flown(1):
        for column in yardstick.broken(each.outcome):
            left[column].append(each.index)

    def unexplained(column: Column) -> Specification | None:
        if known.is_harmless and (flown := known.unexplained(column)):
            return flown
        if known.sets[column] or not left[column]:
            return None
        return store.evaluation(left[column].pop()).specification

    share = 0.4 * most / len(space.candidates)  # of the flights, for single faults
    n_alone, rng = min(N_ALONE, int(share)), Random(store.settings.seed)
    return Probing(space, known, store.settings.faults, rng, n_alone, unexplained)


def _recorded(store: CampaignStore, evaluate_many: EvaluateIn) -> Prober[Evaluated]:
    """Return a prober that records its flights, and knows the recorded ones."""

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
