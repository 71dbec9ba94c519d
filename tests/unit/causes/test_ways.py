"""Ways to break a goal, of weaknesses by several measures."""

import pytest

from mrsfi_runtime.causes.ways import ways
from tests.support.weaknesses import weakness


@pytest.mark.parametrize(
    ("measure", "masked", "expected"),
    [
        ("true", True, True),
        ("true", False, False),
        ("missed", True, True),
        ("believed", True, False),
    ],
)
def test_a_way_is_unseen_if_the_goal_truly_breaks_and_the_ci_never_notices(
    measure, masked, expected
):
    (way,) = ways([weakness("g1", measure, "f4", masked=masked)])

    assert way.is_unseen == expected
