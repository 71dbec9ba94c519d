"""The messages of an external node in one mission, and the faults that reach it.

From the rules of a mapping, ``Speech`` makes a ``Saying`` of each topic that the node receives, and
a ``Hearing`` of each on which it commands. An impossible mapping is a ``UsageError``, a
message that does not fit is a ``ProtocolError``.

A ``Relay`` passes commands other than heading and speed unchanged to an external world.
Faults that delay or block a message of a server to a robot hold them back (``Held``). Other
commands are forged after the node has sent them. ``out_of_reach`` lists the faults of a
pool that affect neither received values nor commands.

Begin with ``Speech``.
"""

import json
import math
import pathlib
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, Self, cast

from mrsfi_bridge.errors import BridgeError
from mrsfi_bridge.settings import TypeTable
from mrsfi_bridge.structures import FLOATS, INTEGERS, SCALAR, TEXTS
from mrsfi_runtime.cosimulation.node_mapping import (
    COMMANDS,
    QUANTITIES,
    SPOKEN,
    Element,
    Entry,
    NodeMapping,
    Path,
    Rule,
    command_robot,
    command_sensor,
    path_text,
    spread,
)
from mrsfi_runtime.errors import ProtocolError, UsageError, expected
from mrsfi_runtime.kernel.effects import note
from mrsfi_runtime.kernel.injections import Plan, longest
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field, Mode
from mrsfi_runtime.model.faults import LAST, FaultPool, Specification, Target, describe, touched
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Payload, Publisher, Topic, TopicQos

if TYPE_CHECKING:
    from mrsfi_bridge.structures import Structure
    from mrsfi_runtime.kernel.injections import InjectionState


_STAMP, _FRAME = ("header", "stamp"), ("header", "frame_id")


class Saying(NamedTuple):
    """A topic that a node receives, and its content.

    ``targets`` are the properties that it carries; ``spoken`` those that a world sends
    in every tick. ``values`` are read from a belief, ``payload`` makes a message of them, whose
    header gets the time if it ``is_stamped``.
    """

    topic: Topic
    targets: frozenset[Target]
    spoken: frozenset[Target]
    values: Callable[[State], tuple[Any, ...]]
    payload: Callable[[tuple[Any, ...]], Payload]
    is_stamped: bool = False


class Hearing(NamedTuple):
    """A topic on which a node commands, and the function that applies a message."""

    topic: Topic
    obey: Callable[[State, Payload], None]


class Relayed(NamedTuple):
    """A topic whose messages are relayed to one of the world, for a robot."""

    topic: Topic
    world: Topic
    robot: int


class Speech:
    """All topics of a node; an impossible mapping is a ``UsageError``."""

    def __init__(self, mapping: NodeMapping, mission: Mission, types: TypeTable) -> None:
        self.types = types
        self.mapping = mapping
        self.mission = mission
        self._elements = mapping.elements(mission)
        self._headings: dict[int, tuple[State, int, tuple[float, float]]] = {}
        self._patterns = [(_pattern(rule), rule.kinds[-1]) for rule in mapping.obeys if rule.kinds]
        self.sayings = tuple(
            self._saying(rule, filled(rule.topic.name), element)
            for rule, filled, element in spread(mapping.tells, self._elements, mission)
        )
        obeyed = [*spread(mapping.obeys, self._elements, mission)]
        self.hearings = tuple(
            self._hearing(rule, filled(rule.topic.name), element)
            for rule, filled, element in obeyed
            if rule.fields
        )
        self.relayed = tuple(
            Relayed(
                Topic(filled(rule.topic.name), rule.topic.type),
                Topic(filled(rule.world), rule.topic.type),
                element.place,
            )
            for rule, filled, element in obeyed
            if rule.world and element is not None
        )
        names = {each.topic.name for each in self.hearings}  # on which the node commands
        self.obeyed = frozenset(names | {each.topic.name for each in self.relayed})

    @classmethod
    def of(cls, mapping: str, mission: Mission, ros: int = 1) -> Self:
        """Return the topics of a node from a table as JSON, empty for generated topics."""
        table = NodeMapping.of(json.loads(mapping) if mapping else None)
        types = TypeTable([pathlib.Path(folder) for folder in table.types], ros)
        return cls(table, mission, types)

    def qos(self, prefix: str) -> dict[str, TopicQos]:
        """Return the quality of service of all topics in the mapping, by their names."""
        rules = (*self.mapping.tells, *self.mapping.obeys)
        return {
            f"{prefix}{filled(rule.topic.name)}": rule.qos
            for rule, filled, _ in spread(rules, self._elements, self.mission)
        }

    @property
    def received(self) -> frozenset[Target]:
        """Properties that the node receives."""
        return frozenset(target for each in self.sayings for target in each.targets)

    def _saying(self, rule: Rule, name: str, element: Element | None) -> Saying:
        reads: list[Callable[[State], Any]] = []
        places: list[tuple[Path, int | None, Any]] = []
        targets = []
        for path, entry in rule.fields.items():
            kind = self._kind(rule, path)
            if entry.value is not None:
                places.append((path, None, entry.value))
                continue
            of, quantity = self._resolved(rule, entry, element, QUANTITIES)
            read, affected = QUANTITIES[of.kind][quantity]
            if affected is not None:
                targets.append((affected, of.place))
            places.append((path, len(reads), None))
            reads.append(_scaled(read, of.place, entry, kind))
        mapped = {path[:2] for path in rule.fields}
        has_header = self.types.message(rule.topic.type).has_header
        is_stamped = has_header and _STAMP not in mapped
        if is_stamped and _FRAME not in mapped:
            places.append((_FRAME, None, self.mapping.frame_id))
        carried = frozenset(targets)
        spoken = frozenset(target for target in carried if target[0] in SPOKEN)

        def values(ci: State) -> tuple[Any, ...]:
            return tuple([read(ci) for read in reads])

        topic, payload = Topic(name, rule.topic.type), partial(_message, places)
        return Saying(topic, carried, spoken, values, payload, is_stamped)

    def _hearing(self, rule: Rule, name: str, element: Element | None) -> Hearing:
        kinds = {path: self._kind(rule, path) for path in rule.fields}
        by_element: dict[Element, list[tuple[str, Path, Entry]]] = {}
        for path, entry in rule.fields.items():
            of, command = self._resolved(rule, entry, element, COMMANDS)
            by_element.setdefault(of, []).append((command, path, entry))

        def obey(ci: State, message: Payload) -> None:
            for of, commands in by_element.items():
                given = {
                    command: (_number(name, message, path, kinds[path]) - entry.offset)
                    / entry.scale
                    for command, path, entry in commands
                }
                if of.kind == "robot":
                    command_robot(ci, of.place, given, self._heading_before(ci, of.place))
                else:
                    command_sensor(ci, of.place, given)

        return Hearing(Topic(name, rule.topic.type), obey)

    def _heading_before(self, ci: State, robot: int) -> tuple[float, float]:
        """Return the heading that was commanded before the tick."""
        command, noted = ci.commands[robot], self._headings.get(robot)
        if noted is None or noted[0] is not ci or noted[1] != ci.mission.tick:
            noted = ci, ci.mission.tick, (command.heading_x, command.heading_y)
            self._headings[robot] = noted
        return noted[2]

    def _resolved(
        self,
        rule: Rule,
        entry: Entry,
        element: Element | None,
        known: Mapping[str, Mapping[str, Any]],
    ) -> tuple[Element, str]:
        owner, _, name = entry.of.rpartition(".")
        named = {each.name: each for each in self._elements}
        of = element or named.get(owner)
        place = f"[node] {rule.topic.name}: found '{entry.of}'"
        if of is None:
            raise UsageError(f"{place}; {expected(owner, named)}")
        if name not in known.get(of.kind, {}):
            raise UsageError(f"{place}; {expected(name, known.get(of.kind, {}))}")
        return of, name

    def strangers(self, topics: Sequence[str]) -> Iterator[tuple[str, str, str]]:
        """Yield topics, kinds and names of commanded elements that the mission does not have."""
        for pattern, kind in self._patterns:
            for topic in topics:
                match = pattern.fullmatch(topic)
                if match is not None and topic not in self.obeyed:
                    yield topic, kind, match[kind]

    def _kind(self, rule: Rule, path: Path) -> str:
        """Return the type of a field, which must be one number or text of its message."""
        place, walked = f"[node] {rule.topic.name}: {rule.topic.type}", path
        try:
            structure: Structure | None = self.types.message(rule.topic.type)
        except BridgeError as error:
            raise UsageError(f"[node] {rule.topic.name}: {error}") from error
        kind = ""
        while walked:
            step, *rest = walked
            fields = () if structure is None else structure.definition.fields
            known = {field.name: field for field in fields}
            if step not in known:
                raise UsageError(
                    f"{place}: found field '{path_text(path)}'; {expected(step, known)}"
                )
            field = known[str(step)]
            is_array = field.length != SCALAR
            if is_array != (bool(rest) and isinstance(rest[0], int)):
                wanted = f"{step}[0]" if is_array else str(step)
                raise UsageError(f"{place}: found '{path_text(path)}'; expected {wanted}")
            walked = tuple(rest[1:] if is_array else rest)
            kind = field.type
            structure = structure.nested.get(kind) if structure is not None else None
        if structure is not None:
            inner = ", ".join(field.name for field in structure.definition.fields)
            raise UsageError(
                f"{place}: found '{path_text(path)}', a {kind}; expected one of its fields: {inner}"
            )
        return kind


def _scaled(
    read: Callable[[State, int], Any], index: int, entry: Entry, kind: str
) -> Callable[[State], Any]:
    """Return a function that reads a field's value from a belief, in the type of the field."""
    scale, offset = entry.scale, entry.offset
    if kind in FLOATS:
        if (scale, offset) == (1.0, 0.0):
            return lambda ci: float(read(ci, index))
        return lambda ci: offset + scale * read(ci, index)
    if kind in INTEGERS:
        return lambda ci: round(offset + scale * read(ci, index))
    if kind == "bool":
        return lambda ci: bool(read(ci, index))
    return lambda ci: str(read(ci, index)) if kind in TEXTS else read(ci, index)


def _message(places: list[tuple[Path, int | None, Any]], values: tuple[Any, ...]) -> Payload:
    message: dict[str, Any] = {}
    for path, number, value in places:
        at: Any = message
        for step, after in zip(path, (*path[1:], None), strict=True):
            inner: Any = [] if isinstance(after, int) else {}
            if after is None:
                inner = value if number is None else values[number]
            if isinstance(step, int):
                at.extend(type(inner)() for _ in range(step + 1 - len(at)))
                if after is None or not at[step]:
                    at[step] = inner
                at = at[step]
            elif after is None:
                at[step] = inner
            else:
                at = at.setdefault(step, inner)
    return message


def _number(topic: str, message: Mapping[str, Any], path: Path, kind: str) -> float:
    """Return the number at a path of a received message."""
    value: Any = message
    try:
        for step in path:
            value = value[step]
    except (KeyError, IndexError, TypeError):
        raise ProtocolError(
            f"{topic} carried {_shown(message)}; expected a field {path_text(path)}"
        ) from None
    is_number = isinstance(value, int | float) and math.isfinite(value)
    if not is_number or isinstance(value, bool) != (kind == "bool"):
        raise ProtocolError(
            f"{topic} carried {_shown(value)} in {path_text(path)}; expected "
            + ("true or false" if kind == "bool" else "a finite number")
        )
    return float(value)


def _shown(value: Any) -> str:
    shown = repr(value)
    return shown if len(shown) <= 80 else f"{shown[:80]}…"


def _pattern(rule: Rule) -> re.Pattern[str]:
    pattern = re.escape(rule.topic.name).replace(r"\{", "{").replace(r"\}", "}")
    return re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>[^/]+)", pattern))


class Held(NamedTuple):
    """A timed fault that holds back the commands of a robot: ``delay`` ticks, or forever if 0.

    One with a ``trigger``, an index in the pool, is active for at most ``most`` ticks.
    """

    fault: int
    robot: int
    start: int
    finish: int
    delay: int
    trigger: int
    most: int

    def window(self, plan: Plan) -> tuple[int, int]:
        """Return its first and last active tick, as known at this point of a flight."""
        if self.trigger < 0:
            return self.start, min(self.finish, self.start + self.most - 1)
        trigger = plan.triggers[self.trigger]
        begin = max(self.start, trigger.fired + 1 + trigger.delay)
        return begin, min(self.finish, begin + self.most - 1) if trigger.fired >= 0 else -1


def robot_held(mission: Mission, pool: FaultPool, fault: str) -> int | None:
    """Return the robot whose commands a fault of a pool holds back, if there is one."""
    known = pool[fault]
    if known.kind.mode not in {Mode.DELAY, Mode.BLOCK}:
        return None
    message, _ = mission.message_goal[known.target]
    is_of_robot = message.sender in mission.robot_index
    return None if is_of_robot else mission.robot_index.get(message.receiver)


def held_commands(
    mission: Mission, pool: FaultPool, specification: Specification
) -> Iterator[Held]:
    """Yield the timed faults of a specification that hold commands back."""
    for number, timed in enumerate(specification):
        robot = robot_held(mission, pool, timed.fault)
        if robot is not None:
            kind, ticks = pool[timed.fault].kind, int(timed.values[0])
            delay = 0 if kind.mode is Mode.BLOCK else ticks
            place, most = -1, ticks if kind.mode is Mode.BLOCK else LAST
            if timed.trigger:
                place = [*pool.triggers_by_id].index(timed.trigger)
                most = longest(kind, timed.values, pool.triggers[place])
            if ticks > 0:
                yield Held(number, robot, timed.start, timed.finish, delay, place, most)


class Relay:
    """Relays the newest command of each topic once the node has answered a tick.

    ``publishers`` are those of the world by the node's topic, with the robot of each.
    """

    def __init__(self, publishers: Mapping[str, tuple[int, Publisher]]) -> None:
        self._publishers = publishers
        self.begin(())

    def begin(self, held: Sequence[Held]) -> None:
        """Begin a flight with faults that hold commands back."""
        self._held = held
        self._commands: dict[str, Payload] = {}
        self._under_way: list[tuple[int, str, Payload]] = []

    def take(self, topic: str, message: Payload) -> None:
        """Take a command."""
        self._commands[topic] = message

    def pass_on(self, plan: Plan, tick: int) -> None:
        """Publish the commands due in a tick, except those that faults hold back."""
        due = {name: message for when, name, message in self._under_way if when == tick}
        self._under_way = [each for each in self._under_way if each[0] > tick]
        commands, self._commands = self._commands, {}
        for held in self._held:
            first, last = held.window(plan)
            if not first <= tick <= last:
                continue
            names = [name for name in commands if self._publishers[name][0] == held.robot]
            note(plan, cast("InjectionState", held), tick, bool(names))
            for name in names:
                message = commands.pop(name)
                if held.delay and tick + held.delay <= last:
                    self._under_way.append((tick + held.delay, name, message))
        for name, message in {**due, **commands}.items():
            self._publishers[name][1](message)


def out_of_reach(mission: Mission, pool: FaultPool, speech: Speech) -> dict[str, str]:
    """Return the faults of a pool that cannot be injected, by ID, and the targets of each."""
    received, passed_on = speech.received, {each.robot for each in speech.relayed}
    unreachable = {}
    for fault in pool:
        targets = touched(mission, fault)
        is_forged = any(
            target[0] is Field.ACTIVATION
            or (target[0] is Field.MOTION and target[1] not in passed_on)
            for target in targets
        )
        is_held = robot_held(mission, pool, fault.id) in passed_on
        if not (is_forged or is_held or received.intersection(targets)):
            unreachable[fault.id] = ", ".join(describe(mission, target) for target in targets)
    return unreachable
