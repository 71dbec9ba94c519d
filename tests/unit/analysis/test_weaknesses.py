"""What people read of weaknesses, in sentences."""

import pytest

from mrsfi_runtime.analysis.weaknesses import harmless
from mrsfi_runtime.causes.ways import ways
from tests.support.search import pool_of
from tests.support.weaknesses import weakness

POOL = pool_of("f2", "f3", "f7", "f9")


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        ((), "4 of 4 faults break no goal in any form tried, alone or together: f2, f3, f7, f9"),
        (
            (weakness("g1", "believed", "f9"), weakness("g2", "true", "f3", "f9")),
            "2 of 4 faults break no goal in any form tried, alone or together: f2, f7",
        ),
        (
            (weakness("g1", "missed", "f9"), weakness("g2", "true", "f2", "f3")),
            "1 of 4 faults breaks no goal in any form tried, alone or together: f7",
        ),
        (
            (weakness("g1", "true", "f2", "f3"), weakness("g2", "true", "f7", "f9")),
            "Each of 4 faults breaks a goal in some form, alone or together with others",
        ),
    ],
)
def test_faults_that_are_in_no_way_to_break_a_goal_are_named_in_the_order_of_the_pool(
    found, expected
):
    assert harmless(POOL, ways(found)) == expected
