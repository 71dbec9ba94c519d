"""Read what ``faults.ecore`` says of fault types: mode, properties and parameters.

An annotation of a class says its mode and the property that it touches, one of a number among
its attributes the range of the parameter. A class that says nothing means what it inherits.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from enum import Enum
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from m2t.diagnostics import Report, shown
from m2t.metamodel_contract import BOUNDS, MEANING, OURS
from m2t.read.nodes import Node
from mrsfi_runtime.model.fault_types import (
    ELEMENTS,
    N_VALUES,
    REPORTED,
    ROLES,
    WITHIN_REACH,
    FaultType,
    Field,
    Mode,
    Parameter,
    Range,
    Role,
    Roles,
    Struck,
)

Lineage: TypeAlias = Callable[[Node], Iterable[Node]]
"""Gives a class after all that it inherits from, the most general class first."""

Word = TypeVar("Word", bound=Enum)

_BASE = "FaultType"
_STRUCK = MappingProxyType({f"{struck.value.title()}Fault": struck for struck in Struck})
_OF_CLASS = ("mode", "property")
_OF_PARAMETER = ("range", "role", "search")
_GIVEN_ROLES = MappingProxyType({role.name: role for role in (Role.LOWEST, Role.HIGHEST)})
_ROLE_OF_RANGE = MappingProxyType(
    {
        Range.TICKS: Role.TICKS,
        Range.PERCENT: Role.PERCENT,
        Range.X: Role.X,
        Range.Y: Role.Y,
        Range.Z: Role.Z,
    }
)
_NUMBERS = ("//EInt", "//EDouble")


class FaultTypeReader:
    """Reads the fault types of a metamodel whose classes are sound.

    Parameters
    ----------
    lineage
        Inheritance among the classes of the metamodels.
    report
        Takes the diagnostics.
    """

    def __init__(self, lineage: Lineage, report: Report) -> None:
        self._lineage = lineage
        self._report = report
        self._said: dict[Node, Mapping[str, str]] = {}
        self._found: set[tuple[Node, str]] = set()

    def read(self, root: Node) -> Mapping[str, FaultType]:
        """Return the fault types of a package by name, in the order of the file."""
        kinds = [node for node in root.children if self._is_fault_type(node)]
        found = [self._fault_type(node) for node in kinds if not _is_abstract(node)]
        self._require_containments(root, kinds)
        self._require_all_read(root)
        types = [kind for kind in found if kind is not None]
        own = [kind.name for kind in types if kind.mode is Mode.OWN]
        return MappingProxyType(
            {
                kind.name: replace(kind, effect=own.index(kind.name)) if kind.name in own else kind
                for kind in types
            }
        )

    def _is_fault_type(self, node: Node) -> bool:
        """Return whether a class inherits from that of fault types, or says that it is one."""
        parents = self._lineage(node) if node.tag == "eClassifiers" else ()
        return bool(_annotations(node)) or any(_name(parent) == _BASE for parent in parents)

    def _fault_type(self, node: Node) -> FaultType | None:
        """Return what a class means, unless something is wrong with it."""
        n_errors = self._report.n_errors
        classes = [*self._lineage(node)]
        meant = self._meaning(node, classes)
        struck = self._struck(node, classes)
        declared = self._parameters(node, classes)
        mode = self._word(node, Mode, meant.get("mode")) if meant else None
        names = meant.get("property", "").split()
        properties = [self._word(node, Field, name) for name in names]
        if self._report.n_errors > n_errors or mode is None or struck is None:
            return None
        touched = tuple(word for word in properties if word is not None)
        self._require_reach(node, mode, struck, touched)
        if mode is Mode.OWN:
            self._require_own(node, touched, declared)
            return FaultType(_name(node), mode, struck, touched, tuple(declared))
        roles = self._roles(node, mode, touched)
        if roles is None:
            return None
        parameters = self._in_order(node, mode, roles, declared, touched)
        return FaultType(_name(node), mode, struck, touched, parameters)

    def _meaning(self, node: Node, classes: list[Node]) -> Mapping[str, str]:
        """Return what the nearest class of a lineage that says anything says."""
        for known in reversed(classes):
            said = self._details(known, _OF_CLASS)
            if said:
                return said
        modes = ", ".join(mode.name for mode in Mode)
        self._add(
            node,
            "RequiredFeature",
            f"says no mode; expected an annotation of source {MEANING} with a mode ({modes}) and "
            "the property that it acts on; add one",
        )
        return {}

    def _struck(self, node: Node, classes: list[Node]) -> Struck | None:
        found = [_STRUCK[_name(known)] for known in classes if _name(known) in _STRUCK]
        if len(found) != 1:
            listed = ", ".join(_STRUCK)
            finding = f"inherits from {len(found)} of {listed}; expected one; correct eSuperTypes"
            self._add(node, "RequiredFeature", finding)
            return None
        return found[0]

    def _require_reach(
        self, node: Node, mode: Mode, struck: Struck, touched: tuple[Field, ...]
    ) -> None:
        for affected in touched or (None,):
            if affected not in WITHIN_REACH[struck]:
                listed = ", ".join(field.name for field in WITHIN_REACH[struck] if field)
                what = "no property" if affected is None else f"property {affected.name}"
                finding = (
                    f"of mode {mode.name} touches {what}, but refers to one {struck.value}; "
                    f"expected one of {listed}, or another supertype; correct either"
                )
                self._add(node, "RequiredFeature", finding)

    def _require_own(
        self, node: Node, touched: tuple[Field, ...], declared: Mapping[Parameter, Role]
    ) -> None:
        """Refuse a type of mode OWN that no region could be written for."""
        is_one_kind = any(set(touched) <= {*known} for known in ELEMENTS)
        if not touched or not is_one_kind or len(set(touched)) < len(touched):
            choices = "; or ".join(", ".join(field.name for field in known) for known in ELEMENTS)
            named = " and ".join(field.name for field in touched) or "no property"
            finding = (
                f"of mode OWN touches {named}; "
                f"expected some of: {choices}; correct property, or make a type for each"
            )
            self._add(node, "EnumLiteral", finding)
        if len(declared) > N_VALUES:
            finding = (
                f"has {len(declared)} parameters; mode OWN takes at most {N_VALUES}; join some"
            )
            self._add(node, "KnownFeature", finding)
        for parameter, role in declared.items():
            if role in _GIVEN_ROLES.values():
                finding = (
                    f"has parameter {parameter.name} with a role; mode OWN has none; delete it"
                )
                self._add(node, "KnownFeature", finding)

    def _roles(self, node: Node, mode: Mode, touched: tuple[Field, ...]) -> Roles | None:
        """Return the parameters that a mode takes for the properties that a type names."""
        known = ROLES[mode]
        affected = touched[0] if touched else None
        if len(touched) > 1 or affected not in known:
            listed = ", ".join(field.name if field else "no property" for field in known)
            names = " and ".join(field.name for field in touched) or "no property"
            finding = f"of mode {mode.name} touches {names}; expected {listed}; correct property"
            self._add(node, "EnumLiteral", finding)
            return None
        return known[affected]

    def _parameters(self, node: Node, classes: list[Node]) -> dict[Parameter, Role]:
        """Return the parameters of a class in the order of the metamodel, with their roles."""
        numbers = {_name(feature): feature for feature in _numbers(classes)}
        found = {}
        self._require_numbers(classes, numbers)
        for name, feature in numbers.items():
            said = self._details(feature, _OF_PARAMETER)
            if not said and _is_bound(feature, numbers):
                continue
            of = self._range(node, feature, said)
            if of is not None:
                parameter = Parameter(
                    name,
                    of,
                    evolves=said.get("search") != "false",
                    is_integer=feature.attributes["eType"].endswith("EInt") or of is Range.TICKS,
                )
                given = _GIVEN_ROLES.get(said.get("role", ""))
                found[parameter] = given or _ROLE_OF_RANGE.get(of, Role.VALUE)
        return found

    def _require_numbers(self, classes: list[Node], numbers: Mapping[str, Node]) -> None:
        """Refuse bounds of parameters that are no numbers."""
        for known in classes:
            for feature in known.children:
                name = _name(feature)
                is_bound = name.endswith(BOUNDS) and name.removesuffix(name[-4:]) in numbers
                if is_bound and name not in numbers:
                    finding = "bounds a parameter; expected one EInt or EDouble; correct it"
                    self._add(feature, "ReferenceType", finding)

    def _range(self, node: Node, feature: Node, said: Mapping[str, str]) -> Range | None:
        """Return the range of a parameter; whatever its annotation says makes sense."""
        if "range" not in said:
            listed = ", ".join(of.name for of in Range)
            finding = (
                f"of {_name(node)} is a number without a range; every number of a fault type is a "
                f"parameter; expected an annotation of source {MEANING} with a range ({listed}); "
                "add one, or put what is no parameter into Fault"
            )
            self._add(feature, "RequiredFeature", finding)
            return None
        if said.get("search", "true") not in {"true", "false"}:
            finding = f"has search {shown(said['search'])}; expected true or false; correct it"
            self._add(feature, "EnumLiteral", finding)
        if said.get("role") not in {None, *_GIVEN_ROLES}:
            listed = ", ".join(_GIVEN_ROLES)
            finding = f"has role {shown(said['role'])}; expected {listed}, or none; correct it"
            self._add(feature, "EnumLiteral", finding)
        return self._word(feature, Range, said["range"])

    def _in_order(
        self,
        node: Node,
        mode: Mode,
        roles: Roles,
        declared: Mapping[Parameter, Role],
        touched: tuple[Field, ...],
    ) -> tuple[Parameter, ...]:
        """Return the parameters in the order in which the mode takes them."""
        by_role: dict[Role, Parameter] = {}
        for parameter, role in declared.items():
            if role not in (*roles.needed, *roles.optional) or role in by_role:
                listed = " and ".join(known.value for known in roles.needed) or "no parameter"
                finding = (
                    f"has parameter {parameter.name} as its {role.value}; mode {mode.name} takes "
                    f"{listed}; delete it, or correct its range or role"
                )
                self._add(node, "KnownFeature", finding)
            elif not _is_of_property(parameter, role, touched):
                finding = (
                    f"has parameter {parameter.name} of range {parameter.range.name}; expected "
                    f"{touched[0].name}, that of its property; correct it"
                )
                self._add(node, "EnumLiteral", finding)
            by_role.setdefault(role, parameter)
        for role in roles.needed:
            if role not in by_role:
                finding = f"lacks the {role.value} that mode {mode.name} takes; add a parameter"
                self._add(node, "RequiredFeature", finding)
        order = (*roles.needed, *roles.optional)
        return tuple(by_role[role] for role in order if role in by_role)

    def _word(self, node: Node, words: type[Word], text: str | None) -> Word | None:
        """Return the member of an enumeration that an annotation names."""
        found = words.__members__.get(text or "")
        if found is None:
            listed = ", ".join(words.__members__)
            what = {"Field": "property"}.get(words.__name__, words.__name__.lower())
            finding = f"has {what} {shown(text or '')}; expected one of {listed}; correct it"
            self._add(node, "EnumLiteral", finding)
        return found

    def _details(self, node: Node, keys: tuple[str, ...]) -> Mapping[str, str]:
        """Return what our annotation of an element says; empty without one."""
        if node not in self._said:
            entries = [entry for note in _annotations(node) for entry in note.children]
            said: dict[str, str] = {}
            for entry in entries:
                key = entry.attributes.get("key", "")
                if key not in keys or key in said:
                    finding = (
                        f"has the key {shown(key)}; expected {', '.join(keys)}, each once; "
                        "correct it"
                    )
                    self._add(entry, "KnownFeature", finding)
                said[key] = entry.attributes.get("value", "")
            self._said[node] = said
        return self._said[node]

    def _require_containments(self, root: Node, kinds: list[Node]) -> None:
        """Refuse fault types that no fault can hold, and several of them in one feature."""
        held: set[str] = set()
        names = {_name(kind) for kind in kinds}
        for feature in _contained(root, "Fault"):
            target = feature.attributes["eType"].rpartition("/")[2]
            if target in names and feature.attributes.get("upperBound", "1") != "1":
                finding = "holds many fault types, of which a fault has one; delete upperBound"
                self._add(feature, "SingleValue", finding)
            held.add(target)
        for kind in kinds:
            if not _is_abstract(kind) and not held & {_name(k) for k in self._lineage(kind)}:
                finding = "is contained in no feature of Fault; expected one of its type; add it"
                self._add(kind, "RequiredFeature", finding)

    def _require_all_read(self, root: Node) -> None:
        """Refuse annotations of ours at what is no fault type or parameter, or that say nothing."""
        for node in root.walk():
            source = node.attributes.get("source", "")
            if source.startswith(OURS) and (source != MEANING or node.parent not in self._said):
                finding = (
                    f"has the source {shown(source)}; expected {MEANING} at a fault type or a "
                    "parameter of one, and no other source of ours; correct or delete it"
                )
                self._add(node, "KnownFeature", finding)
            elif source == MEANING and not node.children:
                finding = "says nothing; expected details with a key and a value; delete it"
                self._add(node, "RequiredFeature", finding)

    def _add(self, node: Node, constraint: str, finding: str) -> None:
        """Add a defect once, however many classes inherit it."""
        if (node, finding) not in self._found:
            self._found.add((node, finding))
            self._report.add(node, constraint, finding)


def _name(node: Node) -> str:
    return node.attributes.get("name", "")


def _is_abstract(node: Node) -> bool:
    return node.attributes.get("abstract") == "true"


def _annotations(node: Node) -> list[Node]:
    return [child for child in node.children if child.attributes.get("source") == MEANING]


def _numbers(classes: Iterable[Node]) -> Iterator[Node]:
    """Yield the attributes of classes that hold one number, and all that have an annotation."""
    for known in classes:
        for feature in known.children:
            is_one = feature.attributes.get("upperBound", "1") == "1"
            if is_one and feature.attributes.get("eType", "").endswith(_NUMBERS):
                yield feature


def _is_bound(feature: Node, numbers: Mapping[str, Node]) -> bool:
    """Return whether a number is the bound of another one of its class."""
    name = _name(feature)
    bounded = (numbers.get(name.removesuffix(end)) for end in BOUNDS if name.endswith(end))
    return any(known is not None and known.parent is feature.parent for known in bounded)


def _is_of_property(parameter: Parameter, role: Role, touched: tuple[Field, ...]) -> bool:
    """Return whether a value has the range of the property that takes it."""
    is_value = role in (Role.VALUE, Role.LOWEST, Role.HIGHEST) and touched[:1] != ()
    return not is_value or touched[0] not in REPORTED or parameter.range.name == touched[0].name


def _contained(root: Node, class_name: str) -> Iterator[Node]:
    """Yield the features of a class that contain something."""
    for node in root.children:
        if node.tag == "eClassifiers" and _name(node) == class_name:
            for feature in node.children:
                if feature.attributes.get("containment") == "true":
                    yield feature
