"""Give every element of an imported model a readable ID."""

import re
from collections import defaultdict
from collections.abc import Mapping
from itertools import count
from typing import Any

from m2t.diagnostics import shown
from m2t.importing.notes import Notes
from m2t.metaclasses import contained, slots
from m2t.naming import identifier, snake_case
from mrsfi_runtime.errors import ModelError

_USABLE = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,99}", re.ASCII)
_UNUSABLE = re.compile(r"[^A-Za-z0-9_.-]+", re.ASCII)
_LONGEST_BASE = 80


def give_ids(root: Any, own_ids: Mapping[Any, str], notes: Notes) -> None:
    """Set the ID of every element below a root, and the name of those that have none.

    IDs are unique, also as names in Python; ``notes`` take every one that is new or changed. An
    element keeps its own ID if that can be used; the first of several with the same ID does. A
    fault without ID takes its name. The others get an ID from their place, such as ``g1_area``
    or ``r1_sensor_2``.
    """
    identified = [element for element in contained(root) if _has(element, "ID")]
    namer = _Namer(own_ids, notes)
    for element in [element for element in identified if not namer.keeps_own(element)]:
        namer.derive(element)
    for element in identified:
        if _has(element, "name") and not element.name:
            element.name = element.ID
            notes.add("default", element, "name", "is absent; set to the ID")


class _Namer:
    def __init__(self, own_ids: Mapping[Any, str], notes: Notes) -> None:
        self._own_ids = own_ids
        self._notes = notes
        self._taken: set[str] = set()
        self._kept: set[str] = set()
        self._numbers: dict[str, count[int]] = defaultdict(lambda: count(2))

    def keeps_own(self, element: Any) -> bool:
        own = self._own(element)
        if own is None or not _USABLE.fullmatch(own) or not self._take(own):
            return False
        self._kept.add(own)
        element.ID = own
        if element not in self._own_ids:
            self._notes.add("renamed", element, "ID", "has no ID; its name is its ID now")
        return True

    def derive(self, element: Any) -> None:
        own = self._own(element)
        legal = _UNUSABLE.sub("_", own or "").strip("_.-")[:_LONGEST_BASE]
        if legal and not legal[0].isalpha():
            legal = f"{snake_case(element.eClass.name)}_{legal}"
        base = new = legal or self._place(element)
        while not self._take(new):
            new = f"{base}_{next(self._numbers[base])}"
        element.ID = new
        if own is None:
            self._notes.add("renamed", element, "ID", f"has no ID; is now {new}")
            return
        self._notes.add("renamed", element, "ID", f"{shown(own)} is now {new}")
        if own in self._kept:
            message = f"{shown(own)} is the ID of more than one element; the first keeps it"
            self._notes.add("inconsistent", element, "ID", message)

    def _own(self, element: Any) -> str | None:
        """Return the ID that the file gives an element; a fault without one goes by its name."""
        name = element.name if element.eClass.name == "Fault" else None
        return self._own_ids.get(element, name)

    def _take(self, identity: str) -> bool:
        try:
            name = identifier(identity)
        except ModelError:
            return False
        if name in self._taken:
            return False
        self._taken.add(name)
        return True

    def _place(self, element: Any) -> str:
        """Return what an element is called by its place, such as ``g1_area`` or ``robot_1``."""
        container = element.eContainer()
        if container is None:
            return snake_case(element.eClass.name)
        feature = element.eContainmentFeature()
        word = snake_case(feature.name)
        if feature.many:
            position = container.eGet(feature).index(element) + 1
            word = f"{snake_case(element.eClass.name)}_{position}"
        if container.eContainer() is None:
            return word
        return f"{container.ID if _has(container, 'ID') else self._place(container)}_{word}"


def _has(element: Any, name: str) -> bool:
    return name in slots(element.eClass)
