"""What a mission says of itself."""

from dataclasses import replace

import pytest

from mrsfi_runtime.model.mission import Battery, MotionSource
from tests.support.world import robot


@pytest.mark.parametrize(
    ("max_speed", "fastest"), [(None, 8.0), (0.0, 0.0), (4.0, 4.0), (11.5, 11.5)]
)
def test_a_robot_reaches_its_greatest_speed_or_twice_the_nominal_one(max_speed, fastest):
    described = replace(robot("a", 0.0, 0.0, speed=4.0), max_speed=max_speed)

    assert described.fastest == fastest


def test_what_batteries_and_drives_add_up_to_is_the_same_on_every_python():
    """``sum`` makes 0.6 of these since Python 3.12, and made 0.6000000000000001 before."""
    numbers = (0.1, 0.2, 0.3)
    described = replace(
        robot("a", 0.0, 0.0),
        batteries=tuple(Battery(f"b{n}", "", n) for n in numbers),
        motion_sources=tuple(MotionSource(f"m{n}", "", n) for n in numbers),
    )

    assert described.total_energy == 0.6000000000000001
    assert described.energy_per_distance_unit == 0.6000000000000001
