"""All messages of a tick as one: for speed, where both sides know of it.

What is published, what is counted and who hears what stays as without it; only the journey
is shared. A bundle is a JSON list of ``[topic, message]`` pairs in the order in which they were
published, the one that closes the tick last.
"""

import json
from collections.abc import Callable
from typing import Any

from mrsfi_runtime.cosimulation.lockstep_topics import (
    FAILURE,
    GO,
    GO_BUNDLE,
    SETUP,
    TICK,
    TICK_BUNDLE,
)
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import Payload, Publisher, Topic, Transport

_ALONE = (SETUP, FAILURE)
"""Topics that belong to no tick."""

_encode = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class BundlingTransport:
    """A transport that can send what belongs to one tick as one message.

    ``closing`` is the topic whose message ends a tick of this side; ``sends`` and ``hears`` are
    those of the bundles of this side and of the other. If ``is_first`` it bundles from the start;
    otherwise it answers in kind: bundles with bundles, messages with messages.
    """

    def __init__(
        self, transport: Transport, closing: Topic, sends: Topic, hears: Topic, *, is_first: bool
    ) -> None:
        self._transport = transport
        self.provide, self.call = transport.provide, transport.call
        self.watch, self.close = transport.watch, transport.close
        self.ros = transport.ros
        self._closing = closing
        self._hears = hears
        self._is_first = self._is_bundling = is_first
        self._waiting: list[tuple[str, Payload]] = []
        self._callbacks: dict[str, Callable[[Payload], None]] = {}
        self._send = transport.advertise(sends)
        transport.subscribe(hears, self._receive)

    @classmethod
    def of_ci(cls, transport: Transport) -> "BundlingTransport":
        """Return the transport of a collective intelligence that bundles."""
        return cls(transport, GO, GO_BUNDLE, TICK_BUNDLE, is_first=True)

    @classmethod
    def of_simulation(cls, transport: Transport) -> "BundlingTransport":
        """Return the transport of a simulation that does as the collective intelligence does."""
        return cls(transport, TICK, TICK_BUNDLE, GO_BUNDLE, is_first=False)

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic, alone or in the bundle of its tick."""
        publish_alone = self._transport.advertise(topic)
        is_alone, is_closing = topic in _ALONE, topic == self._closing

        def publish(payload: Payload) -> None:
            if is_alone:
                self._waiting.clear()  # of a run that came to its end
            if is_alone or not self._is_bundling:
                publish_alone(payload)
                return
            self._waiting.append((topic.name, payload))
            if is_closing:
                pairs, self._waiting = self._waiting, []
                self._send({"data": _encode(pairs)})

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic, however it came; one per topic."""

        def receive(payload: Payload) -> None:
            self._is_bundling = self._is_first
            callback(payload)

        self._callbacks[topic.name] = callback
        self._transport.subscribe(topic, receive)

    def _receive(self, payload: Payload) -> None:
        """Take a bundle apart; as on the bus, what nobody subscribed to is left aside."""
        self._is_bundling = True
        for name, message in self._pairs(payload.get("data")):
            callback = self._callbacks.get(name)
            if callback is not None:
                callback(message)

    def _pairs(self, text: Any) -> list[tuple[str, Payload]]:
        try:
            pairs = [(str(name), dict(message)) for name, message in json.loads(text)]
        except (TypeError, ValueError) as error:
            raise ProtocolError(
                f"{self._hears.name} carried {str(text)[:80]!r}; expected a JSON list of "
                "[topic, message] pairs"
            ) from error
        return pairs
