"""What elements of models hold, feature by feature in the order of the metamodel."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from pyecore.ecore import EEnum

from m2t.metaclasses import Slot, slots


def values(element: Any, slot: Slot) -> list[Any]:
    """Return what an element holds in a feature, be it one value, many, or none."""
    value = getattr(element, slot.name)
    if slot.many:
        return list(value)
    return [] if value is None else [value]


def is_set(element: Any, name: str) -> bool:
    """Return whether the model gives an optional feature that the element's class has."""
    slot = slots(element.eClass).get(name)
    return slot is not None and bool(element.eIsSet(slot.feature))


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


def copies(roots: Iterable[Any], known: Callable[[Any], Any] = lambda kind: kind) -> dict[Any, Any]:
    """Return copies of elements and all that they contain, by their originals.

    What they refer to beyond themselves stays the same, and what is unset stays unset. ``known``
    gives the class of the copies for a class, and the enumeration for an enumeration. All copies
    are made before any gets its values, which may refer to any of them.
    """
    made = {element: known(element.eClass)() for root in roots for element in contained(root)}
    for element, copy in made.items():
        for slot in slots(element.eClass).values():
            if slot.many or element.eIsSet(slot.feature):
                for value in values(element, slot):
                    is_literal = isinstance(slot.type, EEnum)
                    same = known(slot.type).getEEnumLiteral(value.name) if is_literal else value
                    put(copy, slot, made.get(same, same))
    return made
