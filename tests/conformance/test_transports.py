"""What every transport does, whatever carries its messages.

The last test runs the others again for roslibpy's own clients.
"""

import asyncio
import json
import os
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from time import monotonic

import pytest
from websockets.asyncio.server import serve

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import TransportClosed, TransportError, UsageError
from mrsfi_runtime.transport.rosbridge import EmbeddedTransport, RosbridgeTransport
from mrsfi_runtime.transport.topics import CLIENTS, LocalBus, Service, Topic
from tests.support.rosbridge import FLIGHT_SEED, code_of, specification
from tests.support.two_sides import TwoSides
from tests.tiers import slow

CLIENT = os.environ.get("MRSFI_TEST_CLIENT", CLIENTS[0])
OTHER = {"wire": "twisted", "asyncio": "twisted", "twisted": "asyncio"}
SPEED = Topic("/r1/speed", "std_msgs/Float64")
ENERGY = Topic("/r1/energy", "std_msgs/Float64")
NUMBERS = Topic("/mission/go", "std_msgs/Int64MultiArray")
RESET = Service("/mission/reset", "std_srvs/Trigger")


@contextmanager
def on_one_bus():
    """Yield two ends that are the same."""
    bus = LocalBus()
    yield bus, bus


@contextmanager
def on_a_server(first, second):
    """Yield two ends, made of a server that both join."""
    with EmbeddedBridge() as bridge:
        yield first(bridge), second(bridge)


def of_socket(bridge):
    return RosbridgeTransport(bridge.url, CLIENT)


TRANSPORTS = {
    "local": on_one_bus,
    "embedded": lambda: on_a_server(EmbeddedTransport, EmbeddedTransport),
    "rosbridge": lambda: on_a_server(of_socket, of_socket),
    "embedded and rosbridge": lambda: on_a_server(EmbeddedTransport, of_socket),
    "rosbridge and embedded": lambda: on_a_server(of_socket, EmbeddedTransport),
}
"""What yields two ends of one bus, by name: a transport of yours is a line here."""


class Ends:
    """Two ends of one bus, and what arrives there."""

    def __init__(self, first, second):
        self.first, self.second = first, second
        self.arrived = SimpleQueue()

    def take(self, n):
        """Return the next n things that arrive."""
        return [self.arrived.get(timeout=10) for _ in range(n)]

    def settle(self):
        """Wait until the server knows what both ends asked for before."""
        for end in (self.first, self.second):
            done = SimpleQueue()
            end.call(Service("/rosapi/get_time", "rosapi/GetTime"), {}, done.put)
            done.get(timeout=10)


@pytest.fixture(params=TRANSPORTS)
def ends(request):
    with TRANSPORTS[request.param]() as (first, second):
        yield Ends(first, second)
        first.close()
        second.close()


@pytest.mark.parametrize(
    ("topic", "values"),
    [
        (SPEED, [0.1, -0.0, 1e300, 5e-324, *map(float, range(200))]),
        (NUMBERS, [[1, 0, 2**62], [], [-1]]),
    ],
    ids=["numbers", "lists"],
)
def test_messages_arrive_in_order_and_whole(ends, topic, values):
    ends.second.subscribe(topic, lambda payload: ends.arrived.put(payload["data"]))
    publish = ends.first.advertise(topic)
    ends.settle()

    for value in values:
        publish({"data": value})

    assert list(map(repr, ends.take(len(values)))) == list(map(repr, values))


def test_order_holds_across_topics(ends):
    for topic in (SPEED, ENERGY):
        ends.second.subscribe(topic, lambda p, name=topic.name: ends.arrived.put((name, p["data"])))
    speed, energy = ends.first.advertise(SPEED), ends.first.advertise(ENERGY)
    ends.settle()

    for value in range(50):
        speed({"data": float(value)})
        energy({"data": float(value)})

    expected = [(t.name, float(value)) for value in range(50) for t in (SPEED, ENERGY)]
    assert ends.take(100) == expected


def test_a_callback_may_publish(ends):
    answer = ends.second.advertise(ENERGY)
    ends.second.subscribe(SPEED, answer)
    ends.first.subscribe(ENERGY, lambda payload: ends.arrived.put(payload["data"]))
    publish = ends.first.advertise(SPEED)
    ends.settle()

    for value in (1.0, 2.0, 3.0):
        publish({"data": value})

    assert ends.take(3) == [1.0, 2.0, 3.0]


def test_a_service_answers_its_caller(ends):
    ends.first.provide(RESET, lambda _request: {"success": True, "message": "run 7"})
    ends.settle()

    ends.second.call(RESET, {}, ends.arrived.put)

    reply = ends.take(1)[0]
    assert (reply.values["success"], reply.values["message"]) == (True, "run 7")
    assert reply.problem == ""


def test_a_service_that_nobody_provides_answers_with_the_problem(ends):
    ends.second.call(RESET, {}, ends.arrived.put)

    reply = ends.take(1)[0]
    assert reply.values == {}
    assert RESET.name in reply.problem


def test_an_error_in_a_callback_is_seen(ends):
    ends.second.watch(ends.arrived.put)
    ends.second.subscribe(SPEED, lambda payload: payload["nothing"])
    publish = ends.first.advertise(SPEED)
    ends.settle()

    try:
        publish({"data": 1.0})
    except KeyError as error:  # the local bus has the publisher see it
        ends.arrived.put(error)

    assert isinstance(ends.take(1)[0], KeyError)


def test_an_error_in_what_takes_a_reply_is_seen(ends):
    ends.first.provide(RESET, lambda _request: {"success": True, "message": ""})
    ends.second.watch(ends.arrived.put)
    ends.settle()

    try:
        ends.second.call(RESET, {}, lambda reply: reply.values["nothing"])
    except KeyError as error:  # on the local bus it is the caller's
        ends.arrived.put(error)

    assert isinstance(ends.take(1)[0], KeyError)


def test_a_closed_transport_delivers_nothing(ends):
    ends.second.subscribe(SPEED, ends.arrived.put)
    publish = ends.first.advertise(SPEED)
    ends.settle()

    ends.second.close()
    publish({"data": 1.0})

    with pytest.raises(Empty):
        ends.arrived.get(timeout=0.3)


def test_what_was_published_before_closing_arrives(ends):
    ends.second.subscribe(SPEED, lambda payload: ends.arrived.put(payload["data"]))
    publish = ends.first.advertise(SPEED)
    ends.settle()

    for value in range(20):
        publish({"data": float(value)})
    ends.first.close()

    assert ends.take(20) == [float(value) for value in range(20)]


def test_a_mission_flies_over_it_as_in_one_process(ends):
    code = code_of("uuv_sampling", 40)
    faults = specification(code, FLIGHT_SEED)

    found = TwoSides(code, 1, ends.first, ends.second).evaluate(faults)

    assert found == ReferenceEngine(code, 1).evaluate(faults)


@pytest.mark.parametrize("end", [EmbeddedTransport, of_socket])
def test_who_closed_a_transport_cannot_publish_on_it(end):
    with EmbeddedBridge() as bridge:
        transport = end(bridge)
        publish = transport.advertise(SPEED)
        transport.close()

        with pytest.raises(TransportClosed, match="was closed"):
            publish({"data": 1.0})


@pytest.mark.parametrize("end", [EmbeddedTransport, of_socket])
def test_callbacks_run_in_one_thread_whichever_publishes(end):
    with EmbeddedBridge() as bridge:
        transport, arrived = end(bridge), SimpleQueue()
        transport.subscribe(SPEED, lambda _: arrived.put(threading.get_ident()))
        publish = transport.advertise(SPEED)

        publish({"data": 1.0})
        other = threading.Thread(target=publish, args=({"data": 2.0},))
        other.start()
        first, second = (arrived.get(timeout=10) for _ in range(2))
        other.join()
        transport.close()

    assert first == second != threading.get_ident()


def test_closing_twice_does_no_harm(ends):
    for _ in range(2):
        ends.first.close()


def test_a_lost_connection_is_told_and_publishing_raises():
    lost = SimpleQueue()
    with EmbeddedBridge() as bridge:
        transport = RosbridgeTransport(bridge.url, CLIENT)
        transport.watch(lost.put)
        publish = transport.advertise(SPEED)

    error = lost.get(timeout=10)
    assert isinstance(error, TransportClosed)
    assert f"the connection to {bridge.url} was lost" in str(error)
    for use in (
        lambda: publish({"data": 1.0}),
        lambda: transport.call(RESET, {}, print),
        lambda: transport.watch(raise_it),
    ):
        with pytest.raises(TransportClosed, match="was lost"):
            use()
    transport.close()


def raise_it(error):
    raise error


def test_a_lost_connection_stays_lost_when_the_server_comes_back():
    with EmbeddedBridge() as bridge:
        transport = RosbridgeTransport(bridge.url, CLIENT)
        lost = SimpleQueue()
        transport.watch(lost.put)
        port = int(bridge.url.rpartition(":")[2])
    lost.get(timeout=10)
    with EmbeddedBridge(ServerSettings(port=port)) as again:
        fresh = RosbridgeTransport(again.url, CLIENT)
        publish = fresh.advertise(SPEED)
        arrived = SimpleQueue()
        transport.subscribe(SPEED, arrived.put)
        publish({"data": 1.0})

        with pytest.raises(Empty):
            arrived.get(timeout=2.0)
        fresh.close()
    transport.close()


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="Linux only")
@pytest.mark.skipif(CLIENTS[0] != CLIENT, reason="roslibpy's own clients leave it to the server")
def test_a_server_that_waits_for_acknowledgements_is_not_kept_waiting():
    n_rounds, delayed_s = 40, 0.04  # what Linux waits before it acknowledges

    async def answer_in_two_writes(connection):
        opened = connection.transport.get_extra_info("socket")
        opened.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 0)
        async for frame in connection:
            if json.loads(frame)["op"] == "publish":
                for name in (ENERGY.name, SPEED.name):
                    await connection.send(json.dumps({"op": "publish", "topic": name, "msg": {}}))
                    await asyncio.sleep(0)

    with served(answer_in_two_writes) as url:
        transport = RosbridgeTransport(url, CLIENT)
        arrived = SimpleQueue()
        transport.subscribe(SPEED, arrived.put)
        publish = transport.advertise(NUMBERS)
        begin = monotonic()
        for _ in range(n_rounds):
            publish({"data": []})
            arrived.get(timeout=10)
        elapsed = monotonic() - begin
        transport.close()

    assert elapsed < n_rounds * delayed_s / 2


@contextmanager
def served(handler):
    """Serve websockets in a thread and yield the URL."""
    urls, ended = SimpleQueue(), threading.Event()

    async def run():
        async with serve(handler, "127.0.0.1", 0, compression=None) as server:
            urls.put(f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}")
            await asyncio.to_thread(ended.wait)

    thread = threading.Thread(target=lambda: asyncio.run(run()))
    thread.start()
    try:
        yield urls.get(timeout=10)
    finally:
        ended.set()
        thread.join()


@pytest.mark.parametrize(
    ("url", "expected"),
    [
        ("127.0.0.1:9090", "expected ws://HOST:PORT"),
        ("http://127.0.0.1:9090", "expected ws://HOST:PORT"),
        ("ws://", "expected ws://HOST:PORT"),
        ("ws://127.0.0.1:99999", "expected a port"),
    ],
)
def test_a_url_that_makes_no_sense_is_a_usage_error(url, expected):
    with pytest.raises(UsageError, match=expected):
        RosbridgeTransport(url, CLIENT)


def test_a_url_where_nobody_listens_is_told_without_its_token():
    with pytest.raises(TransportClosed, match="cannot be reached") as told:
        RosbridgeTransport("ws://127.0.0.1:1/?token=secret", CLIENT)

    assert "secret" not in str(told.value)


def test_a_server_that_asks_for_a_token_lets_in_who_shows_it():
    with EmbeddedBridge(ServerSettings(token="0123456789abcdef")) as bridge:
        told = "requires a token" if CLIENT == "wire" else "expected a rosbridge server"
        with pytest.raises(TransportError, match=told):
            RosbridgeTransport(bridge.url, CLIENT)
        transport = RosbridgeTransport(f"{bridge.url}/?token=0123456789abcdef", CLIENT)
        replies = SimpleQueue()
        transport.call(RESET, {}, replies.put)

        assert RESET.name in replies.get(timeout=10).problem
        transport.close()


def test_one_process_has_one_kind_of_client():
    with EmbeddedBridge() as bridge:
        transport = RosbridgeTransport(bridge.url, CLIENT)
        with pytest.raises(UsageError, match="already uses roslibpy's other client"):
            RosbridgeTransport(bridge.url, OTHER[CLIENT])
        transport.close()


@slow
@pytest.mark.skipif(CLIENTS[0] != CLIENT, reason="the run that this test starts")
@pytest.mark.parametrize("client", CLIENTS[1:])
def test_all_of_this_holds_for_roslibpys_own_clients(client):
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n0", __file__],
        check=False,
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, "MRSFI_TEST_CLIENT": client},
        timeout=240,
    )

    assert done.returncode == 0, done.stdout + done.stderr
