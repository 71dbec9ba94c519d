"""More connections and larger messages than a server takes: it stays small, and serves others."""

import json
import socket
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

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


@contextmanager
def bounded(server: Server, extra: int) -> Iterator[None]:
    """Require that the server's memory grows by less than so much in the body."""
    before = server.peak_memory()
    yield
    assert server.peak_memory() - before < extra


@pytest.mark.parametrize("manner", ["one frame", "continued frames", "fragments"])
def test_a_message_of_100_megabytes_is_refused_in_bounded_memory(manner):
    with bridge("--max-frame", 4) as server, Witness(server.url) as witness:
        with bounded(server, 40 * MEBI), raw_socket(server.url) as raw:
            send_operation(raw, "set_level", level="error")
            hundred_megabytes(raw, manner)
            raw.shutdown(socket.SHUT_WR)
            tail = drained(raw)

        assert b"longer than 4194304 bytes" in tail or b"bytes, the limit" in tail
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
