"""One tick of the simulated world."""

import pytest

from mrsfi_runtime.kernel.commands import move, reports_position
from tests.support.world import robot, state

VALID = [1, 2, 0, 3]


def test_a_robot_moves_by_its_speed_along_its_heading():
    world = state()
    world.commands[0].heading_x, world.commands[0].heading_y = 0.6, 0.8
    world.commands[0].speed = 5.0

    move(world, VALID, 0)

    assert (world.robots[0].x, world.robots[0].y, world.robots[0].speed) == (3.0, 4.0, 5.0)


@pytest.mark.parametrize(("speed", "expected"), [(-1.0, 0.0), (7.0, 7.0), (99.0, 8.0)])
def test_no_command_makes_a_robot_faster_than_it_is(speed, expected):
    world = state()
    world.commands[0].speed = speed

    move(world, VALID, 0)

    assert world.robots[0].speed == expected


def test_energy_pays_for_distance_and_for_all_samples_of_active_sensors():
    world = state()
    world.switches[1].active = 0

    move(world, VALID, 0)

    assert world.robots[0].energy == 10_000.0 - 4.0 * 5.0 - 2 * 3.0
    assert world.robots[1].energy == 10_000.0 - 4.0 * 5.0 - 2 * 3.0 * 2


def test_an_inactive_sensor_takes_no_samples():
    world = state()
    world.switches[1].active = 0

    for tick in range(50):
        move(world, VALID, tick)

    assert [sensor.count for sensor in world.sensors] == [50, 0, 0, 150]


def test_a_robot_without_energy_stops_with_its_sensors():
    world = state(robots=(robot("a", 0.0, 0.0, energy=30.0),))
    move(world, VALID, 0)
    stopped_at = (world.robots[0].x, world.robots[0].y)
    count = world.sensors[0].count

    move(world, VALID, 1)

    assert world.robots[0].energy == 0.0
    assert (world.robots[0].x, world.robots[0].y, world.robots[0].speed) == (*stopped_at, 0.0)
    assert [sensor.active for sensor in world.sensors] == [0, 0]
    assert world.sensors[0].count == count


def test_position_is_reported_only_while_the_gps_is_active():
    world = state()
    world.switches[0].active = 0

    move(world, VALID, 0)

    assert not reports_position(world, 0)
    assert reports_position(world, 1)
