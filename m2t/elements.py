"""What elements of models hold, feature by feature in the order of the metamodel."""

from collections.abc import Iterator
from typing import Any

from m2t.metamodels import Slot, slots


def values(element: Any, slot: Slot) -> list[Any]:
    """Return what an element holds in a feature, be it one value, many, or none."""
    value = getattr(element, slot.name)
    if slot.many:
        return list(value)
    return [] if value is None else [value]


def put(element: Any, slot: Slot, value: Any) -> None:
    """Set a feature of an element, or add to its values if it holds many."""
    if slot.many:
        getattr(element, slot.name).append(value)
    else:
        setattr(element, slot.name, value)


def contained(element: Any) -> Iterator[Any]:
    """Yield an element and all that it contains, in the order in which they are written."""
    yield element
    for slot in slots(element.eClass).values():
        if slot.is_contained:
            for child in values(element, slot):
                yield from contained(child)


def copied(element: Any, *, with_ids: bool = True) -> Any:
    """Return a copy of an element and all that it contains; references stay as they are.

    Parameters
    ----------
    element
        The element.
    with_ids
        Whether the copies have the IDs of their originals, else none.
    """
    copy = element.eClass()
    for slot in slots(element.eClass).values():
        is_given = slot.many or element.eIsSet(slot.feature)
        if is_given and (with_ids or not slot.is_id):
            for value in values(element, slot):
                held = copied(value, with_ids=with_ids) if slot.is_contained else value
                put(copy, slot, held)
    return copy
