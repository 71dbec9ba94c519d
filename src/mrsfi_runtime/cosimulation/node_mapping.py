"""How an external node names things: topics, types of messages, and their fields.

A mapping is a table, ``[node]`` of ``mrsfi.toml``, described in docs/node.md. A topic with
``{robot}``, ``{sensor}`` or ``{obstacle}`` stands for one of each. A field is a path such as
``pose.pose.position.x`` or ``data[0]``; its value is ``offset + scale × mrsfi's value``.

Invariant: a ``NodeMapping`` is checked when it is made. An invalid one is a
``UsageError`` that names the entry, what was found and what was expected.

Begin with ``QUANTITIES``, the values of a belief that a node can receive, and ``COMMANDS``.
``NodeMapping.of`` reads a table, and ``spread`` applies rules to the elements of a
mission. ``GENERATED`` is the table of nodes that use the topics of docs/bus.md.
"""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeAlias

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.settings import full_name
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.kernel.commands import feasible
from mrsfi_runtime.kernel.state import TOLERANCE, State
from mrsfi_runtime.model.fault_types import Field, plain_name
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import (
    BEST_EFFORT,
    RELIABLE,
    TRANSIENT_LOCAL,
    VOLATILE,
    Service,
    Topic,
    TopicQos,
)


class Quantity(NamedTuple):
    """A value that a node can receive; ``affected`` is the property by which faults change it.

    ``read`` takes it from a belief, for an element by its index.
    """

    read: Callable[[State, int], Any]
    affected: Field | None = None


def _heading(x: Callable[[float, float, float], Any]) -> Quantity:
    def read(ci: State, index: int) -> Any:
        command = ci.commands[index]
        return x(command.heading_x, command.heading_y, ci.robots[index].speed)

    return Quantity(read)


QUANTITIES: Mapping[str, Mapping[str, Quantity]] = {
    "robot": {
        "x": Quantity(lambda ci, index: ci.robots[index].x, Field.POSITION),
        "y": Quantity(lambda ci, index: ci.robots[index].y, Field.POSITION),
        "z": Quantity(lambda ci, index: ci.robots[index].z, Field.POSITION),
        "speed": Quantity(lambda ci, index: ci.robots[index].speed, Field.SPEED),
        "vx": _heading(lambda x, _, speed: x * speed)._replace(affected=Field.SPEED),
        "vy": _heading(lambda _, y, speed: y * speed)._replace(affected=Field.SPEED),
        "energy": Quantity(lambda ci, index: ci.robots[index].energy, Field.ENERGY),
        "heading_x": _heading(lambda x, _, __: x),
        "heading_y": _heading(lambda _, y, __: y),
        "yaw": _heading(lambda x, y, _: math.atan2(y, x)),
        "qz": _heading(lambda x, y, _: math.sin(math.atan2(y, x) / 2.0)),
        "qw": _heading(lambda x, y, _: math.cos(math.atan2(y, x) / 2.0)),
        "sent": Quantity(lambda ci, index: ci.commands[index].sent_speed),
        "radius": Quantity(lambda ci, index: ci.traits[index].radius),
    },
    "sensor": {
        "samples": Quantity(lambda ci, index: ci.sensors[index].count, Field.COUNT),
        "active": Quantity(lambda ci, index: ci.sensors[index].active == 1, Field.ACTIVATION),
        "rate": Quantity(lambda ci, index: ci.sensors[index].rate, Field.RATE),
        "cost": Quantity(lambda ci, index: ci.sensors[index].cost, Field.COST),
    },
    "obstacle": {
        "x": Quantity(lambda ci, index: ci.obstacles[index].x, Field.OBSTACLE),
        "y": Quantity(lambda ci, index: ci.obstacles[index].y, Field.OBSTACLE),
        "radius": Quantity(lambda ci, index: ci.obstacles[index].radius),
    },
}
"""By kind of element and name. The heading is the commanded one; ``yaw`` is its angle, ``qz`` and
``qw`` its quaternion. ``sent`` is the last commanded speed, also if forged."""

SPOKEN = (Field.POSITION, Field.SPEED, Field.ENERGY, Field.COUNT)
"""Properties that a world sends in every tick; a position only while the robot has one."""

Given: TypeAlias = Mapping[str, float]  # commanded values of a message, by name

COMMANDS: Mapping[str, Mapping[str, str]] = {
    "robot": {
        "heading_x": "direction of any length, first coordinate",
        "heading_y": "second coordinate",
        "yaw": "direction as an angle in radians, from x to y",
        "turn": "change of the direction in radians",
        "vx": "velocity in units per tick, first coordinate",
        "vy": "second coordinate",
        "to_x": "point to head for, first coordinate",
        "to_y": "second coordinate",
        "speed": "units per tick",
    },
    "sensor": {"active": "whether it is on"},
}
"""Commands of a node, by kind of element."""


def command_robot(ci: State, index: int, given: Given, before: tuple[float, float]) -> None:
    """Apply a message to the commands of a robot; it replaces earlier values of the tick.

    ``before`` is the heading that was commanded before the tick.
    """
    robot, command = ci.robots[index], ci.commands[index]
    if "heading_x" in given:
        _turn(ci, index, given["heading_x"], given["heading_y"])
    if "to_x" in given:
        _turn(ci, index, given["to_x"] - robot.x, given["to_y"] - robot.y)
    if "yaw" in given:
        _turn(ci, index, math.cos(given["yaw"]), math.sin(given["yaw"]))
    if "turn" in given:
        x, y = before
        cos, sin = math.cos(given["turn"]), math.sin(given["turn"])
        _turn(ci, index, x * cos - y * sin, x * sin + y * cos)
    speed = given.get("speed")
    if "vx" in given:
        speed = math.sqrt(given["vx"] ** 2 + given["vy"] ** 2)
        _turn(ci, index, given["vx"], given["vy"])
    if speed is not None:
        command.speed_claimed = 1
        command.speed = feasible(robot, speed)


def command_sensor(ci: State, index: int, given: Given) -> None:
    """Apply a message to the switch of a sensor."""
    switch = ci.switches[index]
    switch.claimed = 1
    switch.active = int(given["active"] != 0)


def _turn(ci: State, index: int, x: float, y: float) -> None:
    """Command a heading; a vector of nearly no length is ignored, a unit vector unchanged."""
    command = ci.commands[index]
    length = math.sqrt(x * x + y * y)
    if length <= TOLERANCE:
        return
    if abs(length - 1.0) > TOLERANCE:
        x, y = x / length, y / length
    command.heading_claimed = 1
    command.heading_x, command.heading_y = x, y


Path: TypeAlias = tuple[str | int, ...]
"""The place of a number in a message: names of fields, and indices of arrays."""

Table: TypeAlias = Mapping[str, Any]


def _each(topic: str, kind: str, **fields: str) -> Table:
    return {"topic": topic, "type": kind, "fields": fields}


GENERATED: Table = {
    "tells": [
        _each("/{robot}/position", "geometry_msgs/Point", x="x", y="y", z="z"),
        _each("/{robot}/speed", "std_msgs/Float64", data="speed"),
        _each("/{robot}/energy", "std_msgs/Float64", data="energy"),
        _each("/{robot}/speed/sent", "std_msgs/Float64", data="sent"),
        _each("/{robot}/{sensor}/samples", "std_msgs/Int64", data="samples"),
        _each("/{robot}/{sensor}/active", "std_msgs/Bool", data="active"),
    ],
    "obeys": [
        _each("/{robot}/command/heading", "geometry_msgs/Vector3", x="heading_x", y="heading_y"),
        _each("/{robot}/command/speed", "std_msgs/Float64", data="speed"),
        _each("/{robot}/{sensor}/command/active", "std_msgs/Bool", data="active"),
    ],
}
"""Of a node that uses the topics of docs/bus.md, as generated code does."""

_ANSWER = Topic("/mission/answer", "std_msgs/Int64MultiArray")
_RESET = Service("/mission/reset", "std_srvs/Trigger")
_NAMES = ("tells", "obeys", "answer", "reset", "names", "types", "frame_id", "clock_hz")
_OF_RULE = ("topic", "type", "fields", "world", "qos")
_KIND = re.compile(r"\{(\w*)\}")


class Entry(NamedTuple):
    """Content of a field: ``offset + scale × of``, or the constant ``value``."""

    of: str
    scale: float = 1.0
    offset: float = 0.0
    value: Any = None


class Rule(NamedTuple):
    """A topic, or one of each element that it names, and the content of its fields.

    Without fields, messages are relayed to a topic of the ``world``. ``qos`` is for native ROS 2.
    """

    topic: Topic
    fields: Mapping[Path, Entry]
    world: str = ""
    qos: TopicQos = TopicQos()

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of elements that the topic names."""
        return tuple(_KIND.findall(self.topic.name))


class Element(NamedTuple):
    """An element of the mission: its kind, its index in the model, its name on topics."""

    kind: str
    place: int
    name: str


@dataclass(frozen=True, slots=True)
class NodeMapping:
    """The topics of a node, made of ``table``.

    A message on ``answer`` ends its answer to a tick; the service ``reset`` returns it to before
    tick 0. ``types`` are folders with definitions. Headers have the time of the tick and
    ``frame_id``, and ``/clock`` is published ``clock_hz`` times a tick.
    """

    table: Table
    tells: tuple[Rule, ...]
    obeys: tuple[Rule, ...]
    answer: Topic
    reset: Service
    names: Mapping[str, str]
    types: tuple[str, ...]
    frame_id: str
    clock_hz: int

    @classmethod
    def of(cls, table: Table | None) -> "NodeMapping":
        """Return the mapping that a table describes; the default has the generated topics.

        An invalid table is a ``UsageError``.
        """
        table = GENERATED if table is None else table
        for name in table:
            if name not in _NAMES:
                raise UsageError(f"[node]: found '{name}'; {expected(name, _NAMES)}")
        return cls(
            table=table,
            tells=tuple(_rules(table, "tells", QUANTITIES)),
            obeys=tuple(_rules(table, "obeys", COMMANDS)),
            answer=_answer(table.get("answer")),
            reset=_RESET._replace(name=_text(table, "reset", "[node]", _RESET.name)),
            names=_names(table.get("names", {})),
            types=tuple(map(str, table.get("types", ()))),
            frame_id=_text(table, "frame_id", "[node]", "map"),
            clock_hz=_clock_hz(table.get("clock_hz", 1)),
        )

    def elements(self, mission: Mission) -> tuple[Element, ...]:
        """Return the robots, sensors and obstacles of a mission, with the node's names."""
        listed = {
            "robot": [each.id for each in mission.robots],
            "sensor": [each.id for each in mission.sensors],
            "obstacle": [each.id for each in mission.obstacles],
        }
        elements = [
            Element(kind, place, plain_name(name))
            for kind, names in listed.items()
            for place, name in enumerate(names)
        ]
        known = [each.name for each in elements]
        for name in self.names:
            if name not in known:
                raise UsageError(f"[node] names: found '{name}'; {expected(name, known)}")
        return tuple(each._replace(name=self.names.get(each.name, each.name)) for each in elements)


def spread(
    rules: Iterable[Rule], elements: Sequence[Element], mission: Mission
) -> Iterator[tuple[Rule, Callable[[str], str], Element | None]]:
    """Yield each rule with each of its elements, and the function that fills in a topic name."""
    robots = {each.place: each.name for each in elements if each.kind == "robot"}
    for rule in rules:
        of = rule.kinds[-1] if rule.kinds else ""
        if not of:
            yield rule, str, None
        for each in elements:
            if each.kind == of:
                named = {of: each.name}
                if of == "sensor":
                    named["robot"] = robots[mission.sensor_robot[each.place]]
                yield rule, partial(_KIND.sub, lambda match, named=named: named[match[1]]), each


def path_of(text: str) -> Path | None:
    """Return the path that ``a.b[2].c`` stands for, or ``None`` if it stands for none."""
    path: list[str | int] = []
    for step in text.split("."):
        match = re.fullmatch(r"([A-Za-z]\w*)((?:\[\d+\])*)", step, re.ASCII)
        if match is None:
            return None
        path += (match[1], *map(int, re.findall(r"\d+", match[2])))
    return tuple(path)


def path_text(path: Path) -> str:
    """Return a path as ``path_of`` takes it."""
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")


def _rules(table: Table, name: str, known: Mapping[str, Mapping[str, Any]]) -> Iterator[Rule]:
    rules = table.get(name, [])
    if not isinstance(rules, list) or not rules:
        raise UsageError(f"[node]: found no [[node.{name}]]; expected at least one topic")
    for number, rule in enumerate(rules, 1):
        place = f"[node]: [[node.{name}]] {number}"
        if not isinstance(rule, Mapping):
            raise UsageError(f"{place}: found {rule!r}; expected a table")
        for key in rule:
            if key not in _OF_RULE:
                raise UsageError(f"{place}: found '{key}'; {expected(key, _OF_RULE)}")
        topic, qos = Topic(_text(rule, "topic", place), _type(rule, place)), _qos(rule, place)
        if "world" in rule and known is COMMANDS:
            if rule.get("fields") or _KIND.findall(topic.name) != ["robot"]:
                raise UsageError(
                    f"{place}: found world = {rule['world']!r}; expected a topic with {{robot}} "
                    "and no fields: its messages are passed on unchanged"
                )
            yield Rule(topic, {}, _text(rule, "world", place), qos)
            continue
        yield _checked(Rule(topic, dict(_fields(rule, place)), qos=qos), known, place)


def _qos(rule: Table, place: str) -> TopicQos:
    given = rule.get("qos", {})
    known = {"reliability": (RELIABLE, BEST_EFFORT), "durability": (VOLATILE, TRANSIENT_LOCAL)}
    if not isinstance(given, Mapping):
        raise UsageError(f"{place}: found qos = {given!r}; expected {{ depth = 10 }}")
    for name, value in given.items():
        if name not in TopicQos._fields:
            raise UsageError(f"{place}: qos: found '{name}'; {expected(name, TopicQos._fields)}")
        if name in known and value not in known[name]:
            raise UsageError(f"{place}: {name}: found {value!r}; {expected(value, known[name])}")
        if name == "depth" and not (type(value) is int and value > 0):
            raise UsageError(f"{place}: depth: found {value!r}; expected a number of messages")
    return TopicQos(**given)


def _clock_hz(given: Any) -> int:
    if type(given) is not int or not 1 <= given <= 1000:
        raise UsageError(f"[node]: clock_hz: found {given!r}; expected an integer, 1 to 1000")
    return given


def _fields(rule: Table, place: str) -> Iterator[tuple[Path, Entry]]:
    fields = rule.get("fields")
    if not isinstance(fields, Mapping) or not fields:
        raise UsageError(f"{place}: found fields = {fields!r}; expected {{ field = 'name' }}")
    for text, given in fields.items():
        path = path_of(text)
        if path is None:
            raise UsageError(f"{place}: found field '{text}'; expected a path such as data[0].x")
        entry = {"of": given} if isinstance(given, str) else given
        if not isinstance(entry, Mapping) or not {"of", "value"} & entry.keys():
            raise UsageError(f"{place}: {text}: found {given!r}; expected a name or {{ of = … }}")
        for key, value in entry.items():
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if key not in Entry._fields or (key in {"scale", "offset"} and not is_number):
                raise UsageError(
                    f"{place}: {text}: found {key} = {value!r}; expected of, scale and offset "
                    "(numbers), or value"
                )
        if entry.get("scale") == 0:
            raise UsageError(f"{place}: {text}: found scale = 0; expected any other number")
        yield path, Entry(**{"of": "", **entry})


def _checked(rule: Rule, known: Mapping[str, Mapping[str, Any]], place: str) -> Rule:
    """Return a rule after checks that its fields exist for the elements of its topic."""
    kinds = rule.kinds
    for kind in kinds:
        if kind not in known:
            raise UsageError(f"{place}: found {{{kind}}} in its topic; {expected(kind, known)}")
    named = [entry.of for entry in rule.fields.values() if entry.value is None]
    for of in named:
        element, _, name = of.rpartition(".")
        if bool(element) == bool(kinds):
            raise UsageError(
                f"{place}: found '{of}'; expected "
                + ("a name without an element" if kinds else "ELEMENT.NAME, such as r1.x")
            )
        names = known[kinds[-1]] if kinds else {n: None for each in known.values() for n in each}
        if name not in names:
            raise UsageError(f"{place}: found '{of}'; {expected(name, names)}")
    if known is COMMANDS:
        _require_pairs(named, place)
    return rule


def _require_pairs(named: Sequence[str], place: str) -> None:
    """Refuse one coordinate without the other."""
    for of in named:
        element, _, name = of.rpartition(".")
        for pair in (("heading_x", "heading_y"), ("vx", "vy"), ("to_x", "to_y")):
            both = [f"{element}.{each}".removeprefix(".") for each in pair]
            if name in pair and not set(both) <= set(named):
                raise UsageError(f"{place}: found '{of}' alone; expected {' and '.join(both)}")


def _type(rule: Table, place: str) -> str:
    name = _text(rule, "type", place)
    try:
        return full_name(name)
    except ProtocolError as error:
        raise UsageError(f"{place}: {error}") from error


def _answer(given: Any) -> Topic:
    if given is None:
        return _ANSWER
    place = "[node]: answer"
    if not isinstance(given, Mapping) or given.keys() != {"topic", "type"}:
        raise UsageError(f"{place}: found {given!r}; expected {{ topic = …, type = … }}")
    return Topic(_text(given, "topic", place), _type(given, place))


def _names(given: Any) -> dict[str, str]:
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given.values()):
        raise UsageError(f"[node]: names: found {given!r}; expected {{ r1 = 'husky1' }}")
    return {plain_name(element): name for element, name in given.items()}


def _text(table: Table, name: str, place: str, default: str | None = None) -> str:
    text = table.get(name, default)
    if not isinstance(text, str) or not text:
        raise UsageError(f"{place}: found {name} = {text!r}; expected a text")
    return text
