"""The server on real sockets: access, limits, clients that misbehave, and those that do not."""

import json
import os
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import pytest
from websockets.exceptions import InvalidStatus

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import Limits, ServerSettings
from tests.integration.network import (
    MEBI,
    PATIENCE,
    Client,
    Witness,
    masked_frame,
    opening_handshake,
    raw_socket,
    send_operation,
)
from tests.support.bridge import TEXT, parse_frames

TOKEN = "0123456789abcdef"


@contextmanager
def bridge(limits: Limits | None = None, **settings: Any) -> Iterator[EmbeddedBridge]:
    with EmbeddedBridge(ServerSettings(limits=limits or Limits(), **settings)) as server:
        yield server
    assert server.failed is None


def client(server: EmbeddedBridge, path: str = "/", **options: Any) -> Client:
    return Client(server.url + path, **options)


def is_served(server: EmbeddedBridge) -> bool:
    """Return whether two new clients can talk to each other."""
    with Witness(server.url) as witness:
        return witness.is_served()


def raw(server: EmbeddedBridge) -> socket.socket:
    """Return a socket on which nothing was said."""
    host, port = server.url.removeprefix("ws://").split(":")
    return socket.create_connection((host, int(port)), PATIENCE)


def until_closed(connection: socket.socket) -> float:
    """Return how long it takes the server to close a socket."""
    start = time.monotonic()
    connection.settimeout(PATIENCE)
    try:
        while connection.recv(65536):
            pass
    except ConnectionResetError:
        pass
    return time.monotonic() - start


def test_operations_that_share_a_segment_with_the_handshake_are_carried_out():
    with bridge() as server, raw(server) as connection:
        call = json.dumps({"op": "call_service", "service": "/rosapi/get_time"}).encode()
        connection.sendall(opening_handshake(server.url) + masked_frame(call))
        content = connection.recv(65536)
        while b"secs" not in content:
            content += connection.recv(65536)

    assert content.startswith(b"HTTP/1.1 101")


def test_a_message_may_come_in_several_frames():
    text = json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": "é"}).encode()
    with bridge() as server, raw_socket(server.url) as connection:
        for number, byte in enumerate(text):
            is_final = number == len(text) - 1
            opcode = 1 if number == 0 else 0
            connection.sendall(masked_frame(bytes((byte,)), opcode, is_final=is_final))

        (frame,) = parse_frames(connection.recv(65536))

    assert json.loads(frame.data)["result"] is True


@pytest.mark.parametrize(
    ("path", "headers"), [(f"/?token={TOKEN}", {}), ("/", {"Authorization": f"Bearer {TOKEN}"})]
)
def test_a_client_that_shows_the_token_is_let_in(path, headers):
    with bridge(token=TOKEN) as server, client(server, path, additional_headers=headers) as guest:
        guest.settle()


@pytest.mark.parametrize("path", ["/", "/?token=", f"/?token={TOKEN[:-1]}x", "/?token=%ff%c3%28"])
def test_a_client_without_the_token_is_not(path):
    with bridge(token=TOKEN) as server, pytest.raises(InvalidStatus) as refusal:
        client(server, path)

    assert refusal.value.response.status_code == 401
    assert b"token" in refusal.value.response.body


@pytest.mark.parametrize(
    ("origin", "is_let_in"),
    [
        (None, True),
        ("http://localhost:8080", True),
        ("https://127.0.0.1", True),
        ("http://ui.example", True),
        ("http://evil.example", False),
        ("http://localhost.evil.example", False),
        ("null", False),
    ],
)
def test_only_pages_of_this_machine_and_those_named_may_connect(origin, is_let_in):
    with bridge(origins=("http://ui.example",)) as server:
        if is_let_in:
            client(server, origin=origin).close()
            return
        with pytest.raises(InvalidStatus) as refusal:
            client(server, origin=origin)

    assert refusal.value.response.status_code == 403


def test_one_client_too_many_is_refused_until_another_leaves():
    with bridge(Limits(clients=2)) as server:
        first, second = client(server), client(server)
        with pytest.raises(InvalidStatus) as refusal:
            client(server)
        first.close()
        third = client(server)

        second.settle()
        third.settle()
        second.close()
        third.close()

    assert refusal.value.response.status_code == 503
    assert b"the limit of 2 clients is reached" in refusal.value.response.body


def test_who_is_connected_is_told_to_those_who_ask():
    with bridge() as server, client(server) as peer:
        for topic in ("/client_count", "/connected_clients"):
            peer.send("subscribe", topic=topic)
        first = [peer.receive()["msg"] for _ in range(2)]
        with client(server):
            then = [peer.receive()["msg"] for _ in range(2)]
        after = [peer.receive()["msg"] for _ in range(2)]

    counts = [told[0]["data"] for told in (first, then, after)]
    clients = [told[1]["clients"] for told in (first, then, after)]
    assert counts == [len(each) for each in clients] == [1, 2, 1]
    assert {each["ip_address"] for each in clients[1]} == {"127.0.0.1"}
    assert abs(clients[1][1]["connection_time"]["secs"] - time.time()) < 60


def test_hundreds_of_sockets_that_say_nothing_keep_nobody_out():
    with bridge(Limits(handshake_s=2.0)) as server, ExitStack() as stack:
        sockets = [stack.enter_context(raw(server)) for _ in range(300)]

        assert is_served(server)
        assert max(map(until_closed, sockets)) < PATIENCE


def test_sockets_beyond_the_limit_are_cut_off_at_once_and_clients_are_served():
    limits = Limits(clients=2, handshake_s=5.0)
    with bridge(limits) as server, client(server) as early, ExitStack() as stack:
        sockets = [stack.enter_context(raw(server)) for _ in range(400)]
        early.settle()
        for connection in sockets:
            connection.setblocking(False)

        end = time.monotonic() + 4.0  # before the time for handshakes is over
        n_cut = 0
        while n_cut < 400 - 257 and time.monotonic() < end:
            n_cut = sum(map(is_closed, sockets))
            early.settle()

        assert n_cut == 400 - 257
        assert max(map(until_closed, sockets)) < PATIENCE
        client(server).close()


def is_closed(connection: socket.socket) -> bool:
    try:
        return connection.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionResetError:
        return True


@pytest.mark.parametrize("content", [b"", b"GET / HTTP/1.1\r\n", os.urandom(100) + b"\r\n\r\n"])
def test_a_socket_that_does_not_shake_hands_is_closed(content):
    with bridge(Limits(handshake_s=0.5)) as server, raw(server) as connection:
        connection.sendall(content)

        assert until_closed(connection) < PATIENCE
        assert is_served(server)


def test_a_socket_that_drips_its_handshake_is_closed():
    with bridge(Limits(handshake_s=0.5)) as server, raw(server) as connection:
        connection.settimeout(0.05)
        closed = False
        for byte in b"GET / HTTP/1.1\r\nHost: " + b"x" * 1000:
            try:
                connection.sendall(bytes((byte,)))
                closed = closed or connection.recv(1) == b""
            except TimeoutError:
                continue
            except OSError:
                closed = True
            if closed:
                break

        assert closed


def test_a_client_that_does_not_answer_pings_is_gone():
    limits = Limits(ping_s=0.3, pong_s=0.5)
    with bridge(limits) as server, raw_socket(server.url) as silent, client(server) as alive:
        assert until_closed(silent) < PATIENCE

        alive.settle()  # whose library answers pings


def test_a_message_beyond_the_limit_ends_its_client_only_which_is_told():
    with bridge(Limits(frame_bytes=1000)) as server, client(server) as large:
        large.send_raw("x" * 1001)

        status = large.receive()
        assert (status["op"], status["level"]) == ("status", "error")
        assert status["msg"] == "your message exceeds 1000 bytes, the limit"
        assert large.closed() == 1009
        assert is_served(server)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (masked_frame(b"\xff\xfe"), 1007),
        (masked_frame(b"\xff\xfe", 2), 1007),
        (masked_frame(b"{}", 0x71), 1002),
        (masked_frame(b"{}", 0x03), 1002),
        (masked_frame(b"{}", 0x00), 1002),
        (b"\x81\x02{}", 1002),
    ],
)
def test_what_is_no_websocket_frame_ends_its_client_only(content, code):
    with bridge() as server, raw_socket(server.url) as connection:
        connection.sendall(content)

        (frame, *_) = parse_frames(connection.recv(4096))
        assert struct.unpack("!H", frame.data[:2]) == (code,)
        assert until_closed(connection) < PATIENCE
        assert is_served(server)


def test_10000_malformed_messages_leave_the_service_unharmed(caplog):
    with bridge() as server, client(server) as bad:
        for number in range(10_000):
            bad.send_raw(f'{{"op": "publish", "topic": "/{number}", "msg": ')
        bad.settle()

        assert is_served(server)
    dropped = [record for record in caplog.records if "dropped operation" in record.getMessage()]
    assert len(dropped) == 10 + 10


def flood(server: EmbeddedBridge, publisher: Client) -> int:
    """Publish 20 MB; return how much waited at most."""
    publisher.send("advertise", topic="/t", type=TEXT)
    most = 0
    for _ in range(100):
        publisher.send("publish", topic="/t", msg={"data": "x" * 200_000})
        publisher.settle()
        most = max(most, held(server))
    return most


def test_a_client_that_reads_too_slowly_is_told_and_disconnected_and_others_are_served():
    limits = Limits(queue_bytes=2 * MEBI, close_s=PATIENCE)
    with bridge(limits) as server, raw_socket(server.url) as lazy, client(server) as publisher:
        send_operation(lazy, "subscribe", topic="/t", type=TEXT)
        most = flood(server, publisher)

        assert is_served(server)
        content = b""
        while content.count(b"too slow: ") < 2:  # as status, and as reason of the closing frame
            part = lazy.recv(MEBI)
            assert part
            content += part
    assert MEBI < most < 3 * MEBI
    assert len(content) < 15 * MEBI


def test_a_client_that_never_reads_is_cut_off():
    limits = Limits(queue_bytes=2 * MEBI, close_s=0.5)
    with bridge(limits) as server, raw_socket(server.url) as lazy, client(server) as publisher:
        send_operation(lazy, "subscribe", topic="/t", type=TEXT)
        flood(server, publisher)
        end = time.monotonic() + PATIENCE
        while held(server) and time.monotonic() < end:
            publisher.settle()

        assert held(server) == 0


def held(server: EmbeddedBridge) -> int:
    assert server._server is not None
    return server._server.n_held_bytes


def test_a_client_that_is_only_late_gets_everything():
    with bridge() as server, client(server) as late, client(server) as publisher:
        late.send("subscribe", topic="/t", type=TEXT)
        late.settle()
        publisher.send("advertise", topic="/t", type=TEXT)
        for number in range(50):
            publisher.send("publish", topic="/t", msg={"data": f"{number} {'x' * 100_000}"})
        publisher.settle()

        numbers = [int(late.receive()["msg"]["data"].split()[0]) for _ in range(50)]

    assert numbers == list(range(50))


def test_what_waits_for_all_clients_is_bounded(caplog):
    limits = Limits(total_bytes=3 * MEBI, queue_bytes=2 * MEBI, close_s=1.0)
    with bridge(limits) as server, client(server) as publisher, ExitStack() as stack:
        lazy = [stack.enter_context(raw_socket(server.url)) for _ in range(20)]
        for connection in lazy:
            send_operation(connection, "subscribe", topic="/t", type=TEXT)
        publisher.send("advertise", topic="/t", type=TEXT)
        most = 0
        for _ in range(60):
            publisher.send("publish", topic="/t", msg={"data": "x" * 100_000})
            publisher.settle()
            most = max(most, held(server))

        assert is_served(server)
        n_cut = sum("most of them for this one" in record.getMessage() for record in caplog.records)
    assert most <= 3 * MEBI
    assert 0 < n_cut < 20


def test_what_clients_leave_unfinished_is_bounded():
    limits = Limits(total_bytes=4 * MEBI, frame_bytes=2 * MEBI)
    with bridge(limits) as server, ExitStack() as stack:
        head = struct.pack("!BBQ", 0x81, 0x80 | 127, 2 * MEBI) + bytes(4)
        for _ in range(10):
            connection = stack.enter_context(raw_socket(server.url))
            connection.sendall(head + b"x" * (2 * MEBI - 1))
        assert is_served(server)

        assert held(server) <= 4 * MEBI


def test_large_messages_arrive_in_order_and_others_are_served():
    numbers = {"data": [1.5] * 300_000}
    with bridge() as server, client(server) as peer, client(server) as gone:
        for each in (peer, gone):
            each.send("advertise", topic="/n", type="std_msgs/Float64MultiArray")
        peer.send("subscribe", topic="/n")
        gone.send("publish", topic="/n", msg={"data": [2.5] * 200_000})
        gone.close()
        for number in range(3):
            text = json.dumps({"op": "publish", "topic": "/n", "msg": numbers})
            for place, part in enumerate((text[:99], text[99:])):
                peer.send("fragment", id="f", data=part, num=place, total=2)
            peer.send("publish", topic="/n", msg={"data": [float(number)]})
            assert is_served(server)
        lengths, last = [], None
        while last != 2.0:
            data = peer.receive()["msg"]["data"]
            lengths.append(len(data))
            last = data[0]

    assert [each for each in lengths if each != 200_000] == [300_000, 1] * 3


def test_clients_are_told_that_the_server_ends():
    with bridge() as server:
        connection = client(server)
        connection.settle()

    assert connection.closed() == 1001
    connection.close()
