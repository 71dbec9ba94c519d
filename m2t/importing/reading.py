"""Turn the nodes of a published file into nodes of our metamodels, which are checked as any other.

It is an XMI file, whose root ``Setup`` holds a mission and fault specifications. Most features
have the names of ours; the tables have those that differ, and what to put where the old format
says nothing. What is not known is dropped with a note. All else keeps its text, so that
``m2t.check`` refuses what ``mrsfi validate`` refuses, by the same rules. References keep theirs,
too: a ``PublishedFile`` finds what they mean.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from m2t.check.attribute_values import DOUBLE
from m2t.check.references import resolve
from m2t.check.structure import ModelTree, Reference, check_structure
from m2t.diagnostics import Report, shown
from m2t.importing.notes import Notes
from m2t.metaclasses import Slot, concrete_classes, slots
from m2t.metamodel_contract import BOUNDS
from m2t.read.model_files import ModelFile, ModelFiles
from m2t.read.nodes import XMI, XSI, Node, Spelling, follow

SETUP_NAMESPACE = "acs_project_setup"
NAMESPACES = frozenset({"", SETUP_NAMESPACE, "acs_project_mission", "acs_project_fault"})
ROOT = "Setup"

RENAMED: Mapping[str, Mapping[str, str]] = {
    "Message": {"from": "sender", "to": "receiver"},
    "Fault": {"probability": "likelihood"},
}
"""Old names of features by class, with ours."""

WRAPPED: Mapping[str, Mapping[str, str]] = {
    "Goal": {"members": "goalMembers", "dependentGoals": "dependencies", "area": "goalArea"}
}
"""Features that the old format holds one level deeper, by class, with their name there."""

BACK_REFERENCES = frozenset({"parentID", "goal_ID"})
"""Attributes that repeat the ID of the container."""

ZERO_VALUES = frozenset({"VAL", "CAPACITY"})
"""Attributes of the old Zero types, whose value can only be zero."""

OPTIONAL = frozenset(
    {"header", "name", "maxSpeed", "turnRate", "positionNoise", "start", "finish", "likelihood"}
    | {"distanceUnit", "timeUnit", "energyUnit"}
)
"""Attributes that stay unset if the file does not give them; bounds of search do as well."""

USUAL: Mapping[str, str] = {"EDouble": "0.0", "EInt": "0", "EString": ""}
"""What any other absent attribute means, by its type."""

DEFAULTS: Mapping[tuple[str, str], Callable[[int], str]] = {
    ("Patrol", "period"): lambda duration: str(max(1, duration // 10)),
    ("Visit", "deadline"): lambda duration: str(max(1, duration - 1)),
    ("Visit", "tolerance"): lambda _: "1.0",
    ("Track", "tolerance"): lambda _: "10.0",
    ("FixedDistanceBetweenRobots", "tolerance"): lambda _: "1.0",
    ("Sensor", "type"): lambda _: "GPS_POSITION",
}
"""Values of attributes that the old format lacks or leaves out, given the mission's duration.

Patrol: a tenth of the mission. Visit: by its last tick, within the radius of a robot. Track:
ten distance units off. FixedDistanceBetweenRobots: one unit off. A sensor without type has the
first literal, as in Eclipse. Any other absent number is 0, as in Eclipse.
"""


_ZERO = re.compile(r"[+-]?(0*\.?0*)", re.ASCII)
_COPIED = ("Area", "Coordinates")
"""Classes whose elements are copied where the old format refers to one."""

_AFFECTED = "affected"
_EXACT = 2.0**53


class _Given:
    """What a file says of an element; what is taken is gone, and the rest gets dropped."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.attributes = dict(node.attributes)
        self.children: dict[str, list[Node]] = {}
        for child in node.children:
            name = child.tag if child.namespace in NAMESPACES else f"{child.namespace} {child.tag}"
            self.children.setdefault(name, []).append(child)

    def take_children(self, name: str) -> list[Node]:
        return self.children.pop(name, [])

    def rename(self, old: str, new: str) -> None:
        """Call a feature otherwise; one that is given by both names is given twice."""
        again = self.take_children(old)
        if old in self.attributes:
            text = self.attributes.pop(old)
            if self.attributes.setdefault(new, text) is not text:
                again.append(_made(self.node, new, None, text=text))
        if again:
            self.children.setdefault(new, []).extend(again)

    def unwrap(self, name: str, inner: str) -> Iterator["_Given"]:
        """Lift what a wrapper holds; yield the wrapper with what is left."""
        lifted: list[Node] = []
        for node in self.take_children(name):
            wrapper = _Given(node)
            if inner in wrapper.attributes:
                texts = (self.attributes.get(name, ""), wrapper.attributes.pop(inner))
                self.attributes[name] = " ".join(texts).strip()
            elif inner not in wrapper.children and (
                wrapper.attributes or wrapper.children or node.text.strip()
            ):
                lifted.append(node)
                continue
            lifted.extend(wrapper.take_children(inner))
            yield wrapper
        if lifted:
            self.children[name] = lifted


@dataclass(slots=True, eq=False)
class PublishedFile(ModelFile):
    """A model of a published file, checked as a file of its own; ``found`` follows references."""

    found: Callable[[str], Node | None] = field(kw_only=True, repr=False)

    def find(self, fragment: str) -> Node | None:
        """Return the node that a fragment means anywhere in the published file."""
        return self.found(fragment)


class PublishedReader:
    """Reads the elements of one published file, of which those with an xmi:id are ``by_xmi_id``.

    ``origins`` gets the node of the file for every node that is made. What cannot be carried over
    is noted as it is read.
    """

    def __init__(self, root: Node, origins: dict[Any, Node], report: Report, notes: Notes) -> None:
        self._origins = origins
        self._root = root
        self._report = report
        self._notes = notes
        self._read: dict[Node, Node] = {}
        self._elsewhere: list[Reference] = []
        self._checked_xmi_ids: dict[str, Node] = {}
        self.by_xmi_id: dict[str, Node] = {}
        self._by_id: dict[str, list[Node]] = {}
        for node in root.walk():
            if "ID" in node.attributes:
                self._by_id.setdefault(node.attributes["ID"], []).append(node)
            if node.xmi_id is not None:
                self.by_xmi_id.setdefault(node.xmi_id, node)

    def model(self, node: Node, metaclass: Any) -> Node:
        """Return the root of a model, without the areas and coordinates that it refers to."""
        root = _made(node, metaclass.name, None)
        root.namespace = metaclass.ePackage.nsURI
        return self._element(root, node, metaclass)

    def copy_elsewhere(self, root: Node) -> None:
        """Copy areas and coordinates that are referred to; report what stands in other files."""
        tree = ModelTree(root, self._files(root), references=self._elsewhere)
        resolve(tree, None, self._report)
        points_first = sorted(tree.resolved, key=lambda each: each[0].slot.type.name == "Area")
        for reference, targets in points_first:
            if reference.slot.type.name in _COPIED:
                for target in targets:
                    self._copy(target, reference.source, reference.slot.name, reference.node)

    def checked(self, root: Node) -> ModelTree:
        """Return a model whose nodes were checked as those of any other; report what is wrong."""
        files = self._files(root)
        tree = check_structure(files.containing(root), root.metaclass, files, self._report)
        assert tree is not None  # the root is of that class
        resolve(tree, None, self._report)
        return tree

    def _files(self, root: Node) -> ModelFiles:
        """Return the one file of a model; xmi:ids are unique over all models."""
        ids = self._checked_xmi_ids
        file = PublishedFile(root.path, Spelling("UTF-8"), (root,), by_xmi_id=ids, found=self._find)
        return ModelFiles(self._report, file)

    def drop_rest(self) -> None:
        """Note what of the root is not carried over."""
        given = _Given(self._root)
        for name in ("mission", "specification"):
            given.take_children(name)
        self._drop(given, "")

    def _copy(self, target: Node, parent: Node, tag: str, node: Node) -> None:
        made = self._add(parent, node, tag)
        made.metaclass = target.metaclass
        made.attributes = {name: text for name, text in target.attributes.items() if name != "ID"}
        for child in target.children:
            self._copy(child, made, child.tag, node)

    def _add(self, parent: Node, node: Node, tag: str, text: str = "") -> Node:
        """Add a child to a node that was made, and remember where it comes from."""
        made = _made(node, tag, parent, text=text)
        self._origins[made] = node
        parent.children.append(made)
        return made

    def _element(self, made: Node, node: Node, metaclass: Any) -> Node:
        """Give a node what the file says of an element, and all that it contains."""
        made.metaclass = metaclass
        made.prefixes = {"": metaclass.ePackage.nsURI}
        if node.xmi_id is not None:
            made.qualified[XMI, "id"] = node.xmi_id
        self._origins[made] = node
        self._read[node] = made
        given = self._given(node, metaclass.name)
        for slot in slots(metaclass).values():
            if slot.name == "task":
                self._tasks(made, slot, given)
            if slot.is_contained:
                self._parts(made, slot, given)
            elif slot.is_reference:
                self._refer(made, slot, given)
            else:
                self._values(made, slot, given)
        self._drop(given, metaclass.name)
        return made

    def _given(self, node: Node, class_name: str) -> _Given:
        """Return what the file says of an element, in features of the names and depth of ours."""
        given = _Given(node)
        for old, new in RENAMED.get(class_name, {}).items():
            given.rename(old, new)
        for name, inner in WRAPPED.get(class_name, {}).items():
            for wrapper in given.unwrap(name, inner):
                self._drop(wrapper, "")
        return given

    def _tasks(self, goal: Node, slot: Slot, given: _Given) -> None:
        """Take the one of nine containments that the old format has in place of a class."""
        known = concrete_classes(slot.type.ePackage, slot.type)
        for node in given.take_children(slot.name):
            wrapper = _Given(node)
            names = {tag: tag[:1].upper() + tag[1:] for tag in wrapper.children}
            for tag in [tag for tag, name in names.items() if name in known]:
                for child in wrapper.take_children(tag):
                    self._part(goal, slot, child, names[tag])
            if len(wrapper.children) < len(names):
                self._drop(wrapper, "")
            else:
                given.children.setdefault(slot.name, []).append(node)

    def _parts(self, made: Node, slot: Slot, given: _Given) -> None:
        is_copied = slot.type.name in _COPIED
        text = given.attributes.pop(slot.name, "")
        if text and is_copied:
            self._elsewhere.append(Reference(made, slot, given.node, tuple(text.split())))
        elif text:
            made.attributes[slot.name] = text
        for child in given.take_children(slot.name):
            href = child.attributes.get("href")
            if href is None:
                self._part(made, slot, child)
                continue
            self._elsewhere.append(Reference(made, slot, child, (href,)))
            if not is_copied:
                self._add(made, child, slot.name).attributes["href"] = href

    def _part(self, made: Node, slot: Slot, child: Node, name: str = "") -> None:
        """Add what an element contains, of the class that is named, here or by its xsi:type."""
        part = self._add(made, child, slot.name)
        if name := name or (child.xsi_type or "").rpartition(":")[2]:
            part.qualified[XSI, "type"] = name
        known = concrete_classes(slot.type.ePackage, slot.type)
        self._element(part, child, known.get(name, slot.type))

    def _refer(self, made: Node, slot: Slot, given: _Given) -> None:
        if slot.name in given.attributes:
            made.attributes[slot.name] = given.attributes.pop(slot.name)
        for child in given.take_children(slot.name):
            rest = _Given(child)
            href = rest.attributes.pop("href", None)
            for target in (child.text.split() or [""]) if href is None else [href]:
                self._add(made, child, slot.name).attributes["href"] = target
            self._drop(rest, "")
        if slot.name not in made.attributes and not made.tagged(slot.name):
            self._report_older(made, slot.name, given)

    def _values(self, made: Node, slot: Slot, given: _Given) -> None:
        """Take the values of an attribute, of which those that are elements may become one."""
        children = given.take_children(slot.name)
        texts = [child.text.strip() for child in children]
        text = given.attributes.pop(slot.name, None)
        if text is None and texts and not slot.many:
            text = texts[0]
            self._drop(_Given(children.pop(0)), "")
        elif text is None and not texts and not slot.is_id:
            text = self._default(made, slot, given.node)
        if text is not None:
            made.attributes[slot.name] = _whole(text) if slot.type.name == "EInt" else text
        for child in children:
            self._add(made, child, slot.name, child.text.strip())
            self._drop(_Given(child), "")

    def _report_older(self, made: Node, name: str, given: _Given) -> None:
        """Report a fault that strikes something else than its type does here, if this is one."""
        for other in (*given.attributes, *given.children):
            if name.startswith(_AFFECTED) and other.startswith(_AFFECTED):
                finding = f"has {other}, so that the file is of an older metamodel; expected {name}"
                self._report.add(made, "KnownFeature", f"{finding}; correct it")

    def _default(self, made: Node, slot: Slot, node: Node) -> str | None:
        """Return and note what an absent attribute means; ``None`` if it stays unset."""
        if slot.name in OPTIONAL or slot.name.endswith(BOUNDS):
            return None
        special = DEFAULTS.get((made.metaclass.name, slot.name))
        if special is not None:
            text, meaning = special(self._duration()), "; set to {}"
        elif slot.type.name in USUAL and made.metaclass.name != "MessageData":
            text = USUAL[slot.type.name]
            meaning = ", which means {} in Eclipse" if text else ", which means empty"
        else:
            return None
        self._notes.add("default", node, slot.name, f"is absent{meaning.format(text)}")
        return text

    def _duration(self) -> int:
        """Return what the mission lasts, which is read before all else; 0 if that is wrong."""
        text = next(iter(self._origins)).attributes.get("duration", "")
        return int(text) if text.isdecimal() else 0

    def _find(self, fragment: str) -> Node | None:
        """Return what became of a node: by xmi:id, path, or an ID that only one element has."""
        found = self.by_xmi_id.get(fragment)
        if found is None and fragment.startswith("/"):
            found = follow(self._root, fragment.partition("/")[2].partition("/")[2])
        elif found is None:
            named = self._by_id.get(fragment, [])
            found = named[0] if len(named) == 1 else None
        return None if found is None else self._read.get(found)

    def _drop(self, given: _Given, class_name: str) -> None:
        node = given.node
        for name, text in given.attributes.items():
            self._drop_attribute(node, name, text, class_name)
        for (namespace, name), text in node.qualified.items():
            if namespace != XMI and (namespace, name) != (XSI, "type") and node.parent is not None:
                self._notes.add("dropped", node, name, f"belongs to no model ({shown(text)})")
        for child in [child for kept in given.children.values() for child in kept]:
            is_ours = child.namespace in NAMESPACES
            what = "that is not known here" if is_ours else "of another namespace"
            self._notes.add("dropped", child, child.tag, f"is an element {what}")
        if node.text.strip() and class_name:
            message = f"is text between elements ({shown(node.text.strip())})"
            self._notes.add("dropped", node, "text", message)

    def _drop_attribute(self, node: Node, name: str, text: str, class_name: str) -> None:
        reason, contradiction = f"is not known here ({shown(text)})", ""
        if name in BACK_REFERENCES:
            reason, contradiction = "repeats the container's ID", _misplaced(node, text)
        elif name in ZERO_VALUES and class_name.startswith("Zero"):
            reason = "is zero by the type of the fault"
            if not _ZERO.fullmatch(text.strip()):
                contradiction = f"is {shown(text)} in a fault of type {class_name}; read as zero"
        elif name == "ID":
            reason = "nothing refers to the element by ID"
        self._notes.add("dropped", node, name, reason)
        if contradiction:
            self._notes.add("inconsistent", node, name, contradiction)


def _misplaced(node: Node, container_id: str) -> str:
    """Return how an element's container contradicts what it says of it; empty if it does not."""
    known = () if node.parent is None else (node.parent.attributes.get("ID"), node.parent.xmi_id)
    if node.parent is None or not any(known) or container_id in known:
        return ""
    return f"is {shown(container_id)}, but {node.parent.description} contains it; kept it there"


def _made(node: Node, tag: str, parent: Node | None, text: str = "") -> Node:
    return Node(node.path, node.line, "", tag, parent, node.prefixes, text=text)


def _whole(text: str) -> str:
    """Return a whole number as integers are written: Java writes a double of 1000 as 1000.0."""
    number = float(text) if DOUBLE.fullmatch(text) else 0.5
    return str(int(number)) if number.is_integer() and abs(number) < _EXACT else text
