"""What people read of weaknesses, in sentences."""

import pytest

from mrsfi_runtime.analysis.weaknesses import harmless
from mrsfi_runtime.causes.mildest import ways
from tests.support.search import pool_of
from tests.support.weaknesses import weakness

POOL = pool_of("f2", "f3", "f7", "f9")


@pytest.mark.parametrize(
    "found",
    [
        (),
        (weakness("g1", "believed", "f9"), weakness("g2", "true", "f3", "f9")),
        (weakness("g1", "missed", "f9"), weakness("g2", "true", "f2", "f3")),
        (weakness("g1", "true", "f2", "f3"), weakness("g2", "true", "f7", "f9")),
    ],
)
def test_faults_that_are_in_no_way_to_break_a_goal_are_named_in_the_order_of_the_pool(
    found, approved
):
    approved(harmless(POOL, ways(found)))
