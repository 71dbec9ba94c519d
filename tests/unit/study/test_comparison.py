"""Comparisons of algorithms: variants, results of runs, and rank tests."""

import json
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import combinations, product
from math import erfc, inf, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.database import canonical
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import (
    Comparison,
    Quartiles,
    RankTest,
    RunResult,
    Sweep,
    Variant,
    as_json,
    compare,
    compare_ranks,
    front_volume,
    holm,
    measure_run,
    quartiles,
    variants_of,
)
from tests.support.campaigns import evaluation, store_of
from tests.support.comparisons import run_result
from tests.support.search import paper_mission

FEW = st.lists(st.integers(0, 4), min_size=2, max_size=5)
PAPERS = "crossover=0.7,population=20"
SIX = (0, 0, 0, 0, 0, 0)


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


def wins(first: list[float], second: list[float]) -> float:
    return sum((a > b) + 0.5 * (a == b) for a in first for b in second)


def every_u(pooled: list[float], n_first: int) -> list[float]:
    """Return U of every division of the pooled values."""
    found = []
    for chosen in combinations(range(len(pooled)), n_first):
        first = [pooled[i] for i in chosen]
        second = [value for i, value in enumerate(pooled) if i not in chosen]
        found.append(wins(first, second))
    return found


@given(FEW, FEW)
def test_small_samples_have_the_p_value_of_all_divisions_ties_or_not(first, second):
    u = wins(first, second)
    all_u = every_u([*first, *second], len(first))
    n_least = min(sum(v <= u for v in all_u), sum(v >= u for v in all_u))

    found = compare_ranks(first, second)

    assert (found.u, found.method) == (u, "exact")
    assert found.a12 == pytest.approx(u / (len(first) * len(second)))
    assert found.p_value == pytest.approx(min(1.0, 2 * n_least / len(all_u)))


def test_the_textbook_case_without_ties():
    # Age at diagnosis of five men and four women; U = 17 and p = 0.1111 in the literature.
    men, women = [19, 22, 16, 29, 24], [20, 11, 17, 12]

    found = compare_ranks(men, women)

    assert (found.u, found.method, found.a12) == (17.0, "exact", 0.85)
    assert found.p_value == pytest.approx(14 / 126)
    assert found.magnitude == "large"


def test_a_sample_of_one_value_is_not_told_from_another():
    found = compare_ranks([1.0], [2.0])

    assert (found.u, found.a12) == (0.0, 0.0)
    assert found.p_value > 0.9


@pytest.mark.parametrize("n", [1, 4, 30])
def test_samples_in_which_all_values_are_equal_do_not_differ(n):
    assert compare_ranks([3.0] * n, [3.0] * n) == RankTest(n * n / 2, 1.0, "exact", 0.5)


def test_large_samples_have_the_normal_p_value_with_corrections():
    first = [value % 7 for value in range(30)]
    second = [value % 5 + 1 for value in range(30)]
    _, ties = np.unique([*first, *second], return_counts=True)
    variance = 900 / 12 * (61 - sum(t**3 - t for t in ties) / (60 * 59))
    u = wins(first, second)
    z = (abs(u - 450) - 0.5) / sqrt(variance)

    found = compare_ranks(first, second)

    assert (found.u, found.method) == (u, "normal")
    assert found.p_value == pytest.approx(erfc(z / sqrt(2)))


def test_what_was_never_reached_is_ranked_behind_everything():
    few = compare_ranks([1.0, 2.0, inf], [3.0, inf, inf])
    many = compare_ranks([5.0] * 15 + [inf] * 15, [7.0] * 5 + [inf] * 25)

    assert few == compare_ranks([1.0, 2.0, 4.0], [3.0, 4.0, 4.0])
    assert many == compare_ranks([5] * 15 + [9] * 15, [7] * 5 + [9] * 25)
    assert compare_ranks([-inf, -inf], [-inf]).p_value == 1.0


@pytest.mark.parametrize(
    ("a12", "magnitude"),
    [
        (0.5, "negligible"),
        (0.559, "negligible"),
        (0.56, "small"),
        (0.639, "small"),
        (0.64, "medium"),
        (0.709, "medium"),
        (0.71, "large"),
        (0.0, "large"),
        (0.4, "small"),
    ],
)
def test_magnitude_has_the_thresholds_of_vargha_and_delaney(a12, magnitude):
    assert RankTest(0.0, 1.0, "exact", a12).magnitude == magnitude


def test_holm_adjusts_as_in_the_literature():
    # R: p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert holm([0.6, 0.5]) == (1.0, 1.0)
    assert holm([0.04]) == (0.04,)
    assert holm([]) == ()


@given(st.lists(st.floats(0, 1), max_size=8))
def test_holm_keeps_the_order_and_lowers_no_p_value(p_values):
    adjusted = holm(p_values)

    assert all(p <= a <= 1.0 for p, a in zip(p_values, adjusted, strict=True))
    by_p = sorted(range(len(p_values)), key=p_values.__getitem__)
    assert sorted(adjusted) == [adjusted[place] for place in by_p]


@given(st.lists(st.integers(-50, 50), min_size=1, max_size=12))
def test_quartiles_are_those_of_numpy(values):
    found = quartiles([float(value) for value in values])

    expected = np.quantile(values, [0.25, 0.5, 0.75])
    assert (found.lower, found.median, found.upper) == pytest.approx(tuple(expected))


def test_quartiles_of_what_was_never_reached_are_infinite():
    assert quartiles([3.0, inf, 1.0, 2.0]) == Quartiles(1.75, 2.5, inf)
    assert quartiles([inf, 1.0]) == Quartiles(inf, inf, inf)
    assert quartiles([inf, inf, 1.0, 1.0, 1.0]) == Quartiles(1.0, 1.0, inf)


def test_values_are_listed_or_evenly_spaced_without_rounding():
    sweep = Sweep.parse("mutation=0.1:0.9:5,population=10,20,40:60:3")

    assert sweep.values == {
        "mutation": (0.1, 0.3, 0.5, 0.7, 0.9),
        "population": (10, 20, 40, 50, 60),
    }
    assert len(sweep.settings()) == 25


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (
            "crossover=0.3,0.7,population=20,20",
            ["crossover=0.3,population=20", "crossover=0.7,population=20"],
        ),
        ("crossover=0.3,population=10", ["crossover=0.3,population=10", PAPERS]),
    ],
)
def test_the_papers_setting_is_added_unless_it_is_one_of_them(text, names):
    sweep = Sweep.parse(text)

    variants = variants_of(["eaSimple"], sweep)

    assert [each.name for each in variants] == names
    assert sweep.papers == PAPERS
    assert {each.overrides["algorithm"] for each in variants} == {"eaSimple"}
    assert variants[-1].overrides == {"algorithm": "eaSimple", "crossover": 0.7, "population": 20}


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0.3",
        "crossover=",
        "crossover=high",
        "crossover=1/0",
        "crossover=0:1",
        "crossover=0:1:1",
        "crossover=0:1:2.5",
        "crossover=0:1:1000000000",
        "population=10,,20",
        "crosover=0.5",
        "seed=1,2",
        "crossover=0.5,crossover=0.6",
    ],
)
def test_what_is_no_sweep_is_refused(text, refused):
    with refused(UsageError):
        Sweep.parse(text)


def test_a_sweep_is_of_one_algorithm_and_a_variant_is_as_good_as_a_name(refused):
    sweep, own = Sweep.parse("crossover=0.3"), Variant("own", {"mutation_operator": "free"})

    assert variants_of(["paper", own]) == (Variant("paper", {"algorithm": "paper"}), own)
    with refused(UsageError):
        variants_of(["paper", "random"], sweep)
    with refused(UsageError):
        variants_of([own, own])


def test_every_setting_is_tested_against_the_papers_and_told_better_worse_or_nothing():
    sweep = Sweep.parse("crossover=0.1,0.2,0.3")
    best = {"crossover=0.1": 20.0, "crossover=0.2": 40.0, "crossover=0.3": 60.0}
    runs = [
        run_result(
            name,
            seed,
            improvements=((1, best.get(name, 40.0) + seed),),
            hypervolume=None,
            at_once=(1,),
        )
        for name in sweep.settings()
        for seed in range(8)
    ]

    found = compare(tuple(sweep.settings()), runs, sweep)

    tests = [test for test in found.tests if test.measure == "fitness"]
    assert {test.second for test in tests} == {"crossover=0.7"}
    assert {test.first: test.verdict for test in tests} == {
        "crossover=0.1": "worse",
        "crossover=0.2": "not shown",
        "crossover=0.3": "better",
    }
    assert found.with_values({"crossover": 0.2}) == tuple(40.0 + seed for seed in range(8))
    assert len(found.with_values({})) == 24, "the paper's setting is none of the combinations"


def measured(
    believed: Sequence[tuple[int, ...]],
    goals: tuple[str, ...] = (),
    counts: str = "believed",
) -> RunResult:
    settings = CampaignSettings(seed=3, goals=goals, violations=counts)
    with store_of([evaluation(*each) for each in enumerate(believed)], settings) as store:
        return measure_run(store, paper_mission(), 1.5)


def test_each_improvement_of_the_fitness_is_kept_with_its_place():
    run = measured([(4, 0, 0, 0, 0, 0), (2, 1, 0, 0, 0, 0), (9, 0, 0, 0, 0, 0), (9, *SIX[1:])])

    assert run.improvements == ((1, 4.0), (3, 9.0))
    assert run.best_fitness == 9.0
    assert [run.best_after(n) for n in range(5)] == [0.0, 4.0, 4.0, 9.0, 9.0]


def test_goals_are_counted_by_one_specification_and_by_all_so_far():
    run = measured([SIX, (1, 0, 0, 0, 0, 0), (0, 1, 1, 0, 0, 0), (1, 0, 0, 1, 1, 0)])

    assert run.at_once == (2, 3, 4, None, None, None)
    assert run.together == (2, 3, 3, 4, 4, None)


def test_true_violations_are_looked_at_on_request():
    run = measured([(1, 3, 0, 0, 0, 0)], counts="true")  # of which halves are true: 0 and 1

    assert run.at_once[:2] == (1, None)


def test_no_evaluations_have_a_result():
    run = measured([])

    assert (run.best_fitness, run.hypervolume, run.front_size) == (0.0, 0.0, 0)
    assert run.at_once == run.together == (None,) * 6


def test_the_front_is_over_the_chosen_goals():
    found = [(5, 9, 1, 0, 0, 0), (1, 9, 5, 0, 0, 0), (1, 0, 4, 0, 0, 0)]

    assert measured(found, goals=("g1", "g3")).front_size == 2
    assert measured(found, goals=("g3", "g2")).front_size == 1


@given(st.integers(2, 3), st.data())
def test_hypervolume_is_the_share_of_vectors_that_the_front_reaches(n_goals, data):
    duration = 6
    point = st.tuples(*[st.integers(0, duration)] * n_goals)
    front = data.draw(st.lists(point, min_size=1, max_size=8))
    grid = list(product(range(duration + 1), repeat=n_goals))
    n_reached = sum(
        any(all(x <= y for x, y in zip(vector, member, strict=True)) for member in front)
        for vector in grid
    )

    volume = front_volume(front, [duration] * n_goals)

    assert volume == pytest.approx(n_reached / len(grid))


def test_hypervolume_needs_two_goals_and_not_too_many():
    assert front_volume([(4,)], [10]) is None
    assert front_volume([(4,) * 8], [10] * 8) is None
    assert front_volume([(10,) * 7], [10] * 7) == pytest.approx(1.0)
    assert front_volume([], [10, 10]) == 0.0


@pytest.mark.parametrize(
    ("minimise", "most", "sizes"), [("faults", 4, (1, 3)), ("fault_ticks", 4 * 9, (1, 12))]
)
def test_what_is_minimised_is_one_objective_more_of_the_hypervolume(minimise, most, sizes):
    few, many = sizes
    small = (TimedFault("f8", 0, few - 1, (1.0,)),)
    parts = (3, 5, 4) if minimise == "fault_ticks" else (1, 1, 1)
    large = tuple(TimedFault(f"f{n}", n, n + long - 1) for n, long in enumerate(parts))
    found = [
        evaluation(0, (4, *SIX[1:]), specification=small),
        evaluation(1, (9, *SIX[1:]), specification=large),
        evaluation(2, (4, *SIX[1:]), specification=large),
    ]
    waters = replace(paper_mission(), duration=9)
    settings = CampaignSettings(goals=("g1",), faults=4, minimise=minimise, algorithm="nsga2")

    with store_of(found, settings) as store:
        run = measure_run(store, waters, 1.0)

    reached = 5 * most + (10 - 5) * (most + 1 - many)  # vectors of (0 … 9, 1 … most)
    assert run.hypervolume == pytest.approx(reached / (10 * most))
    assert run.front_size == 2


def test_a_result_survives_json():
    run = measured([(1, 0, 2, 0, 0, 0), (3, 0, 2, 0, 0, 0)])
    unvalued = replace(run, hypervolume=None)

    assert RunResult.from_text(canonical(asdict(run))) == run
    assert RunResult.from_text(canonical(asdict(unvalued))) == unvalued


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", "null"])
def test_a_text_that_is_no_result_is_refused_as_the_store_understands_it(text):
    with pytest.raises((ValueError, TypeError)):
        RunResult.from_text(text)
