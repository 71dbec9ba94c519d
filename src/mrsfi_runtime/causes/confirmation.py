"""Judge from recorded flights which weaknesses of a campaign break the same goal in another world.

Another world is an external simulation. Each weakness flies its listed variant there. If that
breaks the goal, the mildest known one follows; if that does not break the goal, bisection between
the two looks for the mildest that does.

All is a function of the recorded flights: ``Elsewhere`` has the result so far of each weakness, and
the flight that it needs next. So whoever flies may stop at any moment, and a report has the same
results as the command. The first variant is flown ``N_LOOKS`` times. If these flights differ, each
variant is, and a goal breaks if it breaks in more than half of the flights of a variant.
"""

from collections import Counter, defaultdict
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import chain, combinations, starmap
from operator import attrgetter, itemgetter
from statistics import median_low
from typing import Any, NamedTuple, Self, TypeAlias

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import (
    MARGIN,
    MEASURES,
    Yardstick,
    form,
    timed_as_json,
    yardstick_of,
)
from mrsfi_runtime.errors import counted
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Outcome, interval_in_words
from mrsfi_runtime.record.store import FlightElsewhere
from mrsfi_runtime.search.space import SearchSpace

N_LOOKS = 3
"""Flights of a specification to find out whether external parts repeat themselves.

Also the flights of each specification if they do not.
"""

N_STEPS = 4
"""Flights of a bisection."""

SAME, WEAKER, OTHER, NOTHING = "same goal", "same goal, less gravely", "other goals", "nothing"
ANYWAY, ERROR, OPEN = "breaks without faults", "ended with an error", "not flown yet"
LISTED, MILDEST, SHRUNK = "listed", "mildest", "shrunk"

BREAKS = {"missed": "fails", "true": "is violated", "believed": "has a false alarm"}
"""What happens to a goal, by measure, as a predicate."""

Step: TypeAlias = tuple[str, int, Specification]
"""A variant that a weakness needs: its kind, how urgent it is (0 first), and itself."""


@dataclass(frozen=True, slots=True)
class Confirmation:
    """The result of a weakness in another world.

    ``verdict`` is one of the words above. ``variant`` is the mildest that was found to break the
    goal there, or else the listed one, and ``kind`` says which it is; ``measure`` is the gravest by
    which it breaks the goal, in ``n_broken`` of ``n_flown`` flights, and ``goals`` are the others
    that it breaks. ``delay`` is by how many ticks later the listed variant breaks the goal there.
    """

    world: str
    verdict: str
    kind: str = LISTED
    variant: Specification = ()
    measure: str | None = None
    goals: tuple[str, ...] = ()
    n_broken: int = 0
    n_flown: int = 0
    delay: int | None = None

    @property
    def words(self) -> str:
        """What breaks there."""
        goals = f": {', '.join(self.goals)}" if self.verdict == OTHER else ""
        return f"{self.verdict} {BREAKS[self.measure]}" if self.measure else self.verdict + goals

    @property
    def share(self) -> str:
        """In how many of several flights the variant broke the goal; empty for one flight."""
        if self.n_flown < 2:
            return ""
        interval = interval_in_words(self.n_broken, self.n_flown)
        return f"{self.n_broken} of {self.n_flown} flights {interval}"

    @property
    def sentence(self) -> str:
        """What breaks in which world."""
        return f"In the world {self.world}: {', '.join(filter(None, (self.words, self.share)))}"

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return asdict(self) | {"variant": [*map(timed_as_json, self.variant)]}


class Elsewhere:
    """Weaknesses in another world, by the recorded flights there in the campaign's mission seed."""

    def __init__(
        self,
        world: str,
        space: SearchSpace,
        weaknesses: Iterable[GoalWeakness],
        flights: Iterable[FlightElsewhere] = (),
    ) -> None:
        self.world = world
        self.space = space
        self.weaknesses = tuple(weaknesses)
        self.flights: defaultdict[Specification, list[FlightElsewhere]] = defaultdict(list)
        for each in flights:
            self.learn(each)

    def learn(self, flight: FlightElsewhere) -> None:
        """Add a flight."""
        self.flights[form(flight.flown.specification)].append(flight)

    @property
    def repeats_itself(self) -> bool | None:
        """Whether equal flights had equal results; ``None`` while that is not known."""
        first = next((some for each, some in self.flights.items() if each), [])
        looks = [each.flown.found for each in first[:N_LOOKS]]
        return None if len(looks) < N_LOOKS else all(each == looks[0] for each in looks)

    def n_missing(self, variant: Specification) -> int:
        """Return how many flights of a variant are missing to judge it, as far as is known."""
        first = next((each for each in self.flights if each), form(variant))
        is_more = self.repeats_itself is False or (variant and form(variant) == first)
        return max(0, (N_LOOKS if is_more else 1) - len(self.flights.get(form(variant), ())))

    @property
    def yardstick(self) -> Yardstick | None:
        """The yardstick by the flights without faults: of several, the largest counts."""
        mission = self.space.gate.mission
        flights = (each.flown for each in self.flights.get((), ()))
        found = [yardstick_of(mission, each.found, each.mission_seed) for each in flights]
        most = zip(*(each.most for each in found), strict=True)
        return replace(found[0], most=tuple(map(max, most))) if found else None

    def results(self) -> Iterator[tuple[GoalWeakness, Confirmation, Step | None]]:
        """Yield each weakness with its result so far, and the variant that it needs next."""
        yardstick, duration = self.yardstick, self.space.duration
        for each in self.weaknesses:
            if yardstick is None or self.n_missing(()):
                yield each, Confirmation(self.world, OPEN), (LISTED, 0, ())
                continue
            most = yardstick.most[yardstick.columns.index(each.shown.column)]
            if most > 2 * MARGIN * duration:  # the count without faults is one margin less
                yield each, Confirmation(self.world, ANYWAY), None
            else:
                yield each, *self._inquired(each, yardstick)

    @property
    def transfer(self) -> "Transfer":
        """How many of the weaknesses break the same goal there."""
        return Transfer.of((weakness.number, each) for weakness, each, _ in self.results())

    def wanted(self, running: Sequence[Specification]) -> Iterator[Specification]:
        """Yield the flights to begin, the most urgent first, beside those that are under way."""
        steps = sorted((step for *_, step in self.results() if step), key=itemgetter(1))
        variants = [*dict.fromkeys(variant for *_, variant in steps)]
        for each in variants[: 1 if self.repeats_itself is None else None]:
            yield from [each] * (self.n_missing(each) - running.count(each))

    def _inquired(
        self, weakness: GoalWeakness, yardstick: Yardstick
    ) -> tuple[Confirmation, Step | None]:
        steps, step, found = self._steps(weakness), None, Confirmation(self.world, OPEN)
        with suppress(StopIteration):
            step = next(steps)
            while not self.n_missing(step[2]):
                kind, _, variant = step
                step, result = None, self._result(weakness, kind, variant, yardstick)
                is_same = result.verdict == SAME
                if kind == LISTED:
                    found = result
                elif is_same:
                    found = replace(result, delay=found.delay)
                step = steps.send(is_same)
        return found, step

    def _result(
        self, weakness: GoalWeakness, kind: str, variant: Specification, yardstick: Yardstick
    ) -> Confirmation:
        column, here = weakness.shown.column, weakness.shown.since
        flights = self.flights[form(variant)]
        flown = flights[: 1 if self.repeats_itself else None]
        broken = [yardstick.broken(each.flown.found) for each in flown]
        n_broken = Counter(chain.from_iterable(broken))
        measure = _gravest(column.goal, n_broken, len(flown))
        goals = tuple(
            goal
            for goal in self.space.gate.mission.goal_ids
            if goal != column.goal and _gravest(goal, n_broken, len(flown))
        )
        if measure is not None:
            is_same = MEASURES.index(measure) >= MEASURES.index(column.kind)
            verdict = SAME if is_same else WEAKER
        elif any(isinstance(each.flown.found, Outcome) for each in flights):
            verdict = OTHER if goals else NOTHING
        else:
            verdict = ERROR
        pairs = zip(flown, broken, strict=True)
        there = [each.since[column] for each, some in pairs if column in some & each.since.keys()]
        delay = None if here is None or not there else median_low(there) - here
        numbers = n_broken[Column(column.goal, measure or column.kind)], len(flown), delay
        return Confirmation(self.world, verdict, kind, variant, measure, goals, *numbers)

    def _steps(self, weakness: GoalWeakness) -> Generator[Step, bool, None]:
        """Yield variants to fly, and receive whether each breaks the goal as gravely."""
        listed = weakness.shown.witness
        if not (yield LISTED, 0, listed) or weakness.mildest is None:
            return
        mild = weakness.mildest.weakness.witness
        if form(mild) != form(listed) and not (yield MILDEST, 1, mild):
            yield from self._shrinking(mild, listed)

    def _shrinking(self, mild: Specification, strong: Specification) -> Generator[Step, bool, None]:
        """Bisect between a variant that does not break the goal and one that does."""
        kept, broke = 0.0, 1.0
        for _ in range(N_STEPS):
            middle = (kept + broke) / 2
            tried = _between(self.space, mild, strong, middle)
            if form(tried) in {form(mild), form(strong)}:
                return
            clashes = any(starmap(self.space.clash, combinations(tried, 2)))
            is_broken = not clashes and (yield SHRUNK, 1, tried)
            kept, broke = (kept, middle) if is_broken else (middle, broke)


def _gravest(goal: str, n_broken: Counter[Column], n_flown: int) -> str | None:
    """Return the gravest measure by which a goal breaks in more than half of the flights."""
    n_of = ((2 * n_broken[Column(goal, each)], each) for each in reversed(MEASURES))
    return next((each for n, each in n_of if n > n_flown), None)


def _between(
    space: SearchSpace, mild: Specification, strong: Specification, share: float
) -> Specification:
    """Return the variant at a share of the way from a mild one to a strong one.

    It is the strong one if they do not have the same faults as often.
    """
    alike, pairs = attrgetter("fault", "trigger"), [*zip(form(mild), form(strong), strict=False)]
    if len(mild) != len(strong) or any(alike(low) != alike(high) for low, high in pairs):
        return strong

    def part(low: float, high: float) -> float:
        return low + (high - low) * share

    def one(low: TimedFault, high: TimedFault) -> TimedFault:
        start, finish = (round(part(*ends)) for ends in zip(low[1:3], high[1:3], strict=True))
        whole = space.candidates[high.fault].is_integer
        values = zip(map(part, low.values, high.values), whole, strict=True)
        new = (float(round(each) if is_whole else f"{each:.6g}") for each, is_whole in values)
        return high._replace(start=start, finish=finish, values=tuple(new))

    return tuple(starmap(one, pairs))


def confirmations(
    space: SearchSpace,
    flights: Iterable[FlightElsewhere],
    weaknesses: Sequence[GoalWeakness],
) -> dict[int, tuple[Confirmation, ...]]:
    """Return the results of weaknesses, by number, in all other worlds where they were flown."""
    by_world = defaultdict[str, list[FlightElsewhere]](list)
    found = defaultdict[int, tuple[Confirmation, ...]](tuple)
    for flight in flights:
        by_world[flight.world].append(flight)
    for world, some in by_world.items():
        for weakness, each, _ in Elsewhere(world, space, weaknesses, some).results():
            found[weakness.number] += (each,) * (each.verdict != OPEN)
    return found


class Transfer(NamedTuple):
    """How many weaknesses break the same goal in another world, and the numbers of the others."""

    n_same: int
    others: tuple[int, ...]

    @classmethod
    def of(cls, found: Iterable[tuple[int, Confirmation]]) -> Self:
        """Return it of results by the numbers of weaknesses, without those that are not judged."""
        judged = [each for each in found if each[1].verdict not in {ANYWAY, OPEN}]
        others = tuple(number for number, each in judged if each.verdict != SAME)
        return cls(len(judged) - len(others), others)

    @property
    def n_judged(self) -> int:
        """How many weaknesses were judged."""
        return self.n_same + len(self.others)

    @property
    def words(self) -> str:
        """All of it."""
        if not self.n_judged:
            return "no weakness could be judged yet"
        of, verb = counted(self.n_judged, "weaknesses"), "breaks" if self.n_same == 1 else "break"
        left = f"; not: {', '.join(map(str, self.others))}" if self.others else ""
        share = interval_in_words(self.n_same, self.n_judged)
        return f"{self.n_same} of {of} {verb} the same goal {share}{left}"


def transfers(weaknesses: Iterable[GoalWeakness]) -> Iterator[str]:
    """Yield the same of each world in which weaknesses were flown."""
    by_world: defaultdict[str, list[tuple[int, Confirmation]]] = defaultdict(list)
    for weakness in weaknesses:
        for each in weakness.elsewhere:
            by_world[each.world].append((weakness.number, each))
    for world, found in by_world.items():
        yield f"In the world {world}, {Transfer.of(found).words}"
