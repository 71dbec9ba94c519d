"""What the collective intelligence says before the first motion."""

from functools import partial

import pytest

from mrsfi_runtime.cosimulation.lockstep import Flight
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.transport.topics import LocalBus, Topic
from tests.support.world import paper_code

CODE, SEED = paper_code(), 4
CHANNELS = (("command/heading", "geometry_msgs/Vector3"), ("command/speed", "std_msgs/Float64"))


@pytest.fixture
def heard():
    return {}


@pytest.fixture
def flight(heard):
    bus = LocalBus()
    for robot in CODE.mission.robots:
        switches = [(f"{sensor.id}/command/active", "std_msgs/Bool") for sensor in robot.sensors]
        for channel, kind in (*CHANNELS, *switches):
            name = f"/{robot.id}/{channel}"
            bus.subscribe(Topic(name, kind), partial(heard.__setitem__, name))
    laid_out = plan(CODE.mission, CODE.pool, ())
    return Flight(CODE.functions, CODE.mission, SEED, CODE.interface(bus), laid_out)


def test_its_own_simulation_knows_how_a_mission_begins(flight, heard):
    flight.begin(initial_state(CODE.mission, SEED))

    assert heard == {}


def test_a_simulation_of_others_is_told_every_command(flight, heard):
    start = initial_state(CODE.mission, SEED)

    flight.begin(start, tells_all=True)

    expected = {}
    for robot, command in zip(CODE.mission.robots, start.commands, strict=True):
        heading = {"x": command.heading_x, "y": command.heading_y, "z": 0.0}
        expected[f"/{robot.id}/command/heading"] = heading
        expected[f"/{robot.id}/command/speed"] = {"data": float(robot.speed)}
        for sensor in robot.sensors:
            expected[f"/{robot.id}/{sensor.id}/command/active"] = {"data": True}
    assert heard == expected
