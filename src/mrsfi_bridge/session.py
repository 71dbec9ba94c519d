"""One client of the server: what it asks for, and what it is told. Knows no sockets."""

import logging
from asyncio import AbstractEventLoop
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from mrsfi_bridge.broker import SUCCEEDED, Actions, Broker, BrokerOfRos2, Services
from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import text_frames
from mrsfi_bridge.protocol import (
    Budget,
    Fragments,
    Operation,
    Subscription,
    Uses,
    Wish,
    absolute,
    check_operation,
    operations,
    settled,
    wanted_encoding,
    wish,
)
from mrsfi_bridge.settings import Limits, TypeTable

LOGGER = logging.getLogger("mrsfi.bridge")

LEVELS = ("info", "warning", "error", "none")
_MAX_REASON = 500
_LOGGED_FIRST = 10
_LOGGED_EVERY = 1000


@dataclass(slots=True)
class Counts:
    """What the server did since it started."""

    clients: int = 0
    received: int = 0
    sent: int = 0
    dropped: int = 0


class Hub:
    """What all clients share; ``scheduler`` is its clock.

    ``waiting`` are the bytes of throttled messages that wait for their time. ``refused`` is called
    with each operation of a client that is dropped, or ``None`` if it was no JSON, and the reason.
    """

    def __init__(self, types: TypeTable, limits: Limits, scheduler: AbstractEventLoop) -> None:
        self.types = types
        self.limits = limits
        self.scheduler = scheduler
        is_ros_2 = types.ros == 2
        self.broker = BrokerOfRos2(types, limits, scheduler) if is_ros_2 else Broker(types, limits)
        self.services = Services(types, limits, scheduler)
        self.actions = Actions(types, limits, scheduler)
        self.waiting = Budget(limits.total_bytes)
        self.counts = Counts()
        self.refused: Callable[[Any, str], None] = lambda _value, _reason: None


class Session:
    """Carries out the operations of one client, whose ``name`` is for the log.

    ``send`` takes frames for it; ``fragments`` are messages whose parts have not all come.
    """

    def __init__(self, hub: Hub, name: str, send: Callable[[bytes], None]) -> None:
        self.name = name
        self._hub = hub
        self._send = send
        self._level = "none"
        self._adverts: Uses[None] = Uses(hub.limits.uses)
        self._wishes: Uses[Wish] = Uses(hub.limits.uses)
        self._subscriptions: dict[str, Subscription] = {}
        self._goals: dict[str | int, str] = {}
        self.fragments = Fragments(2 * hub.limits.frame_bytes)
        self._n_dropped = 0

    def receive(self, text: str) -> None:
        """Carry out the operations of a text; what is wrong is dropped, counted and logged."""
        for value in operations(text, self._drop):
            self._carry_out(value)

    def _carry_out(self, value: Any) -> None:
        self._hub.counts.received += 1
        try:
            operation = check_operation(value)
            getattr(self, f"_{operation['op']}")(operation)  # one for each of the protocol
        except ProtocolError as error:
            self._drop(str(error), value)

    def leave(self) -> None:
        """End everything that the client does."""
        self._hub.broker.leave(self)
        self._hub.services.leave(self)
        self._hub.actions.leave(self)
        for topic in tuple(self._subscriptions):
            self._end(topic)
        if self._n_dropped:
            LOGGER.info("%s: %d operations dropped in all", self.name, self._n_dropped)

    def status(self, level: str, text: str, operation_id: Any = None) -> None:
        """Tell the client something, if it asked for that level."""
        if LEVELS.index(level) < LEVELS.index(self._level):
            return
        operation = {"op": "status", "level": level, "msg": text}
        if operation_id is not None:
            operation["id"] = operation_id
        self._send(text_frames(operation))

    def _drop(self, reason: str, value: Any = None) -> None:
        reason = reason[:_MAX_REASON]
        self._hub.counts.dropped += 1
        self._n_dropped += 1
        if self._n_dropped <= _LOGGED_FIRST or self._n_dropped % _LOGGED_EVERY == 0:
            LOGGER.warning("%s: dropped no. %d: %s", self.name, self._n_dropped, reason)
        self.status("error", reason, value.get("id") if isinstance(value, dict) else None)
        self._hub.refused(value, reason)

    def _advertise(self, operation: Operation) -> None:
        topic, use_id = absolute(operation["topic"]), operation.get("id")
        self._adverts.check(topic, use_id)
        is_latched = operation.get("latch", False)
        self._hub.broker.advertise(self, topic, operation["type"], is_latched=is_latched)
        self._adverts.add(topic, use_id, None)

    def _unadvertise(self, operation: Operation) -> None:
        topic = absolute(operation["topic"])
        if topic not in self._adverts:
            raise ProtocolError(f"topic '{topic}' is not one that you advertise")
        if self._adverts.remove(topic, operation.get("id")):
            self._hub.broker.unadvertise(self, topic)

    def _publish(self, operation: Operation) -> None:
        topic = self._joined(operation)
        self._hub.broker.publish(self, topic, operation.get("msg", {}))

    def _joined(self, operation: Operation) -> str:
        """Return a topic; one in use is advertised for a client that publishes without more ado."""
        name = absolute(operation["topic"])
        topic = self._hub.broker.topics.get(name)
        if name not in self._adverts and topic is not None:
            type_name, is_latched = topic.structure.name, operation.get("latch", False)
            self._advertise({"topic": name, "type": type_name, "latch": is_latched})
        return name

    def _subscribe(self, operation: Operation) -> None:
        topic, use_id = operation["topic"], operation.get("id")
        wanted = wish(operation)
        self._wishes.check(topic, use_id)
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            hub = self._hub
            subscription = Subscription(hub.scheduler, hub.waiting, self._deliver, topic)
        wishes = {**self._wishes.get(topic, {}), use_id: wanted}
        subscription.wish = settled(wishes.values())
        self._hub.broker.subscribe(
            (self, topic), absolute(topic), operation.get("type"), subscription
        )
        self._subscriptions[topic] = subscription
        self._wishes.add(topic, use_id, wanted)

    def _unsubscribe(self, operation: Operation) -> None:
        topic = operation["topic"]
        if topic not in self._wishes:
            raise ProtocolError(f"topic '{topic}' is not one that you subscribe to")
        if self._wishes.remove(topic, operation.get("id")):
            self._end(topic)
        else:
            self._subscriptions[topic].wish = settled(self._wishes[topic].values())

    def _end(self, topic: str) -> None:
        """End the subscription to a topic, as the client spells it."""
        self._subscriptions.pop(topic).close()
        self._hub.broker.unsubscribe((self, topic), absolute(topic))

    def _call_service(self, operation: Operation) -> None:
        encoding = wanted_encoding(operation)
        answer = {"op": "service_response", "service": operation["service"]}
        name, mark, call_id = operation["service"].partition("#")
        if operation.get("id") is not None:
            answer["id"] = operation["id"]
        elif mark:  # as older clients write it
            answer["id"] = call_id

        def reply(is_ok: bool, values: Any) -> None:
            told = {**answer, "values": values, "result": is_ok}
            self._send(text_frames(told, encoding))

        arguments = operation.get("args")
        if arguments is None:
            arguments = {}
        timeout = operation.get("timeout") or 0
        self._hub.services.call(self, absolute(name), arguments, reply, timeout)

    def _service_response(self, operation: Operation) -> None:
        """Pass an answer on: as with the genuine server, values count for more than result."""
        values = operation.get("values")
        if operation.get("result") is False and not isinstance(values, dict):
            reason = values if isinstance(values, str) else "the provider reported a failure"
            self._hub.services.refuse(self, operation["id"], reason)
        else:
            self._hub.services.respond(self, operation["id"], {} if values is None else values)

    def _advertise_service(self, operation: Operation) -> None:
        name = operation["service"]

        def ask(call_id: str, request: dict[str, Any]) -> None:
            call = {"op": "call_service", "id": call_id, "service": name, "args": request}
            self._send(text_frames(call))

        if self._hub.services.advertise(self, absolute(name), operation["type"], ask):
            self.status("warning", f"service '{name}' had another provider before you")

    def _unadvertise_service(self, operation: Operation) -> None:
        self._hub.services.unadvertise(self, absolute(operation["service"]))

    def _advertise_action(self, operation: Operation) -> None:
        name, type_name = operation["action"], operation["type"]

        def ask(goal_id: str, goal: dict[str, Any] | None) -> None:
            told = {"op": "cancel_action_goal", "id": goal_id, "action": name}
            if goal is not None:
                told |= {"op": "send_action_goal", "action_type": type_name, "feedback": True}
                told["args"] = goal
            self._send(text_frames(told))

        if self._hub.actions.advertise(self, absolute(name), type_name, ask):
            self.status("warning", f"action '{name}' had another provider before you")

    def _unadvertise_action(self, operation: Operation) -> None:
        self._hub.actions.unadvertise(self, absolute(operation["action"]))

    def _send_action_goal(self, operation: Operation) -> None:
        encoding = wanted_encoding(operation)
        name, own_id = operation["action"], operation.get("id")
        named = {"action": name} if own_id is None else {"id": own_id, "action": name}

        def answer(told: Operation) -> None:
            if told["op"] == "action_result":
                self._goals.pop(own_id or "", None)
            elif not operation.get("feedback", False):
                return
            said = {"op": told["op"], **named, **told}
            self._send(text_frames(said, encoding))

        goal, type_name = operation.get("args") or {}, operation["action_type"]
        goal_id = self._hub.actions.send_goal(self, absolute(name), type_name, goal, answer)
        if goal_id:
            self._goals[own_id or ""] = goal_id

    def _cancel_action_goal(self, operation: Operation) -> None:
        self._hub.actions.cancel(self._goals.get(operation["id"], ""))

    def _action_feedback(self, operation: Operation) -> None:
        self._hub.actions.feed_back(self, operation["id"], operation.get("values", {}))

    def _action_result(self, operation: Operation) -> None:
        is_ok = operation.get("result", True)
        values, status = operation.get("values", {}), operation.get("status", SUCCEEDED)
        self._hub.actions.finish(self, operation["id"], values, status, is_ok=is_ok)

    def _set_level(self, operation: Operation) -> None:
        if operation["level"] not in LEVELS:
            expected = ", ".join(LEVELS)
            raise ProtocolError(f"level '{operation['level']:.20}', expected one of {expected}")
        self._level = operation["level"]

    def _fragment(self, operation: Operation) -> None:
        text = self.fragments.add(operation)
        if text is not None:
            self.receive(text)

    def _deliver(self, frames: bytes) -> None:
        self._hub.counts.sent += 1
        self._send(frames)
