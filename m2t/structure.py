"""Check the nodes of a file against its metamodel, and report all that it forbids.

pyecore's reader lets most defects pass and stops at the first of the others, so every node
is checked before pyecore loads the file.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from m2t.diagnostics import shown
from m2t.document import Node, Report
from m2t.metamodels import conforms, features, is_contained, is_reference, reference_type
from m2t.values import BadValueError, require_value

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"

_SHOWN_ALTERNATIVES = 12


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference as text: ``targets`` are fragments, or file and fragment.

    ``source`` is the node that refers; ``node`` is that which holds the text: the same, or a
    child with an href.
    """

    source: Node
    feature: Any
    node: Node
    targets: tuple[str, ...]


@dataclass(slots=True)
class ModelTree:
    """The nodes of one file, each with its metaclass, and the references between them.

    ``resolved`` has the nodes that each reference leads to, once it is known to lead there.
    ``is_sound`` says whether the file keeps all constraints of structure.
    """

    root: Node
    by_id: dict[str, Node] = field(default_factory=dict)
    by_xmi_id: dict[str, Node] = field(default_factory=dict)
    references: list[Reference] = field(default_factory=list)
    resolved: list[tuple[Reference, tuple[Node, ...]]] = field(default_factory=list)
    is_sound: bool = False


def check_structure(root: Node, package: Any, class_name: str, report: Report) -> ModelTree | None:
    """Check the nodes of a file and give each its metaclass.

    Parameters
    ----------
    root
        Root element of the document.
    package
        The metamodel.
    class_name
        Class that the root has to have.
    report
        Takes the diagnostics.

    Returns
    -------
    ModelTree or None
        What is known of the file; ``None`` if the root is not of that class.
    """
    if (root.namespace, root.tag) != (package.nsURI, class_name):
        found = f"{{{root.namespace}}}{root.tag}" if root.namespace else root.tag
        report.add(
            root,
            "RootElement",
            f"is the root ({shown(found)}); expected {class_name} of namespace {package.nsURI}; "
            "correct the root or give the right file",
        )
        return None
    checker = _Checker(ModelTree(root), package, report)
    checker.element(root, package.getEClassifier(class_name))
    return checker.tree


@dataclass(frozen=True, slots=True)
class _Element:
    """An element being checked: ``given`` counts what the file gives of each feature."""

    node: Node
    features: Mapping[str, Any]
    given: Counter[str] = field(default_factory=Counter)


class _Checker:
    """Walks the nodes of one file."""

    def __init__(self, tree: ModelTree, package: Any, report: Report) -> None:
        self.tree = tree
        self._package = package
        self._report = report
        self._features: dict[Any, Mapping[str, Any]] = {}

    def element(self, node: Node, metaclass: Any) -> None:
        """Check one node with everything that it contains."""
        node.metaclass = metaclass
        element = _Element(node, self._features_of(metaclass))
        self._require_no_text(node)
        for name, text in node.attributes.items():
            self._attribute(element, name, text)
        self._qualified(node)
        for child in node.children:
            self._child(element, child)
        for feature in element.features.values():
            self._require_count(node, feature, element.given[feature.name])

    def _features_of(self, metaclass: Any) -> Mapping[str, Any]:
        if metaclass not in self._features:
            self._features[metaclass] = {feature.name: feature for feature in features(metaclass)}
        return self._features[metaclass]

    def _attribute(self, element: _Element, name: str, text: str) -> None:
        feature = element.features.get(name)
        if feature is None:
            self._unknown(element.node, f"has no attribute {shown(name)}", element, "attribute")
            return
        if is_reference(feature):
            targets = tuple(text.split())
            element.given[name] = len(targets)
            reference = Reference(element.node, feature, element.node, targets)
            self.tree.references.append(reference)
            return
        element.given[name] = 1
        if is_contained(feature):
            finding = (
                f"has {name} as an attribute; expected an element <{name}> in place; move it there"
            )
            self._report.add(element.node, "ContainedElement", finding)
            return
        self._value(element, feature, text)

    def _value(self, element: _Element, feature: Any, text: str) -> None:
        try:
            require_value(feature, text)
        except BadValueError as bad:
            self._report.add(element.node, bad.constraint, bad.finding)
            return
        if feature.iD:
            self._remember_id(element.node, text)

    def _remember_id(self, node: Node, identity: str) -> None:
        first = self.tree.by_id.setdefault(identity, node)
        if first is not node:
            self._report.add(
                node,
                "UniqueId",
                f"has the ID of {first.tag} in line {first.line}; expected IDs that are unique in "
                "the file, over all classes; rename one",
            )

    def _qualified(self, node: Node) -> None:
        """Check attributes of other namespaces: only those of XMI itself have a place."""
        for (namespace, name), text in node.qualified.items():
            if (namespace, name) == (XMI, "id"):
                self._remember_xmi_id(node, text)
            elif not _is_known_qualified(node, namespace, name):
                finding = (
                    f"has attribute {shown(f'{{{namespace}}}{name}')}, which belongs to no model; "
                    "expected attributes of the metamodel; delete it"
                )
                self._report.add(node, "KnownFeature", finding)

    def _remember_xmi_id(self, node: Node, identity: str) -> None:
        first = self.tree.by_xmi_id.setdefault(identity, node)
        if first is not node:
            self._report.add(
                node,
                "UniqueId",
                f"has xmi:id {shown(identity)}, as has an element in line {first.line}; expected "
                "different ones; change one",
            )

    def _child(self, element: _Element, child: Node) -> None:
        feature = element.features.get(child.tag) if not child.namespace else None
        if feature is None:
            finding = f"is an unknown element of {element.node.description}"
            self._unknown(child, finding, element, "element")
            return
        element.given[child.tag] += 1
        if is_contained(feature):
            self._contain(feature, child)
        elif is_reference(feature):
            self._refer(element.node, feature, child)
        else:
            self._value(element, feature, child.text)

    def _contain(self, feature: Any, child: Node) -> None:
        if "href" in child.attributes:
            finding = (
                f"refers to {shown(child.attributes['href'])}; expected the element itself in "
                "this place; move it here"
            )
            self._report.add(child, "ContainedElement", finding)
            return
        metaclass = self._concrete_type(feature, child)
        if metaclass is not None:
            self.element(child, metaclass)

    def _refer(self, source: Node, feature: Any, child: Node) -> None:
        target = child.attributes.get("href")
        if target is None or set(child.attributes) != {"href"} or child.children:
            finding = (
                "is a reference; expected nothing but href, such as "
                f'<{child.tag} href="mission.xmi#m1"/>; correct it'
            )
            self._report.add(child, "ContainedElement", finding)
            return
        self.tree.references.append(Reference(source, feature, child, (target,)))

    def _concrete_type(self, feature: Any, child: Node) -> Any:
        """Return the class of a contained element; ``None`` after a report."""
        declared = reference_type(feature)
        text = child.qualified.get((XSI, "type"))
        metaclass = declared if text is None else self._named_class(child, text)
        if metaclass is not None and not metaclass.abstract and conforms(metaclass, declared):
            return metaclass
        found = "no xsi:type" if text is None else f"xsi:type {shown(text)}"
        expected = ", ".join(
            f"{self._package.nsPrefix}:{kind.name}" for kind in self._concrete_classes(declared)
        )
        self._report.add(
            child, "ConcreteType", f"has {found}; expected one of {expected}; choose one"
        )
        return None

    def _named_class(self, node: Node, text: str) -> Any:
        prefix, colon, name = text.rpartition(":")
        if not colon or node.prefixes.get(prefix) != self._package.nsURI:
            return None
        found = self._package.getEClassifier(name)
        return found if hasattr(found, "eStructuralFeatures") else None

    def _concrete_classes(self, declared: Any) -> Iterator[Any]:
        for kind in self._package.eClassifiers:
            is_class = hasattr(kind, "eStructuralFeatures")
            if is_class and not kind.abstract and conforms(kind, declared):
                yield kind

    def _unknown(self, node: Node, finding: str, element: _Element, what: str) -> None:
        """Report a feature that the element's class does not have, and name those it has."""
        names = [
            name
            for name, feature in element.features.items()
            if is_contained(feature) == (what == "element")
        ]
        listed = ", ".join(names[:_SHOWN_ALTERNATIVES]) or f"no {what}s"
        more = ", ..." if len(names) > _SHOWN_ALTERNATIVES else ""
        finding = f"{finding}; expected {listed}{more}; correct or delete it"
        self._report.add(node, "KnownFeature", finding)

    def _require_no_text(self, node: Node) -> None:
        text = node.text.strip()
        if text:
            finding = f"holds the text {shown(text)}; expected attributes and elements; delete it"
            self._report.add(node, "NoText", finding)

    def _require_count(self, node: Node, feature: Any, count: int) -> None:
        name = feature.name
        if count < feature.lowerBound:
            expected = f"at least {feature.lowerBound}" if feature.many else "one"
            found = count or "no"
            finding = f"has {found} {name}; expected {expected}; add what is missing"
            self._report.add(node, "RequiredFeature", finding)
        elif not feature.many and count > 1:
            finding = f"has {count} {name}; expected one; delete the others"
            self._report.add(node, "SingleValue", finding)


def _is_known_qualified(node: Node, namespace: str, name: str) -> bool:
    if node.parent is None:
        return (namespace, name) in {
            (XMI, "version"),
            (XSI, "schemaLocation"),
            (XSI, "noNamespaceSchemaLocation"),
        }
    return (namespace, name) == (XSI, "type")
