"""Messages of a tick: counted, bundled, the first commands, and the true state."""

import json
import math
from functools import partial

import pytest

from mrsfi_runtime.cosimulation.bus_topics import (
    GO,
    GO_BUNDLE,
    GRACE,
    SETUP,
    TICK,
    TICK_BUNDLE,
    BundlingTransport,
    CountedTopics,
)
from mrsfi_runtime.cosimulation.lockstep import Flight, Heard, take_true_values, true_values
from mrsfi_runtime.errors import ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.goal_tasks import avoid_collision
from mrsfi_runtime.kernel.injections import plan
from mrsfi_runtime.transport.topics import LocalBus, Topic
from tests.support.world import paper_code

FIRST = Topic("/a", "std_msgs/Float64")
ENERGY = Topic("/d", "std_msgs/Float64")
SPEED = Topic("/r1/speed", "std_msgs/Float64")
COMMAND = Topic("/r1/command/speed", "std_msgs/Float64")
ON_THE_BUS = (SPEED, TICK, TICK_BUNDLE, COMMAND, GO, GO_BUNDLE, SETUP)
CODE, SEED = paper_code(), 4
CHANNELS = (("command/heading", "geometry_msgs/Vector3"), ("command/speed", "std_msgs/Float64"))
SHORT = paper_code(10)
CLEAR = [type(goal.task) for goal in SHORT.mission.goals].index(avoid_collision.AvoidCollision)
ACTIVE = "/r1/s2/active"
ACTIVATION = Topic(ACTIVE, "std_msgs/Bool")


@pytest.fixture
def bus():
    return LocalBus()


@pytest.fixture
def count(bus):
    count = CountedTopics(bus, "simulation", lambda: None)
    for topic in ("/a", "/b", "/c"):
        count.subscribe(Topic(topic, FIRST.type), lambda payload: float(payload["data"]))
    count.open()
    return count


@pytest.mark.parametrize("order", [("/a", "/b", ""), ("/a", "", "/b"), ("", "/a", "/b")])
def test_a_tick_is_complete_when_its_announced_messages_are_there_in_any_order(count, order):
    steps = [count.count(topic) if topic else count.announced(0, 2) for topic in order]

    assert steps == [False, False, True]


def test_every_tick_begins_anew(count):
    for tick in range(3):
        assert not count.count("/a")
        assert count.announced(tick, 1)
        count.turn()


@pytest.mark.parametrize(
    ("counted", "announced", "message"),
    [
        ("/a /a", [], "two messages arrived on /a"),
        ("/a /b", [(0, 1)], r"2 messages .* it announced 1"),
        *(("", [(tick, 0)], f"announced tick {tick}; expected tick 0") for tick in (-1, 1, 7)),
        ("", [(0, 1), (0, 1)], "announced tick 0; expected tick 1"),
    ],
)
def test_what_does_not_add_up_is_an_error(count, counted, announced, message):
    steps = [partial(count.count, topic) for topic in counted.split()]
    *before, last = [*steps, *(partial(count.announced, *each) for each in announced)]
    for step in before:
        step()

    with pytest.raises(ProtocolError, match=message):
        last()


def test_what_is_missing_is_overdue_after_the_grace(count):
    count.count("/b")
    count.announced(0, 2)

    assert count.overdue(GRACE / 2, 10.0) is None
    error = count.overdue(2 * GRACE, 10.0)
    assert type(error) is TransportError
    assert "1 of 2 messages from the simulation arrived; none on /a, /c" in str(error)


def test_what_arrives_on_no_known_topic_is_of_another_mission(count):
    for topic in ("/a", "/b", "/c"):
        count.count(topic)
    count.announced(0, 4)

    assert "3 of 4 messages from the simulation arrived; it flies another mission" in str(
        count.overdue(2 * GRACE, 10.0)
    )


def test_silence_is_overdue_after_the_timeout(count):
    assert count.overdue(9.9, 10.0) is None
    assert type(count.overdue(10.1, 10.0)) is TransportTimeout


def test_between_runs_nothing_counts_and_nothing_is_overdue(count):
    count.close()

    assert not count.count("/a")
    assert not count.count("/a")
    assert count.overdue(1e9, 1.0) is None


@pytest.mark.parametrize(
    ("kind", "sound", "wrong"),
    [
        *(
            (f"std_msgs/{kind}", *([{"data": value} for value in values] for values in both))
            for kind, *both in (
                ("Float64", [0, -1.5], [None, "1", True, math.nan, math.inf, 10**400]),
                ("Int64", [0, 2**63 - 1], [None, "1", True, 1.0, 2**63]),
                ("Bool", [True, False], [None, "true", 1, 0.0]),
                ("Float64MultiArray", [[], [1, 2.0]], [None, 1.0, "12", [1.0, None], [math.nan]]),
            )
        ),
        ("geometry_msgs/Point", [], [{"x": 0.0, "y": math.nan, "z": 0.0}]),
        ("geometry_msgs/Vector3", [], [{"x": 0.0, "z": 0.0}]),
        (
            "rosgraph_msgs/Clock",
            [{"clock": {"secs": 1, "nsecs": 0}}, {"clock": {"sec": 1, "nanosec": 0}}],
            [{"clock": {"sec": 1.0}}, {"clock": {"nanosec": 0}}],
        ),
    ],
)
def test_a_message_of_another_form_names_its_topic(kind, sound, wrong):
    bus, received = LocalBus(), []
    topics = CountedTopics(bus, "simulation", lambda: None)
    topics.subscribe(Topic("/x", kind), received.append)
    publish = bus.advertise(Topic("/x", kind))

    for payload in sound:
        publish(payload)
    for payload in ({}, *wrong):
        with pytest.raises(ProtocolError, match=rf"^/x carried .* expected {kind} of finite"):
            publish(payload)

    assert received == sound


def test_muted_topics_publish_nothing(bus, count):
    received = []
    bus.subscribe(ENERGY, received.append)
    publish = count.advertise(ENERGY)

    publish({"data": 1.0})
    count.is_muted = True
    publish({"data": 2.0})

    assert received == [{"data": 1.0}]
    assert count.n_sent == 1


@pytest.fixture
def passed(bus):
    """All that passes on the bus, in order."""
    messages = []
    for topic in ON_THE_BUS:
        bus.subscribe(topic, lambda payload, topic=topic: messages.append((topic, payload["data"])))
    return messages


def test_what_belongs_to_a_tick_travels_as_one_message(bus, passed):
    ci = BundlingTransport(bus, is_ci=True)
    command, go = ci.advertise(COMMAND), ci.advertise(GO)

    command({"data": 1.5})
    go({"data": [1, 0, 1]})

    (sent,) = passed
    assert sent[0] == GO_BUNDLE
    assert json.loads(sent[1]) == [[COMMAND.name, {"data": 1.5}], [GO.name, {"data": [1, 0, 1]}]]


def test_the_other_side_hears_each_message_in_order(bus):
    ci, simulation = BundlingTransport(bus, is_ci=True), BundlingTransport(bus, is_ci=False)
    command, go = ci.advertise(COMMAND), ci.advertise(GO)
    heard = []
    for topic in (GO, COMMAND):
        simulation.subscribe(topic, partial(lambda name, said: heard.append((name, said)), topic))

    command({"data": 0.1 + 0.2})
    go({"data": [1, 0, 1]})

    assert heard == [(COMMAND, {"data": 0.1 + 0.2}), (GO, {"data": [1, 0, 1]})]


@pytest.mark.parametrize("is_bundling", [True, False])
def test_a_simulation_answers_in_kind(bus, passed, is_bundling):
    ci = BundlingTransport(bus, is_ci=True) if is_bundling else bus
    simulation = BundlingTransport(bus, is_ci=False)
    speed, tick, go = simulation.advertise(SPEED), simulation.advertise(TICK), ci.advertise(GO)
    simulation.subscribe(GO, lambda _: (speed({"data": 2.0}), tick({"data": [1, 0, 1]})))

    go({"data": [1, 0, 0]})

    topics = [topic for topic, _ in passed]
    expected = [GO_BUNDLE, TICK_BUNDLE] if is_bundling else [SPEED, TICK, GO]  # depth first
    assert sorted(topics) == sorted(expected)


def test_a_simulation_that_answered_bundles_goes_back_to_messages(bus, passed):
    ci, simulation = BundlingTransport(bus, is_ci=True), BundlingTransport(bus, is_ci=False)
    tick = simulation.advertise(TICK)
    simulation.subscribe(GO, tick)

    ci.advertise(GO)({"data": [1, 0, 0]})
    bus.advertise(GO)({"data": [2, 0, 0]})

    assert sorted({topic for topic, _ in passed}) == sorted({GO_BUNDLE, TICK_BUNDLE, GO, TICK})


def test_what_waits_of_a_run_that_ended_is_dropped_when_the_next_begins(bus, passed):
    ci = BundlingTransport(bus, is_ci=True)
    setup, command, go = ci.advertise(SETUP), ci.advertise(COMMAND), ci.advertise(GO)

    command({"data": 1.5})
    setup({"data": [2, 7]})
    go({"data": [2, 0, 0]})

    assert passed == [(SETUP, [2, 7]), (GO_BUNDLE, '[["/mission/go",{"data":[2,0,0]}]]')]


def test_what_nobody_subscribed_to_is_left_aside(bus):
    ci, heard = BundlingTransport(bus, is_ci=True), []
    ci.subscribe(TICK, heard.append)

    bus.advertise(TICK_BUNDLE)({"data": '[["/other", {}], ["/mission/tick", {"data": [1]}]]'})

    assert heard == [{"data": [1]}]


@pytest.mark.parametrize("text", [None, 3, "", "[", "{}x", '["a"]', '[["a"]]', '[["a", 1]]'])
def test_a_bundle_of_another_form_is_refused(bus, text):
    BundlingTransport(bus, is_ci=True)

    with pytest.raises(ProtocolError, match=r"/mission/tick/bundle carried .*; expected a JSON"):
        bus.advertise(TICK_BUNDLE)({"data": text})


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

    flight.begin(start, sends_all=True)

    expected = {}
    for robot, command in zip(CODE.mission.robots, start.commands, strict=True):
        heading = {"x": command.heading_x, "y": command.heading_y, "z": 0.0}
        expected[f"/{robot.id}/command/heading"] = heading
        expected[f"/{robot.id}/command/speed"] = {"data": float(robot.speed)}
        for sensor in robot.sensors:
            expected[f"/{robot.id}/{sensor.id}/command/active"] = {"data": True}
    assert heard == expected


def told(values):
    """Return a topic of a robot's true state that has said this."""
    bus = LocalBus()
    heard = Heard(bus, SHORT.truth[0])
    bus.advertise(SHORT.truth[0])({"data": values})
    return heard


@pytest.fixture
def said():
    """Messages of the simulation, by topic."""
    return {}


@pytest.fixture
def simulation(said):
    bus = LocalBus()
    simulation = SHORT.simulation(bus, SHORT.mission)
    for topic in (*SHORT.truth, ACTIVATION):
        bus.subscribe(topic, said.setdefault(topic.name, []).append)
    simulation.reset(3)
    return simulation


def test_the_true_state_of_every_robot_is_told_whole(simulation, said):
    mirror = initial_state(SHORT.mission, 3)
    for tick in range(5):
        simulation.step(tick)
    simulation.publish_truth()

    for index, topic in enumerate(SHORT.truth):
        take_true_values(mirror, index, told(said[topic.name][-1]["data"]))

    assert (mirror.robots, mirror.sensors) == (simulation.world.robots, simulation.world.sensors)


def test_a_robot_faster_than_its_maximum_speed_still_meets_what_is_on_its_way():
    world = initial_state(SHORT.mission, 3)
    first, second = world.robots[0], world.robots[1]
    second.x = second.y = first.y = 10_000.0
    first.x = 9_950.0
    for wake, robot in zip(world.wakes, (first, second), strict=False):
        wake.x, wake.y = robot.x, robot.y
    before = avoid_collision.violated(world, CLEAR)

    take_true_values(world, 0, told([10_050.0, *true_values(world, 0)[1:]]))

    assert (before, avoid_collision.violated(world, CLEAR)) == (False, True)


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
    world = initial_state(SHORT.mission, 3)
    for sensor in world.sensors:
        sensor.count = 7

    with pytest.raises(ProtocolError, match=f"^/truth/r1 .*{problem}"):
        take_true_values(world, 0, told(values))


def test_values_are_numbers_of_position_speed_energy_then_of_each_sensor():
    world = initial_state(SHORT.mission, 3)
    world.sensors[1].count = 7

    values = true_values(world, 0)

    assert values == [250.0, -250.0, 1.0, 5.0, 100_000.0, 0.0, 1.0, 7.0, 1.0]
