from itertools import combinations
from random import Random

import pytest

from mrsfi_runtime.causes.cause_set import Column, Question, floor
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.mission import FailedFlight
from tests.support.planted import faults, flights
from tests.tiers import seeds


def minimum(planted, names, keep=0.95, columns=None):
    return question(planted, names, keep, columns).minimum()


def question(planted, names, keep=0.95, columns=None):
    flown = flights(planted)
    counts = flown.counts(faults(names))
    asked = range(len(counts)) if columns is None else columns
    return Question(flown, faults(names), floor(counts, keep, asked))


def test_of_two_of_which_either_is_enough_only_one_is_in_it():
    planted = {"g1": lambda flown: (10, 0) if {"b", "f"} & flown else (0, 0)}

    asked = question(planted, "abcdefg")

    assert asked.minimum() == (1,)
    assert {*asked.minima()} == {(1,), (5,)}


def test_it_keeps_the_true_violations_as_well_as_those_of_the_measure():
    planted = {"g1": lambda flown: (10 * ("a" in flown), 10 * ("c" in flown))}

    assert minimum(planted, "abcd") == (0, 2)


def test_it_keeps_a_share_of_every_violated_goal():
    planted = {
        "g1": lambda flown: (100, 0) if "a" in flown else (0, 0),
        "g2": lambda flown: (94 * ("b" in flown) + 5 * ("c" in flown) + ("d" in flown), 0),
        "g3": lambda flown: (0, 0),
    }

    assert minimum(planted, "abcd") == (0, 1, 2)
    assert minimum(planted, "abcd", keep=0.94) == (0, 1)
    assert minimum(planted, "abcd", keep=1.0) == (0, 1, 2, 3)


def test_a_share_is_what_is_written_not_the_nearest_binary_number():
    counts = tuple(range(2000))

    kept = floor(counts, 0.95, range(2000))

    assert all(
        20 * least >= 19 * count > 20 * (least - 1) for count, least in kept.items() if least
    )
    assert kept[20] == 19
    assert kept[1900] == 1805
    assert 0 not in kept


def test_what_is_violated_without_any_fault_has_no_cause():
    planted = {"g1": lambda flown: (7, 7)}

    assert minimum(planted, "abc") == ()


@pytest.mark.parametrize("seed", seeds(range(40), 12, 9))
def test_it_is_one_minimal_whatever_the_faults_do_together(seed):
    random = Random(seed)
    names = "abcdefgh"
    table = {
        frozenset(some): tuple(random.choice((0, 5, 90, 100)) for _ in range(4))
        for n in range(len(names) + 1)
        for some in combinations(names, n)
    }
    table[frozenset()] = (0, 0, 0, 0)
    planted = {"g1": lambda flown: table[flown][:2], "g2": lambda flown: table[flown][2:]}
    asked = question(planted, names)

    for found in (asked.minimum(), *asked.minima()):
        assert asked.is_kept_by(found)
        assert not any(asked.is_kept_by({*found} - {place}) for place in found)


def test_every_specification_is_flown_once():
    planted = {"g1": lambda flown: (10, 0) if {"b", "f"} <= flown else (0, 0)}
    asked = question(planted, "abcdefg")
    asked.minimum()
    n_flown = asked.flights.n_flown.total()

    asked.minimum()

    assert asked.flights.n_flown.total() == n_flown < 2**7


def test_counts_are_those_of_the_measure_and_the_true_ones_over_all_mission_seeds():
    planted = {"g1": lambda flown: (3, 8), "g2": lambda flown: (4, 1)}

    flown = flights(planted, "masked")

    assert flown.columns == (
        Column("g1", "masked"),
        Column("g1", "true"),
        Column("g2", "masked"),
        Column("g2", "true"),
    )
    assert flown.counts(faults("a")) == (5, 8, 0, 1)
    assert flights(planted, "true").counts(faults("a")) == (8, 1)


def test_a_flight_that_fails_is_told_with_its_faults(monkeypatch, refused):
    flown = flights({"g1": lambda flown: (1, 1)})
    failed = FailedFlight("Traceback …\nmrsfi_runtime.errors.EvaluationError: a.py:7: division\n")
    monkeypatch.setattr(flown, "_evaluate_many", lambda many, _: [failed for _ in many])

    with refused(EvaluationError):
        flown.counts(faults("ab"))
