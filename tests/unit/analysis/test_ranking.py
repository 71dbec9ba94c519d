from dataclasses import replace

from mrsfi_runtime.analysis.columns import top
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.campaigns import columns_of, evaluation, store_of
from tests.support.search import paper_mission

MEASURE = Measure.of(CampaignSettings(), paper_mission())
ONE = (TimedFault("f1", 0, 5), TimedFault("f2", 3, 4, (1.0,)))
TWO = (TimedFault("f1", 0, 6), TimedFault("f2", 3, 4, (1.0,)))


def test_the_most_critical_come_first():
    ranked = columns_of([evaluation(i, (v,)) for i, v in enumerate([3, 9, 5, 7])], MEASURE)

    assert ranked.top(3) == (1, 3, 2)


def test_of_equal_fitness_the_earlier_comes_first():
    equal = columns_of([evaluation(i, (5,)) for i in range(4)], MEASURE)

    assert equal.top(3) == (0, 1, 2)


def test_a_specification_counts_once_in_whatever_order_its_faults_stand():
    found = [
        evaluation(0, (1,), specification=ONE),
        evaluation(1, (1,), specification=ONE[::-1]),
        evaluation(2, (1,), specification=TWO),
    ]

    columns = columns_of(found, MEASURE)

    assert columns.distinct.tolist() == [0, 2]
    assert columns.top(10) == (0, 2)
    assert columns.tried == {"f1": 2, "f2": 2}


def test_mean_violations_beside_the_fitness_play_no_part_in_the_ranking():
    low = replace(evaluation(0, (1,)), fitness=(2.0, 9.0))
    high = replace(evaluation(1, (1,)), fitness=(4.0, 0.0))

    with store_of([low, high]) as store:
        assert top(store, MEASURE, 2) == (high, low)
