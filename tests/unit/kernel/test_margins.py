import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN, patience

NUMBERS = st.floats(-1e6, 1e6)


@given(NUMBERS, NUMBERS, st.floats(0.0, 1e3))
def test_a_margin_is_looked_at_before_it_can_be_the_least(left, least, speed):
    wait = patience(left, least, speed)

    assert wait >= 1
    assert wait == 1 or left - (wait - 1) * speed >= least


@pytest.mark.parametrize(
    ("left", "speed", "expected"), [(3.0, 0.0, NEVER), (NO_MARGIN, 2.0, NEVER), (7.0, 2.0, 3)]
)
def test_what_cannot_come_nearer_is_not_looked_at(left, speed, expected):
    assert patience(left, 1.0, speed) == expected
