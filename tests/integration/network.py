"""Real servers, real sockets, and peers that misbehave."""

import base64
import json
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import IO, Any, Self

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from tests.support.cli import command_line

MEBI = 1 << 20
PATIENCE = 20.0
"""Seconds after which a test gives up: far more than anything here takes."""


@dataclass(frozen=True, slots=True)
class Server:
    """A ``mrsfi bridge`` in a process of its own."""

    process: subprocess.Popen[str]
    url: str
    log: IO[str]

    @property
    def pid(self) -> int:
        return self.process.pid

    def peak_memory(self) -> int:
        """Return the most memory that the process ever had, in bytes."""
        status = Path(f"/proc/{self.pid}/status").read_text(encoding="ascii")
        (line,) = (line for line in status.splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) * 1024


@contextmanager
def bridge(*options: str | int) -> Iterator[Server]:
    """Run ``mrsfi bridge`` on a free port until the body ends."""
    with (
        tempfile.TemporaryFile("w+", encoding="utf-8") as log,
        subprocess.Popen(
            command_line("bridge", "--port", "0", *map(str, options)),
            stdout=subprocess.PIPE,
            stderr=log,
            encoding="utf-8",
        ) as process,
    ):
        assert process.stdout is not None
        url = process.stdout.readline().strip()
        try:
            assert url.startswith("ws://127.0.0.1:")
            yield Server(process, url, log)
        finally:
            process.kill()


class Client:
    """A rosbridge client that hides nothing."""

    def __init__(self, url: str, **options: Any) -> None:
        self._connection = connect(
            url, compression=None, max_size=None, close_timeout=1, open_timeout=PATIENCE, **options
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the server."""
        self._connection.close()

    def send(self, op: str, **fields: Any) -> None:
        """Send an operation."""
        self.send_raw(json.dumps({"op": op, **fields}))

    def send_raw(self, content: str | bytes) -> None:
        """Send a text or binary message, whatever it contains."""
        self._connection.send(content)

    def receive(self, timeout: float = PATIENCE) -> Any:
        """Return the next operation that comes."""
        return json.loads(self._connection.recv(timeout))

    def settle(self) -> None:
        """Wait until the server has carried out everything sent before."""
        self.send("call_service", service="/rosapi/get_time", id="settle")
        while self.receive().get("id") != "settle":
            pass

    def closed(self) -> int | None:
        """Read until the server closes; return its code."""
        limit = monotonic() + PATIENCE
        with suppress(ConnectionClosed):
            while monotonic() < limit:
                self._connection.recv(PATIENCE)
        return self._connection.close_code


class Witness:
    """Two clients beside the trouble, on a topic of their own, that must not notice it."""

    def __init__(self, url: str) -> None:
        self._n_sent = 0
        self._speaker = Client(url)
        self._listener = Client(url)
        self._listener.send("subscribe", topic="/witness", type="std_msgs/Int64")
        self._listener.settle()
        self._speaker.send("advertise", topic="/witness", type="std_msgs/Int64")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for client in (self._speaker, self._listener):
            with client:
                pass

    def is_served(self) -> bool:
        """Return whether a message and the answer of a service arrive as ever."""
        self._n_sent += 1
        self._speaker.send("publish", topic="/witness", msg={"data": self._n_sent})
        received = self._listener.receive()
        self._speaker.settle()
        return bool(received["msg"] == {"data": self._n_sent})


def raw_socket(url: str) -> socket.socket:
    """Return a socket on which the opening handshake is done, and nothing else ever will be."""
    host, _, port = url.removeprefix("ws://").partition(":")
    raw = socket.create_connection((host, int(port)), PATIENCE)
    raw.sendall(opening_handshake(url))
    answer = b""
    while not answer.endswith(b"\r\n\r\n"):
        answer += raw.recv(1)
    assert answer.startswith(b"HTTP/1.1 101 ")
    return raw


def opening_handshake(url: str) -> bytes:
    """Return what a client says first."""
    key = base64.b64encode(b"0123456789abcdef").decode()
    return (
        f"GET / HTTP/1.1\r\nHost: {url.removeprefix('ws://')}\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ).encode()


def masked_frame(content: bytes, opcode: int = 1, *, is_final: bool = True) -> bytes:
    """Return a frame as clients send it; its mask is zero, so that content stays as it is."""
    n = len(content)
    if n < 126:
        head = bytes([0x80 | n])
    elif n < 1 << 16:
        head = bytes([0x80 | 126]) + n.to_bytes(2, "big")
    else:
        head = bytes([0x80 | 127]) + n.to_bytes(8, "big")
    return bytes([(0x80 if is_final else 0) | opcode]) + head + bytes(4) + content


def send_operation(raw: socket.socket, op: str, **fields: Any) -> None:
    """Send an operation over a raw socket."""
    raw.sendall(masked_frame(json.dumps({"op": op, **fields}).encode()))


def drained(raw: socket.socket) -> bytes:
    """Read a raw socket until the other side ends it, and return the last MiB of it."""
    raw.settimeout(PATIENCE)
    tail = b""
    with suppress(ConnectionResetError):
        while content := raw.recv(MEBI):
            tail = (tail + content)[-MEBI:]
    return tail


def wait_for_tick(url: str, run: int, tick: int) -> None:
    """Wait until the runs on a server have come so far."""
    with Client(url) as client:
        client.send("subscribe", topic="/mission/tick", type="std_msgs/Int64MultiArray")
        while True:
            flown, at, *_ = client.receive()["msg"]["data"]
            if (flown % 1_000_000, at) >= (run, tick):
                return
