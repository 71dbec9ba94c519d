from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.database import canonical
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import RunResult, front_volume, measure_run
from tests.support.campaigns import evaluation, store_of
from tests.support.search import paper_mission

SIX = (0, 0, 0, 0, 0, 0)


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


def test_a_front_on_an_axis_has_a_volume():
    assert front_volume([(0, 9)], [9, 9]) == pytest.approx(0.1)


def test_a_result_survives_json():
    run = measured([(1, 0, 2, 0, 0, 0), (3, 0, 2, 0, 0, 0)])
    unvalued = replace(run, hypervolume=None)

    assert RunResult.from_text(canonical(asdict(run))) == run
    assert RunResult.from_text(canonical(asdict(unvalued))) == unvalued


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", "null"])
def test_a_text_that_is_no_result_is_refused_as_the_store_understands_it(text):
    with pytest.raises((ValueError, TypeError)):
        RunResult.from_text(text)
