"""The two metamodels, and the meaning of fault types in ``faults.ecore``.

``read_metamodels`` reads a folder once per process; begin there. An annotation of a class gives its
mode and the property that it touches. An annotation of a numeric attribute gives the range of that
parameter. A class without annotation inherits its meaning. ``_Reader`` checks all annotations and
collects all defects; metamodels with any defect are refused as a whole.
"""

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

from pyecore.ecore import EAnnotation, EClass

from m2t.metaclasses import BOUNDS, MEANING, OURS, features, is_kind, lineage
from m2t.metamodel_reader import MetamodelReader
from m2t.read import Report, shown
from mrsfi_runtime.errors import ModelError
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
    Struck,
)

Meanings: TypeAlias = Mapping[str, Any]

_STRUCK = {f"{struck.value.title()}Fault": struck for struck in Struck}
_WORDS: Mapping[str, Mapping[str, object]] = {
    "mode": Mode.__members__,
    "property": Field.__members__,
    "range": Range.__members__,
    "role": {role.name: role for role in (Role.LOWEST, Role.HIGHEST)},
    "search": {"true": True, "false": False},
}
"""Words that annotations may contain, by key, with their meanings."""

_VALUES = (Role.VALUE, Role.LOWEST, Role.HIGHEST)
_ROLE_OF_RANGE = {
    of: Role[of.name] for of in (Range.TICKS, Range.PERCENT, Range.X, Range.Y, Range.Z)
}


def read_fault_types(package: Any, report: Report) -> Mapping[str, FaultType]:
    """Return the fault types of a sound package of faults by name, in the order of the file.

    ``report`` has the elements of all packages; only this one may have meanings.
    """
    reader = _Reader(report)
    kinds = [
        kind  # inherits from FaultType, or has a meaning of one
        for kind in package.eClassifiers
        if isinstance(kind, EClass) and (_annotations(kind) or is_kind(kind, "FaultType"))
    ]
    found = [reader.fault_type(kind) for kind in kinds if not kind.abstract]
    reader.require_containments(package.getEClassifier("Fault"), kinds)
    reader.require_all_read()
    types = [kind for kind in found if kind is not None]
    own = [kind.name for kind in types if kind.mode is Mode.OWN]
    numbered = (
        replace(kind, effect=own.index(kind.name)) if kind.name in own else kind for kind in types
    )
    return {kind.name: kind for kind in numbered}


class _Reader:
    """Reads fault types; stores the meanings of elements, and which have unknown words."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._add = report.add
        self._read: dict[Any, Meanings] = {}
        self._unknown: set[Any] = set()

    def fault_type(self, kind: Any) -> FaultType | None:
        n_errors = self._report.n_errors
        meanings = self._meaning(kind)
        found = [_STRUCK[known.name] for known in lineage(kind) if known.name in _STRUCK]
        if len(found) != 1:
            listed = ", ".join(_STRUCK)
            finding = f"inherits from {len(found)} of {listed}; expected one; correct eSuperTypes"
            self._add(kind, "RequiredFeature", finding)
        parameters = self._parameters(kind)
        inherited = {*lineage(kind), *features(kind)}
        if self._report.n_errors > n_errors or inherited & self._unknown:
            return None
        (mode,), touched = meanings["mode"], meanings.get("property", ())
        declared = FaultType(kind.name, mode, found[0], touched, tuple(parameters))
        self._require_reach(kind, declared)
        if mode is Mode.OWN:
            self._require_own(kind, declared, parameters)
            return declared
        return replace(declared, parameters=self._in_order(kind, declared, parameters))

    def require_containments(self, fault: Any, kinds: list[Any]) -> None:
        """Refuse fault types that no fault can hold, and several of them in one feature."""
        contained = [each for each in fault.eStructuralFeatures if getattr(each, "containment", 0)]
        for feature in contained:
            if feature.eType in kinds and feature.many:
                finding = "may hold many fault types, but a fault has one; delete upperBound"
                self._add(feature, "SingleValue", finding)
        held = {feature.eType for feature in contained}
        for kind in kinds:
            if not kind.abstract and held.isdisjoint(lineage(kind)):
                finding = "is contained in no feature of Fault; expected one of its type; add it"
                self._add(kind, "RequiredFeature", finding)

    def require_all_read(self) -> None:
        """Refuse our annotations elsewhere than at a fault type or parameter, and empty ones."""
        for note in self._report.places:
            source = (note.source or "") if isinstance(note, EAnnotation) else ""
            is_read = source == MEANING and note.eContainer() in self._read
            if source.startswith(OURS) and not is_read:
                finding = (
                    f"has the source {shown(source)}; expected {MEANING} at a fault type or a "
                    "parameter of one, and no other source of mrsfi; correct or delete it"
                )
                self._add(note, "KnownFeature", finding)
            elif source == MEANING and not note.details:
                finding = "is empty; expected details with a key and a value; delete it"
                self._add(note, "RequiredFeature", finding)

    def _annotated(self, element: Any, keys: tuple[str, ...]) -> Meanings:
        """Return the meanings in our annotations of an element, by key; empty without one."""
        if element not in self._read:
            meanings: dict[str, Any] = {}
            for note in _annotations(element):
                for key, text in note.details.items():
                    if key not in keys or key in meanings:
                        expected = f"expected {', '.join(keys)}, each once; correct it"
                        finding = f"has the key {shown(key or '')}; {expected}"
                        self._add(note, "KnownFeature", finding)
                    else:
                        meanings[key] = tuple(self._meant(note, key, text or ""))
            self._read[element] = meanings
        return self._read[element]

    def _meant(self, note: Any, key: str, text: str) -> Iterator[object]:
        """Yield the meaning of each word of an entry; a class may touch several properties."""
        known = _WORDS[key]
        for word in text.split() if key == "property" else [text]:
            if word not in known:
                finding = f"has {key} {shown(word)}; expected one of {', '.join(known)}; correct it"
                self._add(note, "EnumLiteral", finding)
                self._unknown.add(note.eContainer())
            yield known.get(word)

    def _meaning(self, kind: Any) -> Meanings:
        """Return the meanings of the nearest annotated class of a lineage."""
        keys = ("mode", "property")
        meanings = (self._annotated(known, keys) for known in reversed(lineage(kind)))
        nearest = next(filter(None, meanings), {})
        if "mode" not in nearest:
            finding = (
                f"has no mode; expected an annotation of source {MEANING} with a mode "
                f"({', '.join(Mode.__members__)}) and the property that it acts on; add one"
            )
            self._add(kind, "RequiredFeature", finding)
        return nearest

    def _parameters(self, kind: Any) -> dict[Parameter, Role]:
        numbers = {
            feature.name: feature
            for feature in features(kind)
            if not feature.many and feature.eType.name in {"EInt", "EDouble"}
        }
        found = {}
        for feature in features(kind):
            ends = [end for end in BOUNDS if feature.name.endswith(end)]
            bounded = numbers.get(feature.name.removesuffix(*ends)) if ends else None
            if feature.name not in numbers:
                if bounded is not None:
                    finding = "bounds a parameter; expected one EInt or EDouble; correct it"
                    self._add(feature, "ReferenceType", finding)
                continue
            meanings = self._annotated(feature, ("range", "role", "search"))
            is_bound = bounded is not None and bounded.eContainer() is feature.eContainer()
            if "range" in meanings:
                (of,), (evolves,) = meanings["range"], meanings.get("search", (True,))
                is_integer = feature.eType.name == "EInt" or of is Range.TICKS
                (role,) = meanings.get("role", (_ROLE_OF_RANGE.get(of, Role.VALUE),))
                found[Parameter(feature.name, of, evolves, is_integer)] = role
            elif meanings or not is_bound:
                finding = (
                    f"of {kind.name} is a number without a range; every number of a fault type is "
                    f"a parameter; expected an annotation of source {MEANING} with a range "
                    f"({', '.join(Range.__members__)}); add one, or put what is no parameter into "
                    "Fault"
                )
                self._add(feature, "RequiredFeature", finding)
        return found

    def _require_reach(self, node: Any, kind: FaultType) -> None:
        for affected in kind.properties or (None,):
            if affected not in WITHIN_REACH[kind.struck]:
                listed = ", ".join(field.name for field in WITHIN_REACH[kind.struck] if field)
                what = "no property" if affected is None else f"property {affected.name}"
                finding = (
                    f"of mode {kind.mode.name} touches {what}, but refers to one "
                    f"{kind.struck.value}; expected one of {listed}, or another supertype; "
                    "correct either"
                )
                self._add(node, "RequiredFeature", finding)

    def _require_own(self, node: Any, kind: FaultType, roles: Mapping[Parameter, Role]) -> None:
        """Refuse a type of mode OWN for which no region can be written."""
        touched = {*kind.properties}
        is_one_kind = any(touched <= {*known} for known in ELEMENTS)
        if not touched or not is_one_kind or len(touched) < len(kind.properties):
            choices = "; or ".join(", ".join(field.name for field in known) for known in ELEMENTS)
            finding = f"of mode OWN touches {_names(kind)}; expected some of: {choices}"
            self._add(node, "EnumLiteral", f"{finding}; correct property, or make a type for each")
        if len(roles) > N_VALUES:
            finding = f"has {len(roles)} parameters; mode OWN takes at most {N_VALUES}; join some"
            self._add(node, "KnownFeature", finding)
        for parameter, role in roles.items():
            if role.name in _WORDS["role"]:
                finding = f"has parameter {parameter.name} with a role; mode OWN has none"
                self._add(node, "KnownFeature", f"{finding}; delete it")

    def _in_order(
        self, node: Any, kind: FaultType, declared: Mapping[Parameter, Role]
    ) -> tuple[Parameter, ...]:
        known, mode = ROLES[kind.mode], kind.mode.name
        affected = kind.properties[0] if kind.properties else None
        if len(kind.properties) > 1 or affected not in known:
            listed = ", ".join(field.name if field else "no property" for field in known)
            finding = f"of mode {mode} touches {_names(kind)}; expected {listed}; correct property"
            self._add(node, "EnumLiteral", finding)
            return ()
        order = known[affected]
        needed = [role for role in order if role is not Role.Z]
        by_role: dict[Role, Parameter] = {}
        for parameter, role in declared.items():
            if role not in order or role in by_role:
                listed = " and ".join(role.value for role in needed) or "no parameter"
                finding = (
                    f"has parameter {parameter.name} as its {role.value}; mode {mode} takes "
                    f"{listed}; delete it, or correct its range or role"
                )
                self._add(node, "KnownFeature", finding)
            elif role in _VALUES and affected in REPORTED and parameter.range.name != affected.name:
                finding = (
                    f"has parameter {parameter.name} of range {parameter.range.name}; expected "
                    f"{affected.name}, that of its property; correct it"
                )
                self._add(node, "EnumLiteral", finding)
            by_role.setdefault(role, parameter)
        for role in needed:
            if role not in by_role:
                finding = f"lacks the {role.value} that mode {mode} takes; add a parameter"
                self._add(node, "RequiredFeature", finding)
        return tuple(by_role[role] for role in order if role in by_role)


def _annotations(element: Any) -> list[Any]:
    return [note for note in element.eAnnotations if note.source == MEANING]


def _names(kind: FaultType) -> str:
    return " and ".join(field.name for field in kind.properties) or "no property"


MISSION_FILE = "mission.ecore"
FAULTS_FILE = "faults.ecore"
MISSION_ROOT = "Mission"
FAULTS_ROOT = "FaultSpecification"


@dataclass(frozen=True, slots=True)
class Metamodels:
    """The packages ``mission`` and ``faults`` as pyecore objects, and the fault types by name."""

    mission: Any
    faults: Any
    fault_types: Mapping[str, FaultType]

    @property
    def mission_class(self) -> Any:
        """Class of the root of a mission model."""
        return self.mission.getEClassifier(MISSION_ROOT)

    @property
    def faults_class(self) -> Any:
        """Class of the root of a fault model."""
        return self.faults.getEClassifier(FAULTS_ROOT)

    @property
    def packages(self) -> tuple[Any, Any]:
        """Both packages; the second refers to the first."""
        return (self.mission, self.faults)


def metamodel_folder() -> Path:
    """Return the folder that the variable ``MRSFI_METAMODELS`` names, or else the installed one."""
    chosen = os.environ.get("MRSFI_METAMODELS")
    return Path(chosen) if chosen else installed_metamodels()


@cache
def installed_metamodels() -> Path:
    """Return the folder of our metamodels: inside the installed package or in the source tree.

    If neither place has them, this raises a ``ModelError``.
    """
    candidates = [place / "metamodels" for place in Path(__file__).resolve().parents[:2]]
    for folder in candidates:
        if (folder / MISSION_FILE).is_file() and (folder / FAULTS_FILE).is_file():
            return folder
    places = " and ".join(str(folder) for folder in candidates)
    what = f"{MISSION_FILE} and {FAULTS_FILE} are missing in {places}"
    raise ModelError(f"{what}; install mrsfi again")


def load_metamodels() -> Metamodels:
    """Load both metamodels of ``metamodel_folder``, once per process and folder.

    Files that are missing or cannot be used raise a ``ModelError``.
    """
    return read_metamodels(metamodel_folder())


@cache
def read_metamodels(folder: Path) -> Metamodels:
    """Read ``mission.ecore`` and ``faults.ecore`` from a folder, once.

    Defects of the files, one per line, raise a ``ModelError``.
    """
    reader = MetamodelReader()
    mission = reader.read(folder / MISSION_FILE, MISSION_ROOT)
    faults = reader.read(folder / FAULTS_FILE, FAULTS_ROOT)
    types = read_fault_types(faults, reader.report)
    reader.report.require_no_errors()
    return Metamodels(mission, faults, types)


def meaning(fault_type: Any) -> FaultType:
    """Return the meaning of a fault type by its class in the metamodel."""
    return load_metamodels().fault_types[fault_type.eClass.name]
