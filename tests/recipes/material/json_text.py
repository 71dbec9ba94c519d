"""Ends of a bus in one process: messages travel as JSON text through a queue for each end."""

import json
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from queue import SimpleQueue
from threading import Thread, current_thread
from typing import Any

from mrsfi_runtime.transport.topics import (
    FailureListener,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
)


class JsonTextBus:
    """What the ends share: who there is, who answers which service, and numbers for calls."""

    def __init__(self) -> None:
        self.ends: list[JsonTextTransport] = []
        self.providers: dict[str, JsonTextTransport] = {}
        self.numbers = count()

    def broadcast(self, **frame: Any) -> None:
        """Send a frame to every end."""
        for end in tuple(self.ends):
            end.send(**frame)


class JsonTextTransport:
    """An end of a bus; its callbacks run in a thread of its own."""

    def __init__(self, bus: JsonTextBus) -> None:
        self._bus = bus
        self._frames: SimpleQueue[str] = SimpleQueue()
        self._subscribers: defaultdict[str, list[Callable[[Payload], None]]] = defaultdict(list)
        self._providers: dict[str, Provider] = {}
        self._waiting: dict[int, Callable[[Reply], None]] = {}
        self._listener: FailureListener | None = None
        self._thread = Thread(target=self._receive, daemon=True)
        self._thread.start()
        bus.ends.append(self)

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""

        def publish(payload: Payload) -> None:
            self._bus.broadcast(op="message", topic=topic.name, values=payload)

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, in order."""
        self._subscribers[topic.name].append(callback)

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service; the newest provider answers."""
        self._providers[service.name] = provider
        self._bus.providers[service.name] = self

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; the reply comes in the thread of the callbacks."""
        number = next(self._bus.numbers)
        self._waiting[number] = on_reply
        provider = self._bus.providers.get(service.name)
        if provider is None:
            problem = f"nobody provides service '{service.name}'"
            self.send(op="reply", number=number, values={}, problem=problem)
        else:
            provider.send(op="call", service=service.name, number=number, values=request)

    def watch(self, listener: FailureListener) -> None:
        """Have a function told of errors in callbacks; there is no connection to lose."""
        self._listener = listener

    def close(self) -> None:
        """Give up all topics and services."""
        if self not in self._bus.ends:
            return
        self._bus.ends.remove(self)
        for name in self._providers:
            self._bus.providers.pop(name, None)
        self.send(op="close")
        if current_thread() is not self._thread:
            self._thread.join()

    def send(self, **frame: Any) -> None:
        """Put a frame into the queue of this end."""
        self._frames.put(json.dumps(frame))

    def _receive(self) -> None:
        while (frame := json.loads(self._frames.get()))["op"] != "close":
            try:
                self._take(frame)
            except Exception as error:  # noqa: BLE001 - the listener decides
                if self._listener is not None:
                    self._listener(error)

    def _take(self, frame: dict[str, Any]) -> None:
        if frame["op"] == "message":
            for callback in self._subscribers.get(frame["topic"], ()):
                callback(frame["values"])
        elif frame["op"] == "call":
            self._answer(frame)
        elif frame["number"] in self._waiting:
            self._waiting.pop(frame["number"])(Reply(frame["values"], frame["problem"]))

    def _answer(self, frame: dict[str, Any]) -> None:
        number = frame["number"]
        try:
            values = self._providers[frame["service"]](frame["values"])
        except Exception as error:
            self._bus.broadcast(op="reply", number=number, values={}, problem=str(error))
            raise
        self._bus.broadcast(op="reply", number=number, values=values, problem="")


@contextmanager
def json_text_ends() -> Iterator[tuple[JsonTextTransport, JsonTextTransport]]:
    """Yield two ends of a bus."""
    bus = JsonTextBus()
    yield JsonTextTransport(bus), JsonTextTransport(bus)
