"""Counting the messages of a tick."""

import pytest

from mrsfi_runtime.errors import ProtocolError, TransportError, TransportTimeout
from mrsfi_runtime.hosting.ledger import GRACE, CountedTransport, Ledger
from mrsfi_runtime.transport.local_bus import LocalBus
from mrsfi_runtime.transport.topics import Topic

SPEED = Topic("/a", "std_msgs/Float64")


@pytest.fixture
def ledger():
    ledger = Ledger("simulation")
    for topic in ("/a", "/b", "/c"):
        ledger.know(topic)
    ledger.open()
    return ledger


def test_a_tick_is_complete_when_its_announced_messages_are_there(ledger):
    steps = [ledger.count("/a"), ledger.count("/b"), ledger.announce(0, 2)]

    assert steps == [False, False, True]


def test_a_message_may_come_after_its_announcement(ledger):
    steps = [ledger.count("/a"), ledger.announce(0, 2), ledger.count("/b")]

    assert steps == [False, False, True]


def test_every_tick_begins_anew(ledger):
    for tick in range(3):
        assert not ledger.count("/a")
        assert ledger.announce(tick, 1)
        ledger.turn()


def test_a_topic_speaks_once_a_tick(ledger):
    ledger.count("/a")

    with pytest.raises(ProtocolError, match="two messages on /a"):
        ledger.count("/a")


def test_more_messages_than_announced_are_an_error(ledger):
    ledger.count("/a")
    ledger.count("/b")

    with pytest.raises(ProtocolError, match=r"2 messages .* it announced 1"):
        ledger.announce(0, 1)


@pytest.mark.parametrize("tick", [-1, 1, 7])
def test_another_tick_than_the_expected_one_is_an_error(ledger, tick):
    with pytest.raises(ProtocolError, match=f"announced tick {tick}; expected tick 0"):
        ledger.announce(tick, 0)


def test_a_tick_that_is_announced_twice_is_an_error(ledger):
    ledger.announce(0, 1)

    with pytest.raises(ProtocolError, match="announced tick 0; expected tick 1"):
        ledger.announce(0, 1)


def test_what_is_missing_is_overdue_after_the_grace(ledger):
    ledger.count("/b")
    ledger.announce(0, 2)

    assert ledger.overdue(GRACE / 2, 10.0) is None
    error = ledger.overdue(2 * GRACE, 10.0)
    assert type(error) is TransportError
    assert "1 of 2 messages of the simulation arrived; nothing on /a, /c" in str(error)


def test_silence_is_overdue_after_the_timeout(ledger):
    assert ledger.overdue(9.9, 10.0) is None
    assert type(ledger.overdue(10.1, 10.0)) is TransportTimeout


def test_between_runs_nothing_counts_and_nothing_is_overdue(ledger):
    ledger.close()

    assert not ledger.count("/a")
    assert not ledger.count("/a")
    assert ledger.overdue(1e9, 1.0) is None


def test_a_message_that_cannot_be_read_names_its_topic(ledger):
    bus = LocalBus()
    transport = CountedTransport(bus, ledger, lambda: None)
    transport.subscribe(SPEED, lambda payload: float(payload["data"]))

    with pytest.raises(ProtocolError, match=r"/a carried .* expected std_msgs/Float64"):
        bus.advertise(SPEED)({"data": None})


def test_a_muted_transport_publishes_nothing(ledger):
    bus, received = LocalBus(), []
    bus.subscribe(SPEED, received.append)
    transport = CountedTransport(bus, ledger, lambda: None)
    publish = transport.advertise(SPEED)

    publish({"data": 1.0})
    transport.is_muted = True
    publish({"data": 2.0})

    assert received == [{"data": 1.0}]
    assert transport.n_sent == 1
