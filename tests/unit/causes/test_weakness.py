import math
from dataclasses import replace

import numpy as np
import pytest

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.weakness import MEASURES, Known, Yardstick, faults_of, in_seeds
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import FailedFlight
from tests.support.search import outcome_of, paper_mission

MISSION = paper_mission()
FIRST, SECOND = Column("g1", "believed"), Column("g2", "true")


@pytest.mark.parametrize(
    ("without_faults", "with_them", "is_broken"),
    [(0, 0, False), (0, 1, True), (7, 57, False), (7, 58, True), (58, 7, False)],
)
def test_a_goal_is_broken_above_what_is_there_without_faults(without_faults, with_them, is_broken):
    fault_free = outcome_of(*[without_faults] * 6)
    yardstick = Yardstick.of(MISSION, fault_free)

    broken = yardstick.broken(replace(fault_free, believed=(with_them, *[without_faults] * 5)))

    assert broken == ({FIRST} if is_broken else set())


def test_it_is_broken_since_it_exceeds_that():
    flight = {measure: np.zeros((4, 6)) for measure in MEASURES}
    flight["believed"][:, 0] = (7, 57, 58, 59)
    flight["true"][3, 1] = 1

    for without_faults, ticks in ((0, {FIRST: 0, SECOND: 3}), (7, {FIRST: 2})):
        assert Yardstick.of(MISSION, outcome_of(*[without_faults] * 6)).since(flight) == ticks


def test_what_is_truly_broken_is_detected_as_late_as_the_belief_shows_it():
    fault_free = replace(outcome_of(*[0] * 6), true=(0, 0, 0, 4, 0, 0))
    broken = replace(
        fault_free,
        true=(3, 3, 3, 9, 0, 0),
        missed=(0, 0, 0, 0, 1, 0),
        detection=((90, 0), (90, 7), (90, 90), (99, 0), (1, 1), (0, 0)),
    )
    yardstick = Yardstick.of(MISSION, fault_free)

    assert dict(yardstick.late(broken)) == {"g1": 0, "g2": 7, "g3": math.inf, "g5": math.inf}
    assert not [*yardstick.late(replace(broken, detection=None))]  # not recorded


def _flown(known, *faults, breaks=(), start=0):
    known.learn(tuple(TimedFault(f, start, 9) for f in faults), frozenset(breaks))


def test_a_fault_that_breaks_a_goal_alone_is_minimal_and_no_set_with_it_is():
    known = Known(MISSION)
    known.add(FIRST, frozenset({"f1", "f2"}))
    known.add(SECOND, frozenset({"f1", "f2"}))

    _flown(known, "f1", breaks=[FIRST])
    known.add(FIRST, frozenset({"f1", "f3"}))

    assert known.sets[FIRST] == [{"f1"}]
    assert known.sets[SECOND] == [{"f1", "f2"}]
    assert known.has_part_of(FIRST, frozenset({"f1", "f9"}))
    assert not known.has_part_of(SECOND, frozenset({"f1", "f9"}))


def test_several_faults_that_break_a_goal_are_not_taken_for_minimal():
    known = Known(MISSION)

    _flown(known, "f1", "f2", breaks=[FIRST])

    assert not any(known.sets.values())


def test_forms_are_counted_once_and_by_their_faults():
    known = Known(MISSION)
    for start, broken in ((0, [FIRST]), (1, []), (0, [FIRST]), (2, [FIRST, SECOND])):
        _flown(known, "f1", breaks=broken, start=start)
    _flown(known, "f1", "f2", breaks=[FIRST])

    tries = {each.column: (each.n_tried, each.n_broken) for each in known.weaknesses()}
    assert tries == {FIRST: (3, 2), SECOND: (3, 1)}
    breaking = [*known.breaking(FIRST, frozenset({"f1"}))]
    assert breaking == [(TimedFault("f1", start, 9),) for start in (0, 2)]


def test_weaknesses_stand_by_goal_size_and_measure_with_a_form_for_several_or_the_longest():
    known = Known(MISSION)
    _flown(known, "f2", breaks=[SECOND], start=5)
    _flown(known, "f2", breaks=[SECOND, SECOND._replace(kind="believed")], start=1)
    _flown(known, "f3", breaks=[SECOND], start=3)
    _flown(known, "f3", breaks=[SECOND], start=6)
    _flown(known, "f3", start=4)
    _flown(known, "f4", "f5", breaks=[SECOND, FIRST])
    known.add(SECOND, frozenset({"f4", "f5"}))
    known.add(FIRST, frozenset({"f4", "f5"}))

    first, believed, *second = known.weaknesses()
    assert {each.column for each in second} == {SECOND}

    assert (first.column, first.faults) == (FIRST, ("f4", "f5"))
    assert (believed.column.kind, believed.faults) == ("believed", ("f2",))
    assert [each.faults for each in second] == [("f2",), ("f3",), ("f4", "f5")]
    assert second[0].witness == believed.witness == (TimedFault("f2", 1, 9),)
    assert second[1].witness == (TimedFault("f3", 3, 9),)
    assert [(each.n_broken, each.n_tried) for each in second] == [(2, 2), (2, 3), (1, 1)]


def _outcomes(specifications, seed):
    """With f4 and f5 g1 is broken in every seed, and by f5 alone in the second; f6 fails there."""
    assert seed > 1  # that of the weaknesses is known
    for specification in specifications:
        faults = faults_of(specification)
        if seed == 2 and "f6" in faults:
            yield FailedFlight("it failed")
        else:
            is_broken = faults >= {"f4", "f5"} or "f6" in faults or (seed == 2 and "f5" in faults)
            yield outcome_of(int(is_broken), *[0] * 5)


def test_a_set_holds_in_a_seed_if_it_breaks_the_goal_and_no_part_of_it_does():
    known = Known(MISSION)
    _flown(known, "f6", breaks=[FIRST])
    _flown(known, "f4", "f5", breaks=[FIRST])
    known.add(FIRST, frozenset({"f4", "f5"}))

    one, two = in_seeds(MISSION, known.weaknesses(), _outcomes, (1, 2, 3))

    assert (one.faults, one.n_held, one.n_seeds) == (("f6",), 2, 3)
    assert (two.faults, two.n_held, two.n_seeds) == (("f4", "f5"), 2, 3)
    assert two.label == "of this seed"
    assert in_seeds(MISSION, [two], _outcomes, (1, 3))[0].label == "firm"


def test_the_more_specifications_keep_a_goal_since_its_last_set_the_lower_is_the_bound():
    known = Known(MISSION)
    assert known.bound(FIRST) == 1.0

    known.n_kept[FIRST] = 59
    assert known.bound(FIRST) == pytest.approx(0.0495, abs=1e-4)  # of three in sixty, roughly
    known.add(FIRST, frozenset({"f1"}))
    assert known.bound(FIRST) == 1.0

    known.n_kept[FIRST] = 7
    known.add(FIRST, frozenset({"f1", "f2"}))  # nothing new
    assert known.n_kept[FIRST] == 7
