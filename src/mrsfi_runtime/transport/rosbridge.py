"""The two transports over a rosbridge server: through roslibpy, or in the server's own process.

roslibpy runs all callbacks in one background thread. It only logs their errors, and it reconnects
on its own, so messages can be lost silently. A ``ListenedTransport`` passes errors in callbacks
and lost connections to its listener, and never reconnects.

A ``RosbridgeTransport`` is one connection to a server. An ``EmbeddedTransport`` joins a server
in this process, in the server's thread and without a socket: messages published within
one callback leave in one write. Errors of the server become errors of the runtime (``as_ours``)
with the same message and exit code.

Begin with ``RosbridgeTransport``. ``wire`` is a separate module because importing it binds the
process to asyncio, after which roslibpy's Twisted client is unusable.

References
----------
Source paper, section III-F.
"""

import logging
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from http import HTTPStatus
from threading import Event, get_ident
from typing import Any, ParamSpec, TypeVar
from urllib.parse import urlsplit

import roslibpy

from mrsfi_bridge import errors as bridge_errors
from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_runtime.errors import (
    MrsfiError,
    ProtocolError,
    TransportClosed,
    TransportTimeout,
    UsageError,
)
from mrsfi_runtime.transport.topics import (
    CLIENTS,
    SEE_LOG,
    Client,
    FailureListener,
    Payload,
    Provider,
    Publisher,
    Reply,
    Service,
    Topic,
    type_name,
    without_token,
)

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")


class ListenedTransport:
    """A transport that reports errors in its callbacks and of its connection to a listener.

    ``lost`` is the reason why the connection ended, or ``None`` while it is open.
    """

    hint = SEE_LOG

    def __init__(self) -> None:
        self.lost: Exception | None = None
        self._listener: FailureListener | None = None

    def watch(self, listener: FailureListener) -> None:
        """Report a lost connection and errors in callbacks to a function."""
        self._listener = listener
        if self.lost is not None:
            listener(self.lost)

    def require_open(self) -> None:
        """Raise ``TransportClosed`` if the connection is lost."""
        if self.lost is not None:
            raise self.lost

    def report(self, error: Exception) -> None:
        """Pass an error to the listener, if there is one."""
        if self._listener is not None:
            self._listener(error)

    def reporting(self, callback: Callable[P, R]) -> Callable[P, R]:
        """Return a callback that reports its errors to the listener, then raises them."""

        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            try:
                return callback(*args, **kwargs)
            except Exception as error:
                self.report(error)
                raise

        return call


_OURS: tuple[tuple[type[bridge_errors.BridgeError], type[MrsfiError]], ...] = (
    (bridge_errors.SettingsError, UsageError),
    (bridge_errors.NotRunningError, TransportClosed),
    (bridge_errors.ProtocolError, ProtocolError),
)


def as_ours(error: bridge_errors.BridgeError) -> MrsfiError:
    """Return the runtime's error with the same message and exit code."""
    return next((ours for theirs, ours in _OURS if isinstance(error, theirs)), MrsfiError)(
        str(error)
    )


@contextmanager
def errors_as_ours() -> Iterator[None]:
    """Turn errors of the server in the body into those of the runtime."""
    try:
        yield
    except bridge_errors.BridgeError as error:
        raise as_ours(error) from error


class EmbeddedTransport(ListenedTransport):
    """A client of a started embedded bridge; its callbacks run in the bridge's thread.

    Closing the transport does not close the bridge.
    """

    def __init__(self, bridge: EmbeddedBridge) -> None:
        super().__init__()
        self._bridge = bridge
        self.ros = bridge.ros
        self._thread = 0
        self._thread = self._run(get_ident)
        self._hub = self._run(lambda: bridge.hub)
        self._subscribed: list[tuple[Callable[[Any], None], str]] = []

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic."""
        name, broker = topic.name, self._hub.broker
        self._run(lambda: broker.advertise(self, name, topic.type))

        def publish(payload: Payload) -> None:
            self._run(lambda: broker.publish(self, name, payload))

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        receive, broker = self.reporting(callback), self._hub.broker

        def take(outgoing: Any) -> None:
            with suppress(Exception):  # reported to the listener
                receive(outgoing.message)

        self._run(lambda: broker.subscribe(take, topic.name, topic.type, take))
        self._subscribed.append((take, topic.name))

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service."""
        answer, services = self.reporting(provider), self._hub.services

        def ask(call_id: str, request: Payload) -> None:
            try:
                services.respond(self, call_id, answer(request))
            except Exception as error:  # noqa: BLE001 - reported to the listener
                services.drop(call_id, f"its provider failed: {error}")

        self._run(lambda: services.advertise(self, service.name, service.type, ask))

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service."""

        def reply(is_answer: bool, values: Any) -> None:
            on_reply(Reply(values) if is_answer else Reply({}, str(values)))

        services = self._hub.services
        self._run(lambda: services.call(self, service.name, request, self.reporting(reply)))

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, in the thread of the callbacks."""
        self._run(lambda: self._bridge.call_later(seconds, self.reporting(function)))

    def barrier(self, then: Callable[[], None]) -> None:
        """Call a function when all clients of the server have answered all their messages."""
        self._run(lambda: self._bridge.barrier(self.reporting(then)))

    def on_refusal(self, listener: Callable[[str, str], None]) -> None:
        """Call a function with topic and reason of each operation that the server drops.

        The topic is empty if the operation names none.
        """
        report = self.reporting(listener)

        def refused(value: Any, reason: str) -> None:
            topic = value.get("topic", "") if isinstance(value, dict) else ""
            self._bridge.call_later(0.0, lambda: report(str(topic), reason))

        self._hub.refused = refused

    def close(self) -> None:
        """Give up all topics and services."""
        if self.lost is None:
            self._run(self._leave)
            self.lost = TransportClosed("the embedded transport was closed")
            self.report(self.lost)

    def _leave(self) -> None:
        for take, name in self._subscribed:
            self._hub.broker.unsubscribe(take, name)
        self._hub.broker.leave(self)
        self._hub.services.leave(self)

    @errors_as_ours()
    def _run(self, function: Callable[[], T]) -> T:
        self.require_open()
        return function() if get_ident() == self._thread else self._run_there(function)

    def _run_there(self, function: Callable[[], T]) -> T:
        done: Future[T] = Future()

        def run() -> None:
            try:
                done.set_result(function())
            except Exception as error:  # noqa: BLE001 - raised in the caller's thread
                done.set_exception(error)

        self._bridge.call_soon(run)
        return done.result()


_PORTS = {"ws": 80, "wss": 443}

for _name in ("autobahn", "roslibpy", "twisted"):  # errors reach the listener instead
    logging.getLogger(_name).addHandler(logging.NullHandler())


class RosbridgeTransport(ListenedTransport):
    """One connection to a rosbridge server; the attribute ``url`` has no token.

    The argument is ``ws://host:port`` or ``wss://host:port``, with ``/?token=…`` if the server
    requires a token. The server must accept within ``timeout`` seconds; ``ros`` is its version of
    ROS. An invalid URL, or a process that already uses the other kind of client, is a
    ``UsageError``. If no rosbridge server listens there, it is ``TransportClosed``; without an
    answer in time, ``TransportTimeout``.
    """

    def __init__(
        self, url: str, client: Client = CLIENTS[0], ros: int = 1, timeout: float = 10.0
    ) -> None:
        super().__init__()
        self.ros = ros
        self.url = without_token(url)
        self._client = client
        self._is_closing = False
        self._opened = Event()
        self._closed = Event()
        _require_listener(url, timeout)
        try:
            self._ros = _ros(url, client)
        except RuntimeError as error:
            raise UsageError(
                f"--client {client}: this process already uses roslibpy's other client"
            ) from error
        self._ros.on("close", self._on_close)
        self._ros.factory.on_ready(self._on_open)
        self._ros.factory.manager.run()
        self._wait_open(timeout)

    def advertise(self, topic: Topic) -> Publisher:
        """Return the function that publishes on a topic.

        The function raises ``TransportClosed`` once the connection is lost.
        """
        ros_topic = self._topic(topic)
        ros_topic.advertise()

        def publish(payload: Payload) -> None:
            self.require_open()
            ros_topic.publish(payload)

        return publish

    def subscribe(self, topic: Topic, callback: Callable[[Payload], None]) -> None:
        """Have a callback receive every message of a topic."""
        self._topic(topic).subscribe(self.reporting(callback))

    def provide(self, service: Service, provider: Provider) -> None:
        """Answer the calls of a service; an error of the provider becomes a failure."""
        provide = self.reporting(provider)

        def answer(request: Any, response: Any) -> bool:
            with suppress(Exception):  # reported to the listener
                response.update(provide(dict(request)))
                return True
            return False

        kind = type_name(service.type, "srv", self.ros)
        ros_service = roslibpy.Service(self._ros, service.name, kind, reconnect_on_close=False)
        ros_service.advertise(answer)

    def call(self, service: Service, request: Payload, on_reply: Callable[[Reply], None]) -> None:
        """Call a service; ``TransportClosed`` if the connection is lost."""
        self.require_open()
        # the server's time-out for the provider; callers here have shorter ones
        fields = {"service": service.name, "args": dict(request), "timeout": 3600.0}
        identifier = f"call_service:{service.name}:{self._ros.id_counter}"
        self._ros.call_async_service(
            roslibpy.Message({"op": "call_service", "id": identifier, **fields}),
            self.reporting(lambda values: on_reply(Reply(dict(values)))),
            self.reporting(
                lambda problem: on_reply(Reply({}, str(problem) or "the service failed"))
            ),
        )

    def call_later(self, seconds: float, function: Callable[[], None]) -> None:
        """Call a function after a time, in the thread of the callbacks."""
        self._ros.call_later(seconds, self.reporting(function))

    def close(self) -> None:
        """Close the connection; roslibpy's thread stays for the next one."""
        self._is_closing = True
        if self._ros.is_connected:
            self._ros.close()
            self._closed.wait(6.0)  # roslibpy gives the server 5 s to agree
        if self.lost is None:
            self.lost = TransportClosed(f"the connection to {self.url} was closed")
            self.report(self.lost)  # a flight in another thread ends at once

    def _topic(self, topic: Topic) -> Any:
        kind = type_name(topic.type, "msg", self.ros)
        return roslibpy.Topic(self._ros, topic.name, kind, reconnect_on_close=False)

    def _wait_open(self, timeout: float) -> None:
        is_open = self._opened.wait(timeout)
        if is_open and self.lost is None:
            return
        self._ros.call_later(0, self._stop_reconnecting)
        if is_open and getattr(self._ros.factory, "status", None) == HTTPStatus.UNAUTHORIZED:
            raise TransportClosed(
                f"{self.url} requires a token, and received none or a wrong one; expected --url "
                f"{self.url}/?token=TOKEN"
            )
        if is_open:
            raise TransportClosed(f"{self.url} refused the connection; expected a rosbridge server")
        raise TransportTimeout(
            f"{self.url} did not answer within {timeout:g} s; expected a rosbridge server"
        )

    def _on_open(self, _protocol: Any) -> None:
        self._stop_reconnecting()
        self._opened.set()

    def _on_close(self, _protocol: Any) -> None:
        self._stop_reconnecting()
        if not self._is_closing:
            self.lost = TransportClosed(f"the connection to {self.url} was lost")
            self.report(self.lost)
        self._opened.set()
        self._closed.set()

    def _stop_reconnecting(self) -> None:
        """Prevent roslibpy from reconnecting; called in its thread."""
        if self._client == "twisted":
            self._ros.factory.stopTrying()
        else:
            self._ros.factory.maxRetries = 0


def _ros(url: str, client: Client) -> Any:
    if client != "wire":
        return roslibpy.Ros(url, transport=client)
    from mrsfi_runtime.transport.wire import WireRos  # noqa: PLC0415 - binds asyncio, as roslibpy's

    return WireRos(url)


def _require_listener(url: str, timeout: float) -> None:
    """Refuse a URL at which no server listens, since roslibpy would retry for an hour."""
    parts = urlsplit(url)
    if parts.scheme not in _PORTS or not parts.hostname:
        raise UsageError(f"--url: found '{url}'; expected ws://HOST:PORT")
    try:
        port = parts.port or _PORTS[parts.scheme]
    except ValueError as error:
        raise UsageError(f"--url: found '{url}'; expected a port from 1 to 65535") from error
    try:
        socket.create_connection((parts.hostname, port), timeout).close()
    except OSError as error:
        raise TransportClosed(
            f"{without_token(url)}: cannot be reached: {error.strerror or error}; start a "
            "rosbridge server (mrsfi bridge), or omit --url to use an embedded one"
        ) from error
