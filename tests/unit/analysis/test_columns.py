"""What a report asks of all evaluations, read without an object for each."""

import tracemalloc
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.fronts import Columns, _met
from mrsfi_runtime.analysis.summary import summarise
from mrsfi_runtime.analysis.tables import MOST_LISTED, evaluations_table, every
from mrsfi_runtime.errors import RecordError, SpecificationError
from mrsfi_runtime.model.faults import COSTS, Specification, TimedFault
from mrsfi_runtime.record.database import fault_texts, specification_text
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure
from tests.support.campaigns import columns_of, evaluation, store_of
from tests.support.measures import FLOWN_TWICE, GOALS, HIDING, MASKED, MEANS
from tests.support.search import paper_mission, pool_of
from tests.tiers import slow

MISSION = paper_mission()
MEASURE = Measure.of(CampaignSettings(), MISSION)
ODD = ("f1", "f2", 'f"3', "f\\4", "f]],[5", '["f6,', "é")
TIMED = st.builds(
    TimedFault,
    st.sampled_from(ODD),
    st.integers(0, 2),
    st.integers(3, 4),
    st.lists(st.sampled_from([0.0, -0.0, -0.05, 1e-300, 200.0, 0.1]), max_size=2).map(tuple),
)
SPECIFICATIONS = st.lists(TIMED, max_size=4).map(tuple)


@given(SPECIFICATIONS, SPECIFICATIONS)
def test_the_texts_of_timed_faults_tell_specifications_apart(one, other):
    (faults, texts), (_, others) = (fault_texts(specification_text(each)) for each in (one, other))

    assert faults == [timed.fault for timed in one]
    assert (sorted(texts) == sorted(others)) == (sorted(one) == sorted(other))


@given(st.lists(SPECIFICATIONS, min_size=1, max_size=6), st.integers(1, 3))
def test_the_first_of_each_specification_is_distinct_and_its_faults_were_tried(found, n_rounds):
    flown = [*found, *[specification[::-1] for _ in range(n_rounds) for specification in found]]
    first: dict[Specification, int] = {}
    for index, specification in enumerate(flown):
        first.setdefault(tuple(sorted(specification)), index)

    columns = columns_of(
        [evaluation(i, (1,), specification=each) for i, each in enumerate(flown)], MEASURE
    )

    assert columns.distinct.tolist() == sorted(first.values())
    assert columns.tried == Counter(timed.fault for each in first for timed in each)


def test_the_first_of_a_specification_is_known_thousands_of_evaluations_later():
    found = [evaluation(i, (i % 7,)) for i in range(4_500)]
    again = replace(found[3], index=4_500)

    columns = columns_of([*found, again], MEASURE)

    assert len(columns) == 4_501
    assert columns.distinct.tolist() == list(range(4_500))
    assert columns.distinct_among([4_500, 9, 3, 9]).tolist() == [3, 9]


@pytest.mark.parametrize(
    ("settings", "found"),
    [(CampaignSettings(goals=GOALS), HIDING), (MASKED, HIDING), (MEANS, FLOWN_TWICE)],
)
def test_violations_are_those_that_the_measure_has(settings, found):
    measure = Measure.of(settings, MISSION)

    columns = columns_of(found, measure, ("g3", "g1"))

    expected = [[measure.by_goal(each)[goal] for goal in GOALS] for each in found]
    assert columns.of(GOALS).tolist() == expected


@pytest.mark.parametrize("minimised", ["faults", "fault_ticks"])
def test_costs_are_those_that_the_measure_has(minimised):
    measure = Measure.of(CampaignSettings(minimise=minimised), MISSION)
    sizes = [[TimedFault("f8", 9 * k, 9 * k + n, (1.0,)) for k in range(n)] for n in range(4)]
    found = [evaluation(n, (1,), specification=tuple(each)) for n, each in enumerate(sizes)]

    cost = COSTS[minimised]
    expected = [cost(each.specification, MISSION.duration) for each in found]
    assert columns_of(found, measure).costs.tolist() == expected


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE evaluation SET specification = '[[\"f1\",1]]' WHERE idx = 1",
        "UPDATE evaluation SET fitness = '[null]' WHERE idx = 1",
        "UPDATE evaluation SET fitness = '[]' WHERE idx = 1",
        "UPDATE evaluation SET believed = '[1.5,0,0,0,0,0]' WHERE idx = 1",
        "UPDATE evaluation SET believed = '[1]' WHERE idx = 1",
        "DELETE FROM evaluation WHERE idx = 1",
    ],
)
def test_a_damaged_row_is_refused(change):
    with store_of([evaluation(i, (1,) * 6) for i in range(3)]) as store:
        store._connection.execute(change)

        with pytest.raises(RecordError):
            Columns.read(store, MEASURE, ("g1",))


def test_a_fault_that_the_pool_does_not_have_is_refused(refused):
    odd = evaluation(0, (1,) * 6, specification=(TimedFault("f99", 0, 1),))

    with store_of([odd]) as store, refused(SpecificationError):
        summarise(Path("run"), store, MISSION, pool_of(), None)


def peak(work: Callable[[], object]) -> int:
    """Return the most bytes that some work holds beyond what was held before."""
    tracemalloc.start()
    work()
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most


@slow
def test_memory_grows_by_some_hundred_bytes_an_evaluation():
    sizes = (10_000, 40_000)  # of less, when garbage is collected decides
    peaks = []
    for n in sizes:
        found = (evaluation(i, (i % 9,) * 6) for i in range(n))
        with store_of(found, CampaignSettings(goals=GOALS)) as store:
            arguments = Path("run"), store, MISSION, pool_of(), "g1:g3=1:1"
            peaks.append(peak(partial(summarise, *arguments)))

    grown = (peaks[1] - peaks[0]) / (sizes[1] - sizes[0])
    assert grown < 300


def rows_of(store: CampaignStore, step: int) -> list[object]:
    return [row[0] for row in evaluations_table("", store.flown(step), MEASURE).rows]


def test_a_table_lists_every_so_manyth_evaluation_across_all_that_is_read_at_once():
    with store_of(evaluation(i, (1,) * 6) for i in range(4_100)) as store:
        assert rows_of(store, 1) == list(range(4_100))
        assert rows_of(store, 2) == list(range(0, 4_100, 2))
        assert rows_of(store, 7) == list(range(0, 4_100, 7))


@pytest.mark.parametrize(
    ("n_evaluations", "step"),
    [(0, 1), (9_999, 1), (100_000, 1), (100_001, 2), (200_000, 2), (1_000_000, 10)],
)
def test_at_most_a_hundred_thousand_are_listed(n_evaluations, step):
    assert every(n_evaluations, MOST_LISTED) == step


@pytest.mark.parametrize(
    ("known", "keys", "places"),
    [([], [4, 3, 3], [0, 1]), ([3], [4, 5], [0, 1]), ([3, 5], [5, 4, 4], [1]), ([7], [7], [])],
)
def test_keys_are_new_where_none_before_is_the_same(known, keys, places):
    known, keys = (np.array(each, np.uint64) for each in (known, keys))

    met, new = _met(known, keys)

    assert new == places
    assert met.tolist() == sorted({*known.tolist(), *keys.tolist()})
