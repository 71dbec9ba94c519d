"""A simulation's connection to a rosbridge server: names, types and times of ROS, and bundles."""

import json
import traceback
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import roslibpy
from robots import WorldError

Message: TypeAlias = dict[str, Any]
Callback: TypeAlias = Callable[[Message], None]

_GO_BUNDLE, _TICK_BUNDLE = "/mission/go/bundle", "/mission/tick/bundle"
_FAILURE = "/mission/failure"


class Bus:
    """Topics and services of a server, with a prefix and the names of a version of ROS.

    Names in a bundle have no prefix; the topic of the bundle has it.

    An error in a callback is published on ``/mission/failure``, then passed to ``fail``;
    roslibpy would only log it.

    Attributes
    ----------
    where
        Returns run and tick of the simulation, for the messages of failures.
    """

    def __init__(
        self, ros: roslibpy.Ros, prefix: str, version: int, fail: Callable[[str], None]
    ) -> None:
        self._ros = ros
        self._prefix = prefix
        self._version = version
        self._fail = fail
        self.where = lambda: "no run"
        self._topics: dict[str, roslibpy.Topic] = {}
        self._callbacks: dict[str, Callback] = {}
        self._is_bundling = False
        self.advertise(_FAILURE, "std_msgs/String")
        self.advertise(_TICK_BUNDLE, "std_msgs/String")
        self._topic(_GO_BUNDLE, "std_msgs/String").subscribe(self._safe(self._take_apart))

    def advertise(self, name: str, type_name: str) -> None:
        """Advertise a topic."""
        self._topics[name] = self._topic(name, type_name)
        self._topics[name].advertise()

    def subscribe(self, name: str, type_name: str, callback: Callback) -> None:
        """Have a callback receive a topic, whether its messages are bundled or not."""

        def hear(message: Message) -> None:
            self._is_bundling = False
            callback(message)

        self._callbacks[name] = callback
        self._topic(name, type_name).subscribe(self._safe(hear))

    def provide(self, name: str, answer: Callable[[], tuple[bool, str]]) -> None:
        """Serve a trigger with a function that returns success and a message."""

        def handle(_request: Any, response: Any) -> bool:
            try:
                is_success, text = answer()
            except Exception as error:  # noqa: BLE001 - any error ends the simulation
                is_success, text = False, self._report(error)
            response.update(success=is_success, message=text)
            return True

        kind = self._type("std_srvs/Trigger", "srv")
        roslibpy.Service(self._ros, self._prefix + name, kind).advertise(handle)

    def call_later(self, seconds: float, callback: Callable[[], None]) -> None:
        """Call a function after a time, in the thread in which messages come."""
        self._ros.call_later(seconds, lambda: self._safe(lambda _message: callback())({}))

    def publish(self, messages: Sequence[tuple[str, Message]]) -> None:
        """Publish the messages of a tick, as a bundle if its commands came as one."""
        if self._is_bundling:
            text = json.dumps(messages, allow_nan=False, separators=(",", ":"))
            messages = [(_TICK_BUNDLE, {"data": text})]
        for name, message in messages:
            self._topics[name].publish(message)

    def time_of(self, tick: int) -> Message:
        """Return the time of a tick: one tick is one second."""
        if self._version == 1:
            return {"secs": tick, "nsecs": 0}
        return {"sec": tick, "nanosec": 0}

    def _type(self, name: str, kind: str) -> str:
        return name if self._version == 1 else name.replace("/", f"/{kind}/")

    def _topic(self, name: str, type_name: str) -> roslibpy.Topic:
        return roslibpy.Topic(self._ros, self._prefix + name, self._type(type_name, "msg"))

    def _take_apart(self, message: Message) -> None:
        self._is_bundling = True
        for name, each in json.loads(message["data"]):
            if callback := self._callbacks.get(name):
                callback(each)

    def _safe(self, callback: Callback) -> Callback:
        def hear(message: Message) -> None:
            try:
                callback(message)
            except Exception as error:  # noqa: BLE001 - any error ends the simulation
                self._report(error)

        return hear

    def _report(self, error: Exception) -> str:
        """Publish in a sentence why the simulation ends; print where its own code failed."""
        words = str(error)
        if not isinstance(error, WorldError):
            words = f"{type(error).__name__}: {error}"
            traceback.print_exception(error)
        reason = f"{self.where()}: {words}"
        self._topics[_FAILURE].publish({"data": reason})
        self._fail(reason)
        return reason
