"""Fix defects that have one sensible remedy, as Epsilon's quick fixes do, for scripts.

A fix checks the element again and changes nothing if it is correct, so offering a fix for too many
elements is harmless. ``mend`` edits loaded models in memory and returns the changes to their
files. ``FIXES`` lists the remedies by constraint; begin there.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

from m2t.metaclasses import contained, is_kind, slots, values
from m2t.models import constraints
from m2t.models.load import Edit, Inspection, LoadedModels, edited
from mrsfi_runtime.errors import Diagnostic

Remedy: TypeAlias = Callable[[Any], None]


@dataclass(frozen=True, slots=True)
class Fix:
    """A remedy for one constraint: its title for the user, and its edit of an element."""

    title: str
    mend: Remedy


@dataclass(frozen=True, slots=True)
class Mending(Edit):
    """Changes by the fixes; ``fixed`` are the removed defects, each with the title of its fix."""

    fixed: tuple[tuple[Diagnostic, str], ...]


def mend(inspection: Inspection) -> Mending | None:
    """Apply all possible fixes in memory: the objects of the inspection are changed.

    Return ``None`` if no fix applies, or if errors of structure must be corrected first. Models
    that cannot be saved raise a ``ModelError``.
    """
    draft = inspection.draft or inspection.remains
    titles = _TITLES if inspection.remains is None else _TITLES_OF_REMAINS
    fixable = tuple(found for found in inspection.diagnostics if found.constraint in titles)
    if draft is None or not fixable:
        return None
    by_loading = {found.path for found in fixable if found.constraint in _TITLES_OF_REMAINS}
    fix = partial(_fix, fixable) if inspection.remains is None else delete_incomplete
    made = edited(draft, fix, loaded=by_loading)
    fixed = tuple((found, titles[found.constraint]) for found in fixable)
    return Mending(made.folder, made.contents, made.before, made.difference, made.respelt, fixed)


def _fix(defects: Iterable[Diagnostic], draft: LoadedModels) -> None:
    elements: dict[tuple[object, ...], list[Any]] = {}
    for element, node in draft.nodes.items():
        elements.setdefault((node.path, node.line, node.description), []).append(element)
    for found in defects:
        # Loading has already fixed repeated references, which are nodes without an object.
        for element in elements.get((found.path, found.line, found.element), ()):
            FIXES[found.constraint].mend(element)


def _delete_self_dependence(goal: Any) -> None:
    if goal in goal.dependentGoals:
        goal.dependentGoals.remove(goal)


def _add_members(task: Any) -> None:
    goal = task.eContainer()
    goal.members.extend(constraints.strangers(goal))


def _delete_repeated_field(entry: Any) -> None:
    message = entry.eContainer()  # None if deleted already: two defects of one name in one line
    if message is not None and entry in constraints.repeated(message.body):
        message.body.remove(entry)


def _round_ticks(kind: Any) -> None:
    for name in constraints.broken_ticks(kind):
        setattr(kind, name, float(round(getattr(kind, name))))


def _exchanging(pairs: Callable[[Any], constraints.Pairs]) -> Remedy:
    def exchange(element: Any) -> None:
        for one, other in pairs(element):
            first, second = getattr(element, one), getattr(element, other)
            setattr(element, one, second)
            setattr(element, other, first)

    return exchange


FIXES: Mapping[str, Fix] = {
    "UniqueReference": Fix("Delete the repeated references", lambda _: None),  # done by loading
    "GoalDependsOnOthers": Fix(
        "Delete the goal from its own dependentGoals", _delete_self_dependence
    ),
    "AvoidCollisionMembers": Fix("Add the robots to the members of the goal", _add_members),
    "UniqueMessageField": Fix("Delete the repeated field", _delete_repeated_field),
    "RandomBoundsOrdered": Fix(
        "Exchange the lowest and the highest random value", _exchanging(constraints.exchanged_draw)
    ),
    "SearchBoundsOrdered": Fix(
        "Exchange the lowest and the highest value", _exchanging(constraints.exchanged_bounds)
    ),
    "WholeTicks": Fix("Round to whole ticks", _round_ticks),
    "WindowOrdered": Fix("Exchange start and finish", _exchanging(constraints.exchanged_window)),
}
"""Fixes by constraint; the ``.evl`` files offer the same under the same titles."""

_TITLES = {name: fix.title for name, fix in FIXES.items()}
_TITLES_OF_REMAINS = {
    "UniqueReference": _TITLES["UniqueReference"],
    "ResolvedReference": "Delete the reference and each element that is incomplete without it",
}
"""Fixes that loading has begun by leaving references out; incomplete elements follow."""


def delete_incomplete(models: LoadedModels) -> None:
    """Delete elements that lack a required feature, and references to deleted elements.

    A goal loses a deleted member. A message without a sender is deleted, and so is a fault of that
    message, or one that waits for a deleted trigger. Roots are never deleted.
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
    """Remove an element's references to deleted elements; return whether it is then incomplete."""
    is_incomplete = (is_kind(element.eClass, "Fault") and not constraints.fault_types(element)) or (
        is_kind(element.eClass, "Trigger") and not constraints.fits_event(element)
    )
    for slot in slots(element.eClass).values():
        held = values(element, slot)
        gone: list[Any] = []
        if slot.is_reference:
            gone = [each for each in held if each not in alive]
            for each in gone:
                _take(element, slot.name, each)
            held = [each for each in held if each in alive]
        is_object = slot.is_reference or slot.is_contained
        is_incomplete |= is_object and len(held) < slot.lower_bound
        is_incomplete |= bool(gone) and not slot.many
    return is_incomplete


def _take(holder: Any, name: str, element: Any) -> None:
    if slots(holder.eClass)[name].many:
        getattr(holder, name).remove(element)
    else:
        setattr(holder, name, None)
