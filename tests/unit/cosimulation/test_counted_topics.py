"""Counting the messages of a tick."""

import math

import pytest

from mrsfi_runtime.cosimulation.counted_topics import GRACE, CountedTopics
from mrsfi_runtime.errors import ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.transport.local_bus import LocalBus
from mrsfi_runtime.transport.topics import Topic

SPEED = Topic("/a", "std_msgs/Float64")
ENERGY = Topic("/d", "std_msgs/Float64")


@pytest.fixture
def bus():
    return LocalBus()


@pytest.fixture
def count(bus):
    count = CountedTopics(bus, "simulation", lambda: None)
    for topic in ("/a", "/b", "/c"):
        count.subscribe(Topic(topic, SPEED.type), lambda payload: float(payload["data"]))
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


def test_a_topic_speaks_once_a_tick(count):
    count.count("/a")

    with pytest.raises(ProtocolError, match="two messages on /a"):
        count.count("/a")


def test_more_messages_than_announced_are_an_error(count):
    count.count("/a")
    count.count("/b")

    with pytest.raises(ProtocolError, match=r"2 messages .* it announced 1"):
        count.announced(0, 1)


@pytest.mark.parametrize("tick", [-1, 1, 7])
def test_another_tick_than_the_expected_one_is_an_error(count, tick):
    with pytest.raises(ProtocolError, match=f"announced tick {tick}; expected tick 0"):
        count.announced(tick, 0)


def test_a_tick_that_is_announced_twice_is_an_error(count):
    count.announced(0, 1)

    with pytest.raises(ProtocolError, match="announced tick 0; expected tick 1"):
        count.announced(0, 1)


def test_what_is_missing_is_overdue_after_the_grace(count):
    count.count("/b")
    count.announced(0, 2)

    assert count.overdue(GRACE / 2, 10.0) is None
    error = count.overdue(2 * GRACE, 10.0)
    assert type(error) is TransportError
    assert "1 of 2 messages of the simulation arrived; nothing on /a, /c" in str(error)


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
        ("std_msgs/Float64", [0, -1.5], [None, "1", True, math.nan, math.inf, 10**400]),
        ("std_msgs/Int64", [0, 2**63 - 1], [None, "1", True, 1.0, 2**63]),
        ("std_msgs/Bool", [True, False], [None, "true", 1, 0.0]),
        ("std_msgs/Float64MultiArray", [[], [1, 2.0]], [None, 1.0, "12", [1.0, None], [math.nan]]),
    ],
)
def test_a_message_of_another_form_names_its_topic(kind, sound, wrong):
    bus, received = LocalBus(), []
    topics = CountedTopics(bus, "simulation", lambda: None)
    topics.subscribe(Topic("/x", kind), received.append)
    publish = bus.advertise(Topic("/x", kind))

    for value in sound:
        publish({"data": value})
    for payload in ({}, *({"data": value} for value in wrong)):
        with pytest.raises(ProtocolError, match=rf"^/x carried .* expected {kind} of finite"):
            publish(payload)

    assert received == [{"data": value} for value in sound]


@pytest.mark.parametrize(
    ("kind", "payload"),
    [
        ("geometry_msgs/Point", {"x": 0.0, "y": math.nan, "z": 0.0}),
        ("geometry_msgs/Vector3", {"x": 0.0, "z": 0.0}),
        ("rosgraph_msgs/Clock", {"clock": {"sec": 1, "nanosec": 0}}),
    ],
)
def test_so_does_one_with_fields_of_its_own(kind, payload):
    bus = LocalBus()
    CountedTopics(bus, "simulation", lambda: None).subscribe(Topic("/x", kind), print)

    with pytest.raises(ProtocolError, match=rf"^/x carried .* expected {kind} of finite"):
        bus.advertise(Topic("/x", kind))(payload)


def test_muted_topics_publish_nothing(bus, count):
    received = []
    bus.subscribe(ENERGY, received.append)
    publish = count.advertise(ENERGY)

    publish({"data": 1.0})
    count.is_muted = True
    publish({"data": 2.0})

    assert received == [{"data": 1.0}]
    assert count.n_sent == 1
