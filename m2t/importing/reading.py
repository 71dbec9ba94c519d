"""Turn the nodes of a published file into objects of our metamodels.

It is an XMI file, whose root ``Setup`` holds a mission and fault specifications. Most features
have the names of ours; the tables have those that differ, and what to put where the old format
says nothing.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from m2t.check.attribute_values import require_value
from m2t.check.structure import Reference, report_count
from m2t.diagnostics import Defect, Report, shown
from m2t.importing.notes import Notes
from m2t.metaclasses import Slot, concrete_classes, conforms, copies, put, slots, values
from m2t.metamodel_contract import BOUNDS
from m2t.read.nodes import XMI, Node, follow

SETUP_NAMESPACE = "acs_project_setup"
NAMESPACES = frozenset({"", SETUP_NAMESPACE, "acs_project_mission", "acs_project_fault"})
ROOT = "Setup"

RENAMED: Mapping[str, Mapping[str, str]] = {"Message": {"from": "sender", "to": "receiver"}}
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


class _Given:
    """What a file says of an element; what is taken is gone, and the rest gets dropped."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.attributes = dict(node.attributes)
        self.children: dict[str, list[Node]] = {}
        for child in node.children:
            name = child.tag if child.namespace in NAMESPACES else f"{child.namespace} {child.tag}"
            self.children.setdefault(name, []).append(child)

    def take_text(self, name: str) -> str | None:
        """Return an attribute, which may be written as an element."""
        text = self.attributes.pop(name, None)
        if text is None and name in self.children:
            text = self.children.pop(name)[0].text.strip()
        return text

    def take_children(self, name: str) -> list[Node]:
        return self.children.pop(name, [])

    def rename(self, old: str, new: str) -> None:
        places: tuple[dict[str, Any], dict[str, Any]] = (self.attributes, self.children)
        for kept in places:
            if old in kept:
                kept[new] = kept.pop(old)

    def unwrap(self, name: str, inner: str) -> Iterator["_Given"]:
        """Lift what a wrapper holds; yield the wrapper with what is left."""
        lifted: list[Node] = []
        for node in self.take_children(name):
            wrapper = _Given(node)
            if inner in wrapper.attributes:
                texts = (self.attributes.get(name, ""), wrapper.attributes.pop(inner))
                self.attributes[name] = " ".join(texts).strip()
            elif inner not in wrapper.children and (wrapper.attributes or wrapper.children):
                lifted.append(node)
                continue
            lifted.extend(wrapper.take_children(inner))
            yield wrapper
        if lifted:
            self.children[name] = lifted


class PublishedReader:
    """Reads the elements of one published file, of which those with an xmi:id are ``by_xmi_id``.

    ``origins`` gets the node of every object that is made, ``own_ids`` the ID that the file gives
    it, if any. What cannot be carried over is reported as it is read, what is missing by
    ``require_all``.
    """

    def __init__(self, root: Node, origins: dict[Any, Node], report: Report, notes: Notes) -> None:
        self._origins = origins
        self.own_ids: dict[Any, str] = {}
        self._root = root
        self._report = report
        self._notes = notes
        self._objects: dict[Node, Any] = {}
        self._references: list[Reference] = []
        self.by_xmi_id: dict[str, Node] = {}
        self._by_id: dict[str, list[Node]] = {}
        for node in root.walk():
            if "ID" in node.attributes:
                self._by_id.setdefault(node.attributes["ID"], []).append(node)
            if (identity := node.xmi_id) is None:
                continue
            first = self.by_xmi_id.setdefault(identity, node)
            if first is not node:
                finding = (
                    f"has xmi:id {shown(identity)}, as has an element in line {first.line}; "
                    "expected different ones, because references use them; change one"
                )
                report.add(node, "UniqueId", finding)

    def element(self, node: Node, metaclass: Any) -> Any:
        """Return an object with all that it contains; references stay open."""
        instance = metaclass()
        self._origins[instance] = node
        self._objects[node] = instance
        given = _Given(node)
        for old, new in RENAMED.get(metaclass.name, {}).items():
            given.rename(old, new)
        for name, inner in WRAPPED.get(metaclass.name, {}).items():
            for wrapper in given.unwrap(name, inner):
                self._drop(wrapper, "")
        for slot in slots(metaclass).values():
            self._feature(instance, slot, given)
        self._drop(given, metaclass.name)
        return instance

    def resolve(self) -> None:
        """Resolve all references; copy areas and coordinates that are referred to."""
        for reference in self._references:
            instance, slot = self._objects[reference.source], reference.slot
            found = [self._target(reference, text) for text in reference.targets]
            targets = [target for target in found if target is not None]
            if len(targets) > 1 and not slot.many:
                report_count(reference.node, slot, len(targets), self._report)
                continue
            if slot.is_contained:
                targets = [self._copied(target, reference.node) for target in targets]
            elif len(set(targets)) < len(targets):
                message = "names an element more than once; kept once"
                self._notes.add("inconsistent", reference.node, slot.name, message)
            for target in dict.fromkeys(targets):
                put(instance, slot, target)

    def _copied(self, target: Any, node: Node) -> Any:
        made = copies([target])
        self._origins |= dict.fromkeys(made.values(), node)
        return made[target]

    def require_all(self, element: Any) -> None:
        """Report what the metamodel requires of an element and the file does not give."""
        for slot in slots(element.eClass).values():
            is_given = slot.many or element.eIsSet(slot.feature)
            count = len(values(element, slot)) if is_given else 0
            if count < slot.lower_bound:
                report_count(element, slot, count, self._report)

    def drop_rest(self) -> None:
        """Note what of the root is not carried over."""
        given = _Given(self._root)
        for name in ("mission", "specification"):
            given.take_children(name)
        self._drop(given, "")

    def _feature(self, instance: Any, slot: Slot, given: _Given) -> None:
        if slot.name == "task":
            self._task(instance, slot, given)
        elif slot.holds_elements:
            self._elements(instance, slot, given)
        elif not slot.is_id:
            self._attribute(instance, slot, given)
        elif (own := given.take_text(slot.name)) is not None:
            self.own_ids[instance] = own

    def _task(self, goal: Any, slot: Slot, given: _Given) -> None:
        """Take the one of nine containments that the old format has in place of a class."""
        known = concrete_classes(slot.type.ePackage, slot.type)
        wrappers = [_Given(node) for node in given.take_children(slot.name)]
        tasks = [
            (child, known[name])
            for wrapper in wrappers
            for tag in list(wrapper.children)
            if (name := tag[:1].upper() + tag[1:]) in known
            for child in wrapper.take_children(tag)
        ]
        for wrapper in wrappers:
            self._drop(wrapper, "")
        if len(tasks) > 1:
            listed = ", ".join(child.tag for child, _ in tasks)
            finding = f"has {len(tasks)} tasks ({listed}); expected one; delete the others"
            self._report.add(given.node, "SingleValue", finding)
        for child, metaclass in tasks[:1]:
            put(goal, slot, self.element(child, metaclass))

    def _elements(self, instance: Any, slot: Slot, given: _Given) -> None:
        parts = given.take_children(slot.name)
        if slot.is_reference or slot.type.name in _COPIED:
            links = [child for child in parts if slot.is_reference or "href" in child.attributes]
            parts = [child for child in parts if child not in links]
            texts = given.attributes.pop(slot.name, "").split()
            texts += [child.attributes.get("href", child.text.strip()) for child in links]
            self._references.append(Reference(given.node, slot, given.node, tuple(texts)))
        if len(parts) > 1 and not slot.many:
            report_count(given.node, slot, len(parts), self._report)
        for child in parts if slot.many else parts[:1]:
            put(instance, slot, self.element(child, slot.type))

    def _attribute(self, instance: Any, slot: Slot, given: _Given) -> None:
        text = given.take_text(slot.name)
        text = self._default(instance, slot, given.node) if text is None else text
        if text is None:
            return
        text = _whole(text) if slot.type.name == "EInt" else text
        try:
            require_value(slot, text)
        except Defect as defect:
            self._report.add(given.node, defect.constraint, defect.finding)
            return
        put(instance, slot, slot.type.from_string(text))

    def _default(self, instance: Any, slot: Slot, node: Node) -> str | None:
        """Return and note what an absent attribute means; ``None`` if it stays unset."""
        if slot.name in OPTIONAL or slot.name.endswith(BOUNDS):
            return None
        special = DEFAULTS.get((instance.eClass.name, slot.name))
        if special is not None:
            text, meaning = special(self._duration()), "; set to {}"
        elif slot.type.name in USUAL and instance.eClass.name != "MessageData":
            text = USUAL[slot.type.name]
            meaning = ", which means {} in Eclipse" if text else ", which means empty"
        else:
            return None
        self._notes.add("default", node, slot.name, f"is absent{meaning.format(text)}")
        return text

    def _duration(self) -> int:
        """Return what the mission lasts, which is read before all else; 0 if that is wrong."""
        return int(next(iter(self._origins)).duration)

    def _target(self, reference: Reference, text: str) -> Any:
        """Return the object that a reference leads to; ``None`` after a report."""
        node = self._find(text.rpartition("#")[2])
        target = None if node is None else self._objects.get(node)
        wanted = reference.slot.type
        if target is not None and conforms(target.eClass, wanted):
            return target
        constraint, found = "ResolvedReference", "no element of the file"
        if target is not None:
            constraint, found = "ReferenceType", f"a {target.eClass.name}"
        finding = (
            f"refers to {shown(text)} as {reference.slot.name}, which is {found}; expected the "
            f"xmi:id of a {wanted.name}; correct the reference"
        )
        self._report.add(reference.node, constraint, finding)
        return None

    def _find(self, fragment: str) -> Node | None:
        """Return a node by xmi:id, by path of Eclipse, or by an ID that only one element has."""
        if fragment in self.by_xmi_id:
            return self.by_xmi_id[fragment]
        if fragment.startswith("/"):
            return follow(self._root, fragment.partition("/")[2].partition("/")[2])
        known = self._by_id.get(fragment, [])
        return known[0] if len(known) == 1 else None

    def _drop(self, given: _Given, class_name: str) -> None:
        node = given.node
        for name, text in given.attributes.items():
            self._drop_attribute(node, name, text, class_name)
        for (namespace, name), text in node.qualified.items():
            if namespace != XMI and node.parent is not None:
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


def _whole(text: str) -> str:
    """Return a whole number without its fraction, as an integer has none: 1000.0 is 1000."""
    head, point, fraction = text.partition(".")
    return text if not point or fraction.strip("0") else head
