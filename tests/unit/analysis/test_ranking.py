from dataclasses import replace

from mrsfi_runtime.analysis.fronts import top
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import columns_of, evaluation, store_of
from tests.support.search import paper_mission

MEASURE = Measure.of(CampaignSettings(), paper_mission())


def test_the_most_critical_come_first_of_equals_the_earlier_and_each_once():
    found = [evaluation(i, (v,)) for i, v in enumerate([3, 9, 5, 9, 7])]

    columns = columns_of([*found, replace(found[3], index=5)], MEASURE)

    assert columns.top(4) == (1, 3, 4, 2)


def test_mean_violations_beside_the_fitness_play_no_part_in_the_ranking():
    low = replace(evaluation(0, (1,)), fitness=(2.0, 9.0))
    high = replace(evaluation(1, (1,)), fitness=(4.0, 0.0))

    with store_of([low, high]) as store:
        assert top(store, MEASURE, 2) == (high, low)
