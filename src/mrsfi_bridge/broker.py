"""Topics, services and actions that clients share.

A ``Broker`` delivers messages from publishers to subscribers,
in order and before ``publish`` returns; ``BrokerOfRos2`` delivers them in turns, as the
middleware of ROS 2 does. ``Services`` passes calls to providers and answers to callers.
``Actions`` are services without a time-out that report progress and can be cancelled.

Invariants: clients are any hashable objects, and no class here uses a socket. Every
call and every goal gets exactly one answer, whatever happens to its provider. A topic exists
while a client publishes or subscribes. A ``ProtocolError`` refuses an unknown or conflicting
type, a message that does not fit its type, an object of another client, and an excess of
``Limits``.

Begin with ``Broker``, then ``Services.call``.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md (actions)
"""

import logging
from asyncio import AbstractEventLoop, TimerHandle
from collections import Counter, deque
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from itertools import count
from typing import Any, NamedTuple, TypeAlias

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import PLAIN, Outgoing
from mrsfi_bridge.protocol import Budget, check_name
from mrsfi_bridge.settings import Limits, ServiceType, TypeTable
from mrsfi_bridge.structures import Structure

Subscriber: TypeAlias = Callable[[Outgoing], None]
"""Takes messages for a client."""


@dataclass(slots=True)
class Publication:
    """A client's publications on a topic: whether the last message is kept, and the message."""

    is_latched: bool
    last: Outgoing | None = None
    n_bytes: int = 0


@dataclass(slots=True, eq=False)
class Topic:
    """A topic in use."""

    name: str
    structure: Structure
    n_numbered: int = 0
    publishers: dict[Hashable, Publication] = field(default_factory=dict)
    subscribers: dict[Hashable, Subscriber] = field(default_factory=dict)


class Broker:
    """Delivers messages from publishers to subscribers, in order, before it returns.

    ``topics`` has the topics by name, in the order in which they came.
    """

    def __init__(self, types: TypeTable, limits: Limits) -> None:
        self._types = types
        self._limits = limits
        self._latched = Budget(limits.latched_bytes)
        self.topics: dict[str, Topic] = {}

    def advertise(
        self, client: Hashable, name: str, type_name: str, *, is_latched: bool = False
    ) -> None:
        """Let a client publish on a topic."""
        topic = self._topic(name, type_name)
        publication = topic.publishers.setdefault(client, Publication(is_latched))
        publication.is_latched = is_latched

    def unadvertise(self, client: Hashable, name: str) -> None:
        """End the publications of a client on a topic, and forget what they latched."""
        topic = self.topics.get(name)
        if topic is not None and (publication := topic.publishers.pop(client, None)):
            self._latched.give_back(publication.n_bytes)
            self._release(topic)

    def publish(self, client: Hashable, name: str, message: Any) -> None:
        """Deliver a message to all subscribers of a topic that the client advertises."""
        topic = self.topics.get(name)
        publication = None if topic is None else topic.publishers.get(client)
        if topic is None or publication is None:
            raise ProtocolError(
                f"topic '{name}' is not advertised; advertise it before you publish"
            )
        outgoing = Outgoing(topic.structure, topic.structure.convert(message))
        topic.n_numbered += 1
        outgoing.number(topic.n_numbered)
        if publication.is_latched:
            self._latch(topic, publication, outgoing)
        self._pass_on(topic, outgoing)

    def subscribe(
        self, client: Hashable, name: str, type_name: str | None, subscriber: Subscriber
    ) -> None:
        """Have a client receive a topic, beginning with the messages kept from before.

        A client that subscribes again does not get the kept messages again.
        """
        topic = self._topic(name, type_name)
        is_known = client in topic.subscribers
        topic.subscribers[client] = subscriber
        for outgoing in () if is_known else self._kept(topic):
            subscriber(outgoing)

    def unsubscribe(self, client: Hashable, name: str) -> None:
        """End the subscription of a client to a topic."""
        topic = self.topics.get(name)
        if topic is not None and topic.subscribers.pop(client, None) is not None:
            self._release(topic)

    def leave(self, client: Hashable) -> None:
        """End everything that a client does on topics."""
        for name in tuple(self.topics):
            self.unadvertise(client, name)
            self.unsubscribe(client, name)

    @property
    def is_idle(self) -> bool:
        """Whether all published messages were delivered."""
        return True

    def _pass_on(self, topic: Topic, outgoing: Outgoing) -> None:
        for subscriber in tuple(topic.subscribers.values()):
            subscriber(outgoing)

    def _kept(self, topic: Topic) -> list[Outgoing]:
        """Return the latched messages, for later subscribers."""
        lasts = (publication.last for publication in topic.publishers.values())
        return [last for last in lasts if last is not None]

    def _latch(self, topic: Topic, publication: Publication, outgoing: Outgoing) -> None:
        """Keep a message for later subscribers."""
        n_bytes = len(outgoing.frames(topic.name, PLAIN))
        if not self._latched.take(n_bytes - publication.n_bytes):
            limit = self._limits.latched_bytes
            raise ProtocolError(
                f"topic '{topic.name}': latched messages exceed {limit} bytes, the limit"
            )
        publication.last, publication.n_bytes = outgoing, n_bytes

    def _topic(self, name: str, type_name: str | None) -> Topic:
        """Return the topic of a name, made if it is new, after checks that its type agrees."""
        topic = self.topics.get(name)
        if topic is not None:
            wanted = topic.structure if type_name is None else self._types.message(type_name)
            if wanted is not topic.structure:
                found = topic.structure.name
                raise ProtocolError(f"topic '{name}' carries {found}, not {wanted.name}")
            return topic
        check_name(name, "topic")
        if type_name is None:
            raise ProtocolError(f"topic '{name}' has no type yet; give one")
        limit = self._limits.topics
        if len(self.topics) >= limit:
            raise ProtocolError(f"topic '{name}': the limit of {limit} topics is reached")
        topic = self.topics[name] = Topic(name, self._types.message(type_name))
        return topic

    def _release(self, topic: Topic) -> None:
        if not topic.publishers and not topic.subscribers:
            del self.topics[topic.name]


DEPTH = 10  # most messages of a topic in transit; of more, the oldest are lost
LIFESPAN_S = 1.0  # how long messages of a topic are kept for later subscribers


@dataclass(slots=True)
class _Lane:
    """Waiting and recent messages of a topic; ``order`` is that of the first subscriptions."""

    order: int
    waiting: deque[Outgoing] = field(default_factory=lambda: deque(maxlen=DEPTH))
    recent: deque[tuple[float, Outgoing]] = field(default_factory=lambda: deque(maxlen=DEPTH))
    n_lost: int = 0


class BrokerOfRos2(Broker):
    """Delivers messages in the next turn of the loop, in order within a topic only.

    A turn delivers one message of each topic, in the order in which topics were subscribed to. A
    late subscriber gets the last second of a topic, also of publishers that have left. This was
    measured on rosbridge_suite 2.1.0 with ROS 2 Jazzy.
    """

    def __init__(self, types: TypeTable, limits: Limits, scheduler: AbstractEventLoop) -> None:
        super().__init__(types, limits)
        self._scheduler = scheduler
        self._lanes: dict[str, _Lane] = {}
        self._ready: dict[str, _Lane] = {}
        self._orders = count()
        self._is_expiring = False

    def subscribe(
        self, client: Hashable, name: str, type_name: str | None, subscriber: Subscriber
    ) -> None:
        """Subscribe as in ``Broker``; the first subscription sets the order of a topic."""
        super().subscribe(client, name, type_name, subscriber)
        if len(self.topics[name].subscribers) == 1:
            self._lane(name).order = next(self._orders)

    @property
    def is_idle(self) -> bool:
        """Whether no topic waits for its turn."""
        return not self._ready

    def _pass_on(self, topic: Topic, outgoing: Outgoing) -> None:
        lane = self._lane(topic.name)
        if len(lane.waiting) == DEPTH and topic.subscribers:
            lane.n_lost += 1
            if lane.n_lost == 1:
                logger = logging.getLogger("mrsfi.bridge")
                logger.warning("%s: lost a message, the oldest of %d", topic.name, DEPTH + 1)
        lane.waiting.append(outgoing)
        if not self._ready:
            self._scheduler.call_soon(self._turn)
        self._ready[topic.name] = lane

    def _kept(self, topic: Topic) -> list[Outgoing]:
        since = self._scheduler.time() - LIFESPAN_S
        lane = self._lane(topic.name)
        recent = [each for moment, each in lane.recent if moment >= since]
        recent = [each for each in recent if each.structure is topic.structure]
        come = (*recent, *lane.waiting)
        return [*(each for each in super()._kept(topic) if each not in come), *recent]

    def _lane(self, name: str) -> _Lane:
        if name not in self._lanes:
            self._lanes[name] = _Lane(next(self._orders))
        return self._lanes[name]

    def _turn(self) -> None:
        ready, self._ready = self._ready, {}
        now = self._scheduler.time()
        for name, lane in sorted(ready.items(), key=lambda item: item[1].order):
            outgoing = lane.waiting.popleft()
            lane.recent.append((now, outgoing))
            topic = self.topics.get(name)
            if topic is not None and topic.structure is outgoing.structure:
                super()._pass_on(topic, outgoing)
        for name, lane in ready.items():
            if lane.waiting:
                if not self._ready:
                    self._scheduler.call_soon(self._turn)
                self._ready[name] = lane
        if not self._is_expiring:
            self._is_expiring = True
            self._scheduler.call_later(LIFESPAN_S, self._expire)

    def _expire(self) -> None:
        """Forget expired messages, and topics without any."""
        since = self._scheduler.time() - LIFESPAN_S
        for name, lane in tuple(self._lanes.items()):
            while lane.recent and lane.recent[0][0] <= since:
                lane.recent.popleft()
            if name not in self.topics and not lane.recent and not lane.waiting:
                del self._lanes[name]
        self._is_expiring = any(lane.recent for lane in self._lanes.values())
        if self._is_expiring:
            self._scheduler.call_later(LIFESPAN_S, self._expire)


Ask: TypeAlias = Callable[[str, Any], None]
"""Passes a call on to its provider: identifier of the call, and the request."""

Reply: TypeAlias = Callable[[bool, Any], None]
"""Answers a caller: whether the call succeeded, and the response or the reason."""


OWN: Hashable = "the server itself"  # provider of services that clients cannot replace


class Service(NamedTuple):
    """A service and its provider."""

    type: ServiceType
    owner: Hashable
    ask: Ask


class Call(NamedTuple):
    """A call that waits for its answer; without a timer, there is no time-out."""

    service: str
    type: ServiceType
    owner: Hashable
    caller: Hashable
    reply: Reply
    timer: TimerHandle | None


class Services:
    """Passes calls to providers and answers to callers; every call gets one answer.

    ``services`` maps names to services, in the order of their first advertisement.
    """

    noun = "service"
    _id = "service_request"

    def __init__(self, types: TypeTable, limits: Limits, scheduler: AbstractEventLoop) -> None:
        self._types = types
        self._limits = limits
        self._scheduler = scheduler
        self.services: dict[str, Service] = {}
        self._calls: dict[str, Call] = {}
        self._n_calls: Counter[Hashable] = Counter()
        self._numbers = count(1)

    def advertise(self, owner: Hashable, name: str, type_name: str, ask: Ask) -> bool:
        """Let a client provide a service; return whether it replaces another provider.

        No client replaces the server itself.
        """
        check_name(name, self.noun)
        service_type = self._typed(type_name)
        known = self.services.get(name)
        if known is None and len(self.services) >= self._limits.services:
            raise ProtocolError(
                f"{self.noun} '{name}': the limit of {self._limits.services} is reached"
            )
        if known is not None and known.owner == OWN != owner:
            raise ProtocolError(f"the server itself provides '{name}'; choose another name")
        is_taken = known is not None and known.owner != owner
        if known is not None and is_taken:
            self._abandon(known.owner, name)
        self.services[name] = Service(service_type, owner, ask)
        return is_taken

    def unadvertise(self, owner: Hashable, name: str) -> None:
        """End a service of a client, and answer those who wait for it."""
        known = self.services.get(name)
        if known is None or known.owner != owner:
            raise ProtocolError(f"you do not advertise {self.noun} '{name}'")
        del self.services[name]
        self._abandon(owner, name)

    def call(
        self, caller: Hashable, name: str, arguments: Any, reply: Reply, timeout_s: float = 0
    ) -> str:
        """Pass a call to its provider; ``reply`` always gets exactly one answer.

        ``arguments`` are the fields of the request by name, or in order. ``timeout_s`` is the
        caller's time-out, at most an hour; 0 means that of the server. Returns
        the identifier of the call, or an empty text if it was refused.
        """
        service = self.services.get(name)
        if service is None:
            reply(False, f"{self.noun.capitalize()} {name} does not exist")
            return ""
        if self._n_calls[caller] >= self._limits.calls:
            reply(False, f"you have {self._limits.calls} unanswered calls, the limit")
            return ""
        try:
            request = service.type.request.convert(_named(arguments, service.type))
        except ProtocolError as error:
            reply(False, f"request of {self.noun} {name}: {error}")
            return ""
        call_id = f"{self._id}:{name}:{next(self._numbers)}"
        timer = self._timer(call_id, timeout_s)
        self._calls[call_id] = Call(name, service.type, service.owner, caller, reply, timer)
        self._n_calls[caller] += 1
        service.ask(call_id, request)
        return call_id

    def respond(self, owner: Hashable, call_id: Any, values: Any) -> None:
        """Pass a provider's response to the caller; if it does not fit, both get the reason."""
        call = self._taken(owner, call_id)
        try:
            response = call.type.response.convert(values)
        except ProtocolError as error:
            reason = f"response of {self.noun} {call.service}: {error}"
            call.reply(False, reason)
            raise ProtocolError(reason) from error
        call.reply(True, response)

    def refuse(self, owner: Hashable, call_id: Any, reason: str) -> None:
        """Answer the caller that the provider failed."""
        self._taken(owner, call_id).reply(False, reason)

    def drop(self, call_id: str, reason: str) -> None:
        """End a call with a failure, unless it was answered."""
        if call_id in self._calls:
            call = self._forget(call_id)
            call.reply(False, f"{self.noun.capitalize()} {call.service}: {reason}")

    def leave(self, client: Hashable) -> None:
        """End the services and the calls of a client, and answer those who wait for it."""
        for name in [name for name, known in self.services.items() if known.owner == client]:
            del self.services[name]
        for call_id in [key for key, call in self._calls.items() if call.caller == client]:
            self._forget(call_id)
        for call_id in [key for key, call in self._calls.items() if call.owner == client]:
            self.drop(call_id, "its provider left")
        del self._n_calls[client]

    def _typed(self, type_name: str) -> ServiceType:
        return self._types.service(type_name)

    def _timer(self, call_id: str, timeout_s: float) -> TimerHandle | None:
        """Return the timer that ends a call that takes too long."""
        wait_s = min(timeout_s, 3600.0) if timeout_s > 0 else self._limits.service_s
        reason = f"no answer within {wait_s:g} s"
        return self._scheduler.call_later(wait_s, lambda: self.drop(call_id, reason))

    def _abandon(self, owner: Hashable, name: str) -> None:
        for call_id, call in tuple(self._calls.items()):
            if call.owner == owner and call.service == name:
                self.drop(call_id, "its provider gave it up")

    def _taken(self, owner: Hashable, call_id: Any) -> Call:
        self._asked(owner, call_id)
        return self._forget(call_id)

    def _asked(self, owner: Hashable, call_id: Any) -> Call:
        call = self._calls.get(call_id) if isinstance(call_id, str) else None
        if call is None or call.owner != owner:
            raise ProtocolError(f"no call {call_id!r:.100} waits for your answer")
        return call

    def _forget(self, call_id: str) -> Call:
        call = self._calls.pop(call_id)
        if call.timer is not None:
            call.timer.cancel()
        self._n_calls[call.caller] -= 1
        return call


def _named(arguments: Any, service_type: ServiceType) -> Any:
    """Return the fields of a request; a list gives them in order."""
    if not isinstance(arguments, list):
        return arguments
    fields = service_type.request.definition.fields
    if len(arguments) > len(fields):
        raise ProtocolError(f"{len(arguments)} arguments, expected at most {len(fields)}")
    return {field.name: value for field, value in zip(fields, arguments, strict=False)}


SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""How a goal ended, by ``action_msgs/GoalStatus``. Any other status of a provider is ABORTED."""


class Actions(Services):
    """Services without a time-out that report progress and can be cancelled.

    A provider's ``Ask`` gets ``None`` in place of the goal to cancel it.
    """

    noun = "action"
    _id = "send_action_goal"

    def send_goal(
        self,
        caller: Hashable,
        name: str,
        type_name: str,
        goal: Any,
        answer: Callable[[dict[str, Any]], None],
    ) -> str:
        """Pass a goal to its provider, as ``call`` does; an action of another type is a failure.

        ``answer`` receives the replies: feedback, and last the result.
        """

        def reply(is_ok: bool, values: Any) -> None:
            failed = {"values": values, "status": ABORTED, "result": False}
            answer({"op": "action_result", **(values if is_ok else failed)})

        known = self.services.get(name)
        if known is not None and type_name.replace("/action/", "/") != known.type.name:
            reply(False, f"action '{name}' is of type {known.type.name}, not {type_name:.80}")
            return ""
        return self.call(caller, name, goal, reply)

    def cancel(self, goal_id: str) -> None:
        """Ask a provider to cancel a goal; its result says whether it did."""
        call = self._calls.get(goal_id)
        if call is None:
            raise ProtocolError("you have no active goal with this id")
        self.services[call.service].ask(goal_id, None)

    def cancel_all(self, name: str) -> int:
        """Ask the provider of an action to cancel all its goals; return their number."""
        goal_ids = [goal_id for goal_id, call in self._calls.items() if call.service == name]
        for goal_id in goal_ids:
            self.cancel(goal_id)
        return len(goal_ids)

    def feed_back(self, owner: Hashable, goal_id: Any, values: Any) -> None:
        """Pass feedback on a goal to its caller."""
        call = self._asked(owner, goal_id)
        if call.type.feedback is not None:
            feedback = call.type.feedback.convert(values)
            call.reply(True, {"op": "action_feedback", "values": feedback})

    def finish(
        self, owner: Hashable, goal_id: Any, values: Any, status: int, *, is_ok: bool
    ) -> None:
        """Pass the result of a goal to its caller, as ``respond`` does.

        As on the genuine server, a failed goal has an empty result.
        """
        call = self._asked(owner, goal_id)
        try:
            result = call.type.response.convert(values if is_ok else {})
        except ProtocolError as error:
            reason = f"result of action {call.service}: {error}"
            self.refuse(owner, goal_id, reason)
            raise ProtocolError(reason) from error
        self._forget(goal_id)
        ended = status if is_ok and status in (SUCCEEDED, CANCELED) else ABORTED
        call.reply(True, {"values": result, "status": ended, "result": True})

    def _typed(self, type_name: str) -> ServiceType:
        return self._types.action(type_name)

    def _timer(self, _call_id: str, _timeout_s: float) -> None:
        return None
