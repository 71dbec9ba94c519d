"""What follows from weaknesses: their estimated number, risks, and what to protect first.

The estimate is compared with numbers by hand and with samples of a known number of sets, the risk
of a goal and the greedy cover with brute force.
"""

import math
from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.causes.consequences import (
    Total,
    closing,
    confirmed,
    cover,
    estimate,
    kept,
    ladder,
    risk,
)
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Known, Share
from mrsfi_runtime.model.faults import FaultPool
from tests.support.search import PAPER_FAULTS, paper_mission, paper_space, pool_of
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


CHANCE = st.floats(0.0, 1.0)
SETS = st.dictionaries(st.frozensets(st.sampled_from("abcdefg"), min_size=1), CHANCE, max_size=8)


@given(SETS, st.lists(CHANCE, min_size=7, max_size=7))
def test_the_chance_is_that_of_all_combinations_of_faults(shares, chances):
    likelihoods = dict(zip("abcdefg", chances, strict=True))

    found = kept([*shares.items()], likelihoods)

    expected = 0.0
    for occurs in product([False, True], repeat=7):
        active = {fault for fault, does in zip("abcdefg", occurs, strict=True) if does}
        weight = math.prod(likelihoods[f] if f in active else 1 - likelihoods[f] for f in "abcdefg")
        expected += weight * math.prod(1 - each for some, each in shares.items() if some <= active)
    assert found == pytest.approx(expected, abs=1e-9)


def test_many_sets_that_share_faults_have_a_lower_bound():
    names = [f"f{n}" for n in range(30)]
    shares = [(frozenset([one, names[k - 7], names[k - 12]]), 1.0) for k, one in enumerate(names)]
    likelihoods = dict.fromkeys(names, 0.5)

    assert 0.7 < 1 - kept(shares, likelihoods) < 1 - (1 - 0.5**3) ** 30


def test_risks_leave_out_false_alarms_and_unknown_likelihoods_and_need_others_for_an_upper_value():
    given = {"f1": 0.5, "f2": 0.1, "f3": 0.2}
    pool = FaultPool("p", tuple(replace(f, likelihood=given.get(f.id)) for f in PAPER_FAULTS))
    alone = replace(weakness("g1", "true", "f1"), weighted=Share(0.6, 0.4, 0.8))
    pair = weakness("g1", "missed", "f2", "f3")  # 1 of 4 variants
    first = goal_weaknesses(
        [alone, pair, weakness("g1", "true", "f4"), weakness("g2", "believed", "f1")]
    )
    second = goal_weaknesses([alone])

    one, both, never = (
        risk(pool, *some) for some in (("g1", [first]), ("g1", [first, second]), ("g2", [first]))
    )

    least_share = 1 - 0.975**0.25  # with it, 1 or more of 4 break in 2.5 %
    assert one.lower == both.lower == pytest.approx(1 - 0.8 * (1 - 0.02 * least_share), abs=1e-6)
    assert (one.upper, one.n_sets, one.n_unknown) == (None, 3, 1)
    # two sets are in one campaign, one is in both: 3.25 (3 to 8) are estimated, 2 have likelihoods
    assert both.upper == pytest.approx(1 - 0.5 * 0.98 * (1 - 0.52 / 2) ** 6)
    assert never is None


SOME = st.frozensets(st.sampled_from("abcdefgh"), min_size=1, max_size=4)


@given(st.lists(SOME, min_size=1, max_size=6), st.data())
def test_each_step_closes_most_and_all_take_at_most_a_harmonic_number_times_the_fewest(some, data):
    elements = dict(zip("uvwxyz", some, strict=False))
    struck = st.sampled_from(sorted(frozenset.union(*some)))
    sets = data.draw(st.lists(st.frozensets(struck, min_size=1, max_size=3), max_size=8))

    chosen = cover(elements, sets)

    def left(without):
        return [each for each in sets if not any(elements[name] & each for name in without)]

    for place, name in enumerate(chosen):
        before = chosen[:place]
        ranked = [(len(left([*before, each])), len(elements[each]), each) for each in elements]
        assert name == min(ranked)[2]  # the names are in order
    assert not left(chosen)
    fewest = next(n for n in range(7) if any(not left(c) for c in combinations(elements, n)))
    most = max((len(sets) - len(left([each])) for each in elements), default=0)
    assert len(chosen) <= fewest * sum(Fraction(1, n) for n in range(1, most + 1))


def test_false_alarms_do_not_count_and_each_weakness_flies_without_the_faults_so_far():
    found = goal_weaknesses(
        [
            weakness("g1", "true", "f11"),  # of m2
            weakness("g2", "true", "f2", "f11"),  # of m4 and m2
            weakness("g3", "believed", "f26"),
            weakness("g4", "true", "f2"),
        ]
    )

    steps = ladder(paper_mission(), pool_of(), found)
    flights = [*closing(steps)]

    names = [(step.element, [each.number for each in step.closed]) for step in steps]
    assert names == [("m2", [1, 2]), ("m4", [4])]  # their senders have more faults
    assert [[timed.fault for timed in rest] for _, rest in flights] == [[], ["f2"], []]
    known = Known(paper_space())
    known.learn((), frozenset())
    assert confirmed(steps, known) == (1, {1: True, 4: True})
    second, without_m2 = flights[1]
    known.learn(without_m2, frozenset([second.shown.column]))
    assert confirmed(steps, known) == (2, {1: True, 2: False, 4: True})
