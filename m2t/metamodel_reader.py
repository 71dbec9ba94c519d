"""Read metamodels: check their nodes, let pyecore load sound files, and check the objects.

pyecore accepts unknown types and bounds, fails with exceptions of all kinds, and detects some
defects only when the metamodel is used. So it never gets a file with a known defect.
``MetamodelReader.read`` has the steps in order. The functions below the class check the objects.
"""

import re
from collections.abc import Iterable, Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree
from pyecore.ecore import EClass, EEnum, EObject
from pyecore.resources import URI, ResourceSet

from m2t.metaclasses import (
    CONTRACT,
    MEANING,
    SUPERTYPES,
    Need,
    Needs,
    Slot,
    conforms,
    features,
    is_kind,
    is_read,
    lineage,
    needs,
    slots,
)
from m2t.read import ECORE, XMI, XSI, Node, Report, read_root, shown
from mrsfi_runtime.errors import ModelError

_TAKEN_NAMES = frozenset(name for name in dir(EObject) if not name.startswith("_"))


class _Values(NamedTuple):
    """Format of a type's values, in words and as a pattern, and the constraint that requires it."""

    described: str
    pattern: str
    constraint: str = "NumberSyntax"

    def has(self, text: str) -> bool:
        return re.fullmatch(self.pattern, text, re.ASCII | re.DOTALL) is not None


_VALUES: Mapping[str, _Values] = {
    "Name": _Values(
        "a letter, then letters, digits and _, all of ASCII", r"[A-Za-z]\w*", "NameSyntax"
    ),
    "Count": _Values("-1 or a whole number of at most 6 digits", r"-1|\d{1,6}"),
    "Some": _Values("a text that is not empty", r".+", "RequiredFeature"),
    "EString": _Values("a text", r".*"),
    "EInt": _Values("a whole number of at most 9 digits", r"-?\d{1,9}"),
    "EDouble": _Values("a decimal number", r"-?\d{1,15}(\.\d{1,15})?"),
    "EBoolean": _Values("true or false", r"true|false", "EnumLiteral"),
}
_VALUE_TYPES = {name: values for name, values in _VALUES.items() if name.startswith("E")}
"""Types of attributes other than enumerations, with the format of their defaults."""

_MAX_ANCESTORS = 50
_ECORE_TYPE = f"ecore:EDataType {ECORE}#//"

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
"""The part of Ecore that mrsfi supports, in the notation of ``m2t.metaclasses``."""


class MetamodelReader:
    """Reads metamodel files one after the other; later ones may refer to earlier ones.

    ``report`` has the place of every element of all files.
    """

    def __init__(self) -> None:
        self._nodes: dict[Any, Node] = {}
        self.report = Report(self._nodes)
        self._resources = ResourceSet()
        self._kinds: dict[Node, str] = {}
        self._classifiers: dict[str, Node] = {}
        self._named = {ECORE: ECORE, "Ecore.ecore": ECORE}

    def read(self, path: Path, root_class: str) -> Any:
        """Return the package of a file, named like it, whose models begin with ``root_class``.

        Defects of the file, one per line, raise a ``ModelError``.
        """
        root = read_root(path, self.report)
        if (root.namespace, root.tag) != (ECORE, "EPackage"):
            finding = f"is the root; expected EPackage of namespace {ECORE}; restore the file"
            self.report.add(root, "RootElement", finding)
            raise self.report.error()
        self._named |= {path.name: path.name, root.attributes.get("nsURI", ""): path.name}
        for node in root.walk():
            for name in {"eType", "eSuperTypes"} & node.attributes.keys():
                text = node.attributes[name]
                node.attributes[name] = re.sub("[^ #]+(?=#)", self._address, text)
        self._check(root, "EPackage")
        if root.attributes.get("name") != root.path.stem:
            finding = f"is the package; expected the name {root.path.stem}; restore it"
            self.report.add(root, "RootElement", finding)
        classifiers = root.tagged("eClassifiers")
        for node in classifiers:
            name = f"{root.path.name}#//{node.attributes.get('name')}"
            self._classifiers.setdefault(name, node)
        for node in root.walk():
            self._check_references(node)
        for node in classifiers:
            self._check_ancestors(node)
        self.report.require_no_errors()
        package = self._loaded(root)
        _check_package(package, root_class, self.report)
        self.report.require_no_errors()
        return package

    def _loaded(self, root: Node) -> Any:
        """Let pyecore load a checked file; store the node of each element."""
        try:
            file = _CheckedFile(str(root.path))
            file.root = root
            package = self._resources.get_resource(file).contents[0]
        except Exception as error:  # pyecore raises exceptions of any class
            raise ModelError(
                f"{root.path}:{root.line}: {root.path.name} cannot be loaded "
                f"({type(error).__name__}: {error}); expected a metamodel of classes and "
                "enumerations; restore the file"
            ) from error
        self._place(package, root)
        return package

    def _address(self, found: re.Match[str]) -> str:
        """Return the file, or Ecore's nsURI, of an address in Eclipse; else the address itself.

        Eclipse addresses files by projects and plug-ins, which are other folders here.
        """
        address = found[0]
        name = address.rpartition("/")[2] if address.startswith("platform:/") else address
        return self._named.get(name, address)

    def _place(self, element: Any, node: Node) -> None:
        self._nodes[element] = node
        for tag in ("eAnnotations", "eClassifiers", "eStructuralFeatures", "eLiterals"):
            for part, child in zip(getattr(element, tag, ()), node.tagged(tag), strict=True):
                self._place(part, child)

    def _check(self, node: Node, kind: str) -> None:
        self._kinds[node] = kind
        if node.text.strip():
            finding = f"holds the text {shown(node.text.strip())}; expected none; delete it"
            self.report.add(node, "NoText", finding)
        known = _UNDERSTOOD[kind]
        for name, need in known.items():
            if need.n_least and name not in node.attributes:
                finding = f"has no {name}; every {kind} needs one; add it"
                self.report.add(node, "RequiredFeature", finding)
        self._check_attributes(node, {name: known[name].type for name in _held(known, "attr")})
        for child in node.children:
            self._check_child(node, known, child)

    def _check_attributes(self, node: Node, types: Mapping[str, str]) -> None:
        for name, text in node.attributes.items():
            if name not in types:
                listed = ", ".join(types)
                finding = f"has no attribute {shown(name)}; expected {listed}; correct it"
                self.report.add(node, "KnownFeature", finding)
            elif not (values := _VALUES[types[name]]).has(text):
                finding = f"has {name} {shown(text)}; expected {values.described}; correct it"
                self.report.add(node, values.constraint, finding)
        for namespace, name in node.qualified:
            if (namespace, name) not in {(XSI, "type"), (XMI, "version")}:
                finding = f"has attribute {shown(name)} of namespace {shown(namespace)}; delete it"
                self.report.add(node, "KnownFeature", finding)

    def _check_child(self, node: Node, known: Needs, child: Node) -> None:
        tags = _held(known, "val")
        if child.tag not in tags or child.namespace:
            listed = ", ".join(tags) or "none"
            finding = f"is an unknown element of {node.description}; expected {listed}; correct it"
            self.report.add(child, "KnownFeature", finding)
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
            self.report.add(child, "ConcreteType", finding)

    def _check_references(self, node: Node) -> None:
        """Check the targets of a node's references, and that keys of our annotations are unique."""
        kind, target = self._kinds.get(node), node.attributes.get("eType", "")
        if kind == "EClass":
            for parent in node.attributes.get("eSuperTypes", "").split():
                self._require(node, parent, "EClass")
        elif kind == "EReference":
            self._require(node, target, "EClass")
        elif kind == "EAttribute" and not target.startswith(_ECORE_TYPE):
            self._require(node, target, "EEnum")
        elif kind == "EAttribute" and target.removeprefix(_ECORE_TYPE) not in _VALUE_TYPES:
            expected = f"{', '.join(_VALUE_TYPES)} or an enumeration"
            finding = f"has type {shown(target.removeprefix(_ECORE_TYPE))}; expected {expected}"
            self.report.add(node, "ReferenceType", f"{finding}; choose one")
        elif kind == "EAnnotation" and node.attributes.get("source") == MEANING:
            keys = [entry.attributes.get("key", "") for entry in node.tagged("details")]
            for key in dict.fromkeys(key for key in keys if keys.count(key) > 1):
                finding = f"has the key {shown(key)} again; expected each once; delete one"
                self.report.add(node, "KnownFeature", finding)

    def _require(self, node: Node, target: str, kind: str) -> None:
        found = self._target(node, target)
        if found is not None and self._kinds.get(found) == kind:
            return
        address = target.rpartition(" ")[2].rpartition("#")[0]
        finding = f"refers to {shown(target)}, which is no {kind}"
        if address and address not in self._named.values():
            known = ", ".join(self._named)
            finding += f": found the URI {address[:200]!r}; expected one of {known}"
        self.report.add(node, "ResolvedReference", f"{finding}; correct the reference")

    def _target(self, node: Node, target: str) -> Node | None:
        """Return the node of a referenced classifier, in this or an earlier file."""
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
            self.report.add(node, "ResolvedReference", finding)
        if len(ancestors) > _MAX_ANCESTORS:
            finding = f"inherits from more than {_MAX_ANCESTORS} classes; expected fewer; join some"
            self.report.add(node, "FileSize", finding)


class _CheckedFile(URI):  # type: ignore[misc] # pyecore has no types
    """A file without comments for pyecore, which would read them as elements.

    ``root`` has the checked attributes.
    """

    root: Node

    def create_instream(self) -> BytesIO:
        parser = etree.XMLParser(remove_comments=True, remove_pis=True, resolve_entities=False)
        tree = etree.parse(self.plain, parser)
        for element, node in zip(tree.iter(), self.root.walk(), strict=True):
            for name, text in node.attributes.items():
                element.set(name, text)
        return BytesIO(etree.tostring(tree))


def _held(known: Needs, holding: str) -> list[str]:
    return [name for name, need in known.items() if need.holding == holding]


def _check_package(package: Any, root_class: str, report: Report) -> None:
    classes = [kind for kind in package.eClassifiers if isinstance(kind, EClass)]
    _check_names(package.eClassifiers, report)
    for kind in package.eClassifiers:
        if kind in classes:
            _check_names(features(kind), report)
            for feature in kind.eStructuralFeatures:
                _check_feature(slots(kind)[feature.name], report)
        elif not kind.eLiterals:
            report.add(kind, "RequiredFeature", "has no literals; add one")
        else:
            _check_names(kind.eLiterals, report)
    report.require_no_errors()
    _check_contract(package, root_class, report)
    for kind in classes:
        _check_meaning(kind, report)


def _check_names(elements: Iterable[Any], report: Report) -> None:
    seen: dict[str, Any] = {}
    for element in elements:
        first = seen.setdefault(element.name, element)
        if first is not element:
            there = report.place(first)
            place = f"line {there.line} of {there.path.name}"
            finding = f"has the name of {place}; expected different ones; rename one"
            report.add(element, "UniqueId", finding)


def _check_feature(slot: Slot, report: Report) -> None:
    """Refuse features without values, with values that no file stores, or with reserved names."""
    feature = slot.feature
    lower, upper = feature.lowerBound, feature.upperBound
    if lower == -1 or upper == 0 or lower > upper > -1:
        finding = f"has bounds {lower} and {upper}; expected a lower one first; correct them"
        report.add(feature, "NumberSyntax", finding)
    for name in ("volatile", "transient", "derived", "changeable"):
        if getattr(feature, name) is not (name == "changeable"):
            finding = f"has {name}, so files do not store its values; delete {name}"
            report.add(feature, "KnownFeature", finding)
    if feature.many and not feature.ordered:
        finding = "has ordered=false, so its values could change order; delete ordered"
        report.add(feature, "KnownFeature", finding)
    if feature.name in _TAKEN_NAMES:
        finding = "has a name that every element uses itself; expected another; rename it"
        report.add(feature, "ReservedId", finding)
    text = getattr(feature, "defaultValueLiteral", None)
    if text is not None and (expected := _expected_default(text, slot.type)):
        finding = f"has the default {shown(text)}; expected {expected}; correct it"
        kind = _VALUE_TYPES.get(slot.type.name)
        report.add(feature, "EnumLiteral" if kind is None else kind.constraint, finding)


def _expected_default(text: str, kind: Any) -> str:
    """Return the expected format of a default; empty if the text has it."""
    if isinstance(kind, EEnum):
        names = [literal.name for literal in kind.eLiterals]
        return "" if text in names else " or ".join(names) or "none"
    values = _VALUE_TYPES[kind.name]
    return "" if values.has(text) else values.described


def _check_contract(package: Any, root_class: str, report: Report) -> None:
    seen = set()
    for name, needed in CONTRACT[package.name].items():
        kind = package.getEClassifier(name)
        if not isinstance(kind, EClass) or (kind.abstract and name == root_class):
            finding = f"has no class {name}, which mrsfi reads; restore it"
            report.add(package, "RequiredFeature", finding)
            continue
        parent = SUPERTYPES[package.name].get(name)
        if parent is not None and not is_kind(kind, parent):
            finding = f"does not inherit from {parent}, on which mrsfi relies; restore eSuperTypes"
            report.add(kind, "RequiredFeature", finding)
        for feature, need in needed.items():
            slot = slots(kind).get(feature)
            if slot is None:
                finding = f"has no feature {feature}; mrsfi reads {need} of that name; restore it"
                report.add(kind, "RequiredFeature", finding)
            elif slot.feature not in seen and not _meets(slot, need):
                seen.add(slot.feature)
                finding = f"of {name} is declared in another way; mrsfi reads {need}; restore it"
                report.add(slot.feature, "RequiredFeature", finding)


def _meets(slot: Slot, need: Need) -> bool:
    holding = "attr"
    if slot.holds_elements:
        holding = "val" if slot.is_contained else "ref"
    return (
        ("id" if slot.is_id else holding, slot.many) == (need.holding, need.is_many)
        and slot.lower_bound >= need.n_least
        and (slot.type.name == need.type or (slot.holds_elements and is_kind(slot.type, need.type)))
    )


def _check_meaning(kind: Any, report: Report) -> None:
    """Check that a class inherits from only one class that code reads."""
    read = [known for known in lineage(kind) if is_read(known) and not known.abstract]
    names = [
        known.name
        for known in read
        if not any(conforms(other, known) for other in read if other is not known)
    ]
    if len(names) > 1:
        finding = f"inherits from {' and '.join(names)}, and mrsfi can read it as only one of them"
        report.add(kind, "ConcreteType", f"{finding}; keep one")
