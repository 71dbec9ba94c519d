"""Check the nodes of an ``.ecore`` file before pyecore loads it.

pyecore takes unknown types and bounds for granted, fails with exceptions of all kinds, and
finds some defects only when the metamodel is used.
"""

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from pyecore.ecore import EObject

from m2t.diagnostics import Report, shown
from m2t.metamodel_contract import CONTRACT, SUPERTYPES, Need
from m2t.metamodel_fault_types import FaultTypeReader
from m2t.namespaces import ECORE, XMI, XSI
from m2t.read.nodes import Node

if TYPE_CHECKING:
    from mrsfi_runtime.model.fault_types import FaultType

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_SWITCH = re.compile(r"true|false")
_COUNT = re.compile(r"-1|[0-9]{1,6}", re.ASCII)
_INTEGER = re.compile(r"-?[0-9]{1,9}", re.ASCII)
_NUMBER = re.compile(r"-?[0-9]{1,15}(\.[0-9]{1,15})?", re.ASCII)
_ANY = re.compile(r".*", re.DOTALL)
_SOME = re.compile(r".+", re.DOTALL)

VALUE_TYPES: Mapping[str, re.Pattern[str]] = MappingProxyType(
    {"EString": _ANY, "EInt": _INTEGER, "EDouble": _NUMBER, "EBoolean": _SWITCH}
)
"""Types of attributes beside enumerations, and what their defaults look like."""

_MAX_ANCESTORS = 50
_TAKEN_NAMES = frozenset(name for name in dir(EObject) if not name.startswith("_"))
_STORED: Mapping[str, str] = MappingProxyType(
    {**dict.fromkeys(("volatile", "transient", "derived"), "false"), "changeable": "true"}
)
_ECORE_TYPE = f"ecore:EDataType {ECORE}#//"

_FEATURE = {
    "name": _NAME,
    "eType": _SOME,
    "lowerBound": _COUNT,
    "upperBound": _COUNT,
    **dict.fromkeys(("ordered", "unique", "changeable", "volatile", "transient"), _SWITCH),
    **dict.fromkeys(("unsettable", "derived"), _SWITCH),
}
_ATTRIBUTES: Mapping[str, Mapping[str, re.Pattern[str]]] = MappingProxyType(
    {
        "EPackage": {"name": _NAME, "nsURI": _SOME, "nsPrefix": _NAME},
        "EClass": {
            "name": _NAME,
            "abstract": _SWITCH,
            "interface": _SWITCH,
            "eSuperTypes": _ANY,
            "instanceClassName": _SOME,
        },
        "EEnum": {"name": _NAME, "serializable": _SWITCH, "instanceClassName": _SOME},
        "EEnumLiteral": {"name": _NAME, "value": _INTEGER, "literal": _NAME},
        "EAttribute": {**_FEATURE, "iD": _SWITCH, "defaultValueLiteral": _ANY},
        "EReference": {
            **_FEATURE,
            "containment": _SWITCH,
            "resolveProxies": _SWITCH,
            "eOpposite": _SOME,
        },
        "EAnnotation": {"source": _ANY},
        "details": {"key": _ANY, "value": _ANY},
    }
)
_REQUIRED: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "EPackage": ("name", "nsURI", "nsPrefix"),
        **dict.fromkeys(("EClass", "EEnum", "EEnumLiteral"), ("name",)),
        **dict.fromkeys(("EAttribute", "EReference"), ("name", "eType")),
    }
)
_ANNOTATED = {"eAnnotations": ("EAnnotation",)}
_CHILDREN: Mapping[str, Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "EPackage": {**_ANNOTATED, "eClassifiers": ("EClass", "EEnum")},
        "EClass": {**_ANNOTATED, "eStructuralFeatures": ("EAttribute", "EReference")},
        "EEnum": {**_ANNOTATED, "eLiterals": ("EEnumLiteral",)},
        "EEnumLiteral": _ANNOTATED,
        "EAttribute": _ANNOTATED,
        "EReference": _ANNOTATED,
        "EAnnotation": {**_ANNOTATED, "details": ("details",)},
        "details": {},
    }
)


class MetamodelCheck:
    """Checks metamodel files one after the other; later ones may refer to earlier ones.

    Parameters
    ----------
    report
        Takes the diagnostics.

    Attributes
    ----------
    fault_types
        Those of the file that was checked last, by name.
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._classifiers: dict[str, Node] = {}
        self._kinds: dict[Node, str] = {}
        self.fault_types: Mapping[str, FaultType] = MappingProxyType({})

    def check(self, root: Node, name: str, root_class: str) -> None:
        """Check one file.

        Parameters
        ----------
        root
            Root element of the file.
        name
            Name that its package has to have.
        root_class
            Class that it has to have, that of the root of models.
        """
        if (root.namespace, root.tag) != (ECORE, "EPackage"):
            finding = f"is the root; expected EPackage of namespace {ECORE}; restore the file"
            self._report.add(root, "RootElement", finding)
            return
        self._element(root, "EPackage")
        if root.attributes.get("name") != name:
            finding = f"is the package; expected the name {name}; restore it"
            self._report.add(root, "RootElement", finding)
        self._check_names(root, "eClassifiers")
        for classifier in _named(root, "eClassifiers"):
            self._classifiers[f"{root.path.name}#//{classifier.attributes['name']}"] = classifier
        wanted = self._classifiers.get(f"{root.path.name}#//{root_class}")
        if wanted is None or wanted.attributes.get("abstract") == "true":
            finding = f"has no class {root_class} that models could begin with; restore it"
            self._report.add(root, "RequiredFeature", finding)
        for classifier in _named(root, "eClassifiers"):
            self._classifier(classifier)
        if not self._report.n_errors:
            self._check_contract(root, name)
            self._check_meanings(root, name)
        if not self._report.n_errors:
            self.fault_types = FaultTypeReader(self._lineage, self._report).read(root)

    def _check_contract(self, root: Node, package: str) -> None:
        """Check that the classes and features are there that code reads."""
        seen: set[Node] = set()
        for class_name, needs in CONTRACT[package].items():
            node = self._classifiers.get(f"{root.path.name}#//{class_name}")
            if node is None or self._kinds.get(node) != "EClass":
                finding = f"has no class {class_name}, which mrsfi reads; restore it"
                self._report.add(root, "RequiredFeature", finding)
                continue
            lineage = self._lineage(node)
            self._check_supertype(node, lineage, SUPERTYPES[package].get(class_name))
            features = {feature.attributes["name"]: feature for feature in _features(lineage)}
            for name, need in needs.items():
                feature = features.get(name)
                if feature is None:
                    finding = f"has no feature {name}; mrsfi reads {need} of that name; restore it"
                    self._report.add(node, "RequiredFeature", finding)
                elif feature not in seen and not self._meets(feature, need):
                    seen.add(feature)
                    finding = (
                        f"of {class_name} is read as {need}, which is not what it declares; "
                        "restore it"
                    )
                    self._report.add(feature, "RequiredFeature", finding)

    def _check_meanings(self, root: Node, package: str) -> None:
        """Check that code knows the elements of each class as one thing only."""
        for node in _named(root, "eClassifiers"):
            read = [
                known
                for known in self._lineage(node)
                if known.attributes["name"] in CONTRACT[package]
                and known.attributes.get("abstract") != "true"
            ]
            general = {known for other in read for known in self._ancestors(other)}
            names = [known.attributes["name"] for known in read if known not in general]
            if len(names) > 1:
                finding = (
                    f"inherits from {' and '.join(names)}, and mrsfi can know it as one of them "
                    "only; keep one"
                )
                self._report.add(node, "ConcreteType", finding)

    def _check_supertype(self, node: Node, lineage: Mapping[Node, None], name: str | None) -> None:
        if name is not None and name not in {known.attributes["name"] for known in lineage}:
            finding = f"does not inherit from {name}, on which mrsfi relies; restore eSuperTypes"
            self._report.add(node, "RequiredFeature", finding)

    def _meets(self, feature: Node, need: Need) -> bool:
        """Return whether a feature is declared as code reads it."""
        given = feature.attributes
        holding = "value"
        if self._kinds[feature] == "EReference":
            holding = "part" if given.get("containment") == "true" else "link"
        is_many = given.get("upperBound", "1") != "1"
        return (
            (holding, is_many) == (need.holding, need.is_many)
            and (given.get("iD") == "true") == need.is_id
            and int(given.get("lowerBound", "0")) >= need.n_least
            and need.type in self._type_names(feature)
        )

    def _type_names(self, feature: Node) -> set[str]:
        """Return the names of what a feature's values are: its type and the type's supertypes."""
        target = feature.attributes["eType"]
        classifier = self._target(feature, target)
        if classifier is None:
            return {target.removeprefix(_ECORE_TYPE)}
        return {known.attributes["name"] for known in self._lineage(classifier)}

    def _element(self, node: Node, kind: str) -> None:
        self._kinds[node] = kind
        if node.text.strip():
            finding = f"holds the text {shown(node.text.strip())}; expected none; delete it"
            self._report.add(node, "NoText", finding)
        for name in _REQUIRED.get(kind, ()):
            if name not in node.attributes:
                finding = f"has no {name}; every {kind} needs one; add it"
                self._report.add(node, "RequiredFeature", finding)
        self._attributes(node, kind)
        for child in node.children:
            self._child(node, kind, child)

    def _attributes(self, node: Node, kind: str) -> None:
        for name, text in node.attributes.items():
            pattern = _ATTRIBUTES[kind].get(name)
            if pattern is None:
                listed = ", ".join(_ATTRIBUTES[kind])
                finding = f"has no attribute {shown(name)}; expected {listed}; correct it"
                self._report.add(node, "KnownFeature", finding)
            elif not pattern.fullmatch(text):
                finding = f"has {name} {shown(text)}, which is no such value; correct it"
                self._report.add(node, "NumberSyntax", finding)
        for namespace, name in node.qualified:
            if (namespace, name) not in {(XSI, "type"), (XMI, "version")}:
                finding = f"has attribute {shown(name)} of namespace {shown(namespace)}; delete it"
                self._report.add(node, "KnownFeature", finding)

    def _child(self, node: Node, kind: str, child: Node) -> None:
        kinds = _CHILDREN[kind].get(child.tag) if not child.namespace else None
        if kinds is None:
            listed = ", ".join(_CHILDREN[kind]) or "none"
            finding = f"is an unknown element of {node.description}; expected {listed}; correct it"
            self._report.add(child, "KnownFeature", finding)
            return
        text = child.xsi_type
        prefix, _, name = (text or "").rpartition(":")
        if text is None and len(kinds) == 1:
            self._element(child, kinds[0])
        elif name in kinds and child.prefixes.get(prefix) == ECORE:
            self._element(child, name)
        else:
            listed = ", ".join(f"ecore:{entry}" for entry in kinds)
            finding = f"has xsi:type {shown(text or '')}; expected {listed}; choose one"
            self._report.add(child, "ConcreteType", finding)

    def _check_names(self, node: Node, tag: str) -> None:
        seen: dict[str, Node] = {}
        for child in _named(node, tag):
            first = seen.setdefault(child.attributes["name"], child)
            if first is not child:
                finding = f"has the name of line {first.line}; expected different ones; rename one"
                self._report.add(child, "UniqueId", finding)

    def _classifier(self, node: Node) -> None:
        if self._kinds.get(node) == "EEnum":
            self._check_names(node, "eLiterals")
            if not node.children:
                self._report.add(node, "RequiredFeature", "has no literals; add one")
            return
        supertypes = node.attributes.get("eSuperTypes", "").split()
        for target in supertypes:
            self._require(node, target, "EClass")
        n_errors = self._report.n_errors
        ancestors = self._ancestors(node)
        if len(set(supertypes)) < len(supertypes) or node in ancestors:
            finding = "inherits from itself, or twice from one class; correct eSuperTypes"
            self._report.add(node, "ResolvedReference", finding)
        if len(ancestors) > _MAX_ANCESTORS:
            finding = f"inherits from more than {_MAX_ANCESTORS} classes; expected fewer; join some"
            self._report.add(node, "FileSize", finding)
        if self._report.n_errors == n_errors:
            self._check_features(node)

    def _check_features(self, node: Node) -> None:
        """Check the features of a class, whose names differ from those that it inherits."""
        seen: dict[str, Node] = {}
        for feature in _features(self._lineage(node)):
            first = seen.setdefault(feature.attributes["name"], feature)
            if first is not feature:
                finding = f"has a name that {node.description} has twice; rename one"
                self._report.add(feature, "UniqueId", finding)
        for feature in _named(node, "eStructuralFeatures"):
            self._feature(feature)

    def _feature(self, node: Node) -> None:
        lower = node.attributes.get("lowerBound", "0")
        upper = node.attributes.get("upperBound", "1")
        is_count = _COUNT.fullmatch(lower) and _COUNT.fullmatch(upper)
        if is_count and (lower == "-1" or upper == "0" or int(lower) > int(upper) > -1):
            finding = f"has bounds {lower} and {upper}; expected a lower one first; correct them"
            self._report.add(node, "NumberSyntax", finding)
        self._check_storage(node)
        target = node.attributes.get("eType", "")
        if self._kinds.get(node) == "EReference":
            self._require(node, target, "EClass")
            if "eOpposite" in node.attributes:
                finding = "has an eOpposite, which models of missions do without; delete it"
                self._report.add(node, "KnownFeature", finding)
            return
        pattern = self._pattern(node, target)
        text = node.attributes.get("defaultValueLiteral")
        if pattern is not None and text is not None and not pattern.fullmatch(text):
            finding = f"has the default {shown(text)}, which is no value of its type; correct it"
            self._report.add(node, "NumberSyntax", finding)

    def _check_storage(self, node: Node) -> None:
        """Refuse features whose values no file keeps, keeps in no order, or Python cannot name."""
        for name, usual in _STORED.items():
            if node.attributes.get(name, usual) != usual:
                finding = f"has {name}, with which files do not keep its values; delete {name}"
                self._report.add(node, "KnownFeature", finding)
        is_many = node.attributes.get("upperBound", "1") != "1"
        if is_many and node.attributes.get("ordered") == "false":
            finding = "has ordered, with which its values would change places; delete ordered"
            self._report.add(node, "KnownFeature", finding)
        if node.attributes.get("name") in _TAKEN_NAMES:
            finding = "has a name that every element uses itself; expected another; rename it"
            self._report.add(node, "ReservedId", finding)

    def _pattern(self, node: Node, target: str) -> re.Pattern[str] | None:
        """Return what the values of an attribute look like; ``None`` after a report."""
        if target.startswith(_ECORE_TYPE):
            name = target.removeprefix(_ECORE_TYPE)
            if name not in VALUE_TYPES:
                expected = f"{', '.join(VALUE_TYPES)} or an enumeration"
                finding = f"has type {shown(name)}; expected {expected}; choose one"
                self._report.add(node, "ReferenceType", finding)
            return VALUE_TYPES.get(name)
        self._require(node, target, "EEnum")
        found = self._target(node, target)
        literals = [] if found is None else _named(found, "eLiterals")
        return re.compile("|".join(re.escape(each.attributes["name"]) for each in literals))

    def _require(self, node: Node, target: str, kind: str) -> None:
        found = self._target(node, target)
        if found is None or self._kinds.get(found) != kind:
            finding = f"refers to {shown(target)}, which is no {kind}; correct the reference"
            self._report.add(node, "ResolvedReference", finding)

    def _target(self, node: Node, target: str) -> Node | None:
        """Return the classifier that a reference names, in this file or an earlier one."""
        name = target.rpartition(" ")[2]
        return self._classifiers.get(f"{node.path.name}{name}" if name.startswith("#") else name)

    def _parents(self, node: Node) -> Iterator[Node]:
        for target in node.attributes.get("eSuperTypes", "").split():
            found = self._target(node, target)
            if found is not None:
                yield found

    def _ancestors(self, node: Node) -> dict[Node, None]:
        """Return what a class inherits from, itself if circularly; all of it, unless too much."""
        found = dict.fromkeys(self._parents(node))
        pending = list(found)
        while pending and len(found) <= _MAX_ANCESTORS:
            parents = [parent for parent in self._parents(pending.pop()) if parent not in found]
            found |= dict.fromkeys(parents)
            pending += parents
        return found

    def _lineage(self, node: Node, found: dict[Node, None] | None = None) -> dict[Node, None]:
        """Return a class after all that it inherits from, none of it circular."""
        found = {} if found is None else found
        for parent in self._parents(node):
            if parent not in found:
                self._lineage(parent, found)
        found[node] = None
        return found


def _features(lineage: Mapping[Node, None]) -> Iterator[Node]:
    """Yield the features of classes that have a name."""
    for owner in lineage:
        yield from _named(owner, "eStructuralFeatures")


def _named(node: Node, tag: str) -> list[Node]:
    """Return the children with a tag that have a name."""
    return [child for child in node.tagged(tag) if "name" in child.attributes]
