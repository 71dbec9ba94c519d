"""Give every element of an imported model a readable ID."""

import re
from collections import Counter
from typing import Any

from m2t.diagnostics import shown
from m2t.elements import contained
from m2t.importing.notes import Notes
from m2t.importing.reading import PublishedReader
from m2t.metamodels import slots
from m2t.naming import identifier, snake_case
from mrsfi_runtime.errors import ModelError

_USABLE = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,99}", re.ASCII)
_UNUSABLE = re.compile(r"[^A-Za-z0-9_.-]+", re.ASCII)
_LONGEST_BASE = 80


def give_ids(root: Any, reader: PublishedReader, notes: Notes) -> None:
    """Set the ID of every element of a model, and the name of those that have none.

    Parameters
    ----------
    root
        Root object; IDs are unique below it, also as names in Python.
    reader
        Knows the IDs that the file gives.
    notes
        Takes every ID that is new or changed.

    Notes
    -----
    An element keeps its own ID if that can be used; the first of several with the same ID does.
    A fault without ID takes its name. The others get an ID from their place, such as
    ``g1_area`` or ``r1_sensor_2``.
    """
    identified = [element for element in contained(root) if _has(element, "ID")]
    namer = _Namer(reader, notes)
    for element in [element for element in identified if not namer.keeps_own(element)]:
        namer.derive(element)
    for element in identified:
        _name_by_id(element, reader, notes)


class _Namer:
    """Knows which names are taken."""

    def __init__(self, reader: PublishedReader, notes: Notes) -> None:
        self._reader = reader
        self._notes = notes
        self._taken: set[str] = set()
        self._kept: set[str] = set()
        self._counts: Counter[str] = Counter()

    def keeps_own(self, element: Any) -> bool:
        """Give an element the ID of the file, if that can be used."""
        own, is_name = self._own(element)
        if own is None or not _USABLE.fullmatch(own) or not self._take(own):
            return False
        self._kept.add(own)
        element.ID = own
        if is_name:
            node = self._reader.origins[element]
            self._notes.add("renamed", node, "ID", "has no ID; its name is its ID now")
        return True

    def derive(self, element: Any) -> None:
        """Give an element an ID that is made from its own or from its place."""
        own, _ = self._own(element)
        base = self._place(element)
        if own is not None:
            legal = _UNUSABLE.sub("_", own).strip("_.-")[:_LONGEST_BASE]
            word = snake_case(element.eClass.name)
            base = legal if legal[:1].isalpha() else f"{word}_{legal}" if legal else base
        new = base
        while not self._take(new):
            self._counts[base] += 1
            new = f"{base}_{self._counts[base] + 1}"
        self._note(element, own, new)
        element.ID = new

    def _own(self, element: Any) -> tuple[str | None, bool]:
        own = self._reader.own_ids.get(element)
        if own is None and element.eClass.name == "Fault":
            return element.name, True
        return own, False

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

    def _note(self, element: Any, own: str | None, new: str) -> None:
        node = self._reader.origins[element]
        if own is None:
            self._notes.add("renamed", node, "ID", f"has no ID; is now {new}")
            return
        self._notes.add("renamed", node, "ID", f"{shown(own)} is now {new}")
        if own in self._kept:
            message = f"{shown(own)} is the ID of more than one element; the first keeps it"
            self._notes.add("inconsistent", node, "ID", message)


def _name_by_id(element: Any, reader: PublishedReader, notes: Notes) -> None:
    if _has(element, "name") and not element.name:
        element.name = element.ID
        notes.add("default", reader.origins[element], "name", "is absent; set to the ID")


def _has(element: Any, name: str) -> bool:
    return name in slots(element.eClass)
