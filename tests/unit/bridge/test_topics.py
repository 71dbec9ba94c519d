"""Topics among clients: delivery, types, latching, throttling, ways to leave."""

import pytest

from mrsfi_bridge.settings import Limits
from tests.support.bridge import FLOAT, POINT, TEXT, Peer, new_hub


def advertised(hub, topic="/t", type_name=FLOAT, **more):
    peer = Peer(hub, "warning")
    peer.tell(op="advertise", topic=topic, type=type_name, **more)
    return peer


def subscribed(hub, topic="/t", type_name=FLOAT, **more):
    peer = Peer(hub, "warning")
    peer.tell(op="subscribe", topic=topic, type=type_name, **more)
    return peer


def values(peer):
    return [message["data"] for message in peer.messages()]


def publish(peer, *numbers, topic="/t"):
    for number in numbers:
        peer.tell(op="publish", topic=topic, msg={"data": number})


def test_every_subscriber_receives_every_message_in_order(hub):
    first, second, publisher = subscribed(hub), subscribed(hub), advertised(hub)

    publish(publisher, 1, 2, 3)

    assert values(first) == values(second) == [1.0, 2.0, 3.0]
    assert publisher.take() == []


def test_a_publisher_that_subscribes_receives_its_own_messages(hub):
    peer = advertised(hub)
    peer.tell(op="subscribe", topic="/t")

    publish(peer, 1)

    assert values(peer) == [1.0]


@pytest.mark.parametrize("which", [("a",), ("a", "b"), ()])
def test_subscriptions_of_one_client_deliver_once_and_end_one_by_one_or_all_at_once(hub, which):
    peer, publisher = subscribed(hub, id="a"), advertised(hub)
    peer.tell(op="subscribe", topic="/t", id="b")
    publish(publisher, 1)

    for identifier in which:
        peer.tell(op="unsubscribe", topic="/t", id=identifier)
    if not which:
        peer.tell(op="unsubscribe", topic="/t")
    publish(publisher, 2)

    assert values(peer) == ([1.0, 2.0] if which == ("a",) else [1.0])


def test_unadvertise_is_per_identifier(hub):
    publisher, peer = advertised(hub, id="a"), subscribed(hub)
    publisher.tell(op="advertise", topic="/t", type=FLOAT, id="b")

    publisher.tell(op="unadvertise", topic="/t", id="a")
    publish(publisher, 1)
    publisher.tell(op="unadvertise", topic="/t")

    assert values(peer) == [1.0]
    assert hub.broker.topics["/t"].publishers == {}


def test_names_without_leading_slash_are_the_same_topic_and_keep_their_spelling(hub):
    relative, absolute, publisher = subscribed(hub, "t"), subscribed(hub), advertised(hub, "t/")

    publish(publisher, 1, topic="t")

    assert [operation["topic"] for operation in relative.take()] == ["t"]
    assert [operation["topic"] for operation in absolute.take()] == ["/t"]


def test_a_latched_message_reaches_those_who_come_later_once(hub):
    publisher = advertised(hub, latch=True)
    publish(publisher, 1, 2)

    peer = subscribed(hub, id="a")
    peer.tell(op="subscribe", topic="/t", id="b")

    assert values(peer) == [2.0]


def test_a_latched_message_is_gone_with_its_publisher(hub):
    publisher = advertised(hub, latch=True)
    publish(publisher, 1)
    subscribed(hub, id="keeps the topic")

    publisher.tell(op="unadvertise", topic="/t")

    assert subscribed(hub).take() == []


def test_latched_messages_are_bounded(approved):
    hub, _ = new_hub(Limits(latched_bytes=300))
    publisher, other = (
        advertised(hub, "/a", TEXT, latch=True),
        advertised(hub, "/b", TEXT, latch=True),
    )
    publish(publisher, "x" * 100, "y" * 100, topic="/a")

    publish(other, "z" * 100, topic="/b")

    assert publisher.take() == []
    approved(other.take()[0]["msg"])
    assert values(subscribed(hub, "/a", TEXT)) == ["y" * 100]


@pytest.mark.parametrize(
    "operation",
    [
        {"op": "publish", "topic": "/nowhere", "msg": {}},
        {"op": "publish", "topic": "/t", "msg": {"data": "a"}},
        {"op": "publish", "topic": "/t", "msg": 1},
        {"op": "advertise", "topic": "/t", "type": TEXT},
        {"op": "subscribe", "topic": "/t", "type": TEXT},
        {"op": "advertise", "topic": "/u", "type": "x/Y"},
        {"op": "advertise", "topic": "/u"},
        {"op": "advertise", "topic": "/u v", "type": TEXT},
        {"op": "advertise", "topic": "/", "type": TEXT},
        {"op": "subscribe", "topic": "/u"},
        {"op": "subscribe", "topic": "/t", "throttle_rate": -1},
        {"op": "subscribe", "topic": "/t", "throttle_rate": 10**400},
        {"op": "subscribe", "topic": "/t", "queue_length": -1},
        {"op": "subscribe", "topic": "/t", "fragment_size": 0},
        {"op": "unsubscribe", "topic": "/t"},
        {"op": "unadvertise", "topic": "/u"},
        {"op": "advertise_service", "service": "/a", "type": "x/Y"},
        {"op": "advertise_service", "service": "/rosapi/topics", "type": "std_srvs/Empty"},
        {"op": "unadvertise_service", "service": "/a"},
        {"op": "service_response", "service": "/a", "values": {}},
        {"op": "call_service", "service": 5},
    ],
)
def test_what_is_wrong_is_dropped_counted_and_told_to_those_who_ask(hub, operation, approved):
    told, quiet = advertised(hub), Peer(hub)

    told.tell(**operation, id="mine")
    quiet.tell(**operation)

    (status,) = told.take()
    assert status | {"msg": ""} == {"op": "status", "level": "error", "id": "mine", "msg": ""}
    approved(status["msg"])
    assert hub.counts.dropped >= 1
    assert quiet.take() == []


def test_a_client_may_publish_on_a_topic_in_use_without_advertising(hub):
    peer, other = subscribed(hub), Peer(hub)

    publish(other, 1)

    assert values(peer) == [1.0]


def test_an_unknown_compression_counts_as_none(hub):
    peer, publisher = Peer(hub), advertised(hub)
    peer.tell(op="subscribe", topic="/t", compression="zip")

    publish(publisher, 1)

    assert values(peer) == [1.0]


def test_the_server_numbers_headers_and_gives_those_that_are_there_the_time(hub):
    peer, publisher = Peer(hub), Peer(hub)
    kind = "geometry_msgs/PointStamped"
    publisher.tell(op="advertise", topic="/p", type=kind)
    peer.tell(op="subscribe", topic="/p", type=kind)

    for message in ({}, {"header": {"seq": 9}}, {"header": {"stamp": {"secs": 7}}}):
        publisher.tell(op="publish", topic="/p", msg=message)

    none, now, given = (each["msg"]["header"] for each in peer.take())
    assert [each["seq"] for each in (none, now, given)] == [1, 2, 3]
    assert none["stamp"] == {"secs": 0, "nsecs": 0}
    assert now["stamp"]["secs"] > 1_700_000_000
    assert given["stamp"] == {"secs": 7, "nsecs": 0}


def test_a_topic_without_users_is_forgotten_and_may_change_its_type(hub):
    publisher, peer = advertised(hub), subscribed(hub)

    publisher.tell(op="unadvertise", topic="/t")
    peer.session.leave()
    second = advertised(hub, type_name=TEXT)

    assert second.take() == []
    assert hub.broker.topics["/t"].structure.name == TEXT


def test_a_client_that_leaves_takes_everything_with_it(hub):
    names = set(hub.broker.topics)
    peer, publisher = subscribed(hub), advertised(hub)
    peer.tell(op="subscribe", topic="t", type=FLOAT, throttle_rate=10)

    peer.session.leave()
    publish(publisher, 1)
    publisher.session.leave()

    assert peer.take() == []
    assert set(hub.broker.topics) == names


def test_topics_are_limited(approved):
    hub, _ = new_hub(Limits(topics=5))
    peer = advertised(hub)  # beside the server's four

    peer.tell(op="advertise", topic="/u", type=FLOAT)

    approved(peer.take()[0]["msg"])


def test_messages_that_come_too_early_are_lost_without_a_queue(hub, clock):
    peer, publisher = subscribed(hub, throttle_rate=100), advertised(hub)

    for number in range(10):
        publish(publisher, number)
        clock.advance(0.03)

    assert values(peer) == [0.0, 4.0, 8.0]


def test_a_queue_keeps_the_newest_and_sends_them_in_time(hub, clock):
    peer, publisher = subscribed(hub, throttle_rate=100, queue_length=2), advertised(hub)

    publish(publisher, 0, 1, 2, 3)
    at_once = values(peer)
    clock.advance(0.1)
    then = values(peer)
    clock.advance(0.1)

    assert (at_once, then, values(peer)) == ([0.0], [2.0], [3.0])
    assert hub.waiting.used == 0


def test_a_queue_without_throttling_loses_nothing(hub):
    peer, publisher = subscribed(hub, queue_length=1), advertised(hub)

    publish(publisher, 1, 2, 3)

    assert values(peer) == [1.0, 2.0, 3.0]


def test_the_most_frequent_of_two_wishes_holds(hub, clock):
    peer, publisher = subscribed(hub, throttle_rate=100, queue_length=9, id="a"), advertised(hub)
    publish(publisher, 0, 1, 2)

    peer.tell(op="subscribe", topic="/t", id="b")
    publish(publisher, 3)
    peer.tell(op="unsubscribe", topic="/t", id="b")
    publish(publisher, 4)
    clock.advance(0.1)

    assert values(peer) == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_messages_that_wait_are_bounded_and_the_oldest_lost():
    hub, clock = new_hub(Limits(total_bytes=350))
    peer = subscribed(hub, "/t", TEXT, throttle_rate=1000, queue_length=100)
    publisher = advertised(hub, "/t", TEXT)

    publish(publisher, *(letter * 100 for letter in "abcdef"))
    clock.advance(10)

    assert [text[0] for text in values(peer)] == ["a", "e", "f"]
    assert hub.waiting.used == 0


def test_what_waits_is_given_back_when_its_client_leaves(hub, clock):
    peer, publisher = subscribed(hub, throttle_rate=1000, queue_length=100), advertised(hub)
    publish(publisher, 1, 2, 3)

    peer.session.leave()
    clock.advance(10)

    assert values(peer) == [1.0]
    assert hub.waiting.used == 0


def test_one_message_reaches_clients_in_their_encodings(hub):
    plain, image = subscribed(hub, "/p", POINT), subscribed(hub, "/p", POINT, compression="png")
    publisher = advertised(hub, "/p", POINT)

    publisher.tell(op="publish", topic="/p", msg={"x": 1})

    assert plain.messages() == [{"x": 1.0, "y": 0.0, "z": 0.0}]
    assert [operation["op"] for operation in image.take()] == ["png"]
