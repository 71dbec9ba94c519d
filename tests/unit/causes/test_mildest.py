"""Mildest forms of faults that break a goal from a known threshold on."""

import re

import numpy as np
import pytest

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.mildest import N_STEPS, Deviation, mildest, tried_map
from mrsfi_runtime.causes.weakness import MEASURES, Known
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import FailedFlight
from tests.support.search import outcome_of, paper_space

SPACE = paper_space()
KEPT, BROKEN = outcome_of(*[0] * 6), outcome_of(1, 0, 0, 0, 0, 0)
TRUE = {
    "robots": [{"x": 0.0, "y": 100.0, "z": 1.0}] * 3,
    "sensors": [{"rate": 40.0}] * len(SPACE.gate.mission.sensors),
}
RECORDED = {"world": [TRUE], **dict.fromkeys(MEASURES, np.zeros((1, 6)))}
DEVIATION = Deviation(SPACE, RECORDED)
G1 = Column("g1", "true")
BLOCK, LESS, PLACE, RATE, RANDOM, STOP = "f2", "f4", "f11", "f12", "f21", "f26"


def recorded(_):
    return RECORDED


class Stand:
    """Stands in for a simulator: g1 breaks where a function of specification and seed says so."""

    def __init__(self, breaks):
        self._breaks = breaks
        self.n_flights = 0

    def __call__(self, specifications, seed):
        self.n_flights += len(specifications)
        return [BROKEN if each and self._breaks(each, seed) else KEPT for each in specifications]


def shrunk(breaks, *forms, seeds=(1, 2, 3)):
    """Return the mildest form of the weakness that some forms show, and what flew for it."""
    known, stand = Known(SPACE.gate.mission), Stand(breaks)
    for each in forms:
        known.learn(each, frozenset([G1] if breaks(each, seeds[0]) else []))
    known.add(G1, frozenset(timed.fault for timed in forms[0]))
    (found,) = mildest(SPACE, known, known.weaknesses(), stand, recorded, seeds)
    assert found.n_flights == stand.n_flights - len(seeds)  # without faults
    return found


def whole(fault, *values):
    return TimedFault(fault, 0, 999, values)


def alone(condition):
    """Return what breaks while the only fault fulfils a condition."""
    return lambda drawn, _seed: condition(drawn[0])


def covers(timed, first, last):
    return timed.start <= first and last <= timed.finish


def test_value_and_window_are_shrunk_to_what_is_needed():
    found = shrunk(
        alone(lambda each: each.values[0] >= 37.0 and covers(each, 300, 309)), (whole(LESS, 90.0),)
    )

    (timed,) = found.weakness.witness
    assert 37.0 <= timed.values[0] <= 37.0 * 17 / 16
    assert covers(timed, 300, 309)
    assert timed.finish - timed.start < 60
    assert (found.weakness.n_held, found.weakness.n_seeds) == (3, 3)
    assert found.n_flights < 3 * 25


def test_what_breaks_for_long_enough_is_told_by_its_ticks():
    found = shrunk(alone(lambda each: each.finish - each.start >= 9), (whole(STOP),))

    assert re.fullmatch(
        r"f26: g1 breaks when at work for 10 ticks; up to 9 ticks never, in \d+ tries",
        found.sentence,
    )


def test_whole_values_stay_whole_and_within_their_bounds():
    found = shrunk(alone(lambda each: each.values[0] >= 3), (whole(BLOCK, 700.0),))
    least = shrunk(alone(lambda each: True), (whole(BLOCK, 700.0),))

    assert found.weakness.witness[0].values == (3.0,)
    assert least.weakness.witness[0].values == (1.0,)
    assert least.sentence.endswith("for 1 tick; nothing less that was tried kept it")


def test_a_place_and_a_number_are_measured_by_what_is_true():
    def is_far(each):
        return each.values[0] ** 2 + (each.values[1] - 100.0) ** 2 >= 400.0**2

    place = shrunk(alone(is_far), (whole(PLACE, 1200.0, -800.0, 1.0),))
    rate = shrunk(alone(lambda each: each.values[0] >= 70), (whole(RATE, 120.0),))

    x, y, z = place.weakness.witness[0].values
    assert x / (100.0 - y) == pytest.approx(1200 / 900, rel=1e-3)
    assert 400.0 <= (x**2 + (y - 100.0) ** 2) ** 0.5 <= 425.0
    assert z == 1.0
    (told,) = rate.weakness.witness[0].values
    assert 70.0 <= told <= 72.0
    assert f"from {told - 40:.4g} samples per tick off for " in rate.sentence


def test_it_has_to_break_in_all_seeds_or_in_the_first_of_them():
    found = shrunk(lambda drawn, seed: drawn[0].values[0] >= 20 * seed, (whole(LESS, 90.0),))
    first = shrunk(lambda _, seed: seed < 3, (whole(LESS, 90.0),))

    assert 60.0 <= found.weakness.witness[0].values[0] < 64.0
    assert (first.weakness.n_held, first.weakness.witness[0].values) == (2, (0.0,))


def test_it_begins_with_the_mildest_form_that_is_known():
    short, long = (TimedFault(STOP, 5, 8),), (whole(STOP),)

    found = shrunk(lambda drawn, _: drawn in (short, long), long, short)

    assert found.weakness.witness == short


def test_both_of_two_faults_are_needed_and_never_overlap_where_they_conflict():
    def breaks(drawn, _seed):
        return len(drawn) == 2 and all(each.finish - each.start >= 4 for each in drawn)

    pair = (TimedFault(PLACE, 0, 499, (1200.0, -800.0, 1.0)), TimedFault(RANDOM, 500, 999))
    found = shrunk(breaks, pair).weakness
    part = shrunk(lambda drawn, seed: PLACE in {each.fault for each in drawn}, pair).weakness

    assert {each.fault for each in found.witness} == {PLACE, RANDOM}
    assert all(5 <= each.finish - each.start + 1 <= 6 for each in found.witness)
    assert (part.n_held, part.witness) == (0, pair)


def test_the_sentence_names_the_strongest_form_that_kept_the_goal():
    found = shrunk(
        alone(lambda each: each.values[0] >= 37.0),
        (whole(LESS, 90.0),),
        (whole(LESS, 36.5),),
        (whole(LESS, 36.0),),
    )

    told = re.fullmatch(
        r"f4: g1 breaks from PERCENTAGE (\S+) percent for 1 tick; "
        r"up to PERCENTAGE (\S+) percent never, in (\d+) tries",
        found.sentence,
    )
    assert told
    assert 36.5 <= float(told[2]) < 37.0 <= float(told[1]) < 40.0
    assert int(told[3]) >= 4


def test_what_fails_breaks_nothing_but_without_faults_it_is_an_error(refused):
    known = Known(SPACE.gate.mission)
    known.learn((whole(STOP),), frozenset([G1]))

    def failing(specifications, seed):
        return [FailedFlight("it failed") if each or seed == 2 else KEPT for each in specifications]

    (found,) = mildest(SPACE, known, known.weaknesses(), failing, recorded, (1,))
    assert found.weakness.witness == (whole(STOP),)
    with refused(EvaluationError):
        mildest(SPACE, known, known.weaknesses(), failing, recorded, (1, 2))


def test_a_map_has_every_step_of_value_and_window_and_what_breaks():
    def breaks(drawn, _seed):
        return drawn[0].values[0] >= 45.0 and drawn[0].finish >= 499

    known = Known(SPACE.gate.mission)
    known.learn((whole(LESS, 90.0),), frozenset([G1]))
    (weakness,) = known.weaknesses()

    tried = tried_map(DEVIATION, weakness, Stand(breaks), 1)

    assert {(each.off, each.ticks) for each in tried if each.is_broken} == {
        (each.off, each.ticks) for each in tried if each.off >= 0.45 and each.ticks >= 500
    }
    assert len({each.off for each in tried}) == len({each.ticks for each in tried}) == N_STEPS
    assert max(tried) == (0.9, SPACE.duration, True)
