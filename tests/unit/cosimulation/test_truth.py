"""What a generated simulation says on a bus beside its topics: the true state, and changes only."""

import pytest

from mrsfi_runtime.cosimulation.lockstep import Heard, take_true_values, true_values
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.transport.topics import LocalBus, Topic
from tests.support.world import paper_code

CODE = paper_code(10)
ACTIVE = "/r1/s2/active"
ACTIVATION = Topic(ACTIVE, "std_msgs/Bool")


def told(values):
    """Return a topic of a robot's true state that has said this."""
    bus = LocalBus()
    heard = Heard(bus, CODE.truth[0])
    bus.advertise(CODE.truth[0])({"data": values})
    return heard


@pytest.fixture
def said():
    """Messages of the simulation, by topic."""
    return {}


@pytest.fixture
def simulation(said):
    bus = LocalBus()
    simulation = CODE.simulation(bus, CODE.mission)
    for topic in (*CODE.truth, ACTIVATION):
        bus.subscribe(topic, said.setdefault(topic.name, []).append)
    simulation.reset(3)
    return simulation


def test_the_true_state_of_every_robot_is_told_whole(simulation, said):
    mirror = initial_state(CODE.mission, 3)
    for tick in range(5):
        simulation.step(tick)
    simulation.publish_truth()

    for index, topic in enumerate(CODE.truth):
        take_true_values(mirror, index, told(said[topic.name][-1]["data"]))

    assert (mirror.robots, mirror.sensors) == (simulation.world.robots, simulation.world.sensors)


def test_nobody_hears_the_truth_unasked(simulation, said):
    simulation.step(0)

    assert said["/truth/r1"] == []


def test_activation_is_told_at_the_first_tick_and_when_it_changed(simulation, said):
    counts = []
    for tick, active in enumerate((1, 1, 0, 0, 1)):
        simulation.world.switches[1].active = active
        simulation.step(tick)
        counts.append(len(said[ACTIVE]))

    assert counts == [1, 1, 2, 2, 3]
    assert said[ACTIVE] == [{"data": True}, {"data": False}, {"data": True}]


def test_a_new_run_tells_activation_again(simulation, said):
    simulation.step(0)
    simulation.reset(3)
    simulation.step(0)

    assert said[ACTIVE] == [{"data": True}] * 2


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ([], "expected 9 numbers"),
        ([1.0] * 8, "expected 9 numbers"),
        ([1.0] * 10, "expected 9 numbers"),
        ([1.0] * 5 + [6.0, 1.0, 7.0, 1.0], "carried count 6.0 and active 1.0 of its sensor 1"),
        ([1.0] * 5 + [7.0, 1.0, 7.5, 1.0], "carried count 7.5 and active 1.0 of its sensor 2"),
        ([1.0] * 5 + [7.0, 1.0, 1e300, 1.0], "carried count 1e"),
        ([1.0] * 5 + [7.0, 1.0, 8.0, 2.0], "carried count 8.0 and active 2.0 of its sensor 2"),
    ],
)
def test_values_that_do_not_fit_a_robot_are_refused(values, problem):
    world = initial_state(CODE.mission, 3)
    for sensor in world.sensors:
        sensor.count = 7

    with pytest.raises(ProtocolError, match=f"^/truth/r1 .*{problem}"):
        take_true_values(world, 0, told(values))


def test_values_are_numbers_of_position_speed_energy_then_of_each_sensor():
    world = initial_state(CODE.mission, 3)
    world.sensors[1].count = 7

    values = true_values(world, 0)

    assert values == [250.0, -250.0, 1.0, 5.0, 100_000.0, 0.0, 1.0, 7.0, 1.0]
