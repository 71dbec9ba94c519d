"""Visitor of ``mission_loader.py``: the mission as one nested expression."""

from collections.abc import Callable, Mapping
from typing import Any

from pyecore.ecore import EEnumLiteral

from m2t.environment import Call, Expression, Name
from m2t.load import LoadedModels
from m2t.metaclasses import Slot, base_class, is_read, slots, values
from m2t.metamodel_contract import OWN_TASK
from m2t.naming import snake_case

_NAMES: Mapping[str, str] = {"missionArea": "area"}
_ORIGIN = Call("Coordinates", (("x", 0.0), ("y", 0.0), ("z", 0.0)), is_flat=True)


def visit(models: LoadedModels) -> Mapping[str, Any]:
    """Turn the mission into calls of the runtime's vocabulary, which the metamodel names.

    An element becomes a call of its class with the features that the runtime reads, in the
    order of the metamodel and without those that are unset; a team's own go to
    ``collective_intelligence.py``.
    """
    mission = call(models.mission)
    return {"imports": functions(mission), "result": mission}


def call(element: Any) -> Call:
    """Return an element; one without an identity is short enough for one line."""
    metaclass = base_class(element.eClass)
    if not is_read(metaclass):
        return Call(OWN_TASK, (("class_name", str(metaclass.name)),), is_flat=True)
    known = [slot for slot in slots(metaclass).values() if is_read(metaclass, slot.name)]
    given = (
        (_NAMES.get(slot.name, snake_case(slot.name)), _value(element, slot))
        for slot in known
        if not slot.feature.unsettable or element.eIsSet(slot.feature)
    )
    arguments = tuple((name, value) for name, value in given if value not in (None, ()))
    return Call(metaclass.name, arguments, is_flat=not any(slot.is_id for slot in known))


def _value(element: Any, slot: Slot) -> Expression:
    """Return what an element holds in a feature; where it gives no point, it means the origin."""
    value = held(element, slot, call)
    return _ORIGIN if value is None and slot.type.name == "Coordinates" else value


def held(element: Any, slot: Slot, part: Callable[[Any], Expression]) -> Expression:
    """Return what an element holds in a feature: parts as ``part`` returns them, links as IDs."""

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
