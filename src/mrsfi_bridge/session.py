"""One client of the server, the hub of all clients, and the services of rosapi.

A ``Session`` is one client: ``receive`` takes a text, and the method named after an operation
carries it out, ``_publish`` for ``publish``. Invalid operations are dropped, counted, logged,
and reported in a ``status`` to a client that set a level. All sessions share a ``Hub`` of
types, topics, services and actions. A session has no socket, only a function that sends.

``provide_rosapi`` makes the server itself provide the services under ``/rosapi``, by which
clients query topics, types and nodes and keep parameters. Clients of the server are not ROS nodes:
as on the genuine server, the node ``/rosbridge_websocket`` stands for all of them.

Begin with ``Session.receive``.
"""

import json
import logging
from asyncio import AbstractEventLoop
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

from mrsfi_bridge.broker import OWN, SUCCEEDED, Actions, Broker, BrokerOfRos2, Services
from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.frames import text_frames, to_json
from mrsfi_bridge.protocol import (
    Budget,
    Fragments,
    Operation,
    Subscription,
    Uses,
    Wish,
    absolute,
    check_name,
    check_operation,
    operations,
    settled,
    wanted_encoding,
    wish,
)
from mrsfi_bridge.settings import Limits, TypeTable, full_name
from mrsfi_bridge.structures import SCALAR, TIMES, Definition, Field, Structure, now

LOGGER = logging.getLogger("mrsfi.bridge")

LEVELS = ("info", "warning", "error", "none")

_CANCEL, _CANCEL_GOAL = "/_action/cancel_goal", "action_msgs/CancelGoal"
"""Service of an action that cancels all its goals, by the end of its name; and its type."""


@dataclass(slots=True)
class Counts:
    """Counts since the server started."""

    clients: int = 0
    received: int = 0
    sent: int = 0
    dropped: int = 0


class Hub:
    """Topics, services and actions of all clients; ``scheduler`` is the clock.

    ``waiting`` counts the bytes of throttled messages. ``refused`` is called
    with each dropped operation, or ``None`` if it was not JSON, and the reason.
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

    ``send`` takes frames for the client; ``fragments`` are its incomplete messages.
    """

    def __init__(self, hub: Hub, name: str, send: Callable[[bytes], None]) -> None:
        self.name = name
        self._hub = hub
        self._send = send
        self._level = "none"
        self._adverts: Uses[None] = Uses()
        self._wishes: Uses[Wish] = Uses()
        self._subscriptions: dict[str, Subscription] = {}
        self._goals: dict[str | int, str] = {}
        self.fragments = Fragments(2 * hub.limits.frame_bytes)
        self._n_dropped = 0

    def receive(self, text: str) -> None:
        """Carry out the operations of a text; drop, count and log invalid ones."""
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
        for shared in (self._hub.broker, self._hub.services, self._hub.actions):
            shared.leave(self)
        for topic in tuple(self._subscriptions):
            self._end(topic)
        if self._n_dropped:
            LOGGER.info("%s: %d operations dropped in total", self.name, self._n_dropped)

    def status(self, level: str, text: str, operation_id: Any = None) -> None:
        """Send the client a message, if it set this level or a lower one."""
        if LEVELS.index(level) < LEVELS.index(self._level):
            return
        operation = {"op": "status", "level": level, "msg": text}
        if operation_id is not None:
            operation["id"] = operation_id
        self._send(text_frames(operation))

    def _drop(self, reason: str, value: Any = None) -> None:
        reason = reason[:500]
        self._hub.counts.dropped += 1
        self._n_dropped += 1
        if self._n_dropped <= 10 or self._n_dropped % 1000 == 0:  # enough to know what it is
            LOGGER.warning("%s: dropped operation %d: %s", self.name, self._n_dropped, reason)
        self.status("error", reason, value.get("id") if isinstance(value, dict) else None)
        self._hub.refused(value, reason)

    def _advertise(self, operation: Operation) -> None:
        topic, use_id = absolute(operation["topic"]), operation.get("id")
        is_latched = operation.get("latch", False)
        self._hub.broker.advertise(self, topic, operation["type"], is_latched=is_latched)
        self._adverts.setdefault(topic, {})[use_id] = None

    def _unadvertise(self, operation: Operation) -> None:
        topic = absolute(operation["topic"])
        if topic not in self._adverts:
            raise ProtocolError(f"you do not advertise topic '{topic}'")
        if self._adverts.remove(topic, operation.get("id")):
            self._hub.broker.unadvertise(self, topic)

    def _publish(self, operation: Operation) -> None:
        name = absolute(operation["topic"])
        topic = self._hub.broker.topics.get(name)
        if name not in self._adverts and topic is not None:  # in use: advertise it
            type_name, is_latched = topic.structure.name, operation.get("latch", False)
            self._advertise({"topic": name, "type": type_name, "latch": is_latched})
        self._hub.broker.publish(self, name, operation.get("msg", {}))

    def _subscribe(self, operation: Operation) -> None:
        topic, use_id = operation["topic"], operation.get("id")
        wanted = wish(operation)
        subscription = self._subscriptions.get(topic)
        if subscription is None:
            hub = self._hub
            subscription = Subscription(hub.scheduler, hub.waiting, self._deliver, topic)
        wishes = {**self._wishes.get(topic, {}), use_id: wanted}
        subscription.wish = settled(wishes.values())
        self._hub.broker.subscribe(
            (self, topic), absolute(topic), operation.get("type"), subscription.receive
        )
        self._subscriptions[topic] = subscription
        self._wishes[topic] = wishes

    def _unsubscribe(self, operation: Operation) -> None:
        topic = operation["topic"]
        if topic not in self._wishes:
            raise ProtocolError(f"you do not subscribe to topic '{topic}'")
        if self._wishes.remove(topic, operation.get("id")):
            self._end(topic)
        else:
            self._subscriptions[topic].wish = settled(self._wishes[topic].values())

    def _end(self, topic: str) -> None:
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
            answered = {**answer, "values": values, "result": is_ok}
            self._send(text_frames(answered, encoding))

        given, timeout = operation.get("args"), operation.get("timeout") or 0
        arguments = {} if given is None else given
        self._hub.services.call(self, absolute(name), arguments, reply, timeout)

    def _service_response(self, operation: Operation) -> None:
        """Pass an answer on; as on the genuine server, ``values`` override ``result``."""
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
            self.status("warning", f"you replace another provider of service '{name}'")

    def _unadvertise_service(self, operation: Operation) -> None:
        self._hub.services.unadvertise(self, absolute(operation["service"]))

    def _advertise_action(self, operation: Operation) -> None:
        name, type_name = operation["action"], operation["type"]

        def ask(goal_id: str, goal: dict[str, Any] | None) -> None:
            request = {"op": "cancel_action_goal", "id": goal_id, "action": name}
            if goal is not None:
                request |= {"op": "send_action_goal", "action_type": type_name, "feedback": True}
                request["args"] = goal
            self._send(text_frames(request))

        def cancel(call_id: str, request: dict[str, Any]) -> None:
            is_all = request == self._hub.types.service(_CANCEL_GOAL).request.default()
            n_goals = self._hub.actions.cancel_all(absolute(name)) if is_all else 0
            goals: list[Operation] = [{}] * n_goals
            response = {"return_code": 0 if is_all else 1, "goals_canceling": goals}
            self._hub.services.respond(self, call_id, response)

        if self._hub.actions.advertise(self, absolute(name), type_name, ask):
            self.status("warning", f"you replace another provider of action '{name}'")
        self._hub.services.advertise(self, absolute(name) + _CANCEL, _CANCEL_GOAL, cancel)

    def _unadvertise_action(self, operation: Operation) -> None:
        name = absolute(operation["action"])
        self._hub.actions.unadvertise(self, name)
        self._hub.services.unadvertise(self, name + _CANCEL)

    def _send_action_goal(self, operation: Operation) -> None:
        encoding = wanted_encoding(operation)
        name, own_id = operation["action"], operation.get("id")
        named = {"action": name} if own_id is None else {"id": own_id, "action": name}

        def answer(result: Operation) -> None:
            if result["op"] == "action_result":
                self._goals.pop(own_id or "", None)
            elif not operation.get("feedback", False):
                return
            reported = {"op": result["op"], **named, **result}
            self._send(text_frames(reported, encoding))

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


Fields: TypeAlias = dict[str, Any]
Handler: TypeAlias = Callable[[Fields], Fields | None]  # None is a response without fields

ROSOUT = "/rosout"
_BRIDGE = "/rosbridge_websocket"
_ROSAPI = "/rosapi"
_CLIENT_COUNT, _CLIENTS = "/client_count", "/connected_clients"
_DEEPEST = 32


class _Parameters:
    """Values under names like ``/robot/speed``; a name with others below it has all their values.

    More leaves than ``max_parameters``, or a value longer than ``max_bytes`` as JSON text, are a
    ``ProtocolError``.
    """

    def __init__(self, max_parameters: int, max_bytes: int) -> None:
        self._max_parameters = max_parameters
        self._max_bytes = max_bytes
        self._leaves: dict[str, str] = {}

    @property
    def names(self) -> list[str]:
        """Names of all leaves, in the order in which they were set."""
        return list(self._leaves)

    def __contains__(self, name: str) -> bool:
        path = absolute(name)
        return path in self._leaves or any(self._below(path))

    def get(self, name: str) -> Any:
        """Return the value of a leaf, or a dictionary of those below it; ``KeyError`` if none."""
        path = absolute(name)
        if path in self._leaves:
            return json.loads(self._leaves[path])
        tree: dict[str, Any] = {}
        for below in self._below(path):
            *branches, leaf = below[len(path) :].strip("/").split("/")
            node = tree
            for branch in branches:
                node = node.setdefault(branch, {})
            node[leaf] = json.loads(self._leaves[below])
        if not tree:
            raise KeyError(path)
        return tree

    def set(self, name: str, value: Any) -> None:
        """Give a name a value; a dictionary becomes names below it."""
        path = absolute(name)
        check_name(path, "parameter")
        leaves = dict(_leaves(path, value, _DEEPEST))
        n_bytes = sum(map(len, leaves.values()))
        if n_bytes > self._max_bytes:
            raise ProtocolError(f"{path}: {n_bytes} bytes, the limit is {self._max_bytes}")
        if len(self._leaves) + len(leaves) > self._max_parameters:
            raise ProtocolError(
                f"{path}: the limit of {self._max_parameters} parameters is reached"
            )
        self.delete(path)
        above = path
        while above := above.rpartition("/")[0]:  # a name with others below it is not a leaf
            self._leaves.pop(above, None)
        self._leaves.update(leaves)

    def delete(self, name: str) -> None:
        """Delete a name and all below it, if it has a value."""
        path = absolute(name)
        for gone in [path, *self._below(path)]:
            self._leaves.pop(gone, None)

    def _below(self, path: str) -> Iterator[str]:
        prefix = path if path.endswith("/") else f"{path}/"
        return (leaf for leaf in self._leaves if leaf.startswith(prefix))


def _leaves(path: str, value: Any, n_levels: int) -> Iterator[tuple[str, str]]:
    """Yield name and JSON text of every value that is not a dictionary, or an empty one."""
    if not isinstance(value, dict) or not value:
        yield path, json.dumps(value)
        return
    if not n_levels:
        raise ProtocolError(f"{path[:60]}…: more than {_DEEPEST} levels")
    for name, part in value.items():
        if not name or "/" in name:
            raise ProtocolError(f"{path}: '{name:.40}' is not a parameter name")
        yield from _leaves(f"{path.rstrip('/')}/{name}", part, n_levels - 1)


def provide_rosapi(hub: Hub) -> None:
    """Have the server itself provide the services of rosapi, and advertise its own topics."""
    is_ros_1 = hub.types.ros == 1
    for name in (ROSOUT, f"{ROSOUT}_agg") if is_ros_1 else (ROSOUT,):
        hub.broker.advertise(OWN, name, f"{'rosgraph_msgs' if is_ros_1 else 'rcl_interfaces'}/Log")
    hub.broker.advertise(OWN, _CLIENT_COUNT, "std_msgs/Int32", is_latched=True)
    hub.broker.advertise(OWN, _CLIENTS, "rosbridge_msgs/ConnectedClients", is_latched=True)
    tell_clients(hub, [])
    handlers = {
        "get_time": lambda _: {"time": now()},
        **_about_topics(hub),
        **_about_services(hub),
        **_about_types(hub.types),
        **_about_nodes(hub),
    }
    about_parameters = _about_parameters(
        _Parameters(hub.limits.parameters, hub.limits.parameter_bytes), hub.types.ros
    )
    for name, handler in about_parameters.items():
        handlers[name] = handler if is_ros_1 else _of_node(handler)
    if not is_ros_1:
        handlers["get_ros_version"] = lambda _: {"version": hub.types.ros, "distro": "jazzy"}
    types = {"action_servers": "GetActionServers", "get_ros_version": "GetROSVersion"}
    for name, handler in handlers.items():  # whose types are named after them, but for two
        kind = types.get(name, "".join(word.capitalize() for word in name.split("_")))
        type_name = f"{'rosapi' if is_ros_1 else 'rosapi_msgs'}/{kind}"
        hub.services.advertise(OWN, f"{_ROSAPI}/{name}", type_name, _ask(hub, handler))


def tell_clients(hub: Hub, clients: Sequence[Fields]) -> None:
    """Publish address and connection time of each client."""
    hub.broker.publish(OWN, _CLIENT_COUNT, {"data": len(clients)})
    hub.broker.publish(OWN, _CLIENTS, {"clients": list(clients)})


def _ask(hub: Hub, handler: Handler) -> Callable[[str, Fields], None]:
    def ask(call_id: str, request: Fields) -> None:
        try:
            response = handler(request) or {}
        except ProtocolError as error:
            hub.services.refuse(OWN, call_id, str(error))
        else:
            hub.services.respond(OWN, call_id, response)

    return ask


def _about_topics(hub: Hub) -> dict[str, Handler]:
    topics = hub.broker.topics

    def types() -> dict[str, str]:
        return {name: hub.types.spelled(topic.structure.name) for name, topic in topics.items()}

    def all_topics() -> Fields:
        return {"topics": list(topics), "types": list(types().values())}

    def of_type(type_name: str) -> list[str]:
        if hub.types.ros == 1:
            return _of_type(type_name, types())
        return [name for name, found in types().items() if found == type_name]  # in three parts

    def action_servers(_: Fields) -> Fields:
        names = [topic.removesuffix("/goal") for topic in topics if topic.endswith("/goal")]
        parts = ("cancel", "status", "feedback", "result")
        found = [n for n in names if all(f"{n}/{part}" in topics for part in parts)]
        return {"action_servers": [*found, *hub.actions.services]}

    def nodes(part: str, request: Fields) -> Fields:
        topic = topics.get(absolute(request["topic"]))
        return {part: [] if topic is None else _nodes(getattr(topic, part))}

    def raw_types() -> list[str]:
        return [_full_text(topic.structure, hub.types) for topic in topics.values()]

    return {
        "topics": lambda _: all_topics(),
        "topic_type": lambda request: {"type": types().get(absolute(request["topic"]), "")},
        "topics_for_type": lambda request: {"topics": of_type(request["type"])},
        "topics_and_raw_types": lambda _: all_topics() | {"typedefs_full_text": raw_types()},
        "action_servers": action_servers,
        "publishers": partial(nodes, "publishers"),
        "subscribers": partial(nodes, "subscribers"),
    }


def _of_type(type_name: str, types: Mapping[str, str]) -> list[str]:
    """Return the names with a type; none if it is not a type name."""
    with suppress(ProtocolError):
        wanted = full_name(type_name)
        return [name for name, found in types.items() if full_name(found) == wanted]
    return []


def _about_services(hub: Hub) -> dict[str, Handler]:
    services = hub.services.services

    def types() -> dict[str, str]:
        spelled = hub.types.spelled
        return {name: spelled(service.type.name, "srv") for name, service in services.items()}

    return {
        "services": lambda _: {"services": [name for name in services if _CANCEL not in name]},
        "service_type": lambda request: {"type": types().get(absolute(request["service"]), "")},
        "services_for_type": lambda request: {"services": _of_type(request["type"], types())},
    }


def _about_types(types: TypeTable) -> dict[str, Handler]:
    def defined(structure: Structure) -> Fields:
        return {"typedefs": _type_definitions(structure, types)}

    return {
        "message_details": lambda r: defined(types.message(r["type"])),
        "service_request_details": lambda r: defined(types.service(r["type"]).request),
        "service_response_details": lambda r: defined(types.service(r["type"]).response),
    }


def _about_nodes(hub: Hub) -> dict[str, Handler]:
    topics, services = hub.broker.topics, hub.services.services

    def details(request: Fields) -> Fields:
        node = request["node"]
        return {
            "subscribing": [n for n, topic in topics.items() if node in _nodes(topic.subscribers)],
            "publishing": [n for n, topic in topics.items() if node in _nodes(topic.publishers)],
            "services": [n for n, service in services.items() if _node(service.owner) == node],
        }

    return {"nodes": lambda _: {"nodes": [_ROSAPI, _BRIDGE]}, "node_details": details}


def _about_parameters(parameters: _Parameters, ros: int) -> dict[str, Handler]:
    def get(request: Fields) -> Fields:
        try:
            value = parameters.get(request["name"])
        except KeyError:
            default, missing = ("default", "null") if ros == 1 else ("default_value", '""')
            value = _value(request[default] or missing)
        return {"value": to_json(value).decode()}

    def put(request: Fields) -> None:
        value = _value(request["value"])
        is_text = ros != 1 and isinstance(value, dict)  # parameters of ROS 2 are no trees
        parameters.set(request["name"], request["value"] if is_text else value)

    return {
        "get_param": get,
        "set_param": put,
        "has_param": lambda request: {"exists": request["name"] in parameters},
        "delete_param": lambda request: parameters.delete(request["name"]),
        "get_param_names": lambda _: {"names": parameters.names},
    }


def _of_node(handler: Handler) -> Handler:
    """Answer a name that is not NODE:NAME, as parameters of ROS 2 have, with an empty response."""
    return lambda request: handler(request) if request.get("name", ":").count(":") == 1 else None


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _node(client: Any) -> str:
    return _ROSAPI if client == OWN else _BRIDGE


def _nodes(clients: Iterable[Any]) -> list[str]:
    return sorted({_node(client) for client in clients})


def _type_definitions(structure: Structure, types: TypeTable) -> list[Fields]:
    """Return the definitions of a type and of all its parts."""
    definitions = {part.name: part.definition for part in _parts(structure)}
    for field in [field for part in _parts(structure) for field in part.definition.fields]:
        if field.type in TIMES:
            part = "uint32" if field.type == "time" else "int32"
            parts = (Field("secs", part), Field("nsecs", part))
            definitions[field.type] = Definition(field.type, parts)
    return [_type_definition(each, types) for each in definitions.values()]


def _parts(structure: Structure) -> Iterator[Structure]:
    yield structure
    for nested in structure.nested.values():
        yield from _parts(nested)


def _type_definition(definition: Definition, types: TypeTable) -> Fields:
    fields, constants = definition.fields, definition.constants
    return {
        "type": types.spelled(definition.name),
        "fieldnames": [field.name for field in fields],
        "fieldtypes": [types.spelled(field.type) for field in fields],
        "fieldarraylen": [field.length for field in fields],
        "examples": [_example(field) for field in fields],
        "constnames": [constant.name for constant in constants],
        "constvalues": [constant.value for constant in constants],
    }


def _example(field: Field) -> str:
    """Return the default of a field as text: lists and messages empty."""
    if field.length != SCALAR:
        return "[]"
    if "/" in field.type or field.type in TIMES:
        return "{}"
    return {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}.get(field.type, "0")


def _full_text(structure: Structure, types: TypeTable) -> str:
    """Return the definition of a type and of all its parts, as ROS prints them."""
    parts = {part.name: part.definition for part in _parts(structure)}
    own, *others = parts.values()
    border = "=" * 80
    texts = (f"{border}\nMSG: {part.name}\n{_text(part, types)}" for part in others)
    return "\n".join((_text(own, types), *texts))


def _text(definition: Definition, types: TypeTable) -> str:
    lengths = {SCALAR: "", 0: "[]"}
    return "\n".join(
        f"{types.spelled(field.type)}{lengths.get(field.length, f'[{field.length}]')} {field.name}"
        for field in definition.fields
    )
