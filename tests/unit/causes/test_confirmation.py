"""What a weakness flies in another world, and what follows from its flights there."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import cycle

import pytest

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.confirmation import (
    N_STEPS,
    Confirmation,
    Elsewhere,
    Transfer,
)
from mrsfi_runtime.causes.mildest import GoalWeakness, Mildest, gravity
from mrsfi_runtime.causes.weakness import Detection
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Evaluated, FailedFlight, Outcome, interval_in_words, wilson
from mrsfi_runtime.record.store import FlightElsewhere, RecordedFlight
from tests.support.search import outcome_of, paper_mission, paper_space
from tests.support.weaknesses import weakness

SPACE, MISSION, STOP = paper_space(), paper_mission(), "f26"
G1 = Column("g1", "true")
NONE = outcome_of(*[0] * 6)
LISTED, MILD = (TimedFault(STOP, 0, 999),), (TimedFault(STOP, 500, 519),)
FOUND = GoalWeakness(
    1, "g1", (STOP,), (replace(weakness("g1", "true", STOP), witness=LISTED, since=40),)
)
SHRUNK = replace(FOUND, mildest=Mildest(replace(FOUND.shown, witness=MILD), "", 0))


def counts(measure: str = "true", *, goal: int = 0, ticks: int = 9) -> Outcome:
    """Return an outcome that breaks one goal by one measure."""
    return replace(NONE, **{measure: (*[0] * goal, ticks, *[0] * (5 - goal))})


def flown(
    fly: Callable[[Specification], Evaluated],
    found: GoalWeakness = FOUND,
    since: int = 43,
) -> tuple[Confirmation, list[Specification]]:
    """Fly all that a weakness asks for; return the result, and each flight with faults."""
    world, asked = elsewhere(found), list[Specification]()
    while (specification := next(world.wanted(()), None)) is not None:
        flight = RecordedFlight(1, specification, fly(specification))
        world.learn(FlightElsewhere("there", flight, {G1: since}, 0.0))
        asked += [specification] * bool(specification)
    ((_, result, _),) = world.results()
    return result, asked


def elsewhere(*found: GoalWeakness) -> Elsewhere:
    """Return a world in which nothing was flown."""
    return Elsewhere("there", SPACE, found)


def lasting(ticks: int) -> Callable[[Specification], Outcome]:
    """Return a world in which a fault breaks the goal if it is active for so many ticks."""

    def fly(specification: Specification) -> Outcome:
        (each, *_) = (*specification, TimedFault(STOP, 0, -1))
        return counts() if each.finish - each.start + 1 >= ticks else NONE

    return fly


def test_the_listed_variant_confirms_and_the_first_one_is_flown_three_times():
    found, asked = flown(lasting(900))

    assert asked == [LISTED] * 3
    assert (found.verdict, found.measure, found.kind) == ("same goal", "true", "listed")
    assert (found.n_broken, found.n_flown, found.delay) == (1, 1, 3)


def test_so_does_the_mildest_if_it_breaks_the_goal():
    found, asked = flown(lasting(20), SHRUNK)

    assert asked == [*[LISTED] * 3, MILD]
    assert (found.kind, found.variant, found.n_flown) == ("mildest", MILD, 1)


@pytest.mark.parametrize("ticks", [21, 100, 500, 940])
def test_else_bisection_finds_one_between_them(ticks):
    found, asked = flown(lasting(ticks), SHRUNK)

    ((_, start, finish, *_),) = found.variant
    step = (1000 - 20) / 2**N_STEPS
    assert finish - start + 1 - step - 1 <= ticks <= finish - start + 1
    assert len(asked) <= 3 + 1 + N_STEPS
    assert found.kind == ("shrunk" if ticks < 938 else "listed")


@pytest.mark.parametrize(
    ("there", "verdict", "measure", "goals"),
    [
        (NONE, "nothing", None, ()),
        (counts("believed"), "same goal, less gravely", "believed", ()),
        (counts("true", goal=2), "other goals", None, ("g3",)),
        (FailedFlight("boom"), "ended with an error", None, ()),
    ],
)
def test_what_does_not_confirm_flies_no_milder_variant(there, verdict, measure, goals):
    found, asked = flown(lambda each: there if each else NONE, SHRUNK)

    assert (found.verdict, found.measure, found.goals) == (verdict, measure, goals)
    assert asked == [LISTED] * 3


def test_a_graver_measure_confirms_too():
    found, _ = flown(lambda each: counts("missed") if each else NONE)

    assert found.words == "same goal fails"


def test_a_goal_that_breaks_without_faults_cannot_be_confirmed():
    briefly, long = (counts(ticks=ticks) for ticks in (50, 51))

    found, asked = flown(lambda _: long)
    judged, _ = flown(lambda each: counts(ticks=200) if each else briefly)

    assert (found.verdict, asked) == ("breaks without faults", [])
    assert judged.verdict == "same goal"


@pytest.mark.parametrize(("broken", "verdict"), [((1, 1, 0), "same goal"), ((0, 0, 1), "nothing")])
def test_where_equal_flights_differ_more_than_half_of_three_decide(broken, verdict):
    results = cycle(broken)
    world: dict[bool, Iterator[int]] = {False: cycle([0]), True: results}

    found, asked = flown(lambda each: counts(ticks=next(world[bool(each)])))

    assert asked == [LISTED] * 3
    assert (found.verdict, found.n_broken, found.n_flown) == (verdict, sum(broken), 3)
    assert found.share == f"{sum(broken)} of 3 flights {interval_in_words(sum(broken), 3)}"


def test_flights_under_way_are_not_wanted_again_and_the_first_variant_comes_alone():
    other = replace(FOUND, number=2, by=(replace(FOUND.shown, witness=MILD),))
    world = elsewhere(FOUND, other)

    def learn(variant: Specification) -> None:
        found = counts() if variant else NONE
        world.learn(FlightElsewhere("there", RecordedFlight(1, variant, found), {}, 0.0))

    assert [*world.wanted(())] == [()]
    assert not [*world.wanted([()])]
    learn(())
    assert [*world.wanted([LISTED])] == [LISTED] * 2
    for _ in range(3):
        learn(LISTED)
    assert [*world.wanted(())] == [MILD]
    assert not [*world.wanted([MILD])]


def test_there_every_variant_is_flown_three_times_and_so_is_the_flight_without_faults():
    turns = cycle([8, 9, 10])
    world, n = elsewhere(SHRUNK), {(): 0, LISTED: 0, MILD: 0}
    while (variant := next(world.wanted(()), None)) is not None:
        n[variant] += 1
        found = counts(ticks=next(turns)) if variant else NONE
        world.learn(FlightElsewhere("there", RecordedFlight(1, variant, found), {}, 0.0))

    assert set(n.values()) == {3}


def test_a_flight_without_faults_that_fails_is_an_error():
    with pytest.raises(EvaluationError, match="without faults"):
        flown(lambda _: FailedFlight("boom"))


@pytest.mark.parametrize(
    ("k", "n", "low", "high"), [(0, 10, 0.0, 0.2775), (17, 20, 0.6396, 0.9476), (10, 10, 0.7225, 1)]
)
def test_the_interval_of_a_share_is_that_of_wilson(k, n, low, high):
    assert wilson(k, n) == pytest.approx((low, high), abs=1e-4)


def test_the_share_leaves_out_what_cannot_be_judged_and_names_what_does_not_break():
    verdicts = ("same goal", "same goal", "nothing", "breaks without faults", "not flown yet")

    told = Transfer.of(enumerate((Confirmation("there", each) for each in verdicts), 1))

    assert told.words == "2 of 3 weaknesses break the same goal (95 %: 21 % to 94 %); not: 3"


def test_the_gravest_come_first():
    never = Detection("never", 1, 1, 0, 0)
    made = [
        weakness("g1", "believed", "f1"),
        weakness("g1", "true", "f2"),
        weakness("g1", "true", "f3", detection=never),
        weakness("g2", "missed", "f4"),
    ]
    found = [
        GoalWeakness(number, each.column.goal, each.faults, (each,))
        for number, each in enumerate(made, 1)
    ]

    assert [each.number for each in sorted(found, key=gravity(MISSION))] == [4, 3, 2, 1]
