"""The services under ``/rosapi``, by which clients ask what there is.

Clients of the server are no ROS nodes: as with the genuine server, whatever they do counts as
done by the node ``/rosbridge_websocket``.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
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
Handler: TypeAlias = Callable[[Fields], Fields]

ROSOUT = "/rosout"
_BRIDGE = "/rosbridge_websocket"
_ROSAPI = "/rosapi"
_ACTION_TOPICS = ("goal", "cancel", "status", "feedback", "result")


def provide_rosapi(hub: Hub) -> None:
    """Have the server itself provide the services of rosapi, and advertise ``/rosout``."""
    hub.broker.advertise(OWN, ROSOUT, "rosgraph_msgs/Log")
    handlers = {
        "get_time": lambda _: {"time": now()},
        **_about_topics(hub),
        **_about_services(hub),
        **_about_types(hub),
        **_about_nodes(hub),
        **_about_parameters(Parameters(hub.limits.parameters, hub.limits.parameter_bytes)),
    }
    for name, handler in handlers.items():
        hub.services.advertise(OWN, f"{_ROSAPI}/{name}", _type_name(name), _ask(hub, handler))


def _type_name(service: str) -> str:
    """Return the type of a service, which is named after it, but for one."""
    name = "get_action_servers" if service == "action_servers" else service
    return "rosapi/" + "".join(word.capitalize() for word in name.split("_"))


def _ask(hub: Hub, handler: Handler) -> Callable[[str, Fields], None]:
    """Return what passes a call on to one of the functions below."""

    def ask(call_id: str, request: Fields) -> None:
        try:
            response = handler(request)
        except ProtocolError as error:
            hub.services.refuse(OWN, call_id, str(error))
        else:
            hub.services.respond(OWN, call_id, response)

    return ask


def _about_topics(hub: Hub) -> dict[str, Handler]:
    topics = hub.broker.topics

    def list_topics(_: Fields) -> Fields:
        types = [topic.structure.name for topic in topics.values()]
        return {"topics": list(topics), "types": types}

    def topic_type(request: Fields) -> Fields:
        topic = topics.get(absolute(request["topic"]))
        return {"type": "" if topic is None else topic.structure.name}

    def topics_for_type(request: Fields) -> Fields:
        types = {name: topic.structure.name for name, topic in topics.items()}
        return {"topics": _of_type(request["type"], types)}

    def raw_types(request: Fields) -> Fields:
        texts = [_full_text(topic.structure) for topic in topics.values()]
        return {**list_topics(request), "typedefs_full_text": texts}

    def action_servers(_: Fields) -> Fields:
        names = [topic.removesuffix("/goal") for topic in topics if topic.endswith("/goal")]
        found = [n for n in names if all(f"{n}/{part}" in topics for part in _ACTION_TOPICS)]
        return {"action_servers": found}

    return {
        "topics": list_topics,
        "topic_type": topic_type,
        "topics_for_type": topics_for_type,
        "topics_and_raw_types": raw_types,
        "action_servers": action_servers,
    }


def _of_type(type_name: str, types: Mapping[str, str]) -> list[str]:
    """Return the names of what has a type; none for what is no type."""
    with suppress(ProtocolError):
        wanted = full_name(type_name)
        return [name for name, found in types.items() if found == wanted]
    return []


def _about_services(hub: Hub) -> dict[str, Handler]:
    services = hub.services.services

    def service_type(request: Fields) -> Fields:
        service = services.get(absolute(request["service"]))
        return {"type": "" if service is None else service.type.name}

    def names_of(type_name: str) -> list[str]:
        return _of_type(type_name, {name: each.type.name for name, each in services.items()})

    def node(request: Fields) -> Fields:
        service = services.get(absolute(request["service"]))
        return {"node": "" if service is None else _node(service.owner)}

    return {
        "services": lambda _: {"services": list(services)},
        "service_type": service_type,
        "services_for_type": lambda request: {"services": names_of(request["type"])},
        "service_providers": lambda request: {"providers": names_of(request["service"])},
        "service_node": node,
        "service_host": lambda _: {"host": "localhost"},
    }


def _about_types(hub: Hub) -> dict[str, Handler]:
    def defined(structure: Structure) -> Fields:
        return {"typedefs": _type_definitions(structure)}

    types = hub.types
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

    def nodes_of(part: str) -> Handler:
        def nodes(request: Fields) -> Fields:
            topic = topics.get(absolute(request["topic"]))
            return {part: [] if topic is None else _nodes(getattr(topic, part))}

        return nodes

    return {
        "nodes": lambda _: {"nodes": [_ROSAPI, _BRIDGE]},
        "node_details": details,
        "publishers": nodes_of("publishers"),
        "subscribers": nodes_of("subscribers"),
    }


def _about_parameters(parameters: Parameters) -> dict[str, Handler]:
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

    return {
        "get_param": get,
        "set_param": set_value,
        "has_param": lambda request: {"exists": request["name"] in parameters},
        "delete_param": delete,
        "search_param": search,
        "get_param_names": lambda _: {"names": parameters.names},
    }


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
