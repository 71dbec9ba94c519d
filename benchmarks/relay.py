"""A relay on plain websockets that only passes messages on: what a bus costs at the least."""

import asyncio
import json
from collections import defaultdict
from collections.abc import Callable
from threading import Event, Thread
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, broadcast, serve
from websockets.exceptions import ConnectionClosed


class Relay:
    """Sends what is published on a topic to its subscribers, unread.

    It knows no types, no limits and no services, and runs in a thread of its own. Its local
    functions run in that thread.

    Attributes
    ----------
    url
        Where clients connect.
    """

    def __init__(self) -> None:
        self.url = ""
        self._clients: defaultdict[str, set[ServerConnection]] = defaultdict(set)
        self._callbacks: dict[str, Callable[[dict[str, Any]], None]] = {}
        self._loop = asyncio.new_event_loop()
        self._stopped = asyncio.Event()
        self._is_ready = Event()
        self._thread = Thread(target=self._run)

    def __enter__(self) -> "Relay":
        self._thread.start()
        self._is_ready.wait()
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._stopped.set)
        self._thread.join()

    def publish(self, topic: str, message: dict[str, Any]) -> None:
        """Send a message to the subscribers of a topic; in the relay's thread only."""
        frame = json.dumps({"op": "publish", "topic": topic, "msg": message})
        broadcast(self._clients[topic], frame)

    def subscribe(self, topic: str, callback: Callable[[dict[str, Any]], None]) -> None:
        """Have a function receive the messages of a topic."""
        self._callbacks[topic] = callback

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._serve())
        self._loop.close()

    async def _serve(self) -> None:
        server: Server
        async with serve(self._take_client, "127.0.0.1", 0, compression=None) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            self.url = f"ws://127.0.0.1:{port}"
            self._is_ready.set()
            await self._stopped.wait()

    async def _take_client(self, connection: ServerConnection) -> None:
        try:
            async for frame in connection:
                self._take(connection, frame)
        except ConnectionClosed:
            pass  # a client that ended without a word
        finally:
            for clients in self._clients.values():
                clients.discard(connection)

    def _take(self, connection: ServerConnection, frame: str | bytes) -> None:
        operation = json.loads(frame)
        topic = operation.get("topic")
        if operation["op"] == "subscribe":
            self._clients[topic].add(connection)
        elif operation["op"] == "publish":
            broadcast(self._clients[topic], str(frame))
            if topic in self._callbacks:
                self._callbacks[topic](operation["msg"])
