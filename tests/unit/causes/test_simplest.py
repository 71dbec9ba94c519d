"""Simplest forms of specifications whose violations are a function of windows and values."""

import pytest

from mrsfi_runtime.causes.cause_set import Flights
from mrsfi_runtime.causes.explanation import simplest
from mrsfi_runtime.model.faults import TimedFault, value_bounds
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import outcome
from tests.support.search import paper_mission, pool_of

MISSION, POOL = paper_mission(), pool_of()
SPEED = next(fault for fault in POOL if fault.type == "FixedSpeed")
(OWN,), ((LOW, HIGH),) = SPEED.values, value_bounds(MISSION, SPEED)
ODD = 17.123


def simplified(violations, *drawn):
    """Return the simplest form of faults whose believed violations are given."""

    def evaluate_many(specifications, _seed):
        return [outcome([violations(each)], len(each)) for each in specifications]

    flights = Flights(evaluate_many, Measure("believed", 1, ("g1",), ("g1",), 1000), (1,))
    return simplest(flights, MISSION, POOL, drawn)


def timed(start, finish, value=ODD):
    return TimedFault(SPEED.id, start, finish, (value,))


def during(low, high):
    """Return violations: the ticks of a window that a fault covers, some hundred to one."""
    return lambda drawn: sum(
        100 * max(0, min(each.finish, high) - max(each.start, low) + 1) for each in drawn
    )


def test_a_window_is_cut_from_both_ends_to_where_it_counts():
    (found,) = simplified(during(300, 309), timed(7, 912))

    assert (found.start, found.finish) == (300, 309)


def test_what_follows_the_mission_is_cut():
    (found,) = simplified(during(990, 2000), timed(990, 5000))

    assert (found.start, found.finish) == (990, 999)


def test_a_fault_that_needs_one_tick_keeps_one():
    (found,) = simplified(lambda drawn: 10, timed(100, 200))

    assert found.start == found.finish


@pytest.mark.parametrize(
    ("least", "most", "expected"),
    [
        (LOW, HIGH, OWN),
        (OWN + 1e-9, HIGH, HIGH),
        (15, 25, 20),
        (16.5, 17.5, 17),
        (17.05, 17.2, 17.1),
        (ODD, ODD, ODD),
    ],
    ids=["the pool's own", "a bound", "tens", "ones", "tenths", "none but itself"],
)
def test_of_the_values_that_do_the_plainest_is_found(least, most, expected):
    def violations(drawn):
        return 10 * (least <= drawn[0].values[0] <= most)

    (found,) = simplified(violations, timed(100, 100))

    assert LOW <= ODD <= HIGH
    assert found.values == (expected,)


def test_a_hundredth_may_be_lost_but_not_more():
    def violations(drawn):
        return 1000 - 3 * (drawn[0].finish < 200) - 18 * (drawn[0].start > 50)

    (found,) = simplified(violations, timed(50, 200))

    assert found.start == 50
    assert found.finish < 200
