"""What a mission says of itself."""

from dataclasses import replace

import pytest

from tests.support.world import robot


@pytest.mark.parametrize(
    ("max_speed", "fastest"), [(None, 8.0), (0.0, 0.0), (4.0, 4.0), (11.5, 11.5)]
)
def test_a_robot_reaches_its_greatest_speed_or_twice_the_nominal_one(max_speed, fastest):
    described = replace(robot("a", 0.0, 0.0, speed=4.0), max_speed=max_speed)

    assert described.fastest == fastest
