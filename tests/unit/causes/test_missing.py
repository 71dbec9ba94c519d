"""The estimated number of weaknesses: by hand, and beside samples of a known number of sets."""

from random import Random

from mrsfi_runtime.causes.consequences import Total, estimate
from tests.support.weaknesses import weakness


def test_the_estimate_and_its_interval_are_those_of_chao():
    samples = [{*"abcd"}, {*"abef"}, {*"agh"}]  # six sets once, b twice, a three times

    found, nothing, equal = map(Total.of, (samples, [set(), set()], [{*"ab"}, {*"ab"}]))

    missing = 2 / 3 * 6 * 5 / (2 * 2)
    assert found[:2] == (8, 8 + missing)
    # its variance is 5 + 4/9 · (6 · 11² / 16 + 6² · 5² / 64) = 31.4; the factor is 5.86
    assert found[2:] == (8, 38)
    assert nothing == (0, 0, 0, 0)
    assert equal == (2, 2, 2, 4)


def test_intervals_contain_the_number_of_sets_in_nine_of_ten_cases():
    random = Random(1)
    n_right = 0
    for _ in range(400):
        n_sets, n_samples = random.choice([5, 20, 80]), random.choice([2, 3, 6])
        chance = random.choice([0.3, 0.6, 0.9])
        samples = [{k for k in range(n_sets) if random.random() < chance} for _ in range(n_samples)]
        _, _, low, high = Total.of(samples)
        n_right += low <= n_sets <= high

    assert n_right >= 360


def test_sets_with_a_known_part_do_not_count_and_the_first_campaign_may_lack_some():
    first = [weakness("g1", "true", "f1", "f2"), weakness("g1", "true", "f3")]
    second = [
        weakness("g1", "true", "f1"),  # so f1 and f2 are not minimal
        weakness("g1", "believed", "f3", "f4"),  # a part of it breaks the goal by another measure
        weakness("g2", "true", "f5"),
    ]

    by_any, truly = (estimate([first, second], "g1", *some) for some in ((), (["true"],)))

    assert by_any.n_campaigns == 2
    assert by_any.total.n_found == 3
    assert by_any.lacking == (("f1",), ("f3", "f4"))
    assert truly.total[:2] == (2, 2.5)
    assert truly.lacking == (("f1",),)
