"""Delete what is incomplete once something that it refers to is gone."""

from collections.abc import Iterable
from typing import Any

from m2t.constraints.fault_rules import fault_types
from m2t.elements import contained, values
from m2t.load import LoadedModels
from m2t.metaclasses import is_kind, slots


def delete_incomplete(models: LoadedModels) -> None:
    """Delete elements that lack what the metamodels require, and references to what is deleted.

    A goal loses a member that is gone; a message whose sender is gone goes as a whole, and so does
    a fault of that message. Roots stay, whatever they lack.
    """
    roots = [root for root in (models.mission, models.faults) if root is not None]
    while True:
        alive = {element for root in roots for element in contained(root)}
        lost = [element for element in alive if _loses(element, alive) and element not in roots]
        if not lost:
            return
        for element in lost:
            _take(element.eContainer(), element.eContainmentFeature().name, element)


def _loses(element: Any, alive: Iterable[Any]) -> bool:
    """Take references to what is gone from an element; return whether it lacks something then."""
    is_incomplete = is_kind(element.eClass, "Fault") and not fault_types(element)
    for slot in slots(element.eClass).values():
        held = values(element, slot)
        if slot.is_reference:
            gone = [each for each in held if each not in alive]
            for each in gone:
                _take(element, slot.name, each)
            held = [each for each in held if each in alive]
        is_object = slot.is_reference or slot.is_contained
        is_incomplete |= is_object and len(held) < slot.lower_bound
    return is_incomplete


def _take(holder: Any, name: str, element: Any) -> None:
    """Take an element from a feature."""
    if slots(holder.eClass)[name].many:
        getattr(holder, name).remove(element)
    else:
        setattr(holder, name, None)
