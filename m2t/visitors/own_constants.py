"""What a team has added to the metamodel, as constants of generated code: nothing is dropped.

Whatever code does not read of an element becomes a constant that begins with the ID of the
element: ``R1_PAYLOAD = 3.0``. The features of a task belong to its goal: ``G7_RADIUS``. Parts
without a meaning for code are taken apart, many of them into a tuple a feature: ``ZONES_DEPTH =
(3.0, 5.0)``.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from m2t.environment import Expression
from m2t.metaclasses import Slot, base_class, is_read, slots, values
from m2t.naming import constant, snake_case
from m2t.read.nodes import Node
from m2t.visitors.mission_loader import plain
from mrsfi_runtime.errors import ModelError

NONE = -1
"""Index that stands for a reference to nothing."""

_NUMBERS = ("Coordinates", "Area")

Held: TypeAlias = Any
"""An element, or a tuple of what is held, as deep as lists contain lists."""


@dataclass(frozen=True, slots=True)
class Constant:
    """The index of a model element, or a value of one; ``remark`` is a display name."""

    name: str
    value: Expression
    remark: str = ""


Found: TypeAlias = Iterator[tuple[Any, Constant]]
"""Constants, each after the element that it belongs to."""


@dataclass(frozen=True, slots=True)
class OwnFeatures:
    """Finds what elements hold in features that code does not read.

    ``indices`` are those by which code knows elements that others refer to; ``nodes`` have their
    lines.
    """

    indices: Mapping[Any, int]
    nodes: Mapping[Any, Node]

    def of(self, element: Any, prefix: str) -> Found:
        """Yield the constants of an element that code reads, and of all that it contains.

        A value that cannot be a constant raises a ``ModelError``.
        """
        metaclass = base_class(element.eClass)
        for slot in slots(element.eClass).values():
            name = f"{prefix}_{snake_case(slot.name).upper()}"
            if not is_read(metaclass, slot.name):
                yield from self._constants(element, slot, name)
            elif slot.is_contained:
                is_task = slot.type.name == "GoalTask"
                yield from self._parts(element, slot, prefix if is_task else name)

    def _parts(self, element: Any, slot: Slot, prefix: str) -> Found:
        """Yield the constants of parts that code reads: by their IDs, else by where they are."""
        parts = values(element, slot)
        if any(each.is_id for each in slots(slot.type).values()):
            for part in parts:
                yield from self.of(part, constant(part.ID))
        elif slot.many:
            yield from self._columns(tuple(parts), slot.type, prefix, read=False)
        else:
            for part in parts:
                yield from self.of(part, prefix)

    def _constants(self, held: Held, slot: Slot, name: str) -> Found:
        """Yield what is held in a feature: one constant, or one a feature of the parts there."""
        found = _mapped(lambda element: self._values(element, slot, held), held)
        first = next(_flat(held), None)
        if not slot.is_contained:
            yield first, Constant(name, found)
        elif found is not None:
            is_number = base_class(slot.type).name in _NUMBERS
            if is_number:
                yield first, Constant(name, _mapped(_numbers, found))
            yield from self._columns(found, slot.type, name, read=not is_number)

    def _columns(self, held: Held, declared: Any, prefix: str, *, read: bool) -> Found:
        """Yield a constant for each feature of parts, with a value for each part.

        ``read`` asks for features too that code would read of such a part elsewhere.
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
                f"has no {slot.name}; code knows those of all its neighbours as one constant, in "
                "which every one needs a value; add it",
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
                "code; expected a robot, a sensor, an obstacle, a goal, a server or a part that "
                "the mission lists",
            )
        return NONE if value is None else self.indices[value]

    def error(self, element: Any, finding: str) -> ModelError:
        """Return the error that an element cannot become constants."""
        node = self.nodes[element]
        return ModelError(f"{node.path}:{node.line}: {node.description} {finding}")


def _numbers(part: Any) -> Expression:
    """Return a point as (x, y, z), a disc as (x, y, z, radius); no centre means the origin."""
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
