"""The services under ``/rosapi``, by which clients ask what there is.

Clients of the server are no ROS nodes: as with the genuine server, whatever they do counts as
done by the node ``/rosbridge_websocket``.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from typing import Any, TypeAlias

from mrsfi_bridge.definitions import SCALAR, TIMES, Definition, Field
from mrsfi_bridge.encodings import json_text
from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.names import absolute
from mrsfi_bridge.parameters import Parameters
from mrsfi_bridge.services import OWN
from mrsfi_bridge.session import Hub
from mrsfi_bridge.structures import Structure, now
from mrsfi_bridge.type_table import full_name

Fields: TypeAlias = dict[str, Any]

ROSOUT = "/rosout"
_BRIDGE = "/rosbridge_websocket"
_ROSAPI = "/rosapi"
_ACTION_TOPICS = ("goal", "cancel", "status", "feedback", "result")


def provide_rosapi(hub: Hub) -> None:
    """Have the server itself provide the services of rosapi, and advertise ``/rosout``."""
    hub.broker.advertise(OWN, ROSOUT, "rosgraph_msgs/Log")
    for name, type_name, handler in _services(hub):
        hub.services.advertise(OWN, f"{_ROSAPI}/{name}", f"rosapi/{type_name}", _ask(hub, handler))


def _ask(hub: Hub, handler: Callable[[Fields], Fields]) -> Callable[[str, Fields], None]:
    """Return what passes a call on to one of the functions below."""

    def ask(call_id: str, request: Fields) -> None:
        try:
            response = handler(request)
        except ProtocolError as error:
            hub.services.refuse(OWN, call_id, str(error))
        else:
            hub.services.respond(OWN, call_id, response)

    return ask


def _services(hub: Hub) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    yield "get_time", "GetTime", lambda _: {"time": now()}
    yield from _about_topics(hub)
    yield from _about_services(hub)
    yield from _about_types(hub)
    yield from _about_nodes(hub)
    yield from _about_parameters(Parameters(hub.limits.parameters, hub.limits.parameter_bytes))


def _about_topics(hub: Hub) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    topics = hub.broker.topics

    def list_topics(_: Fields) -> Fields:
        types = [topic.structure.name for topic in topics.values()]
        return {"topics": list(topics), "types": types}

    def topic_type(request: Fields) -> Fields:
        topic = topics.get(absolute(request["topic"]))
        return {"type": "" if topic is None else topic.structure.name}

    def topics_for_type(request: Fields) -> Fields:
        with suppress(ProtocolError):
            return {"topics": hub.broker.topics_of(full_name(request["type"]))}
        return {"topics": []}

    def raw_types(request: Fields) -> Fields:
        texts = [_full_text(topic.structure) for topic in topics.values()]
        return {**list_topics(request), "typedefs_full_text": texts}

    def action_servers(_: Fields) -> Fields:
        names = [topic.removesuffix("/goal") for topic in topics if topic.endswith("/goal")]
        found = [n for n in names if all(f"{n}/{part}" in topics for part in _ACTION_TOPICS)]
        return {"action_servers": found}

    yield "topics", "Topics", list_topics
    yield "topic_type", "TopicType", topic_type
    yield "topics_for_type", "TopicsForType", topics_for_type
    yield "topics_and_raw_types", "TopicsAndRawTypes", raw_types
    yield "action_servers", "GetActionServers", action_servers


def _about_services(hub: Hub) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    services = hub.services.services

    def service_type(request: Fields) -> Fields:
        service = services.get(absolute(request["service"]))
        return {"type": "" if service is None else service.type.name}

    def names_of(type_name: str) -> list[str]:
        with suppress(ProtocolError):
            wanted = full_name(type_name)
            return [name for name, service in services.items() if service.type.name == wanted]
        return []

    def node(request: Fields) -> Fields:
        service = services.get(absolute(request["service"]))
        return {"node": "" if service is None else _node(service.owner)}

    yield "services", "Services", lambda _: {"services": list(services)}
    yield "service_type", "ServiceType", service_type
    yield "services_for_type", "ServicesForType", lambda r: {"services": names_of(r["type"])}
    yield "service_providers", "ServiceProviders", lambda r: {"providers": names_of(r["service"])}
    yield "service_node", "ServiceNode", node
    yield "service_host", "ServiceHost", lambda _: {"host": "localhost"}


def _about_types(hub: Hub) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    def message(request: Fields) -> Fields:
        return {"typedefs": _type_definitions(hub.types.message(request["type"]))}

    def service_request(request: Fields) -> Fields:
        return {"typedefs": _type_definitions(hub.types.service(request["type"]).request)}

    def service_response(request: Fields) -> Fields:
        return {"typedefs": _type_definitions(hub.types.service(request["type"]).response)}

    yield "message_details", "MessageDetails", message
    yield "service_request_details", "ServiceRequestDetails", service_request
    yield "service_response_details", "ServiceResponseDetails", service_response


def _about_nodes(hub: Hub) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    topics, services = hub.broker.topics, hub.services.services

    def details(request: Fields) -> Fields:
        node = request["node"]
        return {
            "subscribing": [n for n, topic in topics.items() if node in _nodes(topic.subscribers)],
            "publishing": [n for n, topic in topics.items() if node in _nodes(topic.publishers)],
            "services": [n for n, service in services.items() if _node(service.owner) == node],
        }

    def publishers(request: Fields) -> Fields:
        topic = topics.get(absolute(request["topic"]))
        return {"publishers": [] if topic is None else _nodes(topic.publishers)}

    def subscribers(request: Fields) -> Fields:
        topic = topics.get(absolute(request["topic"]))
        return {"subscribers": [] if topic is None else _nodes(topic.subscribers)}

    yield "nodes", "Nodes", lambda _: {"nodes": [_ROSAPI, _BRIDGE]}
    yield "node_details", "NodeDetails", details
    yield "publishers", "Publishers", publishers
    yield "subscribers", "Subscribers", subscribers


def _about_parameters(
    parameters: Parameters,
) -> Iterator[tuple[str, str, Callable[[Fields], Fields]]]:
    def get(request: Fields) -> Fields:
        try:
            return {"value": json_text(parameters.get(request["name"]))}
        except KeyError:
            return {"value": json_text(_value(request["default"] or "null"))}

    def set_value(request: Fields) -> Fields:
        parameters.set(request["name"], _value(request["value"]))
        return {}

    def delete(request: Fields) -> Fields:
        parameters.delete(request["name"])
        return {}

    def search(request: Fields) -> Fields:
        name = request["name"]
        return {"global_name": absolute(name) if name in parameters else ""}

    yield "get_param", "GetParam", get
    yield "set_param", "SetParam", set_value
    yield "has_param", "HasParam", lambda r: {"exists": r["name"] in parameters}
    yield "delete_param", "DeleteParam", delete
    yield "search_param", "SearchParam", search
    yield "get_param_names", "GetParamNames", lambda _: {"names": parameters.names}


def _value(text: str) -> Any:
    """Return the value of a JSON text; what is no JSON is a text itself."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _node(client: Any) -> str:
    return _ROSAPI if client == OWN else _BRIDGE


def _nodes(clients: Iterable[Any]) -> list[str]:
    return sorted({_node(client) for client in clients})


def _type_definitions(structure: Structure) -> list[Fields]:
    """Return the definitions of a type and of all that it holds."""
    found = {part.name: _type_definition(part.definition) for part in _parts(structure)}
    types = [field.type for part in _parts(structure) for field in part.definition.fields]
    times = {name: _time_definition(name) for name in types if name in TIMES}
    return [*found.values(), *times.values()]


def _parts(structure: Structure) -> Iterator[Structure]:
    yield structure
    for nested in structure.nested.values():
        yield from _parts(nested)


def _type_definition(definition: Definition) -> Fields:
    fields, constants = definition.fields, definition.constants
    return {
        "type": definition.name,
        "fieldnames": [field.name for field in fields],
        "fieldtypes": [field.type for field in fields],
        "fieldarraylen": [field.length for field in fields],
        "examples": [_example(field) for field in fields],
        "constnames": [constant.name for constant in constants],
        "constvalues": [constant.value for constant in constants],
    }


def _time_definition(name: str) -> Fields:
    part = "uint32" if name == "time" else "int32"
    fields = (Field("secs", part), Field("nsecs", part))
    return _type_definition(Definition(name, fields))


def _example(field: Field) -> str:
    """Return the default of a field as text: lists and messages empty."""
    if field.length != SCALAR:
        return "[]"
    if "/" in field.type or field.type in TIMES:
        return "{}"
    return {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}.get(field.type, "0")


def _full_text(structure: Structure) -> str:
    """Return the definition of a type and of all that it holds, as ROS prints them."""
    parts = {part.name: part.definition for part in _parts(structure)}
    own, *others = parts.values()
    border = "=" * 80
    return "\n".join(
        (_text(own), *(f"{border}\nMSG: {part.name}\n{_text(part)}" for part in others))
    )


def _text(definition: Definition) -> str:
    lengths = {SCALAR: "", 0: "[]"}
    return "\n".join(
        f"{field.type}{lengths.get(field.length, f'[{field.length}]')} {field.name}"
        for field in definition.fields
    )
