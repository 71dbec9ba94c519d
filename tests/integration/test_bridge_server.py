"""The server on real sockets: access, limits, clients that misbehave, and those that do not."""

import json
import os
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import Limits, ServerSettings
from tests.support.bridge import FLOAT, TEXT, parse_frames

PATIENCE_S = 20.0
MEBI = 1 << 20
TOKEN = "0123456789abcdef"


@contextmanager
def bridge(limits: Limits | None = None, **settings: Any) -> Iterator[EmbeddedBridge]:
    with EmbeddedBridge(ServerSettings(limits=limits or Limits(), **settings)) as server:
        yield server
    assert server.failed.error is None


def client(server: EmbeddedBridge, path: str = "/", **options: Any) -> ClientConnection:
    return connect(server.url + path, compression=None, open_timeout=PATIENCE_S, **options)


def tell(connection: ClientConnection, **operation: Any) -> None:
    connection.send(json.dumps(operation))


def hear(connection: ClientConnection) -> dict[str, Any]:
    return json.loads(connection.recv(PATIENCE_S))


def is_served(server: EmbeddedBridge) -> bool:
    """Return whether two new clients can talk to each other."""
    with client(server) as publisher, client(server) as subscriber:
        tell(subscriber, op="subscribe", topic="/probe", type=TEXT)
        ask_time(subscriber)
        tell(publisher, op="advertise", topic="/probe", type=TEXT)
        tell(publisher, op="publish", topic="/probe", msg={"data": "hello"})
        return hear(subscriber)["msg"] == {"data": "hello"}


def ask_time(connection: ClientConnection) -> None:
    """Wait until the server did everything that was sent before."""
    tell(connection, op="call_service", service="/rosapi/get_time", id="sync")
    while hear(connection).get("id") != "sync":
        pass


def closing_code(connection: ClientConnection) -> int:
    """Return the code with which the server closes, after what it still says."""
    with suppress(ConnectionClosed):
        while True:
            connection.recv(PATIENCE_S)
    assert connection.close_code is not None
    return connection.close_code


def raw(server: EmbeddedBridge, handshake: bool = True) -> socket.socket:
    """Return a socket that does only what the test has it do."""
    host, port = server.url.removeprefix("ws://").split(":")
    connection = socket.create_connection((host, int(port)), PATIENCE_S)
    if handshake:
        connection.sendall(
            b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        assert b"101 Switching Protocols" in connection.recv(4096)
    return connection


def masked(content: bytes, opcode: int = 0x81) -> bytes:
    """Return a client's frame."""
    size = len(content)
    head = struct.pack("!BB", opcode, 0x80 | size) if size < 126 else None
    head = head or struct.pack("!BBQ", opcode, 0x80 | 127, size)
    return head + bytes(4) + content


def until_closed(connection: socket.socket) -> float:
    """Return how long it takes the server to close a socket."""
    start = time.monotonic()
    connection.settimeout(PATIENCE_S)
    try:
        while connection.recv(65536):
            pass
    except ConnectionResetError:
        pass
    return time.monotonic() - start


def test_messages_arrive_in_order_and_complete():
    with bridge() as server, client(server) as publisher, client(server) as subscriber:
        tell(subscriber, op="subscribe", topic="/t", type=FLOAT)
        ask_time(subscriber)
        tell(publisher, op="advertise", topic="/t", type=FLOAT)
        for number in range(2000):
            tell(publisher, op="publish", topic="/t", msg={"data": number})

        received = [hear(subscriber)["msg"]["data"] for _ in range(2000)]

    assert received == list(range(2000))


def test_operations_that_share_a_segment_with_the_handshake_are_carried_out():
    with bridge() as server, raw(server, handshake=False) as connection:
        call = json.dumps({"op": "call_service", "service": "/rosapi/get_time"}).encode()
        connection.sendall(
            b"GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
            + masked(call)
        )
        content = connection.recv(65536)
        while b"secs" not in content:
            content += connection.recv(65536)

    assert content.startswith(b"HTTP/1.1 101")


def test_a_message_may_come_in_several_frames():
    text = json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": "é"}).encode()
    with bridge() as server, raw(server) as connection:
        for number, byte in enumerate(text):
            opcode = (0x01 if number == 0 else 0x00) | (0x80 if number == len(text) - 1 else 0)
            connection.sendall(masked(bytes((byte,)), opcode))

        (frame,) = parse_frames(connection.recv(65536))

    assert json.loads(frame.data)["result"] is True


@pytest.mark.parametrize(
    ("path", "headers"),
    [(f"/?token={TOKEN}", {}), ("/", {"Authorization": f"Bearer {TOKEN}"})],
)
def test_a_client_that_shows_the_token_is_let_in(path, headers):
    with bridge(token=TOKEN) as server, client(server, path, additional_headers=headers) as guest:
        ask_time(guest)


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

        ask_time(second)
        ask_time(third)
        second.close()
        third.close()

    assert refusal.value.response.status_code == 503
    assert b"2 clients are connected, the limit" in refusal.value.response.body


def test_hundreds_of_sockets_that_say_nothing_keep_nobody_out():
    with bridge(Limits(handshake_s=2.0)) as server, ExitStack() as stack:
        sockets = [stack.enter_context(raw(server, handshake=False)) for _ in range(300)]

        assert is_served(server)
        assert max(map(until_closed, sockets)) < PATIENCE_S


def test_sockets_beyond_the_limit_are_cut_off_at_once_and_clients_are_served():
    limits = Limits(clients=2, handshake_s=5.0)
    with bridge(limits) as server, client(server) as early, ExitStack() as stack:
        sockets = [stack.enter_context(raw(server, handshake=False)) for _ in range(400)]
        ask_time(early)
        for connection in sockets:
            connection.setblocking(False)

        end = time.monotonic() + 4.0  # before the time for handshakes is over
        n_cut = 0
        while n_cut < 400 - 257 and time.monotonic() < end:
            n_cut = sum(map(is_closed, sockets))
            ask_time(early)

        assert n_cut == 400 - 257
        assert max(map(until_closed, sockets)) < PATIENCE_S
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
    with bridge(Limits(handshake_s=0.5)) as server, raw(server, handshake=False) as connection:
        connection.sendall(content)

        assert until_closed(connection) < PATIENCE_S
        assert is_served(server)


def test_a_socket_that_drips_its_handshake_is_closed():
    with bridge(Limits(handshake_s=0.5)) as server, raw(server, handshake=False) as connection:
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
    with bridge(limits) as server, raw(server) as silent, client(server) as alive:
        assert until_closed(silent) < PATIENCE_S

        ask_time(alive)  # whose library answers pings


def test_a_frame_beyond_the_limit_ends_its_client_only():
    with bridge(Limits(frame_bytes=1000)) as server, client(server) as large:
        large.send("x" * 1001)

        assert closing_code(large) == 1009
        assert is_served(server)


def test_a_frame_of_100_megabytes_is_refused_by_its_header():
    with bridge() as server, raw(server) as connection:
        connection.sendall(struct.pack("!BBQ", 0x81, 0x80 | 127, 100 * MEBI) + bytes(4))

        (frame,) = parse_frames(connection.recv(4096))
        assert struct.unpack("!H", frame.data[:2]) == (1009,)
        assert until_closed(connection) < PATIENCE_S
        assert is_served(server)


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (masked(b"\xff\xfe"), 1007),
        (masked(b"{}", 0xF1), 1002),
        (masked(b"{}", 0x83), 1002),
        (masked(b"{}", 0x80), 1002),
        (b"\x81\x02{}", 1002),
    ],
)
def test_what_is_no_websocket_frame_ends_its_client_only(content, code):
    with bridge() as server, raw(server) as connection:
        connection.sendall(content)

        (frame, *_) = parse_frames(connection.recv(4096))
        assert struct.unpack("!H", frame.data[:2]) == (code,)
        assert until_closed(connection) < PATIENCE_S
        assert is_served(server)


def test_10000_malformed_messages_leave_the_service_unharmed(caplog):
    with bridge() as server, client(server) as bad:
        for number in range(10_000):
            bad.send(f'{{"op": "publish", "topic": "/{number}", "msg": ')
        ask_time(bad)

        assert is_served(server)
    dropped = [record for record in caplog.records if "dropped no." in record.getMessage()]
    assert len(dropped) == 10 + 10


def flood(server: EmbeddedBridge, publisher: ClientConnection) -> int:
    """Publish 20 MB; return how much waited at most."""
    tell(publisher, op="advertise", topic="/t", type=TEXT)
    most = 0
    for _ in range(100):
        tell(publisher, op="publish", topic="/t", msg={"data": "x" * 200_000})
        ask_time(publisher)
        most = max(most, held(server))
    return most


SUBSCRIBE = masked(json.dumps({"op": "subscribe", "topic": "/t", "type": TEXT}).encode())


def test_a_client_that_reads_too_slowly_is_told_and_disconnected_and_others_are_served():
    limits = Limits(queue_bytes=2 * MEBI, close_s=PATIENCE_S)
    with bridge(limits) as server, raw(server) as lazy, client(server) as publisher:
        lazy.sendall(SUBSCRIBE)
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
    with bridge(limits) as server, raw(server) as lazy, client(server) as publisher:
        lazy.sendall(SUBSCRIBE)
        flood(server, publisher)
        end = time.monotonic() + PATIENCE_S
        while held(server) and time.monotonic() < end:
            ask_time(publisher)

        assert held(server) == 0


def held(server: EmbeddedBridge) -> int:
    assert server._server is not None
    return server._server.n_held_bytes


def test_a_client_that_is_only_late_gets_everything():
    with bridge() as server, client(server, max_size=None) as late, client(server) as publisher:
        tell(late, op="subscribe", topic="/t", type=TEXT)
        ask_time(late)
        tell(publisher, op="advertise", topic="/t", type=TEXT)
        for number in range(50):
            tell(publisher, op="publish", topic="/t", msg={"data": f"{number} {'x' * 100_000}"})
        ask_time(publisher)

        numbers = [int(hear(late)["msg"]["data"].split()[0]) for _ in range(50)]

    assert numbers == list(range(50))


def test_what_waits_for_all_clients_is_bounded(caplog):
    limits = Limits(total_bytes=3 * MEBI, queue_bytes=2 * MEBI, close_s=1.0)
    with bridge(limits) as server, client(server) as publisher, ExitStack() as stack:
        lazy = [stack.enter_context(raw(server)) for _ in range(20)]
        for connection in lazy:
            connection.sendall(SUBSCRIBE)
        tell(publisher, op="advertise", topic="/t", type=TEXT)
        most = 0
        for _ in range(60):
            tell(publisher, op="publish", topic="/t", msg={"data": "x" * 100_000})
            ask_time(publisher)
            most = max(most, held(server))

        assert is_served(server)
        n_cut = sum("most of them here" in record.getMessage() for record in caplog.records)
    assert most <= 3 * MEBI
    assert 0 < n_cut < 20


def test_what_clients_leave_unfinished_is_bounded():
    limits = Limits(total_bytes=4 * MEBI, frame_bytes=2 * MEBI)
    with bridge(limits) as server, ExitStack() as stack:
        head = struct.pack("!BBQ", 0x81, 0x80 | 127, 2 * MEBI) + bytes(4)
        for _ in range(10):
            connection = stack.enter_context(raw(server))
            connection.sendall(head + b"x" * (2 * MEBI - 1))
        assert is_served(server)

        assert held(server) <= 4 * MEBI


def test_a_provider_that_leaves_answers_its_callers():
    with bridge() as server, client(server) as caller:
        provider = raw(server)
        advertise = {"op": "advertise_service", "service": "/s", "type": "std_srvs/Empty"}
        provider.sendall(masked(json.dumps(advertise).encode()))
        while True:  # until it is known
            tell(caller, op="call_service", service="/rosapi/services")
            if "/s" in hear(caller)["values"]["services"]:
                break
        tell(caller, op="call_service", service="/s", id=1)
        assert b"call_service" in provider.recv(4096)

        provider.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        provider.close()  # with a reset, as of a process that was killed

        answer = hear(caller)
        assert (answer["id"], answer["result"]) == (1, False)
        assert answer["values"] == "Service /s: its provider left"


def test_a_service_call_times_out():
    with bridge(replace(Limits(), service_s=0.2)) as server, client(server) as peer:
        tell(peer, op="advertise_service", service="/s", type="std_srvs/Empty")
        tell(peer, op="call_service", service="/s", id=1)
        assert hear(peer)["op"] == "call_service"

        assert hear(peer)["values"] == "Service /s: no answer within 0.2 s"


def test_clients_are_told_that_the_server_ends():
    with bridge() as server:
        connection = client(server)
        ask_time(connection)

    assert closing_code(connection) == 1001
    connection.close()
