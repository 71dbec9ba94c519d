"""How likely a goal is to break: exactly by brute force, and what is left out."""

import math
from dataclasses import replace
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.causes.consequences import kept, risk
from mrsfi_runtime.causes.mildest import goal_weaknesses
from mrsfi_runtime.causes.weakness import Share
from mrsfi_runtime.model.faults import FaultPool
from tests.support.search import PAPER_FAULTS
from tests.support.weaknesses import weakness

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
