"""Ways to break a goal, of weaknesses by several measures."""

import math

import pytest

from mrsfi_runtime.causes.mildest import ways
from mrsfi_runtime.causes.weakness import Detection
from tests.support.weaknesses import weakness


@pytest.mark.parametrize(
    ("late", "expected"), [((0.0, math.inf), True), ((0.0, 3.0), False), ((), False)]
)
def test_a_way_is_undetected_if_a_variant_is_never_detected(late, expected):
    found = Detection.of(dict(enumerate(late)))

    (way,) = ways([weakness("g1", "true", "f4", detection=found)])

    assert way.is_undetected == expected
