"""What a team has added to the metamodels, for generated code: nothing of a model is lost."""

from collections.abc import Container
from typing import Any

from pyecore.ecore import EEnumLiteral

from m2t.environment import Expression, Table
from m2t.metamodels import Slot, slots


def own_features(element: Any, known: Container[str] = ()) -> Table:
    """Return the features that a model or a default gives an element, by name.

    Parameters
    ----------
    element
        Element of a model.
    known
        Names of features that generated code has by other ways.

    Returns
    -------
    Table
        Values; of a part its own features with its class as ``eClass``, of a reference an ID.
    """
    given = (
        slot
        for name, slot in slots(element.eClass).items()
        if name not in known and (element.eIsSet(slot.feature) or _has_default(slot))
    )
    return Table(tuple((slot.name, _values(element, slot)) for slot in given))


def _has_default(slot: Slot) -> bool:
    return getattr(slot.feature, "defaultValueLiteral", None) is not None


def _values(element: Any, slot: Slot) -> Expression:
    value = getattr(element, slot.name)
    if slot.many:
        return tuple(_value(entry, slot) for entry in value)
    return _value(value, slot)


def _value(value: Any, slot: Slot) -> Expression:
    if value is not None and slot.is_contained:
        return Table((("eClass", str(value.eClass.name)), *own_features(value).entries))
    if value is not None and slot.is_reference:
        return str(getattr(value, "ID", None) or value.eURIFragment())
    if isinstance(value, EEnumLiteral):
        return str(value.name)
    return value if value is None or isinstance(value, int | float) else str(value)
