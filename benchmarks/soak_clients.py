"""Clients that load a bridge with mixed traffic and check every message that they receive.

Run as ``python -m benchmarks.soak_clients KIND URL BEGIN END INDEX …`` by ``bridge_soak.py``: one
process per kind of client, because a process has one kind of roslibpy client only. ``BEGIN``,
when services are called, and ``END`` are times of the monotonic clock, which all processes of a
machine share. The result is one line of
JSON.
"""

import asyncio
import base64
import io
import itertools
import json
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any

import cbor2
import roslibpy
from PIL import Image
from websockets.asyncio.client import ClientConnection, connect

HEADER = "std_msgs/Header"
SUM = "rospy_tutorials/AddTwoInts"
RATES = (50, 20, 20, 10, 10, 5, 5, 2, 1, 1)
"""Messages a second, by topic."""
SIZES = (10, 100, 1_000, 10, 10_000, 100, 1_000, 100_000, 10, 300_000)
"""Letters of a message, by topic."""
CALLS_PER_S = 2
REST = 1.2
"""Seconds between leaving a topic and joining it again, where a client does so."""
DRAIN = 3.0
"""Seconds after the last message in which what is under way arrives."""

Unpack = Callable[[dict[str, Any]], tuple[int, float]]
"""Takes number and time of sending out of an operation."""


@dataclass(slots=True)
class Reception:
    """What came on one topic to one client, in order or not.

    Attributes
    ----------
    is_throttled
        Whether the client asked for fewer messages than there are.
    is_changing
        Whether the client leaves the topic and joins it again.
    may_skip
        Whether the next message may have any number, because the client has just joined.
    """

    topic: int
    is_throttled: bool = False
    is_changing: bool = False
    may_skip: bool = True
    last: int = -1
    n_received: int = 0
    n_lost: int = 0
    n_disordered: int = 0
    delays: list[tuple[float, float]] = field(default_factory=list)

    def take(self, number: int, sent: float) -> None:
        """Count a message and compare its number with the one before."""
        now = time.monotonic()
        self.n_received += 1
        self.delays.append((round(now, 3), round(now - sent, 6)))
        if number <= self.last:
            self.n_disordered += 1
            return
        if not self.is_throttled and not self.may_skip:
            self.n_lost += number - self.last - 1
        self.may_skip = False
        self.last = number


@dataclass(slots=True)
class Report:
    """What the clients of one process did and saw."""

    published: dict[int, int] = field(default_factory=dict)
    receptions: list[Reception] = field(default_factory=list)
    n_calls: int = 0
    n_answers: int = 0
    n_wrong: int = 0
    n_rejoined: int = 0

    def receiver(
        self, topic: int, *, is_throttled: bool = False, is_changing: bool = False
    ) -> Reception:
        """Return what takes the messages of a new subscription."""
        reception = Reception(topic, is_throttled, is_changing)
        self.receptions.append(reception)
        return reception

    def answered(self, expected: int, found: Any) -> None:
        """Count the answer of a service."""
        self.n_answers += 1
        self.n_wrong += found != expected


def topics_of(index: int) -> list[int]:
    """Return the topics that a client subscribes to; the last it leaves and joins."""
    return [(index + step) % len(RATES) for step in (1, 4, 7, 0)]


def name_of(topic: int) -> str:
    """Return the name of a topic."""
    return f"/soak/topic_{topic}"


def header(topic: int, number: int) -> dict[str, Any]:
    """Return a message: its number, the time, and letters that make it as long as it should be."""
    secs, nsecs = divmod(time.monotonic_ns(), 1_000_000_000)
    letters = "x" * SIZES[topic]
    return {"seq": number, "stamp": {"secs": secs, "nsecs": nsecs}, "frame_id": letters}


def unpacked(message: dict[str, Any]) -> tuple[int, float]:
    """Return number and time of sending of a message."""
    if "bytes" in message:  # as ROS nodes send it
        seq, secs, nsecs = struct.unpack_from("<III", message["bytes"])
        return seq, secs + nsecs / 1e9
    stamp = message["stamp"]
    return message["seq"], stamp["secs"] + stamp["nsecs"] / 1e9


def due_times(rate: float, end: float) -> Iterator[float]:
    """Yield when to act: at a fixed rate until the end, never twice for what was missed."""
    due = time.monotonic()
    while due < end:
        yield due
        due = max(due + 1 / rate, time.monotonic() - 1)


@dataclass(frozen=True, slots=True)
class Span:
    """When services are first called, and when all is over."""

    begin: float
    end: float


class RoslibpyClients:
    """Unmodified roslibpy clients in one process, and one thread that makes them act."""

    def __init__(self, kind: str, url: str, span: Span, report: Report) -> None:
        self._kind, self._url, self._span, self._report = kind, url, span, report

    def run(self, indexes: list[int]) -> None:
        """Join, act until the end, and wait for what is under way."""
        threads = []
        clients = [roslibpy.Ros(self._url, transport=self._kind) for _ in indexes]
        for ros, index in zip(clients, indexes, strict=True):
            ros.run()
            threads += [threading.Thread(target=act) for act in self._actions(ros, index)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        time.sleep(max(0.0, self._span.end + DRAIN - time.monotonic()))
        for ros in clients:
            ros.close()

    def _actions(self, ros: Any, index: int) -> Iterator[Callable[[], None]]:
        *steady, changing = topics_of(index)
        for topic in steady:
            self._topic(ros, topic).subscribe(self._callback(topic))
        if index < len(RATES):
            yield partial(self._publish, self._topic(ros, index), index)
        service = roslibpy.Service(ros, f"/soak/sum_{index}", SUM)
        service.advertise(_sum)
        yield partial(self._call, ros, index)
        yield partial(self._come_and_go, ros, changing)

    def _topic(self, ros: Any, topic: int) -> Any:
        return roslibpy.Topic(ros, name_of(topic), HEADER)

    def _callback(self, topic: int) -> Callable[[dict[str, Any]], None]:
        reception = self._report.receiver(topic)
        return lambda message: reception.take(*unpacked(message))

    def _publish(self, publisher: Any, topic: int) -> None:
        publisher.advertise()
        for number, due in enumerate(due_times(RATES[topic], self._span.end)):
            time.sleep(max(0.0, due - time.monotonic()))
            publisher.publish(header(topic, number))
            self._report.published[topic] = number + 1

    def _call(self, ros: Any, index: int) -> None:
        service = roslibpy.Service(ros, f"/soak/sum_{index ^ 1}", SUM)
        time.sleep(max(0.0, self._span.begin - time.monotonic()))
        for number, due in enumerate(due_times(CALLS_PER_S, self._span.end)):
            time.sleep(max(0.0, due - time.monotonic()))
            self._report.n_calls += 1
            service.call(
                roslibpy.ServiceRequest({"a": number, "b": index}),
                lambda values, expected=number + index: self._report.answered(
                    expected, values["sum"]
                ),
                lambda problem: self._report.answered(0, problem),
            )

    def _come_and_go(self, ros: Any, topic: int) -> None:
        reception = self._report.receiver(topic, is_changing=True)
        while time.monotonic() < self._span.end - 2 * REST:
            subscriber = self._topic(ros, topic)
            reception.may_skip = True
            subscriber.subscribe(lambda message: reception.take(*unpacked(message)))
            time.sleep(3 * REST)
            subscriber.unsubscribe()
            time.sleep(REST)
            self._report.n_rejoined += 1


def _sum(request: Any, response: Any) -> bool:
    response["sum"] = request["a"] + request["b"]
    return True


class RawClient:
    """A client on plain websockets, with one of the ways of compression."""

    def __init__(self, index: int, url: str, span: Span, report: Report) -> None:
        self._index, self._url, self._span, self._report = index, url, span, report
        self._wishes: list[dict[str, Any]] = [
            {"compression": compression} for compression in ("none", "png", "cbor", "cbor-raw")
        ]
        self._receptions: dict[str, Reception] = {}
        self._expected: dict[str, int] = {}
        self._fragments: dict[str, dict[int, str]] = {}

    async def run(self) -> None:
        """Join, act until the end, and wait for what is under way."""
        async with connect(self._url, compression=None, max_size=None) as connection:
            receiver = asyncio.create_task(self._receive(connection))
            await self._join(connection)
            actions = [self._call(connection), self._come_and_go(connection)]
            if self._index < len(RATES):
                actions.append(self._publish(connection))
            await asyncio.gather(*actions)
            await asyncio.sleep(max(0.0, self._span.end + DRAIN - time.monotonic()))
            receiver.cancel()

    async def _join(self, connection: ClientConnection) -> None:
        *steady, _ = topics_of(self._index)
        wish = self._wishes[self._index // 2 % len(self._wishes)]
        variants: tuple[dict[str, Any], ...] = (
            {},
            {"fragment_size": 5_000} if wish["compression"] in {"none", "png"} else {},
            {"throttle_rate": 200, "queue_length": 1},
        )
        for topic, variant in zip(steady, variants, strict=True):
            is_throttled = "throttle_rate" in variant
            reception = self._report.receiver(topic, is_throttled=is_throttled)
            self._receptions[name_of(topic)] = reception
            await _send(
                connection, "subscribe", topic=name_of(topic), type=HEADER, **wish, **variant
            )
        await _send(connection, "advertise_service", service=f"/soak/sum_{self._index}", type=SUM)

    async def _receive(self, connection: ClientConnection) -> None:
        async for content in connection:
            await self._take(connection, content)

    async def _take(self, connection: ClientConnection, content: str | bytes) -> None:
        operation = json.loads(content) if isinstance(content, str) else cbor2.loads(content)
        op = operation["op"]
        if op == "publish":
            self._receptions[operation["topic"]].take(*unpacked(operation["msg"]))
        elif op == "png":
            await self._take(connection, _png_text(operation["data"]))
        elif op == "fragment":
            whole = self._whole(operation)
            if whole is not None:
                await self._take(connection, whole)
        elif op == "call_service":
            total = operation["args"]["a"] + operation["args"]["b"]
            answer = {"id": operation["id"], "service": operation["service"], "result": True}
            await _send(connection, "service_response", values={"sum": total}, **answer)
        elif op == "service_response":
            values = operation["values"]
            found = values["sum"] if operation["result"] else values
            self._report.answered(self._expected.pop(operation["id"]), found)

    def _whole(self, fragment: dict[str, Any]) -> str | None:
        parts = self._fragments.setdefault(fragment["id"], {})
        parts[fragment["num"]] = fragment["data"]
        if len(parts) < fragment["total"]:
            return None
        del self._fragments[fragment["id"]]
        return "".join(part for _, part in sorted(parts.items()))

    async def _publish(self, connection: ClientConnection) -> None:
        topic = self._index
        await _send(connection, "advertise", topic=name_of(topic), type=HEADER)
        for number, due in enumerate(due_times(RATES[topic], self._span.end)):
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            await _send(connection, "publish", topic=name_of(topic), msg=header(topic, number))
            self._report.published[topic] = number + 1

    async def _call(self, connection: ClientConnection) -> None:
        await asyncio.sleep(max(0.0, self._span.begin - time.monotonic()))
        for number, due in enumerate(due_times(CALLS_PER_S, self._span.end)):
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            self._report.n_calls += 1
            call = f"{self._index}:{number}"
            self._expected[call] = number + self._index
            arguments = {"a": number, "b": self._index}
            service = f"/soak/sum_{self._index ^ 1}"
            await _send(connection, "call_service", id=call, service=service, args=arguments)

    async def _come_and_go(self, connection: ClientConnection) -> None:
        topic = topics_of(self._index)[-1]
        name = name_of(topic)
        reception = self._report.receiver(topic, is_changing=True)
        self._receptions[name] = reception
        for visit in itertools.count():
            if time.monotonic() > self._span.end - 2 * REST:
                break
            reception.may_skip = True
            wish = self._wishes[visit % len(self._wishes)]
            await _send(connection, "subscribe", topic=name, type=HEADER, **wish)
            await asyncio.sleep(3 * REST)
            await _send(connection, "unsubscribe", topic=name)
            await asyncio.sleep(REST)
            self._report.n_rejoined += 1


async def _send(connection: ClientConnection, op: str, **fields: Any) -> None:
    await connection.send(json.dumps({"op": op, **fields}))


def _png_text(data: str) -> str:
    with Image.open(io.BytesIO(base64.b64decode(data))) as image:
        return image.tobytes().decode()


async def _run_raw(url: str, span: Span, indexes: list[int], report: Report) -> None:
    await asyncio.gather(*(RawClient(index, url, span, report).run() for index in indexes))


def main(kind: str, url: str, span: Span, indexes: list[int]) -> None:
    """Run the clients of one kind and print what they saw."""
    report = Report()
    if kind == "raw":
        asyncio.run(_run_raw(url, span, indexes, report))
    else:
        RoslibpyClients(kind, url, span, report).run(indexes)
    print(json.dumps(asdict(report)))


if __name__ == "__main__":
    _, kind_, url_, begin_, end_, *indexes_ = sys.argv
    main(kind_, url_, Span(float(begin_), float(end_)), [int(word) for word in indexes_])
