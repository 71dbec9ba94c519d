"""A bus in one process whose messages travel as JSON text."""

import json
from collections.abc import Iterator
from contextlib import contextmanager

from mrsfi_runtime.transport.topics import LocalBus, Payload, Publisher, Topic


class JsonTextBus(LocalBus):
    """Delivers what is left of a message once it was a text."""

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        deliver = super().advertise(topic)

        def publish(payload: Payload) -> None:
            deliver(json.loads(json.dumps(payload)))

        return publish


@contextmanager
def json_text_ends() -> Iterator[tuple[JsonTextBus, JsonTextBus]]:
    """Yield two ends of a bus, which are the same."""
    bus = JsonTextBus()
    yield bus, bus
