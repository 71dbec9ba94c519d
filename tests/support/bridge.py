"""A hub without sockets and clients that keep what they are sent, for tests of the server."""

import base64
import heapq
import json
from collections.abc import Callable
from io import BytesIO
from itertools import count
from typing import Any

from PIL import Image
from websockets.frames import OP_TEXT, Frame
from websockets.streams import StreamReader

from mrsfi_bridge.session import Hub, Session, provide_rosapi
from mrsfi_bridge.settings import Limits, TypeTable

TYPES = TypeTable()
FLOAT = "std_msgs/Float64"
TEXT = "std_msgs/String"
POINT = "geometry_msgs/Point"


class Appointment:
    """A callback of ``Clock``."""

    def __init__(self, callback: Callable[[], object]) -> None:
        self.callback: Callable[[], object] | None = callback

    def cancel(self) -> None:
        self.callback = None


class Clock:
    """A clock that moves when it is told to."""

    def __init__(self) -> None:
        self._now = 0.0
        self._due: list[tuple[float, int, Appointment]] = []
        self._numbers = count()

    def time(self) -> float:
        return self._now

    def call_later(self, delay: float, callback: Callable[[], object], /) -> Appointment:
        appointment = Appointment(callback)
        heapq.heappush(self._due, (self._now + delay, next(self._numbers), appointment))
        return appointment

    def call_soon(self, callback: Callable[[], object], /) -> Appointment:
        return self.call_later(0.0, callback)

    @property
    def n_due(self) -> int:
        """How many callbacks wait for their time."""
        return len(self._due)

    def advance(self, seconds: float) -> None:
        end = self._now + seconds
        while self._due and self._due[0][0] <= end:
            self._now, _, appointment = heapq.heappop(self._due)
            if appointment.callback is not None:
                appointment.callback()
        self._now = end


def new_hub(limits: Limits | None = None, types: TypeTable = TYPES) -> tuple[Hub, Clock]:
    """Return what the clients of a server share, with a clock for the test to move."""
    clock = Clock()
    hub = Hub(types, limits or Limits(), clock)
    provide_rosapi(hub)
    return hub, clock


class Peer:
    """A client of a hub, without a socket, that is told of what is as bad as a level."""

    def __init__(self, hub: Hub, level: str = "") -> None:
        self.frames: list[Frame] = []
        self.session = Session(hub, "peer", self._take)
        if level:
            self.tell(op="set_level", level=level)

    def _take(self, frames: bytes) -> None:
        self.frames += parse_frames(frames)

    def tell(self, **operation: Any) -> None:
        """Send one operation."""
        self.session.receive(json.dumps(operation))

    def take(self) -> list[dict[str, Any]]:
        """Return the operations that arrived since the last call."""
        frames, self.frames = self.frames, []
        assert all(frame.opcode is OP_TEXT for frame in frames)
        return [json.loads(frame.data) for frame in frames]

    def messages(self) -> list[dict[str, Any]]:
        """Return the messages that arrived since the last call."""
        return [operation["msg"] for operation in self.take() if operation["op"] == "publish"]

    def call(self, service: str, /, **arguments: Any) -> Any:
        """Return the answer of a service that the server itself provides."""
        self.tell(op="call_service", service=service, args=arguments)
        answer = self.take()[-1]
        assert answer["result"] is True, answer
        return answer["values"]


def parse_frames(content: bytes) -> list[Frame]:
    """Return the frames that a server wrote."""
    reader = StreamReader()
    reader.feed_data(content)
    reader.feed_eof()
    frames = []
    while not _finish(reader.at_eof()):
        frames.append(_finish(Frame.parse(reader.read_exact, mask=False)))
    return frames


def _finish(steps: Any) -> Any:
    try:
        next(steps)
    except StopIteration as stop:
        return stop.value
    raise AssertionError("a frame is cut off")


def png_text(data: str) -> str:
    """Return the text that the pixels of a PNG image in base64 spell."""
    with Image.open(BytesIO(base64.b64decode(data))) as image:
        assert image.mode == "RGB"
        return image.tobytes().decode()
