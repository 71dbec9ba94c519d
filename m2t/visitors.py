"""The visitors: they compute the context of each template from the models.

A visitor returns plain values and expressions in model order; no metamodel object reaches a
template. There is one visitor for each of ``mission_loader.py``, ``fault_loader.py``,
``fault_effects.py``, ``collective_intelligence.py`` and ``topics.py``, in this order. Begin with
``call``, which turns an element into a call of a class or function of the runtime.

User-defined features of the metamodel reach code as constants that begin with the element's ID:
``R1_PAYLOAD = 3.0``. The features of a task belong to its goal: ``G7_RADIUS``. Parts that code does
not read become one constant per feature; a list of parts becomes a tuple per feature:
``ZONES_DEPTH = (3.0, 5.0)``.
"""

from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any, TypeAlias

from pyecore.ecore import EEnumLiteral

from m2t.emit import Call, Expression, Name, Table, literal
from m2t.metaclasses import (
    BOUNDS,
    CONTRACT,
    OWN_TASK,
    PROGRESSING,
    Slot,
    base_class,
    constant,
    identifier,
    is_read,
    is_set,
    slots,
    snake_case,
    values,
)
from m2t.metamodels import load_metamodels, meaning
from m2t.models.constraints import fault_types
from m2t.models.load import LoadedModels
from m2t.read import Node
from mrsfi_runtime.errors import GenerationError, ModelError
from mrsfi_runtime.model.fault_types import OF_ROBOT, OF_SENSOR, FaultType, Mode, Parameter

_ORIGIN = Call("Coordinates", (("x", 0.0), ("y", 0.0), ("z", 0.0)), is_flat=True)
_AS_UNSET = (("required_members", 0), ("grace", 0))  # mean the same as no value


def visit_mission_loader(models: LoadedModels) -> Mapping[str, Any]:
    """Turn the mission into calls of the runtime's classes, which have the metamodel's names.

    An element becomes a call of its class with the set features that the runtime reads, in the
    order of the metamodel. User-defined features go to ``collective_intelligence.py``.
    """
    mission = call(models.mission)
    return {"imports": functions(mission), "result": mission}


def call(element: Any) -> Call:
    """Return the call for an element; one without ID is written on one line."""
    metaclass = base_class(element.eClass)
    if not is_read(metaclass):
        return Call(OWN_TASK, (("class_name", str(metaclass.name)),), is_flat=True)
    known = [slot for slot in slots(metaclass).values() if is_read(metaclass, slot.name)]
    given = (
        ("area" if slot.name == "missionArea" else snake_case(slot.name), _value(element, slot))
        for slot in known
        if not slot.feature.unsettable or element.eIsSet(slot.feature)
    )
    arguments = tuple(
        (name, value)
        for name, value in given
        if value not in (None, ()) and (name, value) not in _AS_UNSET
    )
    is_polygon = metaclass.name == "Area" and len(element.corners) > 0
    if is_polygon and element.center is None:  # it is calculated, and not the origin
        arguments = tuple(each for each in arguments if each[0] != "center")
    name = "polygon" if is_polygon else metaclass.name
    return Call(name, arguments, is_flat=not any(slot.is_id for slot in known))


def _value(element: Any, slot: Slot) -> Expression:
    """Return the value of an element's feature; an absent point is the origin."""
    value = held(element, slot, call)
    return _ORIGIN if value is None and slot.type.name == "Coordinates" else value


def held(element: Any, slot: Slot, part: Callable[[Any], Expression]) -> Expression:
    """Return the value of an element's feature: parts by ``part``, references as IDs."""

    def single(value: Any) -> Expression:
        if slot.is_contained:
            return part(value)
        if slot.is_reference:
            return str(getattr(value, "ID", None) or value.eURIFragment())
        return plain(value, slot)

    found = tuple(single(value) for value in values(element, slot))
    return found if slot.many else next(iter(found), None)


def plain(value: Any, slot: Slot) -> str | int | float | bool:
    """Return the value of an attribute as plain Python; that of an enumeration is its name."""
    if isinstance(value, EEnumLiteral):
        return str(value.name)
    return float(value) if slot.type.name == "EDouble" else value


def functions(expression: Expression) -> tuple[str, ...]:
    """Return the names that an expression calls or takes members of, sorted: its imports."""
    found: set[str] = set()
    pending = [expression]
    for value in pending:
        if isinstance(value, Call):
            found.add(value.function)
            pending.extend(argument for _, argument in value.arguments)
        elif isinstance(value, tuple):
            pending.extend(value)
        elif isinstance(value, Name) and "." in value.text:
            found.add(value.text.partition(".")[0])
    return tuple(sorted(found))


Entry: TypeAlias = tuple[str, Expression]


def visit_fault_loader(models: LoadedModels) -> Mapping[str, Any]:
    """Turn the fault specification into calls of the runtime's classes.

    The meanings of its fault types are a separate table. A mission without a fault model has an
    empty pool.
    """
    faults = models.faults
    own = () if faults is None else _features(faults, CONTRACT["faults"]["FaultSpecification"])
    pool = Call(
        "FaultPool",
        (
            ("id", "" if faults is None else faults.ID),
            ("faults", tuple(_fault(fault) for fault in models.pool)),
            *_given("own", Table(own)),
            *_given("triggers", () if faults is None else tuple(map(_trigger, faults.triggers))),
        ),
    )
    types = tuple(_type(kind) for kind in types_in_use(models))
    return {"imports": functions((pool, *types)), "result": pool, "types": types}


def types_in_use(models: LoadedModels) -> tuple[FaultType, ...]:
    """Return the fault types of which the pool has a fault, in the order of the metamodel."""
    used = {kind.eClass.name for fault in models.pool for kind in fault_types(fault)}
    return tuple(kind for kind in load_metamodels().fault_types.values() if kind.name in used)


def _fault(fault: Any) -> Call:
    """Return a fault: its type, its target, and its window and other features if it has them."""
    (fault_type,) = fault_types(fault)
    kind = meaning(fault_type)
    values = tuple(float(getattr(fault_type, known.name)) for known in kind.parameters)
    reference = f"affected{kind.struck.value.title()}"
    parameters = {f"{known.name}{end}" for known in kind.parameters for end in ("", *BOUNDS)}
    holding = {fault_type.eContainmentFeature().name, *CONTRACT["faults"]["Fault"]}
    own = (*_features(fault, holding), *_features(fault_type, {*parameters, reference}))
    return Call(
        "Fault",
        (
            ("id", fault.ID),
            ("name", fault.name),
            ("kind", Name(f"TYPES[{literal(kind.name)}]")),
            ("target", str(getattr(fault_type, reference).ID)),
            *_given("values", values),
            *_given("bounds", _bounds(fault_type, kind)),
            *_set(fault, "start", "finish", "likelihood", "reference"),
            *_given("own", Table(own)),
            *_given("trigger", "" if fault.trigger is None else str(fault.trigger.ID)),
        ),
    )


def _trigger(trigger: Any) -> Call:
    of = (trigger.goal, trigger.robot, *trigger.faults)
    area = trigger.at if trigger.area is None else trigger.area
    return Call(
        "Trigger",
        (
            ("id", trigger.ID),
            ("event", Name(f"Event.{trigger.event.name}")),
            ("of", tuple(str(each.ID) for each in of if each is not None)),
            *(() if area is None else (("area", call(area)),)),
            *_set(trigger, "delay", "duration"),
        ),
    )


def _set(element: Any, *names: str) -> Iterator[Entry]:
    return ((name, getattr(element, name)) for name in names if is_set(element, name))


def _given(name: str, value: str | tuple[Expression, ...] | Table) -> tuple[Entry, ...]:
    return () if value in ("", (), Table(())) else ((name, value),)


def _type(kind: FaultType) -> Call:
    return Call(
        "FaultType",
        (
            ("", kind.name),
            ("", Name(f"Mode.{kind.mode.name}")),
            ("", Name(f"Struck.{kind.struck.name}")),
            *_given("", tuple(Name(f"Field.{known.name}") for known in kind.properties)),
            *_given("parameters", tuple(map(_parameter, kind.parameters))),
            *((("effect", kind.effect),) if kind.effect >= 0 else ()),
        ),
        is_flat=True,
    )


def _parameter(parameter: Parameter) -> Call:
    return Call(
        "Parameter",
        (
            ("", parameter.name),
            ("", Name(f"Range.{parameter.range.name}")),
            *((("evolves", False),) if not parameter.evolves else ()),
            *((("is_integer", True),) if parameter.is_integer else ()),
        ),
        is_flat=True,
    )


def _bounds(fault_type: Any, kind: FaultType) -> Table:
    pairs: dict[str, tuple[float | None, ...]] = {}
    for parameter in kind.parameters:
        names = [f"{parameter.name}{end}" for end in BOUNDS]
        pairs[parameter.name] = tuple(
            float(getattr(fault_type, name)) if is_set(fault_type, name) else None for name in names
        )
    return Table(tuple((name, pair) for name, pair in pairs.items() if pair != (None, None)))


def _features(element: Any, known: Container[str] = ()) -> tuple[Entry, ...]:
    """Return the values or defaults of all features of an element but the known ones, by name."""
    return tuple(
        (name, held(element, slot, _part))
        for name, slot in slots(element.eClass).items()
        if name not in known
        and (
            element.eIsSet(slot.feature)
            or getattr(slot.feature, "defaultValueLiteral", None) is not None
        )
    )


def _part(part: Any) -> Table:
    """Return a user-defined part as a dictionary, with its class as ``eClass``."""
    return Table((("eClass", str(part.eClass.name)), *_features(part)))


@dataclass(frozen=True, slots=True)
class EffectView:
    """An effect: fault type, number, properties and element that it may change, and parameters.

    Its region is named after the type, so it does not depend on other types.
    """

    type: str
    number: int
    function: str
    properties: str
    element: str
    constants: tuple[str, ...]


def visit_fault_effects(models: LoadedModels) -> Mapping[str, Any]:
    """Collect the fault types of mode OWN of which the pool has a fault."""
    types = types_in_use(models)
    effects = tuple(_effect(kind) for kind in types if kind.mode is Mode.OWN)
    names = [name for effect in effects for name in (effect.function, *effect.constants)]
    for name in names:
        if names.count(name) > 1:
            raise GenerationError(
                f"fault types {' and '.join(effect.type for effect in effects)} of mode OWN: "
                f"two of their names become {name} in Python; rename one"
            )
    return {"effects": effects}


def _effect(kind: FaultType) -> EffectView:
    stem = snake_case(kind.name)
    affected = kind.properties[0]
    of_robot = "robot" if affected in OF_ROBOT else "obstacle"
    return EffectView(
        type=kind.name,
        number=kind.effect,
        function=f"apply_{stem}",
        properties=" and ".join(known.name for known in kind.properties),
        element="sensor" if affected in OF_SENSOR else of_robot,
        constants=tuple(f"{stem}_{parameter.name}".upper() for parameter in kind.parameters),
    )


NONE = -1
"""Index of an unset reference."""

_NUMBERS = ("Coordinates", "Area")

Held: TypeAlias = Any
"""An element or a value, or a tuple of these, nested as deep as lists contain lists."""


@dataclass(frozen=True, slots=True)
class Constant:
    """The index of a model element, or a value of one; ``remark`` is a display name."""

    name: str
    value: Expression
    remark: str = ""


Constants: TypeAlias = Iterator[tuple[Any, Constant]]
"""Constants, each after the element that it belongs to."""


@dataclass(frozen=True, slots=True)
class OwnFeatures:
    """Finds the values of features that code does not read.

    ``indices`` are the indices of elements in code, for references; ``nodes`` have their lines.
    """

    indices: Mapping[Any, int]
    nodes: Mapping[Any, Node]

    def of(self, element: Any, prefix: str) -> Constants:
        """Yield the constants of an element that code reads, and of all elements in it.

        A value that cannot be a constant raises a ``ModelError``.
        """
        metaclass = base_class(element.eClass)
        for slot in slots(element.eClass).values():
            name = f"{prefix}_{snake_case(slot.name).upper()}"
            if not is_read(metaclass, slot.name):
                yield from self._constants(element, slot, name)
            elif slot.is_contained and slot.name != "requirements":
                is_task = slot.type.name == "GoalTask"
                yield from self._parts(element, slot, prefix if is_task else name)

    def _parts(self, element: Any, slot: Slot, prefix: str) -> Constants:
        """Yield the constants of parts that code reads, named by ID or else by place."""
        parts = values(element, slot)
        if any(each.is_id for each in slots(slot.type).values()):
            for part in parts:
                yield from self.of(part, constant(part.ID))
        elif slot.many:
            yield from self._columns(tuple(parts), slot.type, prefix, read=False)
        else:
            for part in parts:
                yield from self.of(part, prefix)

    def _constants(self, held: Held, slot: Slot, name: str) -> Constants:
        """Yield the value of a feature: one constant, or one per feature of its parts."""
        found = _mapped(lambda element: self._values(element, slot, held), held)
        first = next(_flat(held), None)
        if not slot.is_contained:
            yield first, Constant(name, found)
        elif found is not None:
            is_number = base_class(slot.type).name in _NUMBERS
            if is_number:
                yield first, Constant(name, _mapped(_numbers, found))
            yield from self._columns(found, slot.type, name, read=not is_number)

    def _columns(self, held: Held, declared: Any, prefix: str, *, read: bool) -> Constants:
        """Yield a constant for each feature of parts, with a value for each part.

        ``read`` includes features that code reads of such parts elsewhere.
        """
        metaclass = self._class(held, declared)
        known = base_class(metaclass)
        for slot in slots(metaclass).values():
            if read or not is_read(known, slot.name):
                name = f"{prefix}_{snake_case(slot.name).upper()}"
                yield from self._constants(held, slot, name)

    def _class(self, held: Held, declared: Any) -> Any:
        parts = list(_flat(held))
        for part in parts:
            if part.eClass is not parts[0].eClass:
                raise self.error(
                    part,
                    f"is of class {part.eClass.name}, beside others of {parts[0].eClass.name}; "
                    "no constants can hold both; expected parts of one class",
                )
        return parts[0].eClass if parts else declared

    def _values(self, element: Any, slot: Slot, beside: Held) -> Held:
        value = getattr(element, slot.name)
        if slot.many:
            return tuple(self._value(element, entry, slot) for entry in value)
        if value is None and slot.is_contained and isinstance(beside, tuple):
            raise self.error(
                element,
                f"has no {slot.name}; generated code has one constant for all parts of the list, "
                "and each part needs a value; add it",
            )
        return self._value(element, value, slot)

    def _value(self, element: Any, value: Any, slot: Slot) -> Held:
        if slot.is_contained:
            return value
        if not slot.is_reference:
            return "" if value is None else plain(value, slot)
        if value is not None and value not in self.indices:
            raise self.error(
                element,
                f"refers to {self.nodes[value].description} as {slot.name}, which has no index in "
                "generated code; expected a robot, a sensor, an obstacle, a goal, a server or a "
                "part that the mission lists",
            )
        return NONE if value is None else self.indices[value]

    def error(self, element: Any, finding: str) -> ModelError:
        """Return the error that an element cannot become constants."""
        node = self.nodes[element]
        return ModelError(f"{node.path}:{node.line}: {node.description} {finding}")


def _numbers(part: Any) -> Expression:
    """Return a point as (x, y, z), a disc as (x, y, z, radius); an absent centre is the origin."""
    is_disc = base_class(part.eClass).name == "Area"
    point = part.center if is_disc else part
    place = (0.0, 0.0, 0.0) if point is None else (float(point.x), float(point.y), float(point.z))
    return (*place, float(part.radius)) if is_disc else place


def _mapped(function: Callable[[Any], Any], held: Held) -> Any:
    if isinstance(held, tuple):
        return tuple(_mapped(function, entry) for entry in held)
    return function(held)


def _flat(held: Held) -> Iterator[Any]:
    if isinstance(held, tuple):
        for entry in held:
            yield from _flat(entry)
    elif held is not None:
        yield held


@dataclass(frozen=True, slots=True)
class GoalView:
    """A goal: its identifier and constant, class and module of its task, and its members.

    A user-defined task has no module: its regions are empty. Regions are named after the
    identifier, so that renaming or reordering goals keeps code.
    """

    name: str
    constant: str
    task: str
    module: str | None
    has_progress: bool
    members: str


def visit_collective_intelligence(models: LoadedModels) -> Mapping[str, Any]:
    """Collect the goals of the mission, and constants for the elements that their code uses.

    A user-defined feature that cannot be a constant raises a ``ModelError``.
    """
    mission = models.mission
    sensors = [sensor for robot in mission.robots for sensor in robot.sensors]
    indices = {sensor: index for index, sensor in enumerate(sensors)}  # over all robots
    for slot in slots(mission.eClass).values():
        if slot.is_contained and slot.many:
            indices |= {part: index for index, part in enumerate(values(mission, slot))}
    remarks = {robot: robot.name for robot in mission.robots}
    constants = {
        name: Constant(name, indices[element], remarks.get(element, ""))
        for element in (*mission.goals, *mission.robots, *sensors, *mission.obstacles)
        for name in (constant(element.ID),)
    }
    own = OwnFeatures(indices, models.nodes)
    for element, found in chain(own.of(mission, "MISSION"), _required_members(mission)):
        if found.name in constants:
            raise own.error(
                element or mission,
                f"has a value that would become the constant {found.name}, as another element "
                "does; rename the feature or that element",
            )
        constants[found.name] = found
    return {
        "goals": tuple(_goal(goal) for goal in mission.goals),
        "constants": tuple(constants.values()),
    }


def _required_members(mission: Any) -> Constants:
    """Yield how many members the goals of user-defined tasks require, except all."""
    for goal in mission.goals:
        if goal.requiredMembers > 0 and not is_read(base_class(goal.task.eClass)):
            name = f"{constant(goal.ID)}_REQUIRED_MEMBERS"
            yield goal, Constant(name, int(goal.requiredMembers))


def _goal(goal: Any) -> GoalView:
    known = base_class(goal.task.eClass)
    is_own = not is_read(known)
    names = [identifier(member.ID) for member in goal.members]
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return GoalView(
        name=identifier(goal.ID),
        constant=constant(goal.ID),
        task=known.name,
        module=None if is_own else snake_case(known.name),
        has_progress=is_own or known.name in PROGRESSING,
        members=", ".join(names[:8]) + more,
    )


def visit_topics(models: LoadedModels) -> Mapping[str, Any]:
    """Collect a row for each robot and each sensor."""
    robots = models.mission.robots
    return {
        "robots": tuple(_row("RobotTopics", robot=robot.ID) for robot in robots),
        "sensors": tuple(
            _row("SensorTopics", robot=robot.ID, sensor=sensor.ID)
            for robot in robots
            for sensor in robot.sensors
        ),
    }


def _row(kind: str, **ids: str) -> Call:
    names = tuple((element, identifier(each)) for element, each in ids.items())
    return Call(kind, names, is_flat=True)
