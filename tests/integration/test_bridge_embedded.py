"""The server inside this process, with clients that need no socket."""

import json
import threading
from queue import Queue

import pytest
from websockets.sync.client import connect

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.errors import NotRunningError
from mrsfi_runtime.errors import ProtocolError, TransportClosed
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport
from mrsfi_runtime.transport.topics import Service, Topic
from tests.support.bridge import FLOAT, parse_frames

PATIENCE_S = 20.0
SPEED = Topic("/t", FLOAT)


@pytest.fixture
def server():
    with EmbeddedBridge() as bridge:
        yield bridge


def within(bridge, function):
    """Call a function in the server's thread and return what it returns."""
    results = Queue()
    bridge.call_soon(lambda: results.put(function()))
    return results.get(timeout=PATIENCE_S)


def ask(connection, **operation):
    connection.send(json.dumps(operation))
    return json.loads(connection.recv(PATIENCE_S))


def test_what_is_published_in_one_go_leaves_in_one_write(server):
    local = EmbeddedTransport(server)
    names = [f"/t{number}" for number in range(18)]
    publishers = [local.advertise(Topic(name, FLOAT)) for name in names]

    def publish_all():
        for publish in publishers:
            publish({"data": 1.0})

    with connect(server.url) as connection:
        for name in names:
            connection.send(json.dumps({"op": "subscribe", "topic": name, "type": FLOAT}))
        ask(connection, op="call_service", service="/rosapi/get_time")
        writes = within(server, lambda: _writes(server))
        server.call_soon(publish_all)
        topics = [json.loads(connection.recv(PATIENCE_S))["topic"] for _ in names]

        assert topics == names
        assert [len(parse_frames(content)) for content in writes] == [18]


def _writes(server):
    """Return a list that fills with what is written to the only client."""
    writes = []
    (connection,) = server._server._connections
    transport = connection._transport

    class Recorder:
        def write(self, content):
            writes.append(content)
            transport.write(content)

        def __getattr__(self, name):
            return getattr(transport, name)

    connection._transport = Recorder()
    return writes


def test_local_clients_hear_each_other_before_publish_returns(server):
    first, second, received = EmbeddedTransport(server), EmbeddedTransport(server), []

    def talk():
        second.subscribe(SPEED, received.append)
        publish = first.advertise(SPEED)
        publish({"data": 1})
        seen = list(received)
        second.close()
        publish({"data": 2})
        return seen

    assert within(server, talk) == [{"data": 1.0}]
    assert received == [{"data": 1.0}]


def fail(_):
    raise ValueError("on purpose")


def test_the_error_of_a_callback_is_told_and_others_still_receive(server):
    local, received, told = EmbeddedTransport(server), Queue(), Queue()
    local.watch(told.put)
    local.subscribe(SPEED, fail)
    local.subscribe(SPEED, received.put)

    local.advertise(SPEED)({"data": 1})

    assert str(told.get(timeout=PATIENCE_S)) == "on purpose"
    assert received.get(timeout=PATIENCE_S) == {"data": 1.0}


def test_the_error_of_a_service_is_told_to_its_caller_too(server):
    local, told = EmbeddedTransport(server), Queue()
    local.watch(told.put)
    local.provide(Service("/s", "std_srvs/Empty"), fail)

    with connect(server.url) as connection:
        answer = ask(connection, op="call_service", service="/s")

    assert answer["result"] is False
    assert "its provider failed: on purpose" in answer["values"]
    assert isinstance(told.get(timeout=PATIENCE_S), ValueError)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (lambda local: local.advertise(Topic("/t", "x/Y")), "unknown message type"),
        (lambda local: local.subscribe(Topic("/rosout", FLOAT), print), "carries rosgraph_msgs/L"),
        (lambda local: local.provide(Service("/s", "x/Y"), fail), "unknown service type"),
    ],
)
def test_wrong_use_is_an_error_of_the_one_who_uses_it(server, wrong, reason):
    with pytest.raises(ProtocolError, match=reason):
        wrong(EmbeddedTransport(server))


def test_the_error_of_what_is_called_in_its_thread_is_kept(server):
    server.call_soon(lambda: fail(None))
    within(server, list)

    assert str(server.failed) == "on purpose"


def test_closing_twice_is_once_and_leaves_no_thread():
    n_threads = threading.active_count()
    bridge = EmbeddedBridge()
    bridge.start()

    bridge.close()
    bridge.close()

    assert threading.active_count() == n_threads
    with pytest.raises(NotRunningError, match="does not run"):
        bridge.call_soon(print)
    with pytest.raises(TransportClosed, match="does not run"):
        EmbeddedTransport(bridge)


def test_a_server_that_was_never_started_can_be_closed():
    EmbeddedBridge().close()
