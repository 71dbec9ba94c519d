import json
from dataclasses import replace
from math import inf
from typing import Any

import pytest

from mrsfi_runtime.study.comparison import Comparison, Quartiles, RunResult, as_json, compare, holm
from tests.support.comparisons import run_result


def run(algorithm: str, seed: int, best: float, **others: Any) -> RunResult:
    values = {"improvements": ((1, best / 2), (9, best)), "hypervolume": best / 100}
    return run_result(algorithm, seed, **(values | others))


def three() -> Comparison:
    runs = [run("good", seed, 20.0 + seed) for seed in (1, 2, 3, 4)]
    runs += [run("bad", seed, 10.0 + seed) for seed in (4, 3, 2, 1)]
    runs += [run("fair", seed, 17.0 + 2 * seed, at_once=(seed, 30, None)) for seed in (1, 2, 3, 4)]
    return compare(("bad", "good", "fair"), runs)


def test_runs_stand_by_algorithm_as_given_and_by_seed():
    found = three()

    assert [(one.algorithm, one.seed) for one in found.runs] == [
        (name, seed) for name in ("bad", "good", "fair") for seed in (1, 2, 3, 4)
    ]
    assert found.seeds == (1, 2, 3, 4)
    assert [one.digest for one in found.of("fair")] == ["fair1", "fair2", "fair3", "fair4"]


@pytest.mark.parametrize("unknown", [{}, {"hypervolume": None}])
def test_measures_that_no_run_reached_or_computed_are_left_out(unknown):
    runs = [replace(one, **unknown) for one in three().runs]

    names = [criterion.name for criterion in compare(("bad", "good", "fair"), runs).criteria]

    expected = [
        "fitness",
        "hypervolume",
        "at_once_1",
        "at_once_2",
        "together_1",
        "together_2",
        "front_size",
        "seconds",
    ]
    assert names == [name for name in expected if name not in unknown]


def test_medians_have_quartiles_and_what_was_never_reached_is_infinite():
    found = three().quartiles

    assert found["fitness"]["good"] == Quartiles(21.75, 22.5, 23.25)
    assert found["hypervolume"]["good"] == Quartiles(0.2175, 0.225, 0.2325)
    assert found["at_once_2"]["good"] == Quartiles(inf, inf, inf)
    assert found["at_once_2"]["fair"] == Quartiles(30.0, 30.0, 30.0)


def test_a12_above_a_half_means_that_the_first_does_better_also_where_less_is_better():
    tests = {(test.measure, test.first, test.second): test for test in three().tests}

    assert tests["fitness", "bad", "good"].ranks.a12 == 0.0
    assert tests["at_once_1", "good", "fair"].ranks.a12 == 0.875
    assert tests["at_once_2", "good", "fair"].ranks.a12 == 0.0
    assert tests["at_once_2", "bad", "good"].ranks.a12 == 0.5


def test_every_pair_is_tested_on_every_measure_but_size_and_time():
    tests = three().tests

    assert [(t.first, t.second) for t in tests if t.measure == "fitness"] == [
        ("bad", "good"),
        ("bad", "fair"),
        ("good", "fair"),
    ]
    assert len(tests) == 3 * 6
    assert not {"seconds", "front_size"} & {test.measure for test in tests}


def test_p_values_are_adjusted_for_the_pairs_of_their_measure():
    tests = [test for test in three().tests if test.measure == "fitness"]

    assert tests[0].ranks.p_value == pytest.approx(2 / 70)
    assert tuple(test.holm_p_value for test in tests) == pytest.approx(
        holm([test.ranks.p_value for test in tests])
    )


def test_no_effect_is_told_that_the_runs_cannot_show():
    few = compare(("good", "bad"), [run("good", 1, 9.0), run("bad", 1, 1.0)])
    many = [
        run(name, seed, value + seed)
        for name, value in (("good", 90.0), ("bad", 1.0))
        for seed in range(9)
    ]

    (test, *_) = few.tests
    assert (test.ranks.a12, test.ranks.magnitude, test.effect) == (1.0, "large", "not shown")
    assert compare(("good", "bad"), many).tests[0].effect == "large"


def test_one_algorithm_has_quartiles_and_no_tests():
    found = compare(("good",), [run("good", 1, 5.0)])

    assert found.quartiles["fitness"]["good"] == Quartiles(5.0, 5.0, 5.0)
    assert found.tests == ()


def test_json_has_nothing_that_json_has_not():
    content = json.loads(json.dumps(as_json(three()), allow_nan=False))

    assert content["schema"] == 1
    assert content["quartiles"]["at_once_2"]["good"] == {
        "lower": None,
        "median": None,
        "upper": None,
    }
    assert content["tests"][0] == {
        "measure": "fitness",
        "first": "bad",
        "second": "good",
        "u": 0.0,
        "p_value": pytest.approx(2 / 70),
        "holm_p_value": pytest.approx(6 / 70),
        "method": "exact",
        "a12": 0.0,
        "magnitude": "large",
    }
    assert content["runs"][0]["best_fitness"] == 11.0
