"""Weaknesses: the minimal sets of a pool's faults that break a goal.

A goal is judged by three measures; one goal by one measure is a ``Column``. A flight *breaks* a
column if its count is above 0. If the flight without faults has a count, too, the flight's count
must exceed it by more than ``MARGIN`` of the mission's ticks. A set of faults is *minimal* if no
part of it is known to break the same column.

``Yardstick`` judges a flight. ``Known`` learns from flights and lists ``Weakness`` values. The
functions after it add mission seeds, first ticks and detection.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import reduce
from itertools import chain, combinations
from operator import and_, itemgetter
from typing import Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.causes.cause_set import Column, EvaluateIn, Prober
from mrsfi_runtime.engine.recording import Recording, RecordMany
from mrsfi_runtime.errors import EvaluationError, counted
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.model.fault_types import Units
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Evaluated, FailedFlight, Margin, Mission, Outcome
from mrsfi_runtime.record import database
from mrsfi_runtime.record.store import CampaignStore, RecordedFlight
from mrsfi_runtime.search.space import Draw, SearchSpace, drawn_as, draws

MEASURES = ("believed", "true", "missed")
"""Counts of an outcome that judge a goal; masked and phantom follow from two of them."""

MARGIN = 0.05
"""Share of a mission's ticks by which a count must exceed that of the flight without faults."""

DOUBT = 0.05
"""Chance that a bound does not hold."""

FaultSet: TypeAlias = frozenset[str]
"""IDs of faults of a pool."""

Broken: TypeAlias = frozenset[Column]
"""The columns that a flight breaks."""


def columns(mission: Mission) -> tuple[Column, ...]:
    """Return every goal of a mission by every measure, in model order."""
    return tuple(Column(goal, measure) for goal in mission.goal_ids for measure in MEASURES)


@dataclass(frozen=True, slots=True)
class Yardstick:
    """Judges flights in one mission seed, by the flight without faults.

    ``most`` has for each of the ``columns`` the count above which it is broken.
    """

    columns: tuple[Column, ...]
    most: tuple[float, ...]

    @classmethod
    def of(cls, mission: Mission, fault_free: Outcome) -> Self:
        """Return the yardstick that follows from the outcome without faults."""
        margin = MARGIN * mission.duration
        most = tuple(count + (margin if count else 0.0) for count in _counts(fault_free))
        return cls(columns(mission), most)

    def broken(self, flown: Evaluated | None) -> Broken:
        """Return the columns that a flight breaks; none if the evaluation ended with an error."""
        return frozenset(self.over(flown) if isinstance(flown, Outcome) else ())

    def over(self, counts: Outcome | Verdicts) -> Iterator[Column]:
        """Yield the columns that are broken by counts, also of a flight that has not ended."""
        judged = zip(self.columns, _counts(counts), self.most, strict=True)
        return (column for column, count, most in judged if count > most)

    def late(self, flown: Outcome) -> Iterator[tuple[str, float]]:
        """Yield the goals that a flight truly breaks, and by how many ticks detection is late."""
        truly = {goal for goal, kind in self.broken(flown) if kind != MEASURES[0]}
        goals = self.columns[:: len(MEASURES)]
        for (goal, _), (n_broken, n_late) in zip(goals, flown.detection or (), strict=False):
            if goal in truly:
                yield goal, n_late if n_late < n_broken else math.inf

    def since(self, flight: Recording) -> dict[Column, int]:
        """Return the tick from which on each broken column is broken."""
        found = {}
        for place, (column, most) in enumerate(zip(self.columns, self.most, strict=True)):
            is_over = flight[column.kind][:, place // len(MEASURES)] > most
            if is_over.any():
                found[column] = int(is_over.argmax())
        return found


def _counts(counts: Outcome | Verdicts) -> Iterator[int]:
    """Yield counts by column."""
    found = [getattr(counts, measure) for measure in MEASURES]
    return (count for goal in zip(*found, strict=True) for count in goal)


def faults_of(specification: Specification) -> FaultSet:
    """Return the pool faults that a specification has."""
    return frozenset(timed.fault for timed in specification)


def parts(specification: Specification) -> tuple[Specification, ...]:
    """Return the specification without each of its pool faults in turn."""
    faults = dict.fromkeys(timed.fault for timed in specification)
    return tuple(tuple(t for t in specification if t.fault != fault) for fault in faults)


def form(specification: Specification) -> Specification:
    """Return a specification in canonical order: equal timed faults give equal results."""
    return tuple(sorted(specification))


_Z = 2.58  # standard deviations: 1.96 contained nine of ten fresh shares, 2.58 contained 93 %


class Share(NamedTuple):
    """Estimate, and ends of a 95 % interval, of the chance that a variant of a fault breaks."""

    value: float
    low: float
    high: float

    @classmethod
    def of(
        cls, space: SearchSpace, fault: str, tried: Iterable[tuple[Specification, bool]]
    ) -> Self:
        """Estimate it from different variants that flew alone, and whether each broke the goal.

        A variant is not flown twice, so rare ways to draw one come up too often: each way has its
        mean and its probability. An interval of normal approximation takes the mean of a way as
        Jeffreys' posterior, or as exact if all variants of the way were flown.
        """
        n_tried, n_broken = Counter[Draw](), Counter[Draw]()
        for (timed,), is_broken in tried:
            n_tried[drawn_as(space, timed)] += 1
            n_broken[drawn_as(space, timed)] += is_broken
        seen = middle = variance = value = least = 0.0
        most = 1.0
        for way, (chance, n_variants) in draws(space, fault).items():
            n, k = n_tried[way], n_broken[way]
            if n:
                seen, value = seen + chance, value + chance * k / n
            left = max(0.0, 1.0 - n / n_variants)
            mean = (k + 0.5) / (n + 1) if left else k / n
            middle += chance * mean
            if not left:
                least, most = least + chance * mean, most - chance * (1.0 - mean)
            variance += left * chance**2 * mean * (1.0 - mean) / (n + 2)
        value, off = value / seen, _Z * math.sqrt(variance)
        low, high = max(least, middle - off), min(most, middle + off)
        return cls(value, min(value, low), max(value, high))


class Known:
    """Results of flights in one mission seed: minimal sets by column, and all variants tried.

    Sets have the order in which they were found; ``flown`` has the columns that each variant
    breaks. ``n_kept`` counts, since the last set of a column was found, the random specifications
    that contain none of its sets and did not break it; ``n_restarts`` counts its sets so far.
    ``ends_by_bounds`` is whether the search ends when all bounds are low.
    """

    def __init__(self, space: SearchSpace, *, ends_by_bounds: bool = False) -> None:
        self._space = space
        self._ends_by_bounds = ends_by_bounds
        mission = space.gate.mission
        self.sets: dict[Column, list[FaultSet]] = {column: [] for column in columns(mission)}
        self.flown: dict[Specification, Broken] = {}
        self.n_kept = dict.fromkeys(self.sets, 0)
        self.n_restarts = dict.fromkeys(self.sets, 0)
        self._forms: defaultdict[FaultSet, list[Specification]] = defaultdict(list)
        self._unexplained = {column: list[Specification]() for column in self.sets}

    def learn(self, specification: Specification, broken: Broken) -> None:
        """Record what a flight breaks; a single fault is a minimal set of each broken column."""
        tried = form(specification)
        if tried in self.flown:
            return
        self.flown[tried] = broken
        faults = faults_of(specification)
        self._forms[faults].append(specification)
        for column in broken:
            self._unexplained[column].append(specification)
            if len(faults) == 1:
                self.add(column, faults)

    def add(self, column: Column, faults: FaultSet) -> None:
        """Add a set that breaks a column, unless a part of it is known to break it."""
        if not self.has_part_of(column, faults):
            kept = (known for known in self.sets[column] if not faults <= known)
            self.sets[column] = [*kept, faults]
            self.n_kept[column] = 0
            self.n_restarts[column] += 1

    def restore(
        self, found: "Iterable[Weakness]", counts: Mapping[Column, tuple[int, int]]
    ) -> None:
        """Restore recorded sets and counts, after the recorded flights have been learnt."""
        self.sets = {column: [] for column in self.sets}
        for each in found:
            self.sets[each.column].append(frozenset(each.faults))
        for column, (n_kept, n_restarts) in counts.items():
            self.n_kept[column], self.n_restarts[column] = n_kept, n_restarts

    @property
    def counts(self) -> dict[Column, tuple[int, int]]:
        """``n_kept`` and ``n_restarts`` of each column."""
        return {column: (n, self.n_restarts[column]) for column, n in self.n_kept.items()}

    def bound(self, column: Column) -> float:
        """Return the upper bound, 0 … 1, on the chance that such a specification breaks a column.

        Zero events in ``n_kept`` trials (Clopper and Pearson) give 95 % ``confidence``. A search
        that ends by its bounds looks again and again: each column has the same part of the 5 %, and
        the k-th look, after k - 1 sets, 6 / (π k)² of that.
        """
        n = self.n_kept[column]
        return 1.0 - self._doubt(column) ** (1.0 / n) if n else 1.0

    def _doubt(self, column: Column) -> float:
        if not self._ends_by_bounds:
            return DOUBT
        looks = self.n_restarts[column] + 1
        return DOUBT * 6.0 / (math.pi * looks) ** 2 / len(self.sets)

    @property
    def confidence(self) -> str:
        """The confidence of the bounds, in words."""
        return "95 % confidence" + ", all bounds together" * self._ends_by_bounds

    def flights_to_bound(self, column: Column, share: float = 0.1) -> int:
        """Return how many more flights a search needs, at least, to bound a column by a share.

        That is if no further set is found. In each turn, one draw is for the column.
        """
        doubt = self._doubt(column)
        n_draws = math.ceil(math.log(doubt) / math.log1p(-share)) - self.n_kept[column]
        return max(0, n_draws) * (len(self.sets) + self.n_alone)

    @property
    def is_harmless(self) -> bool:
        """Whether no fault is known that breaks a column alone."""
        return not any(len(each) == 1 for sets in self.sets.values() for each in sets)

    @property
    def n_alone(self) -> int:
        """Faults that fly alone in a turn, beside a draw for each column; fewer if harmless."""
        return -(-len(self.sets) // (8 if self.is_harmless else 2))

    def has_part_of(self, column: Column, faults: FaultSet) -> bool:
        """Return whether some faults contain a set that breaks a column."""
        return any(known <= faults for known in self.sets[column])

    def unexplained(self, column: Column) -> Specification | None:
        """Return the flown variant of fewest faults that breaks a column without a known set."""
        self._unexplained[column] = [
            each
            for each in self._unexplained[column]
            if not self.has_part_of(column, faults_of(each))
        ]
        return min(self._unexplained[column], key=len, default=None)

    def tried(self, faults: Iterable[str]) -> Sequence[Specification]:
        """Return the variants of exactly these faults, in order of trial."""
        return self._forms.get(frozenset(faults), ())

    def breaking(self, column: Column, faults: FaultSet) -> Iterator[Specification]:
        """Yield the variants of exactly these faults that broke a column, in order of trial."""
        return (each for each in self.tried(faults) if column in self.flown[form(each)])

    def weaknesses(self, *, are_weighted: bool = True) -> "tuple[Weakness, ...]":
        """Return the weaknesses by goal, small sets first, each by all its measures."""
        broken_by: defaultdict[FaultSet, list[Column]] = defaultdict(list)
        for column, sets in self.sets.items():
            for faults in sets:
                broken_by[faults].append(column)
        place = {column.goal: number for number, column in enumerate(self.sets)}

        def order(each: Weakness) -> tuple[int, int, tuple[str, ...], int]:
            goal, kind = each.column
            return place[goal], len(each.faults), each.faults, MEASURES.index(kind)

        found = []
        for faults, broken in broken_by.items():
            for column, witness in self._witnesses(faults, broken):
                tried = [(each, column in self.flown[form(each)]) for each in self._forms[faults]]
                n_broken = sum(is_broken for _, is_broken in tried)
                named, share = tuple(sorted(faults)), None
                alone = [each for each in tried if are_weighted and len(each[0]) == 1]
                if alone and len(named) == 1:
                    share = Share.of(self._space, named[0], alone)
                found.append(Weakness(column, named, witness, len(tried), n_broken, weighted=share))
        return tuple(sorted(found, key=order))

    def _witnesses(
        self, faults: FaultSet, broken: Iterable[Column]
    ) -> Iterator[tuple[Column, Specification]]:
        """Yield a variant for each column that a minimal set breaks: few variants, active for long.

        A variant that is active for long is the likeliest to break the goal in other seeds, too.
        """

        def shortness(each: Specification) -> tuple[int, Specification]:
            return -sum(timed.finish - timed.start for timed in each), each

        left = {*broken}
        shown = {each: left & self._isolated(each) for each in self._forms[faults]}
        while left:
            witness = min(shown, key=lambda each: (-len(shown[each] & left), shortness(each)))
            if not shown[witness] & left:  # the set is known, but its parts were not flown
                shown = {each: left & self.flown[form(each)] for each in shown}
                continue
            yield from ((column, witness) for column in shown[witness] & left)
            left -= shown[witness]

    def _isolated(self, flown: Specification) -> Broken:
        """Return the columns that a variant breaks and that no flown part of it breaks."""
        broken = self.flown[form(flown)]
        known = (self.flown.get(form(part), broken) for part in parts(flown) if part)
        return broken.difference(*known)


@dataclass(frozen=True, slots=True)
class Detection:
    """Whether, and when, the collective intelligence detects that a set of faults breaks a goal.

    A variant is a specification of exactly these pool faults that the campaign flew, in any mission
    seed, and that truly broke the goal there (by true or missed ticks of its ``Yardstick``). The
    worst mission seed of a variant counts.

    Detection is in time if the belief shows a violation at the tick at which the goal is first
    truly violated, or missed if it never is. Else it is late or never happens. A violation shown
    before that tick is a false alarm. ``latest`` is the longest delay, in ticks.
    """

    worst: str
    n_variants: int
    n_never: int
    n_late: int
    latest: int

    @classmethod
    def of(cls, late: Mapping[Specification, float]) -> Self | None:
        """Return the detection of variants by the delay of each in ticks; infinite for never."""
        ticks = [int(each) for each in late.values() if 0 < each < math.inf]
        n_never = [*late.values()].count(math.inf)
        worst = "never" if n_never else "late" if ticks else "in time"
        return cls(worst, len(late), n_never, len(ticks), max(ticks, default=0)) if late else None

    def in_words(self, units: Units) -> str:
        """Return the worst case in a sentence, with the number of variants."""
        of = f"of {counted(self.n_variants, 'breaking variants')}"
        if self.n_never:
            return f"The CI does not detect it in {self.n_never} {of}"
        if self.n_late:
            late = units.ticks(self.latest)
            return f"The CI detects it late in {self.n_late} {of}, by up to {late}"
        return f"The CI detects it in time in {self.n_variants} {of}"


@dataclass(frozen=True, slots=True)
class Weakness:
    """A goal, a measure, and a minimal set of faults, by sorted IDs, that breaks it.

    ``witness`` is a variant that breaks it. Of the variants that break the most goals and measures
    for which their faults are minimal, it is active for the most ticks. Under it the goal is broken
    from tick ``since`` on, if recorded. ``n_tried`` variants of exactly these faults were flown
    to isolate them; ``n_broken`` of these broke it. ``weighted`` is, for one fault, the share by
    the chance of each variant. In ``n_held`` of the ``n_seeds`` that were flown, the witness breaks
    it and no part of the witness does. All weaknesses of a goal and a set share one ``detection``,
    ``None`` for false alarms or if not recorded. ``depth`` is how far the goal is beyond its limit
    under the witness, at worst, and at which tick; ``None`` without a margin too.
    """

    column: Column
    faults: tuple[str, ...]
    witness: Specification
    n_tried: int
    n_broken: int
    n_held: int = 1
    n_seeds: int = 1
    since: int | None = None
    detection: Detection | None = None
    weighted: Share | None = None
    depth: Margin | None = None

    @property
    def share(self) -> float:
        """Chance that a variant breaks it, above 0, at most 1: weighted, or as tried."""
        return self.weighted.value if self.weighted else self.n_broken / self.n_tried

    @property
    def share_in_words(self) -> str:
        """The share of the variants that break it; of several faults only what was tried."""
        if self.weighted is None:
            return f"{self.n_broken} of {counted(self.n_tried, 'tried variants')}"
        value, low, high = (100 * each for each in self.weighted)
        return f"{value:.0f} % of variants ({low:.0f} to {high:.0f} %)"

    @property
    def label(self) -> str:
        """``firm`` if it holds in all of several mission seeds, else ``of this seed``."""
        return "firm" if self.n_held == self.n_seeds > 1 else "of this seed"

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "goal": self.column.goal,
            "measure": self.column.kind,
            "faults": list(self.faults),
            "witness": [*map(timed_as_json, self.witness)],
            "share": self.share,
            "tried": self.n_tried,
            "broken": self.n_broken,
            "interval": self.weighted and [*self.weighted[1:]],
            "since": self.since,
            "depth": self.depth and {"value": self.depth[0], "tick": self.depth[1]},
            "seeds": {"held": self.n_held, "of": self.n_seeds},
            "detection": self.detection and asdict(self.detection),
            "label": self.label,
        }

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Self:
        """Return the weakness that plain values describe; invalid: Value-, Type- or KeyError."""
        wanted = itemgetter(*TimedFault._fields)
        n_tried, seeds, share = int(row["tried"]), row["seeds"], float(row["share"])
        interval = row.get("interval")
        return cls(
            Column(str(row["goal"]), str(row["measure"])),
            tuple(map(str, row["faults"])),
            database.specification(wanted({"trigger": "", **each}) for each in row["witness"]),
            n_tried,
            int(row.get("broken", round(share * n_tried))),
            int(seeds["held"]),
            int(seeds["of"]),
            None if row["since"] is None else int(row["since"]),
            weighted=None if interval is None else Share(share, *map(float, interval)),
        )


def timed_as_json(timed: TimedFault) -> dict[str, Any]:
    """Return a timed fault as plain values, with its trigger only if it has one."""
    row = timed._asdict() | {"values": [*timed.values]}
    return row if timed.trigger else {name: row[name] for name in row if name != "trigger"}


def flown_with(weaknesses: Iterable[Weakness]) -> tuple[Specification, ...]:
    """Return the specifications that judge weaknesses in a seed: none, witnesses, their parts."""
    witnesses = dict.fromkeys(each.witness for each in weaknesses)
    return tuple(dict.fromkeys([(), *witnesses, *chain.from_iterable(map(parts, witnesses))]))


def in_seeds(
    mission: Mission, weaknesses: Sequence[Weakness], evaluate: EvaluateIn, seeds: Sequence[int]
) -> tuple[Weakness, ...]:
    """Return weaknesses with the number of mission seeds in which they hold.

    The first seed, in which they were found, is not flown again. A flight that fails breaks
    nothing; the flight without faults may not fail.
    """
    flown, n_held = flown_with(weaknesses), Counter(weaknesses)
    for seed in seeds[1:]:
        breaking = Breaking(mission, evaluate, [seed])
        breaking(flown, seed)
        for each in weaknesses:
            broken, *alone = breaking((each.witness, *parts(each.witness)), seed)
            n_held[each] += each.column in broken.difference(*alone)
    return tuple(replace(each, n_held=n_held[each], n_seeds=len(seeds)) for each in weaknesses)


def dated(
    yardstick: Yardstick, weaknesses: Sequence[Weakness], record_many: RecordMany
) -> tuple[Weakness, ...]:
    """Return weaknesses with the ticks from which on goals are broken; each witness is flown."""
    witnesses = dict.fromkeys(each.witness for each in weaknesses)
    since = dict(zip(witnesses, map(yardstick.since, record_many(witnesses)), strict=True))
    return tuple(replace(each, since=since[each.witness].get(each.column)) for each in weaknesses)


def detected(
    mission: Mission,
    store: CampaignStore,
    weaknesses: Sequence[Weakness],
    later: Iterable[RecordedFlight],
) -> tuple[Weakness, ...]:
    """Return weaknesses with their depth, and their detection in the search and later flights."""
    flights = [*store.flown_with({frozenset(each.faults) for each in weaknesses}), *later]
    yardsticks: dict[int, Yardstick] = {}
    late: defaultdict[tuple[str, FaultSet], dict[Specification, float]] = defaultdict(dict)
    depths: dict[tuple[str, Specification], Margin | None] = {}
    for each in sorted(flights, key=lambda each: len(each.specification)):  # first without faults
        if isinstance(each.found, Outcome):
            variant, fault_free = form(each.specification), Yardstick.of(mission, each.found)
            yardstick = yardsticks.setdefault(each.mission_seed, fault_free)
            if each.mission_seed == store.settings.mission_seed and store.has_depths:
                reached = zip(mission.goal_ids, each.found.depths, strict=True)
                depths |= {(goal, variant): depth for goal, depth in reached}
            for goal, ticks in yardstick.late(each.found):
                variants = late[goal, faults_of(variant)]
                variants[variant] = max(ticks, variants.get(variant, 0))
    truly = {
        (each.column.goal, each.faults) for each in weaknesses if each.column.kind != MEASURES[0]
    }
    of = {(goal, faults): Detection.of(late[goal, frozenset(faults)]) for goal, faults in truly}
    return tuple(
        replace(
            each,
            detection=of.get((each.column.goal, each.faults)),
            depth=depths.get((each.column.goal, form(each.witness))),
        )
        for each in weaknesses
    )


MOST_SETS = 50_000
"""Sets of one size up to which ``untried`` counts them."""


def untried(
    known: Known,
    yardstick: Yardstick | None,
    faults: Sequence[str],
    flights: Mapping[Specification, Outcome],
    goals: Collection[str],
) -> dict[int, int]:
    """Return how many faults, pairs and triples were not tried, by size.

    A set is *tried* for a column in a flight that contains no known set of the column and does not
    break it, and in which each of its faults changes a value. Sets that contain a known set need no
    trial. Those that are untried for a column of any of the goals count.
    """
    contained, acting = (defaultdict[str, int](int) for _ in range(2))  # a bit for each flight
    broken = dict.fromkeys(known.sets, 0)
    for place, (variant, outcome) in enumerate(flights.items()):
        for timed, n_changed in zip(variant, outcome.changed, strict=True):
            contained[timed.fault] |= 1 << place
            acting[timed.fault] |= (n_changed > 0) << place
        for column in yardstick.broken(outcome) if yardstick else ():
            broken[column] |= 1 << place
    acted = {}
    for column in (each for each in broken if each.goal in goals):
        judged = ~broken[column]
        for each in known.sets[column]:
            judged &= ~reduce(and_, (contained[fault] for fault in each))
        acted[column] = {fault: acting[fault] & judged for fault in faults}

    def is_untried(some: tuple[str, ...]) -> bool:
        return any(
            not reduce(and_, map(by_fault.__getitem__, some))
            and not known.has_part_of(column, frozenset(some))
            for column, by_fault in acted.items()
        )

    sizes = [n for n in (1, 2, 3) if 0 < math.comb(len(faults), n) <= MOST_SETS]
    return {n: sum(map(is_untried, combinations(faults, n))) for n in sizes}


def yardstick_of(mission: Mission, fault_free: Evaluated, seed: int) -> Yardstick:
    """Return the yardstick of a mission seed; a flight without faults that fails is an error."""
    if isinstance(fault_free, FailedFlight):
        raise EvaluationError(f"without faults, in mission seed {seed}: {fault_free.traceback}")
    return Yardstick.of(mission, fault_free)


class Breaking(Prober[Broken]):
    """Finds the columns that specifications break in mission ``seeds``; failed flights break none.

    The flight without faults that the yardstick of each seed needs is not counted.
    """

    def __init__(self, mission: Mission, evaluate: EvaluateIn, seeds: Sequence[int]) -> None:
        self.seeds = tuple(seeds)
        self.yardsticks = {
            seed: yardstick_of(mission, fault_free, seed)
            for seed in seeds
            for fault_free in evaluate([()], seed)
        }
        super().__init__(evaluate, lambda _, seed, flown: self.yardsticks[seed].broken(flown))
        self.known |= {((), seed): frozenset() for seed in seeds}
