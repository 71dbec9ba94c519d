"""Fronts and rankings of what a campaign flew."""

from dataclasses import replace
from itertools import pairwise, product
from math import atan2

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.fronts import (
    Front,
    FrontPoint,
    Ratio,
    find_front,
    find_harm,
    nearest_ratio,
    parse_ratio,
    thinned,
)
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Evaluation, Measure
from tests.support.campaigns import columns_of, evaluation
from tests.support.search import paper_mission

MEASURE = Measure.of(CampaignSettings(), paper_mission())
FEWEST = Measure.of(CampaignSettings(minimise="faults"), paper_mission())
VECTORS = st.integers(1, 4).flatmap(
    lambda n: st.lists(st.tuples(*[st.integers(0, 6)] * n), min_size=1, max_size=30)
)


def dominates(a: tuple[int, ...], b: tuple[int, ...]) -> bool:
    return a != b and all(x >= y for x, y in zip(a, b, strict=True))


def front_of(*believed: tuple[int, ...], goals: tuple[str, ...] = ("g1", "g3")) -> Front:
    found = [evaluation(i, counts + (0,) * (6 - len(counts))) for i, counts in enumerate(believed)]
    return find_front(MEASURE, columns_of(found, MEASURE, goals), goals)


@given(VECTORS)
def test_no_member_is_dominated_and_every_other_vector_is(vectors):
    goals = MEASURE.goals[: len(vectors[0])]

    members = [point.violations for point in front_of(*vectors, goals=goals).points]

    assert len(set(members)) == len(members)
    assert set(members) <= set(vectors)
    assert not any(dominates(a, b) for a in members for b in members)
    for vector in set(vectors) - set(members):
        assert any(dominates(member, vector) for member in members)


def test_a_front_reads_the_chosen_goals_of_the_belief_in_the_chosen_order():
    front = front_of((1, 9, 5), (3, 9, 2), (1, 9, 2), goals=("g3", "g1"))

    points = (FrontPoint(1, (2, 3)), FrontPoint(0, (5, 1)))
    assert front == Front(("g3", "g1"), points, "believed violations")


def test_of_equal_violations_the_earliest_evaluation_stands():
    assert front_of((1, 0, 1), (4, 0, 4), (4, 0, 4)).points == (FrontPoint(1, (4, 4)),)


COUNTS = st.tuples(*[st.integers(0, 4)] * 2)


def of_sizes(found: list[tuple[tuple[int, int], int]]) -> list[Evaluation]:
    """Return evaluations of two goals' violations, by specifications of so many faults."""
    return [
        evaluation(
            index,
            (first, 0, second, 0, 0, 0),
            specification=tuple(TimedFault("f8", 9 * n, 9 * n, (index,)) for n in range(n_faults)),
        )
        for index, ((first, second), n_faults) in enumerate(found)
    ]


@given(st.lists(st.tuples(COUNTS, st.integers(1, 4)), max_size=20))
def test_a_front_that_minimises_has_whom_nobody_beats_in_violations_or_in_size(found):
    goals = ("g1", "g3")
    front = find_front(FEWEST, columns_of(of_sizes(found), FEWEST, goals), goals)

    vectors = [(*counts, -size) for counts, size in found]
    expected = {one for one in vectors if not any(dominates(other, one) for other in vectors)}
    assert {(*point.violations, -point.cost) for point in front.points} == expected
    assert len(front.points) == len(expected)
    assert front.aims == ("g1", "g3", "faults")
    for point in front.points:
        assert point.evaluation == vectors.index((*point.violations, -point.cost))


@given(st.lists(st.tuples(COUNTS, st.integers(1, 4)), max_size=20))
def test_harm_is_the_most_that_so_few_faults_do_and_rises(found):
    harm = find_harm(FEWEST, columns_of(of_sizes(found), FEWEST, FEWEST.chosen))

    for size in range(5):
        few = [counts for counts, n_faults in found if n_faults <= size]
        shown = [each for each in harm if each.cost <= size]
        assert bool(few) == bool(shown)
        if shown:
            assert shown[-1].n_violated == max(sum(n > 0 for n in counts) for counts in few)
            assert shown[-1].violations == max(map(sum, few))
    for each in harm:
        (counts, n_faults), (others, n_others) = (
            found[each.n_violated_by],
            found[each.violations_by],
        )
        assert (sum(n > 0 for n in counts), sum(others)) == (each.n_violated, each.violations)
        assert max(n_faults, n_others) == each.cost
    rising = [(each.cost, each.n_violated + each.violations) for each in harm]
    assert all(
        low < high for one, two in pairwise(rising) for low, high in zip(one, two, strict=True)
    )


def test_no_evaluations_have_an_empty_front():
    assert front_of().points == ()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("g3:g1=2:1", Ratio(("g3", "g1"), (2.0, 1.0))),
        (" g3 : g1 = 0.5 : 1 ", Ratio(("g3", "g1"), (0.5, 1.0))),
        ("a-b:c.d=0:7", Ratio(("a-b", "c.d"), (0.0, 7.0))),
    ],
)
def test_a_ratio_is_read(text, expected):
    assert parse_ratio(text) == expected
    assert parse_ratio(str(expected)) == expected


@pytest.mark.parametrize(
    "text",
    [
        "",
        "2:1",
        "g3:g1",
        "g3:g1=2",
        "g3:g1=-2:1",
        "g3:g1=2:x",
        "g3:g1=0:0",
        "g3:g3=2:1",
        "g3:g1:g2=2:1:1",
        "g3:g1=nan:1",
        "g3=2:1",
    ],
)
def test_a_ratio_that_makes_no_sense_is_refused(text, refused):
    with refused(UsageError):
        parse_ratio(text)


def test_the_ratio_picks_by_the_quotient_of_the_named_goals():
    front = front_of((10, 0, 1), (5, 0, 11), (7, 0, 8), (1, 0, 12))

    assert nearest_ratio(front, parse_ratio("g3:g1=2:1")) == FrontPoint(1, (5, 11))
    assert nearest_ratio(front, parse_ratio("g1:g3=1:1")) == FrontPoint(2, (7, 8))
    assert nearest_ratio(front, parse_ratio("g1:g3=1:0")) == FrontPoint(0, (10, 1))


@given(
    st.lists(st.tuples(st.integers(0, 50), st.integers(0, 50)), min_size=1, max_size=12),
    st.integers(0, 9),
    st.integers(1, 9),
)
def test_no_other_point_is_nearer_in_angle(vectors, first, second):
    points = tuple(FrontPoint(i, vector) for i, vector in enumerate(vectors))

    picked = nearest_ratio(Front(("a", "b"), points), Ratio(("a", "b"), (first, second)))

    def angle(vector: tuple[int, int]) -> float:
        return abs(atan2(vector[1], vector[0]) - atan2(second, first))

    candidates = [vector for vector in vectors if vector != (0, 0)]
    if picked is None:
        assert not candidates
    else:
        assert angle(picked.violations) == min(map(angle, candidates))


def test_a_front_without_violations_has_nothing_near():
    assert nearest_ratio(front_of((0, 0, 0)), parse_ratio("g3:g1=2:1")) is None
    assert nearest_ratio(front_of(), parse_ratio("g3:g1=2:1")) is None


def test_a_small_cloud_is_drawn_as_a_whole():
    vectors = np.array([(2, 1), (0, 3), (2, 1)])

    assert thinned(vectors) == ([(0, 3), (2, 1)], 0)


def test_of_a_large_cloud_all_have_a_drawn_point_within_a_200th_of_both_axes():
    size = 500
    near = range(-(size // 200), size // 200 + 1)

    drawn, n_left_out = thinned(np.array([(x, y) for x in range(size) for y in range(size)]))

    assert 0 < n_left_out == size * size - len(drawn)
    xs, ys = np.array(drawn).T
    is_covered = np.zeros((size, size), bool)
    for dx, dy in product(near, near):
        is_covered[np.clip(xs + dx, 0, size - 1), np.clip(ys + dy, 0, size - 1)] = True
    assert is_covered.all()


def test_the_most_critical_come_first_of_equals_the_earlier_and_each_once():
    found = [evaluation(i, (v,)) for i, v in enumerate([3, 9, 5, 9, 7])]

    columns = columns_of([*found, replace(found[3], index=5)], MEASURE)

    assert columns.top(4) == (1, 3, 4, 2)


def test_mean_violations_beside_the_fitness_play_no_part_in_the_ranking():
    low = replace(evaluation(0, (1,)), fitness=(2.0, 9.0))
    high = replace(evaluation(1, (1,)), fitness=(4.0, 0.0))

    assert columns_of([low, high], MEASURE).top(2) == (1, 0)
