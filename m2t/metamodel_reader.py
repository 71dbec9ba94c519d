"""Check the nodes of an ``.ecore`` file, and build what is sound straight from them.

pyecore's reader, which is not asked, takes unknown types and bounds for granted, takes comments
for elements, and finds some defects only when the metamodel is used.
"""

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from pyecore import ecore

from m2t.diagnostics import Report, shown
from m2t.metamodel_contract import MEANING, Needs, needs
from m2t.namespaces import ECORE, XMI, XSI
from m2t.read.nodes import Node
from mrsfi_runtime.errors import ModelError


class _Values(NamedTuple):
    """What the values of a type look like, in words and as a pattern, and how they are read."""

    described: str
    pattern: str
    read: Callable[[str], object] = str

    def has(self, text: str) -> bool:
        """Whether a text is a value of the type."""
        return re.fullmatch(self.pattern, text, re.ASCII | re.DOTALL) is not None


_VALUES: Mapping[str, _Values] = MappingProxyType(
    {
        "Name": _Values("a letter, then letters, digits and _, all of ASCII", r"[A-Za-z]\w*"),
        "Count": _Values("-1 or a whole number of at most 6 digits", r"-1|\d{1,6}", int),
        "Some": _Values("a text that is not empty", r".+"),
        "EString": _Values("a text", r".*"),
        "EInt": _Values("a whole number of at most 9 digits", r"-?\d{1,9}", int),
        "EDouble": _Values("a decimal number", r"-?\d{1,15}(\.\d{1,15})?"),
        "EBoolean": _Values("true or false", r"true|false", "true".__eq__),
    }
)
VALUE_TYPES = {name: values for name, values in _VALUES.items() if name.startswith("E")}
"""Types of attributes beside enumerations, and what their defaults look like."""

_MAX_ANCESTORS = 50
_ECORE_TYPE = f"ecore:EDataType {ECORE}#//"
_REFERENCES = frozenset({"eSuperTypes", "eType"})

_ANNOTATED = "val EAnnotation[*] eAnnotations"
_NAMED = f"{_ANNOTATED}, attr Name[1] name"
_FEATURE = (
    f"{_NAMED}, attr Some[1] eType, attr Count[?] lowerBound, attr Count[?] upperBound, "
    "attr EBoolean[?] ordered, attr EBoolean[?] unique, attr EBoolean[?] changeable, "
    "attr EBoolean[?] volatile, attr EBoolean[?] transient, attr EBoolean[?] unsettable, "
    "attr EBoolean[?] derived"
)
_UNDERSTOOD = needs(f"""
EPackage: {_NAMED}, attr Some[1] nsURI, attr Name[1] nsPrefix, val EClass|EEnum[*] eClassifiers
EClass: {_NAMED}, attr EBoolean[?] abstract, attr EBoolean[?] interface,
    attr EString[?] eSuperTypes, attr Some[?] instanceClassName,
    val EAttribute|EReference[*] eStructuralFeatures
EEnum: {_NAMED}, attr EBoolean[?] serializable, attr Some[?] instanceClassName,
    val EEnumLiteral[*] eLiterals
EEnumLiteral: {_NAMED}, attr EInt[?] value, attr Name[?] literal
EAttribute: {_FEATURE}, attr EBoolean[?] iD, attr EString[?] defaultValueLiteral
EReference: {_FEATURE}, attr EBoolean[?] containment, attr EBoolean[?] resolveProxies
EAnnotation: {_ANNOTATED}, attr EString[?] source, val details[*] details
details: attr EString[?] key, attr EString[?] value
""")
"""What mrsfi understands of Ecore, in the notation of ``m2t.metamodel_contract``."""


class MetamodelReader:
    """Reads metamodel files one after the other; later ones may refer to earlier ones.

    ``nodes`` has the node of every element that was read, of all files.
    """

    def __init__(self, report: Report) -> None:
        self.nodes: dict[Any, Node] = {}
        self._report = report
        self._objects: dict[Node, Any] = {}
        self._kinds: dict[Node, str] = {}
        self._classifiers: dict[str, Node] = {}

    def read(self, root: Node) -> Any:
        """Return the package of a file, named like it; every reference in it leads where it should.

        All that is wrong with the file is a ``ModelError``.
        """
        if (root.namespace, root.tag) != (ECORE, "EPackage"):
            finding = f"is the root; expected EPackage of namespace {ECORE}; restore the file"
            self._report.add(root, "RootElement", finding)
            raise self._report.error()
        self._check(root, "EPackage")
        if root.attributes.get("name") != root.path.stem:
            finding = f"is the package; expected the name {root.path.stem}; restore it"
            self._report.add(root, "RootElement", finding)
        classifiers = root.tagged("eClassifiers")
        for node in classifiers:
            name = f"{root.path.name}#//{node.attributes.get('name')}"
            self._classifiers.setdefault(name, node)
        for node in root.walk():
            self._check_references(node)
        for node in classifiers:
            self._check_ancestors(node)
        self._report.require_no_errors()
        return self._loaded(root)

    def _loaded(self, root: Node) -> Any:
        """Build the elements of a checked file, then refer from one to the other."""
        try:
            package = self._built(root)
            for node in root.walk():
                self._refer(node)
        except Exception as error:  # pyecore raises anything
            raise ModelError(
                f"{root.path}:{root.line}: {root.path.name} cannot be loaded "
                f"({type(error).__name__}: {error}); expected a metamodel of classes and "
                "enumerations; restore the file"
            ) from error
        return package

    def _built(self, node: Node) -> Any:
        """Return the element of a node with its attributes and all that it contains."""
        kind = self._kinds[node]
        known = {"name": node.attributes["name"]} if kind == "EClass" else {}  # cannot come later
        built = getattr(ecore, kind)(**known)
        self.nodes[built] = node
        self._objects[node] = built
        for name, text in node.attributes.items():
            if name not in _REFERENCES:
                setattr(built, name, _VALUES[_UNDERSTOOD[kind][name].type].read(text))
        for child in node.children:
            if child.tag == "details":
                built.details[child.attributes.get("key")] = child.attributes.get("value")
            else:
                getattr(built, child.tag).append(self._built(child))
        return built

    def _refer(self, node: Node) -> None:
        """Give a class its supertypes, or a feature its type."""
        for parent in self._parents(node):
            self._objects[node].eSuperTypes.append(self._objects[parent])
        target = node.attributes.get("eType", "")
        if target.startswith(_ECORE_TYPE):
            self._objects[node].eType = getattr(ecore, target.removeprefix(_ECORE_TYPE))
        elif (found := self._target(node, target)) is not None:
            self._objects[node].eType = self._objects[found]

    def _check(self, node: Node, kind: str) -> None:
        """Check a node, and all below it, as an element of a kind."""
        self._kinds[node] = kind
        if node.text.strip():
            finding = f"holds the text {shown(node.text.strip())}; expected none; delete it"
            self._report.add(node, "NoText", finding)
        known = _UNDERSTOOD[kind]
        for name, need in known.items():
            if need.n_least and name not in node.attributes:
                finding = f"has no {name}; every {kind} needs one; add it"
                self._report.add(node, "RequiredFeature", finding)
        self._check_attributes(node, {name: known[name].type for name in _held(known, "attr")})
        for child in node.children:
            self._check_child(node, known, child)

    def _check_attributes(self, node: Node, types: Mapping[str, str]) -> None:
        for name, text in node.attributes.items():
            if name not in types:
                listed = ", ".join(types)
                finding = f"has no attribute {shown(name)}; expected {listed}; correct it"
                self._report.add(node, "KnownFeature", finding)
            elif not (values := _VALUES[types[name]]).has(text):
                finding = f"has {name} {shown(text)}; expected {values.described}; correct it"
                self._report.add(node, "NumberSyntax", finding)
        for namespace, name in node.qualified:
            if (namespace, name) not in {(XSI, "type"), (XMI, "version")}:
                finding = f"has attribute {shown(name)} of namespace {shown(namespace)}; delete it"
                self._report.add(node, "KnownFeature", finding)

    def _check_child(self, node: Node, known: Needs, child: Node) -> None:
        tags = _held(known, "val")
        if child.tag not in tags or child.namespace:
            listed = ", ".join(tags) or "none"
            finding = f"is an unknown element of {node.description}; expected {listed}; correct it"
            self._report.add(child, "KnownFeature", finding)
            return
        kinds = known[child.tag].type.split("|")
        text = child.xsi_type
        prefix, _, name = (text or "").rpartition(":")
        if text is None and len(kinds) == 1:
            self._check(child, kinds[0])
        elif name in kinds and child.prefixes.get(prefix) == ECORE:
            self._check(child, name)
        else:
            listed = ", ".join(f"ecore:{entry}" for entry in kinds)
            finding = f"has xsi:type {shown(text or '')}; expected {listed}; choose one"
            self._report.add(child, "ConcreteType", finding)

    def _check_references(self, node: Node) -> None:
        """Check what a node refers to; of an annotation of ours, that it says all once."""
        kind, target = self._kinds.get(node), node.attributes.get("eType", "")
        if kind == "EClass":
            for parent in node.attributes.get("eSuperTypes", "").split():
                self._require(node, parent, "EClass")
        elif kind == "EReference":
            self._require(node, target, "EClass")
        elif kind == "EAttribute" and not target.startswith(_ECORE_TYPE):
            self._require(node, target, "EEnum")
        elif kind == "EAttribute" and target.removeprefix(_ECORE_TYPE) not in VALUE_TYPES:
            expected = f"{', '.join(VALUE_TYPES)} or an enumeration"
            finding = f"has type {shown(target.removeprefix(_ECORE_TYPE))}; expected {expected}"
            self._report.add(node, "ReferenceType", f"{finding}; choose one")
        elif kind == "EAnnotation" and node.attributes.get("source") == MEANING:
            keys = [entry.attributes.get("key", "") for entry in node.tagged("details")]
            for key in {key for key in keys if keys.count(key) > 1}:
                finding = f"has the key {shown(key)} again; expected each once; delete one"
                self._report.add(node, "KnownFeature", finding)

    def _require(self, node: Node, target: str, kind: str) -> None:
        found = self._target(node, target)
        if found is None or self._kinds.get(found) != kind:
            finding = f"refers to {shown(target)}, which is no {kind}; correct the reference"
            self._report.add(node, "ResolvedReference", finding)

    def _target(self, node: Node, target: str) -> Node | None:
        """Return the node of the classifier that a reference names, here or in an earlier file."""
        name = target.rpartition(" ")[2]
        return self._classifiers.get(f"{node.path.name}{name}" if name.startswith("#") else name)

    def _parents(self, node: Node) -> list[Node]:
        targets = node.attributes.get("eSuperTypes", "").split()
        found = [self._target(node, target) for target in targets]
        return [parent for parent in found if parent is not None]

    def _check_ancestors(self, node: Node) -> None:
        """Refuse a class that inherits in a circle, twice from one class, or from too many."""
        parents = self._parents(node)
        ancestors = dict.fromkeys(parents)
        has_doubles = len(ancestors) < len(parents)
        pending = list(ancestors)
        while pending and len(ancestors) <= _MAX_ANCESTORS:
            parents = self._parents(pending.pop())
            pending += [parent for parent in parents if parent not in ancestors]
            ancestors |= dict.fromkeys(parents)
        if has_doubles or node in ancestors:
            finding = "inherits from itself, or twice from one class; correct eSuperTypes"
            self._report.add(node, "ResolvedReference", finding)
        if len(ancestors) > _MAX_ANCESTORS:
            finding = f"inherits from more than {_MAX_ANCESTORS} classes; expected fewer; join some"
            self._report.add(node, "FileSize", finding)


def _held(known: Needs, holding: str) -> list[str]:
    return [name for name, need in known.items() if need.holding == holding]
