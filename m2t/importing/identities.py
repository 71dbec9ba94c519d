"""Give every element of an imported model a readable ID."""

import re
from collections import defaultdict
from itertools import count

from m2t.diagnostics import shown
from m2t.importing.notes import Notes
from m2t.metaclasses import slots
from m2t.naming import identifier, snake_case
from m2t.read.nodes import Node
from mrsfi_runtime.errors import ModelError

_USABLE = re.compile(r"[A-Za-z][A-Za-z0-9_.-]{0,99}", re.ASCII)
_UNUSABLE = re.compile(r"[^A-Za-z0-9_.-]+", re.ASCII)
_LONGEST_BASE = 80


def give_ids(root: Node, notes: Notes) -> None:
    """Set the ID of every element below the root of a model whose nodes know their classes.

    IDs are unique, also as names in Python; ``notes`` take every one that is new or changed. An
    element keeps its own ID if that can be used; the first of several with the same ID does. A
    fault without ID takes its name. The others get an ID from their place, such as ``g1_area``
    or ``r1_sensor_2``.
    """
    identified = [node for node in root.walk() if _has(node, "ID")]
    namer = _Namer(notes)
    for node in [node for node in identified if not namer.keeps_own(node)]:
        namer.derive(node)
    for node in identified:
        if _has(node, "name") and not node.attributes.get("name"):
            node.attributes["name"] = node.attributes["ID"]
            notes.add("default", node, "name", "is absent; set to the ID")


class _Namer:
    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._taken: set[str] = set()
        self._kept: set[str] = set()
        self._numbers: dict[str, count[int]] = defaultdict(lambda: count(2))

    def keeps_own(self, node: Node) -> bool:
        own = _own(node)
        if own is None or not _USABLE.fullmatch(own) or not self._take(own):
            return False
        self._kept.add(own)
        if "ID" not in node.attributes:
            self._notes.add("renamed", node, "ID", "has no ID; its name is its ID now")
        node.attributes["ID"] = own
        return True

    def derive(self, node: Node) -> None:
        own = _own(node)
        legal = _UNUSABLE.sub("_", own or "").strip("_.-")[:_LONGEST_BASE]
        if legal and not legal[0].isalpha():
            legal = f"{snake_case(node.metaclass.name)}_{legal}"
        base = new = legal or _place(node)
        while not self._take(new):
            new = f"{base}_{next(self._numbers[base])}"
        node.attributes["ID"] = new
        if own is None:
            self._notes.add("renamed", node, "ID", f"has no ID; is now {new}")
            return
        self._notes.add("renamed", node, "ID", f"{shown(own)} is now {new}")
        if own in self._kept:
            message = f"{shown(own)} is the ID of more than one element; the first keeps it"
            self._notes.add("inconsistent", node, "ID", message)

    def _take(self, identity: str) -> bool:
        try:
            name = identifier(identity)
        except ModelError:
            return False
        if name in self._taken:
            return False
        self._taken.add(name)
        return True


def _own(node: Node) -> str | None:
    """Return the ID that the file gives an element; a fault without one goes by its name."""
    name = node.attributes.get("name") if node.metaclass.name == "Fault" else None
    return node.attributes.get("ID", name)


def _place(node: Node) -> str:
    """Return what an element is called by its place, such as ``g1_area`` or ``robot_1``."""
    container = node.parent
    if container is None:
        return snake_case(node.metaclass.name)
    word = snake_case(node.tag)
    if slots(container.metaclass)[node.tag].many:
        position = container.tagged(node.tag).index(node) + 1
        word = f"{snake_case(node.metaclass.name)}_{position}"
    if container.parent is None:
        return word
    return f"{container.attributes['ID'] if _has(container, 'ID') else _place(container)}_{word}"


def _has(node: Node, name: str) -> bool:
    return node.metaclass is not None and name in slots(node.metaclass)
