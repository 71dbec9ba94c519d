from itertools import permutations
from random import Random

import pytest

from mrsfi_runtime.causes.explanation import N_EXACT, N_PERMUTATIONS, attribute
from tests.support.planted import faults, flights


def shares(violations, names):
    return attribute(flights({"g1": violations}), faults(names))


def random_violations(names, seed):
    weights = dict(zip(names, Random(seed).sample(range(1000), len(names)), strict=True))

    def violations(flown):
        believed = 3 + sum(weights[name] for name in flown) % 97
        return believed, 1 + sum(weights[name] ** 2 for name in flown) % 89

    return violations


def added(violations, names, column):
    whole, none = violations(frozenset(names)), violations(frozenset())
    return whole[column] - none[column]


@pytest.mark.parametrize("seed", range(5))
def test_exact_shares_are_the_mean_over_all_orders(seed):
    names = "abcde"
    violations = random_violations(names, seed)
    sums = dict.fromkeys(names, 0)
    orders = [*permutations(names)]
    for order in orders:
        for place, name in enumerate(order):
            before = frozenset(order[:place])
            sums[name] += violations(before | {name})[0] - violations(before)[0]

    found = shares(violations, names)

    assert [share[0] * len(orders) for share in found.shares] == [*sums.values()]
    assert found.margins is None


@pytest.mark.parametrize("names", ["", "a", "abcdef", "abcdefghijklm"])
def test_shares_sum_to_what_the_faults_add_to_the_count_without_them(names):
    violations = random_violations(names, 1)

    found = shares(violations, names).shares

    for column in (0, 1):
        assert sum(share[column] for share in found) == added(violations, names, column)


@pytest.mark.parametrize("names", ["abcd", "abcdefghijklm"])
def test_a_fault_that_changes_nothing_gets_nothing(names):
    weighted = random_violations(names[1:], 2)

    found = shares(lambda flown: weighted(flown - {"a"}), names)

    assert found.shares[0] == (0, 0)
    assert found.margins is None or found.margins[0] == (0.0, 0.0)


def test_beyond_ten_faults_shares_are_sampled_and_their_intervals_hold_the_exact_ones():
    names = "abcdefghijklmnop"
    exact = [10 * place for place in range(len(names))]
    pairs = frozenset("ab")

    def violations(flown):
        return sum(exact[names.index(name)] for name in flown) + 100 * (pairs <= flown), 0

    flown = flights({"g1": violations})
    found = attribute(flown, faults(names))

    assert found == attribute(flights({"g1": violations}), faults(names))
    assert found.margins is not None
    expected = [value + 50 * (place < 2) for place, value in enumerate(exact)]
    within = [
        abs(share[0] - value) <= margin[0]
        for share, margin, value in zip(found.shares, found.margins, expected, strict=True)
    ]
    assert len(names) > N_EXACT
    assert all(within[2:])
    assert abs(found.shares[0][0] - 50) < 3 * found.margins[0][0] / 1.96 + 1e-9
    assert flown.n_flown.total() <= N_PERMUTATIONS * (len(names) + 1)
