"""Counting the messages of a tick."""

import math
from functools import partial

import pytest

from mrsfi_runtime.cosimulation.bus_topics import GRACE, CountedTopics
from mrsfi_runtime.errors import ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.transport.topics import LocalBus, Topic

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


@pytest.mark.parametrize(
    ("counted", "announced", "message"),
    [
        ("/a /a", [], "two messages on /a"),
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
