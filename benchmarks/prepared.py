"""Ticks encoded beforehand, sent over a bare socket: what a client can take, without any server."""

import json
import socket
from collections.abc import Callable
from threading import Thread
from typing import Any

from websockets.frames import OP_TEXT, Frame
from websockets.http11 import Request
from websockets.server import ServerProtocol

_QUICKACK = getattr(socket, "TCP_QUICKACK", None)


class PreparedTicks:
    """Answers each reply of one client with the next tick, in one write.

    Attributes
    ----------
    url
        Where the client connects.

    Parameters
    ----------
    messages
        Returns topic and message of all that is published in a tick.
    n_ticks
        Ticks to encode before anybody connects.
    """

    def __init__(
        self, messages: Callable[[int], list[tuple[str, dict[str, Any]]]], n_ticks: int
    ) -> None:
        self._ticks = [_encoded(messages(tick)) for tick in range(n_ticks)]
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._thread = Thread(target=self._serve, daemon=True)
        self.url = f"ws://127.0.0.1:{self._listener.getsockname()[1]}"

    def __enter__(self) -> "PreparedTicks":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.close()

    def _serve(self) -> None:
        peer, _ = self._listener.accept()
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        protocol = ServerProtocol(max_size=None)
        tick = -1
        with peer:
            while content := _received(peer):
                protocol.receive_data(content)
                for event in protocol.events_received():
                    if isinstance(event, Request):
                        protocol.send_response(protocol.accept(event))
                        peer.sendall(b"".join(protocol.data_to_send()))
                    elif _reply(event) == tick:  # the first one greets
                        tick += 1
                        peer.sendall(self._ticks[tick])


def _encoded(messages: list[tuple[str, dict[str, Any]]]) -> bytes:
    operations = ({"op": "publish", "topic": name, "msg": said} for name, said in messages)
    texts = (json.dumps(operation, separators=(",", ":")) for operation in operations)
    return b"".join(Frame(OP_TEXT, text.encode()).serialize(mask=False) for text in texts)


def _received(peer: socket.socket) -> bytes:
    try:
        content = peer.recv(1 << 16)
        if _QUICKACK is not None:
            peer.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
    except ConnectionError:  # the client is done
        return b""
    return content


def _reply(event: object) -> int | None:
    """Return the tick to which a frame replies, or None if it is no reply."""
    if not isinstance(event, Frame) or event.opcode is not OP_TEXT:
        return None
    operation = json.loads(bytes(event.data))
    return int(operation["msg"]["data"]) if operation["op"] == "publish" else None
