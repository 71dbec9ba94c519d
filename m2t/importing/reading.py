"""Turn the nodes of a published file into objects of our metamodels."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from m2t.check.attribute_values import require_value
from m2t.check.structure import report_count
from m2t.diagnostics import Defect, Report, shown
from m2t.elements import copies, put, values
from m2t.importing.notes import Notes
from m2t.importing.published import (
    BACK_REFERENCES,
    DEFAULTS,
    NAMESPACES,
    OPTIONAL,
    RENAMED,
    WRAPPED,
    ZERO_VALUES,
)
from m2t.metamodels import Slot, concrete_classes, conforms, slots
from m2t.namespaces import XMI
from m2t.read.nodes import Node, follow

_ZERO = re.compile(r"[+-]?(0*\.?0*)", re.ASCII)
_COPIED = ("Area", "Coordinates")
"""Classes whose elements are copied where the old format refers to one."""


class _Given:
    """What a file says of an element; what is taken is gone, and the rest gets dropped."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.attributes = dict(node.attributes)
        self.children: dict[str, list[Node]] = {}
        self.strangers: list[Node] = []
        for child in node.children:
            if child.namespace and child.namespace not in NAMESPACES:
                self.strangers.append(child)
            else:
                self.children.setdefault(child.tag, []).append(child)

    def take_text(self, name: str) -> str | None:
        """Return an attribute, which may be written as an element."""
        text = self.attributes.pop(name, None)
        if text is None and name in self.children:
            text = self.children.pop(name)[0].text.strip()
        return text

    def take_children(self, name: str) -> list[Node]:
        return self.children.pop(name, [])

    def rename(self, old: str, new: str) -> None:
        if old in self.attributes:
            self.attributes[new] = self.attributes.pop(old)
        if old in self.children:
            self.children[new] = self.children.pop(old)

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


@dataclass(frozen=True, slots=True)
class _Pending:
    """A reference to resolve once all elements are read."""

    instance: Any
    slot: Slot
    node: Node
    targets: tuple[str, ...]


class PublishedReader:
    """Reads the elements of one published file.

    Attributes
    ----------
    origins
        Node of every object that was made.
    own_ids
        The ID that the file gives an object, if it gives one.
    n_xmi_ids
        Number of elements with an xmi:id.

    Notes
    -----
    What cannot be carried over is reported as it is read, what is missing by ``require_all``.
    """

    def __init__(self, root: Node, duration: int, report: Report, notes: Notes) -> None:
        self.origins: dict[Any, Node] = {}
        self.own_ids: dict[Any, str] = {}
        self._root = root
        self._duration = duration
        self._report = report
        self._notes = notes
        self._objects: dict[Node, Any] = {}
        self._pending: list[_Pending] = []
        self._by_xmi_id: dict[str, Node] = {}
        self._by_id: dict[str, list[Node]] = {}
        for node in root.walk():
            self._remember(node)

    @property
    def n_xmi_ids(self) -> int:
        """Number of elements with an xmi:id."""
        return len(self._by_xmi_id)

    def _remember(self, node: Node) -> None:
        if "ID" in node.attributes:
            self._by_id.setdefault(node.attributes["ID"], []).append(node)
        identity = node.xmi_id
        if identity is None:
            return
        first = self._by_xmi_id.setdefault(identity, node)
        if first is not node:
            self._report.add(
                node,
                "UniqueId",
                f"has xmi:id {shown(identity)}, as has an element in line {first.line}; expected "
                "different ones, because references use them; change one",
            )

    def element(self, node: Node, metaclass: Any) -> Any:
        """Return an object with all that it contains; references stay open."""
        instance = metaclass()
        self.origins[instance] = node
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
        for pending in self._pending:
            found = [self._target(pending, target) for target in pending.targets]
            targets = [target for target in found if target is not None]
            if len(targets) > 1 and not pending.slot.many:
                report_count(pending.node, pending.slot, len(targets), self._report)
            elif pending.slot.is_contained:
                for target in targets:
                    made = copies([target])
                    self.origins |= dict.fromkeys(made.values(), pending.node)
                    put(pending.instance, pending.slot, made[target])
            else:
                self._refer(pending, targets)

    def require_all(self, element: Any) -> None:
        """Report what the metamodel requires of an element and the file does not give."""
        for slot in slots(element.eClass).values():
            is_given = slot.many or element.eIsSet(slot.feature)
            count = len(values(element, slot)) if is_given else 0
            if count < slot.lower_bound:
                report_count(self.origins[element], slot, count, self._report)

    def drop_rest(self, node: Node, used: Iterable[str]) -> None:
        """Note what of the root is not carried over."""
        given = _Given(node)
        for name in used:
            given.take_children(name)
        self._drop(given, "")

    def _feature(self, instance: Any, slot: Slot, given: _Given) -> None:
        if slot.name == "task":
            self._task(instance, slot, given)
        elif slot.is_contained:
            self._contain(instance, slot, given)
        elif slot.is_reference:
            texts = given.attributes.pop(slot.name, "").split()
            texts.extend(_href(child) for child in given.take_children(slot.name))
            self._pending.append(_Pending(instance, slot, given.node, tuple(texts)))
        elif slot.is_id:
            own = given.take_text(slot.name)
            if own is not None:
                self.own_ids[instance] = own
        else:
            self._attribute(instance, slot, given)

    def _task(self, goal: Any, slot: Slot, given: _Given) -> None:
        """Take the one of nine containments that the old format has in place of a class."""
        tasks = []
        known = concrete_classes(slot.type.ePackage, slot.type)
        for node in given.take_children(slot.name):
            wrapper = _Given(node)
            for tag in list(wrapper.children):
                metaclass = known.get(tag[:1].upper() + tag[1:])
                if metaclass is not None:
                    tasks += [(child, metaclass) for child in wrapper.take_children(tag)]
            self._drop(wrapper, "")
        if len(tasks) > 1:
            listed = ", ".join(child.tag for child, _ in tasks)
            finding = f"has {len(tasks)} tasks ({listed}); expected one; delete the others"
            self._report.add(given.node, "SingleValue", finding)
        for child, metaclass in tasks[:1]:
            put(goal, slot, self.element(child, metaclass))

    def _contain(self, instance: Any, slot: Slot, given: _Given) -> None:
        children = given.take_children(slot.name)
        wanted = slot.type
        if wanted.name in _COPIED:
            texts = given.attributes.pop(slot.name, "").split()
            texts += [_href(child) for child in children if "href" in child.attributes]
            self._pending.append(_Pending(instance, slot, given.node, tuple(texts)))
            children = [child for child in children if "href" not in child.attributes]
        if len(children) > 1 and not slot.many:
            report_count(given.node, slot, len(children), self._report)
        for child in children if slot.many else children[:1]:
            put(instance, slot, self.element(child, wanted))

    def _attribute(self, instance: Any, slot: Slot, given: _Given) -> None:
        text = given.take_text(slot.name)
        if text is None:
            text = self._default(instance, slot, given.node)
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
        name = slot.name
        if name in OPTIONAL or name.endswith(("_MIN", "_MAX")) or name == "name":
            return None
        special = DEFAULTS.get((instance.eClass.name, name))
        if special is not None:
            text = special(self._duration)
            self._notes.add("default", node, name, f"is absent; set to {text}")
            return text
        usual = {"EDouble": "0.0", "EInt": "0", "EString": ""}.get(slot.type.name)
        if usual is not None and instance.eClass.name != "MessageData":
            meaning = f"{usual} in Eclipse" if usual else "empty"
            self._notes.add("default", node, name, f"is absent, which means {meaning}")
            return usual
        return None

    def _target(self, pending: _Pending, text: str) -> Any:
        """Return the object that a reference leads to; ``None`` after a report."""
        node = self._find(text.rpartition("#")[2])
        target = None if node is None else self._objects.get(node)
        wanted = pending.slot.type
        if target is None:
            self._add_error(
                pending,
                "ResolvedReference",
                f"refers to {shown(text)} as {pending.slot.name}, which is no element of the "
                f"file; expected the xmi:id of a {wanted.name}",
            )
        elif not conforms(target.eClass, wanted):
            self._add_error(
                pending,
                "ReferenceType",
                f"refers to {shown(text)} as {pending.slot.name}, which is a "
                f"{target.eClass.name}; expected a {wanted.name}",
            )
            return None
        return target

    def _find(self, fragment: str) -> Node | None:
        """Return a node by xmi:id, by path of Eclipse, or by an ID that only one element has."""
        if fragment in self._by_xmi_id:
            return self._by_xmi_id[fragment]
        if fragment.startswith("/"):
            return follow(self._root, fragment.partition("/")[2].partition("/")[2])
        known = self._by_id.get(fragment, [])
        return known[0] if len(known) == 1 else None

    def _refer(self, pending: _Pending, targets: list[Any]) -> None:
        distinct = list(dict.fromkeys(targets))
        if len(distinct) < len(targets):
            message = "names an element more than once; kept once"
            self._notes.add("inconsistent", pending.node, pending.slot.name, message)
        for target in distinct:
            put(pending.instance, pending.slot, target)

    def _add_error(self, pending: _Pending, constraint: str, finding: str) -> None:
        self._report.add(pending.node, constraint, f"{finding}; correct the reference")

    def _drop(self, given: _Given, class_name: str) -> None:
        """Note all that is left of an element."""
        node = given.node
        for name, text in given.attributes.items():
            self._drop_attribute(node, name, text, class_name)
        for (namespace, name), text in node.qualified.items():
            if namespace != XMI and node.parent is not None:
                self._notes.add("dropped", node, name, f"belongs to no model ({shown(text)})")
        for child in [child for kept in given.children.values() for child in kept]:
            self._notes.add("dropped", child, child.tag, "is an element that is not known here")
        for child in given.strangers:
            self._notes.add("dropped", child, child.tag, "is an element of another namespace")
        if node.text.strip() and class_name:
            message = f"is text between elements ({shown(node.text.strip())})"
            self._notes.add("dropped", node, "text", message)

    def _drop_attribute(self, node: Node, name: str, text: str, class_name: str) -> None:
        if name in BACK_REFERENCES:
            self._notes.add("dropped", node, name, "repeats the container's ID")
            self._compare_with_container(node, name, text)
        elif name in ZERO_VALUES and class_name.startswith("Zero"):
            self._notes.add("dropped", node, name, "is zero by the type of the fault")
            if not _ZERO.fullmatch(text.strip()):
                message = f"is {shown(text)} in a fault of type {class_name}; read as zero"
                self._notes.add("inconsistent", node, name, message)
        elif name == "ID":
            self._notes.add("dropped", node, name, "nothing refers to the element by ID")
        else:
            self._notes.add("dropped", node, name, f"is not known here ({shown(text)})")

    def _compare_with_container(self, node: Node, name: str, text: str) -> None:
        container = node.parent
        if container is None:
            return
        known = (container.attributes.get("ID"), container.xmi_id)
        if any(known) and text not in known:
            message = f"is {shown(text)}, but {container.description} contains it; kept it there"
            self._notes.add("inconsistent", node, name, message)


def _href(child: Node) -> str:
    return child.attributes.get("href", child.text.strip())


def _whole(text: str) -> str:
    """Return a whole number without its fraction, as an integer has none: 1000.0 is 1000."""
    head, point, fraction = text.partition(".")
    return text if not point or fraction.strip("0") else head
