from dataclasses import replace

from mrsfi_runtime.analysis.fronts import distinct, top
from mrsfi_runtime.model.faults import TimedFault
from tests.support.campaigns import evaluation

ONE = (TimedFault("f1", 0, 5), TimedFault("f2", 3, 4, (1.0,)))
TWO = (TimedFault("f1", 0, 6), TimedFault("f2", 3, 4, (1.0,)))


def test_the_most_critical_come_first():
    ranked = top([evaluation(i, (v,)) for i, v in enumerate([3, 9, 5, 7])], 3)

    assert [entry.index for entry in ranked] == [1, 3, 2]


def test_of_equal_fitness_the_earlier_comes_first_whatever_the_order_given():
    equal = [evaluation(i, (5,)) for i in range(4)]

    assert [entry.index for entry in top(reversed(equal), 3)] == [0, 1, 2]


def test_a_specification_counts_once_in_whatever_order_its_faults_stand():
    found = [
        evaluation(0, (1,), specification=ONE),
        evaluation(1, (1,), specification=ONE[::-1]),
        evaluation(2, (1,), specification=TWO),
    ]

    assert [entry.index for entry in distinct(found)] == [0, 2]
    assert [entry.index for entry in top(found, 10)] == [0, 2]


def test_mean_violations_beside_the_fitness_play_no_part_in_the_ranking():
    low = replace(evaluation(0, (1,)), fitness=(2.0, 9.0))
    high = replace(evaluation(1, (1,)), fitness=(4.0, 0.0))

    assert top([low, high], 2) == (high, low)
