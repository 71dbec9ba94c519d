"""More connections and larger messages than a server takes: it stays small, and serves others."""

import asyncio
import json
import resource
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.client import connect as connect_async
from websockets.exceptions import InvalidStatus

from tests.integration.network import (
    MEBI,
    Server,
    Witness,
    bridge,
    drained,
    masked_frame,
    raw_socket,
    send_operation,
)
from tests.support.missing import skip
from tests.tiers import slow

STRING = "std_msgs/String"


@contextmanager
def bounded(server: Server, extra: int) -> Iterator[None]:
    """Require that the server's memory grows by less than so much in the body."""
    before = server.peak_memory()
    yield
    assert server.peak_memory() - before < extra


@pytest.fixture
def many_files() -> Iterator[None]:
    """Allow this process and its children a few thousand files."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = 4096
    if hard not in (resource.RLIM_INFINITY,) and hard < wanted:
        skip(f"needs {wanted} open files; the hard limit is {hard}")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@slow
@pytest.mark.usefixtures("many_files")
def test_1_000_connections_are_served_and_one_more_is_refused():
    async def subscribed(url: str) -> ClientConnection:
        client = await connect_async(url, compression=None, ping_interval=None, open_timeout=30)
        operation = {"op": "subscribe", "topic": "/all", "type": STRING}
        await client.send(json.dumps(operation))
        await client.send(json.dumps({"op": "call_service", "service": "/rosapi/get_time"}))
        await client.recv()
        return client

    async def crowd(url: str) -> tuple[set[str], int]:
        clients = [await subscribed(url) for _ in range(999)]
        speaker = await connect_async(url, compression=None)
        with pytest.raises(InvalidStatus) as refused:
            await connect_async(url)
        await speaker.send(json.dumps({"op": "advertise", "topic": "/all", "type": STRING}))
        message = {"op": "publish", "topic": "/all", "msg": {"data": "to all"}}
        await speaker.send(json.dumps(message))
        received = {json.loads(await client.recv())["msg"]["data"] for client in clients}
        await asyncio.gather(*(client.close() for client in (*clients, speaker)))
        return received, refused.value.response.status_code

    with bridge("--max-clients", 1000) as server:
        with bounded(server, 120 * MEBI):
            received, status = asyncio.run(crowd(server.url))

        assert received == {"to all"}
        assert status == 503
        with Witness(server.url) as witness:
            assert witness.is_served()


@pytest.mark.parametrize("manner", ["one frame", "continued frames", "fragments"])
def test_a_message_of_100_megabytes_is_refused_in_bounded_memory(manner):
    with bridge("--max-frame", 4) as server, Witness(server.url) as witness:
        with bounded(server, 40 * MEBI), raw_socket(server.url) as raw:
            send_operation(raw, "set_level", level="error")
            hundred_megabytes(raw, manner)
            raw.shutdown(socket.SHUT_WR)
            tail = drained(raw)

        assert b"exceeds 4194304 bytes" in tail or b"bytes, the limit" in tail
        assert witness.is_served()


def hundred_megabytes(raw: socket.socket, manner: str) -> None:
    """Send a message of 100 MB, or of it what the server takes."""
    piece = b"x" * 100_000
    if manner == "one frame":
        raw.sendall(b"\x81\xff" + (1000 * len(piece)).to_bytes(8, "big") + bytes(4))
    for number in range(1000):
        content = piece
        if manner == "continued frames":
            content = masked_frame(piece, 1 if number == 0 else 0, is_final=number == 999)
        elif manner == "fragments":
            fields = {"id": "big", "num": number, "total": 1000, "data": piece.decode()}
            content = masked_frame(json.dumps({"op": "fragment", **fields}).encode())
        try:
            raw.sendall(content)
        except (BrokenPipeError, ConnectionResetError):
            return
