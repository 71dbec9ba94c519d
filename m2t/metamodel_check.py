"""Check what a metamodel says: names, bounds, storage, and all that mrsfi reads of it."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from pyecore.ecore import EClass, EEnum, EObject

from m2t.diagnostics import NodeReport, shown
from m2t.metaclasses import Slot, conforms, features, is_kind, is_read, lineage, slots
from m2t.metamodel_contract import CONTRACT, SUPERTYPES, Need
from m2t.metamodel_reader import VALUE_TYPES

_TAKEN_NAMES = frozenset(name for name in dir(EObject) if not name.startswith("_"))
_STORED: Mapping[str, bool] = MappingProxyType(
    {"volatile": False, "transient": False, "derived": False, "changeable": True}
)


def check_package(package: Any, root_class: str, findings: NodeReport) -> None:
    """Check the package of a metamodel, whose models begin with ``root_class``.

    If what mrsfi reads cannot be looked for, because something else is wrong, it is a
    ``ModelError``; all else goes to ``findings``.
    """
    classes = [kind for kind in package.eClassifiers if isinstance(kind, EClass)]
    _check_names(package.eClassifiers, findings)
    for kind in package.eClassifiers:
        if kind in classes:
            _check_names(features(kind), findings)
            for feature in kind.eStructuralFeatures:
                _check_feature(slots(kind)[feature.name], findings)
        elif not kind.eLiterals:
            findings.add(kind, "RequiredFeature", "has no literals; add one")
        else:
            _check_names(kind.eLiterals, findings)
    findings.report.require_no_errors()
    _check_contract(package, root_class, findings)
    for kind in classes:
        _check_meaning(kind, findings)


def _check_names(elements: Iterable[Any], findings: NodeReport) -> None:
    seen: dict[str, Any] = {}
    for element in elements:
        first = seen.setdefault(element.name, element)
        if first is not element:
            there = findings.nodes[first]
            place = f"line {there.line} of {there.path.name}"
            finding = f"has the name of {place}; expected different ones; rename one"
            findings.add(element, "UniqueId", finding)


def _check_feature(slot: Slot, findings: NodeReport) -> None:
    """Refuse features that hold nothing, whose values no file keeps, or Python cannot name."""
    feature = slot.feature
    lower, upper = feature.lowerBound, feature.upperBound
    if lower == -1 or upper == 0 or lower > upper > -1:
        finding = f"has bounds {lower} and {upper}; expected a lower one first; correct them"
        findings.add(feature, "NumberSyntax", finding)
    for name, usual in _STORED.items():
        if getattr(feature, name) is not usual:
            finding = f"has {name}, with which files do not keep its values; delete {name}"
            findings.add(feature, "KnownFeature", finding)
    if feature.many and not feature.ordered:
        finding = "has ordered, with which its values would change places; delete ordered"
        findings.add(feature, "KnownFeature", finding)
    if feature.name in _TAKEN_NAMES:
        finding = "has a name that every element uses itself; expected another; rename it"
        findings.add(feature, "ReservedId", finding)
    text = getattr(feature, "defaultValueLiteral", None)
    if text is not None and (expected := _missed(text, slot.type)):
        finding = f"has the default {shown(text)}; expected {expected}; correct it"
        findings.add(feature, "NumberSyntax", finding)


def _missed(text: str, kind: Any) -> str:
    """Return what a default should be that is no value of its type; nothing if it is one."""
    if isinstance(kind, EEnum):
        names = [literal.name for literal in kind.eLiterals]
        return "" if text in names else " or ".join(names) or "none"
    values = VALUE_TYPES[kind.name]
    return "" if values.has(text) else values.described


def _check_contract(package: Any, root_class: str, findings: NodeReport) -> None:
    """Check that the classes and features are there that code reads."""
    seen = set()
    for name, needs in CONTRACT[package.name].items():
        kind = package.getEClassifier(name)
        if not isinstance(kind, EClass) or (kind.abstract and name == root_class):
            finding = f"has no class {name}, which mrsfi reads; restore it"
            findings.add(package, "RequiredFeature", finding)
            continue
        parent = SUPERTYPES[package.name].get(name)
        if parent is not None and not is_kind(kind, parent):
            finding = f"does not inherit from {parent}, on which mrsfi relies; restore eSuperTypes"
            findings.add(kind, "RequiredFeature", finding)
        for feature, need in needs.items():
            slot = slots(kind).get(feature)
            if slot is None:
                finding = f"has no feature {feature}; mrsfi reads {need} of that name; restore it"
                findings.add(kind, "RequiredFeature", finding)
            elif slot.feature not in seen and not _meets(slot, need):
                seen.add(slot.feature)
                finding = f"of {name} is read as {need}, which is not what it declares; restore it"
                findings.add(slot.feature, "RequiredFeature", finding)


def _meets(slot: Slot, need: Need) -> bool:
    """Return whether a feature is declared as code reads it."""
    holding = "attr"
    if slot.holds_elements:
        holding = "val" if slot.is_contained else "ref"
    return (
        ("id" if slot.is_id else holding, slot.many) == (need.holding, need.is_many)
        and slot.lower_bound >= need.n_least
        and (slot.type.name == need.type or (slot.holds_elements and is_kind(slot.type, need.type)))
    )


def _check_meaning(kind: Any, findings: NodeReport) -> None:
    """Check that code knows the elements of a class as one thing only."""
    read = [known for known in lineage(kind) if is_read(known) and not known.abstract]
    names = [
        known.name
        for known in read
        if not any(conforms(other, known) for other in read if other is not known)
    ]
    if len(names) > 1:
        finding = (
            f"inherits from {' and '.join(names)}, and mrsfi can know it as one of them only; "
            "keep one"
        )
        findings.add(kind, "ConcreteType", finding)
