from collections import Counter

import pytest

from mrsfi_runtime.analysis.tables import find_patterns
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from tests.support.fault_types import FAULT_TYPES

POOL = FaultPool(
    "fs",
    (
        Fault("f1", FAULT_TYPES["ZeroSpeed"], "m1"),
        Fault("f2", FAULT_TYPES["StopRobot"], "r1"),
        Fault("f3", FAULT_TYPES["ZeroSpeed"], "m2"),
        Fault("f4", FAULT_TYPES["StartRobot"], "r1"),
    ),
)


def timed(*faults: str) -> tuple[TimedFault, ...]:
    return tuple(TimedFault(fault, 10 * i, 10 * i + 5) for i, fault in enumerate(faults))


def counted(specifications: list[Specification]) -> Counter[str]:
    return Counter(each.fault for specification in specifications for each in specification)


def test_occurrences_stand_beside_what_the_shares_would_give():
    top = [timed("f1", "f3", "f2"), timed("f1")]
    campaign = [*top, timed("f2", "f2", "f2", "f4")]

    zero, stop, start = find_patterns(top, counted(campaign), POOL)

    assert (zero.type, zero.n_occurrences, zero.n_specifications) == ("ZeroSpeed", 3, 2)
    assert (zero.share, zero.pool_share, zero.campaign_share) == (0.75, 0.5, 0.375)
    assert (zero.pool_expected, zero.campaign_expected) == (2.0, 1.5)
    assert (stop.type, stop.n_occurrences, stop.n_specifications) == ("StopRobot", 1, 1)
    assert (start.type, start.n_occurrences, start.campaign_expected) == ("StartRobot", 0, 0.5)


def test_expected_counts_add_up_to_the_occurrences():
    top = [timed("f1", "f3", "f2", "f2"), timed("f4", "f4", "f4")]

    patterns = find_patterns(top, counted(top), POOL)

    assert sum(pattern.n_occurrences for pattern in patterns) == 7
    assert sum(pattern.pool_expected for pattern in patterns) == pytest.approx(7)
    assert sum(pattern.campaign_expected for pattern in patterns) == pytest.approx(7)


def test_equal_occurrences_stand_by_name():
    patterns = find_patterns([timed("f4", "f2", "f1")], {}, POOL)

    assert [pattern.type for pattern in patterns] == ["StartRobot", "StopRobot", "ZeroSpeed"]


def test_no_specifications_give_zeros():
    patterns = find_patterns([], {}, POOL)

    assert {(p.n_occurrences, p.share, p.pool_expected) for p in patterns} == {(0, 0.0, 0.0)}
