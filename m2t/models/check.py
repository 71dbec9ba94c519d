"""Check the nodes of a model against the metamodel: values, structure, references.

pyecore's reader accepts most defects and stops at the first of the others. So every node is
checked here, and all defects are reported, before any object is made. Numbers are accepted as in
Java, without spellings that only Python has: a model that loads here loads in Eclipse. A part may
stand in a separate file, as Eclipse splits models; it is moved into place.

Begin with ``require_value`` for one attribute, then ``check_structure``, then ``resolve``.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from pyecore.ecore import EEnum

from m2t.metaclasses import Slot, base_class, concrete_classes, conforms, slots
from m2t.read import (
    ROOT_ATTRIBUTES,
    XMI,
    XSI,
    Defect,
    ModelFile,
    ModelFiles,
    Node,
    Report,
    contained_path,
    listed,
    local_path,
    resolved_path,
    shown,
)
from mrsfi_runtime.model.faults import LAST, MOST
from mrsfi_runtime.model.polygons import MOST_CORNERS

MAX_NAME_LENGTH = 200
MAX_TEXT_LENGTH = 2_000

DOUBLE = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf(inity)?)", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Range:
    """Numbers that a feature allows, and the constraint that requires them."""

    constraint: str
    lowest: float
    highest: float = math.inf
    is_open: bool = False

    def __contains__(self, value: float) -> bool:
        above = value > self.lowest if self.is_open else value >= self.lowest
        return above and value <= self.highest

    def __str__(self) -> str:
        if self.highest < math.inf:
            above = "above " * self.is_open
            return f"{above}{self.lowest:,} to {self.highest:,}"
        return f"a number above {self.lowest}" if self.is_open else f"{self.lowest} or more"


_TICKS = Range("DelayNotNegative", 0, LAST)

RANGES: Mapping[str, Range] = {
    "duration": Range("DurationInRange", 1, 10_000_000),
    "radius": Range("RadiusPositive", 0, is_open=True),
    **dict.fromkeys(("speed", "maxSpeed"), Range("SpeedNotNegative", 0)),
    "turnRate": Range("TurnRateInRange", 0, 180, is_open=True),
    "positionNoise": Range("NoiseNotNegative", 0),
    "clearance": Range("ClearanceNotNegative", 0),
    **dict.fromkeys(
        ("energyPerSample", "totalEnergy", "energyPerDistanceUnit"), Range("EnergyNotNegative", 0)
    ),
    "samplesPerSecond": Range("SamplesPerSecondPositive", 1),
    "targetSampleNumber": Range("TargetSampleNumberNotNegative", 0),
    "requiredMembers": Range("RequiredMembersNotNegative", 0),
    "grace": Range("GraceNotNegative", 0),
    "severity": Range("SeverityInRange", 1, 10),
    "period": Range("PeriodPositive", 1),
    "deadline": Range("DeadlinePositive", 1),
    "tolerance": Range("TolerancePositive", 0, is_open=True),
    "fixedDistance": Range("FixedDistancePositive", 0, is_open=True),
    **dict.fromkeys(("start", "finish"), Range("WindowNotNegative", 0)),
    "likelihood": Range("LikelihoodInRange", 0, 1),
    "delay": _TICKS,
}
"""Allowed numbers by feature name; a feature of that name means the same in every class."""

POLYGONS = {("Patrol", "route"), *((of, "area") for of in ("Obstacle", "Goal", "Patrol", "Stay"))}
"""Classes and their features whose areas may be polygons."""


def require_value(slot: Slot, text: str) -> None:
    """Raise a ``Defect`` if a text is no value of an attribute, or outside its range."""
    if slot.type.name == "EString":
        limit = MAX_NAME_LENGTH if slot.name in ("ID", "name") else MAX_TEXT_LENGTH
        if len(text) > limit:
            found = f"has a {slot.name} of {len(text):,} characters"
            raise Defect("StringLength", f"{found}; expected at most {limit:,}; shorten it")
        return
    for constraint, is_kept, expected in _rules(slot, text):
        if not is_kept:
            raise Defect(constraint, f"has {slot.name} {shown(text)}; expected {expected}")


def _rules(slot: Slot, text: str) -> Iterator[tuple[str, bool, str]]:
    """Yield each rule for a text, and whether it is met; each one assumes the one before."""
    kind = slot.type.name
    if isinstance(slot.type, EEnum):
        names = [literal.name for literal in slot.type.eLiterals]
        yield "EnumLiteral", text in names, f"one of {listed(names, text)}; correct the spelling"
    elif kind == "EBoolean":
        is_literal = text in ("true", "false")
        yield "EnumLiteral", is_literal, "true or false; correct the spelling"
    elif kind == "EInt":
        is_number = re.fullmatch(r"[+-]?[0-9]{1,20}", text) is not None
        is_whole = is_number and int(text) in range(-(2**31), 2**31)
        yield "NumberSyntax", is_whole, "a whole number of 32 bits, such as 20; correct it"
    else:
        yield "FiniteNumber", not _NOT_FINITE.fullmatch(text), "a finite number; correct it"
        yield "NumberSyntax", bool(DOUBLE.fullmatch(text)), "a number such as 2.5; correct it"
        is_near = abs(float(text)) <= MOST
        yield "NumberMagnitude", is_near, "a number between -1.0E12 and 1.0E12; correct it"
    allowed = _TICKS if slot.counts_ticks else RANGES.get(slot.name)
    if allowed is not None and kind in ("EInt", "EDouble"):
        yield allowed.constraint, float(text) in allowed, f"{allowed}; correct it"


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference as text: ``targets`` are fragments, or file and fragment.

    ``source`` is the node that refers; ``node`` contains the text: the same node, or a child with
    an href.
    """

    source: Node
    slot: Slot
    node: Node
    targets: tuple[str, ...]


@dataclass(slots=True, eq=False)
class ModelTree:
    """The nodes of one model, each with its metaclass, and the references between them.

    Parts from other files stand in place below ``root``. ``by_id`` has the elements of all files.
    ``resolved`` has the target nodes of each resolved reference.
    """

    root: Node
    files: ModelFiles
    by_id: dict[str, Node] = field(default_factory=dict)
    references: list[Reference] = field(default_factory=list)
    resolved: list[tuple[Reference, tuple[Node, ...]]] = field(default_factory=list)


@dataclass(slots=True)
class ReadModel:
    """A model while it is loaded: its first file, its nodes, and its root object once made.

    ``tree`` is ``None`` if the nodes cannot be used. If not ``is_whole``, the objects lack the
    references to missing elements.
    """

    path: Path
    tree: ModelTree | None = None
    root: Any = None
    is_whole: bool = True


def check_structure(
    file: ModelFile, metaclass: Any, files: ModelFiles, report: Report
) -> ModelTree | None:
    """Check the nodes of the model that begins in a file, and give each its metaclass.

    Files with its parts are read as well. Return the nodes; ``None`` if the file has no root of the
    class.
    """
    roots = file.roots_of(metaclass)
    if not roots:
        file.claimed.update(file.roots)
        for root in file.roots[:1]:
            found = f"{{{root.namespace}}}{root.tag}" if root.namespace else root.tag
            finding = (
                f"is the root ({shown(found)}); expected {metaclass.name} of namespace "
                f"{metaclass.ePackage.nsURI}; correct the root or give the right file"
            )
            report.add(root, "RootElement", finding)
        return None
    for other in roots[1:]:
        found = f"is a second {metaclass.name} of {file.path.name}"
        report.add(other, "RootElement", f"{found}; expected one; delete the others")
    file.claimed.update(roots)
    checker = _Checker(ModelTree(roots[0], files), metaclass.ePackage, report)
    checker.element(roots[0], metaclass)
    return checker.tree


def check_claims(files: ModelFiles, report: Report) -> None:
    """Report roots of files that belong to no model, because saving would lose them."""
    for file in files:
        for root in file.roots:
            if root not in file.claimed:
                finding = (
                    f"is a root of {file.path.name} that no model contains; expected an element "
                    f'with href="{file.path.name}#..." in its place; add one or delete the root'
                )
                report.add(root, "ContainedElement", finding)


def report_count(element: Any, slot: Slot, count: int, report: Report) -> None:
    """Report that a node or object has too few or too many values of a feature."""
    name = slot.name
    if count < slot.lower_bound:
        expected = f"at least {slot.lower_bound}" if slot.many else "one"
        finding = f"has {count or 'no'} {name}; expected {expected}; add what is missing"
        report.add(element, "RequiredFeature", finding)
    else:
        report.add(element, "SingleValue", f"has {count} {name}; expected one; delete the others")


class _Checker:
    """Walks the nodes of one model, from file to file."""

    def __init__(self, tree: ModelTree, package: Any, report: Report) -> None:
        self.tree = tree
        self._package = package
        self._report = report

    def element(self, node: Node, metaclass: Any) -> None:
        node.metaclass = metaclass
        for child in node.children:  # a default namespace applies to children too
            if child.namespace == self._package.nsURI:
                child.namespace = ""  # a feature, as Eclipse takes it
        given = Counter(child.tag for child in node.children if not child.namespace)
        if text := node.text.strip():
            finding = f"holds the text {shown(text)}; expected attributes and elements; delete it"
            self._report.add(node, "NoText", finding)
        for name, text in node.attributes.items():
            given[name] += self._attribute(node, name, text)
        self._qualified(node)
        node.children[:] = [self._child(node, child) for child in node.children]
        for slot in slots(metaclass).values():
            count = given[slot.name]
            if count < slot.lower_bound or (count > 1 and not slot.many):
                report_count(node, slot, count, self._report)
        if base_class(metaclass).name == "Area":
            self._shape(node, given["corners"], has_radius=given["radius"] > 0)

    def _shape(self, node: Node, n_corners: int, *, has_radius: bool) -> None:
        """Check that an area is a disc, or a polygon where that is allowed."""
        parent = node.parent
        owner = "" if parent is None else base_class(parent.metaclass).name
        if not n_corners:
            finding = "" if has_radius else "has no radius; expected one, or corners; add one"
        elif (owner, node.tag) not in POLYGONS:
            finding = "has corners; expected a disc here; give it a radius instead"
        elif has_radius:
            finding = "has a radius and corners; expected one of them; delete the other"
        else:
            finding = f"has {n_corners} corners; expected 3 to {MOST_CORNERS}; correct them"
            finding = "" if 3 <= n_corners <= MOST_CORNERS else finding
        if finding:
            self._report.add(node, "AreaShape", finding)

    def _attribute(self, node: Node, name: str, text: str) -> int:
        """Check an attribute; return the number of its values."""
        slot = slots(node.metaclass).get(name)
        if slot is None:
            self._unknown(node, name, f"has no attribute {shown(name)}", node, "attribute")
        elif slot.is_reference:
            targets = tuple(text.split())
            self.tree.references.append(Reference(node, slot, node, targets))
            return len(targets)
        elif slot.is_contained:
            finding = f"has {name} as an attribute; expected an element <{name}> in place"
            self._report.add(node, "ContainedElement", f"{finding}; move it there")
        else:
            self._value(node, slot, text)
        return 1

    def _value(self, node: Node, slot: Slot, text: str) -> None:
        try:
            require_value(slot, text)
        except Defect as defect:
            self._report.add(node, defect.constraint, defect.finding)
            if slot.is_id:  # too long, but references to it still resolve
                self.tree.files.containing(node).by_id.setdefault(text, node)
            return
        if slot.is_id:
            self._remember_id(node, text)

    def _remember_id(self, node: Node, identity: str) -> None:
        in_file = self.tree.files.containing(node).by_id.setdefault(identity, node)
        in_model = self.tree.by_id.setdefault(identity, node)
        first = in_file if in_file is not node else in_model
        if first is not node:
            place = f"line {first.line}" + ("" if first.path == node.path else f" of {first.path}")
            finding = (
                f"has the ID of {first.tag} in {place}; expected IDs that are unique in "
                "the file, over all classes; rename one"
            )
            self._report.add(node, "UniqueId", finding)

    def _qualified(self, node: Node) -> None:
        """Check attributes of other namespaces: only those of XMI and XSI are allowed."""
        file = self.tree.files.containing(node)
        expected = ROOT_ATTRIBUTES if node in file.claimed else {(XSI, "type"), (XMI, "type")}
        for (namespace, name), text in node.qualified.items():
            if (namespace, name) == (XMI, "id"):
                first = file.by_xmi_id.setdefault(text, node)
                if first is not node:
                    finding = (
                        f"has xmi:id {shown(text)}, as has an element in line {first.line}; "
                        "expected different ones; change one"
                    )
                    self._report.add(node, "UniqueId", finding)
            elif (namespace, name) not in expected:
                finding = (
                    f"has attribute {shown(f'{{{namespace}}}{name}')}, which no metamodel "
                    "declares; expected attributes of the metamodel; delete it"
                )
                self._report.add(node, "KnownFeature", finding)

    def _child(self, node: Node, child: Node) -> Node:
        """Check a child; return it, or the node of another file that its href refers to."""
        slot = slots(node.metaclass).get(child.tag) if not child.namespace else None
        if slot is None:
            of = f" (namespace {shown(child.namespace)})" if child.namespace else ""
            what = f"is an unknown element of {node.description}{of}"
            self._unknown(child, child.tag, what, node, "element")
        elif slot.is_contained:
            return self._contain(node, slot, child)
        elif slot.is_reference:
            self._refer(node, slot, child)
        else:
            self._value(node, slot, child.text)
        return child

    def _contain(self, node: Node, slot: Slot, child: Node) -> Node:
        try:
            if "href" in child.attributes:
                part, kind = self._part(child, slot.type)
            else:
                part, kind = child, self._concrete_type(slot.type, child)
        except Defect as defect:
            beside = [
                f", or use <{other.name} href=...>, which refers to one"
                for other in slots(node.metaclass).values()
                if other.is_reference and other.type is slot.type and "href" in child.attributes
            ]
            self._report.add(child, defect.constraint, "".join((defect.finding, *beside)))
            return child
        self.element(part, kind)
        return part

    def _part(self, child: Node, declared: Any) -> tuple[Node, Any]:
        """Return the root of another file that an element with an href stands for, and its class.

        The root takes the element's tag and parent. If no root fits, or another element already
        contains it, this raises a ``Defect``.
        """
        if set(child.attributes) != {"href"} or child.children or child.text.strip():
            finding = f"has an href and more; expected <{child.tag[:60]} href=...> alone"
            raise Defect("ContainedElement", f"{finding}; correct it")
        target = child.attributes["href"]
        address, _, fragment = target.rpartition("#")
        file = self._file(child, address)
        root = file.root(unquote(fragment))
        if root is None or root in file.claimed:
            what = "is no root of that file" if root is None else "is contained already"
            raise Defect(
                "ContainedElement",
                f"stands for {shown(target)}, which {what}; expected a root of "
                f"{file.path.name} that stands nowhere else; correct the href",
            )
        file.claimed.add(root)
        kinds = concrete_classes(self._package, declared)
        found = kinds.get(root.tag) if root.namespace == self._package.nsURI else None
        named = found if child.xsi_type is None else self._named_class(kinds, child)
        if found is None or named is not found:
            raise Defect(
                "ConcreteType",
                f"stands for {shown(target)}, which is a {root.tag[:60]}; expected one of "
                f"{', '.join(kinds)}, the same as xsi:type if that is given; correct the href",
            )
        root.tag, root.namespace, root.parent = child.tag, "", child.parent
        return root, found

    def _file(self, child: Node, address: str) -> ModelFile:
        """Return the file of a part; refuse files outside the project, and circles of files."""
        files = self.tree.files
        what = f"stands for {shown(child.attributes['href'])}"
        here = files.containing(child)
        owners = (*here.owners, here)
        first, folder = owners[0].path.parent, here.path.parent
        path = contained_path(folder, first, address) if address else None
        if path is None:
            raise Defect(
                "LocalReference" if address else "ContainedElement",
                f"{what}; expected the root of another file, by a relative address inside the "
                "mission's project; move that file there, or the element here",
            )
        known = files.at(path)
        if known is not None and known in owners:
            circle = (*owners[owners.index(known) :], known)
            names = " > ".join(owner.path.name for owner in circle)
            raise Defect(
                "ContainedElement",
                f"{what}, which closes a circle of files ({names}); expected a file that does not "
                "contain this one; move the element into place",
            )
        file = files.read(path, owners)
        if file is None:  # its own defects are reported there
            raise Defect("ContainedElement", f"{what}, a file that cannot be used; correct it")
        return file

    def _named_class(self, kinds: Mapping[str, Any], node: Node) -> Any:
        prefix, _, name = (node.xsi_type or "").rpartition(":")
        return kinds.get(name) if node.prefixes.get(prefix) == self._package.nsURI else None

    def _refer(self, source: Node, slot: Slot, child: Node) -> None:
        target = child.attributes.get("href")
        if target is None or set(child.attributes) != {"href"} or child.children:
            finding = (
                "is a reference; expected only href, such as "
                f'<{child.tag} href="mission.xmi#m1"/>; correct it'
            )
            self._report.add(child, "ContainedElement", finding)
            return
        self.tree.references.append(Reference(source, slot, child, (target,)))

    def _concrete_type(self, declared: Any, child: Node) -> Any:
        if child.xsi_type is None and not declared.abstract:
            return declared
        kinds = concrete_classes(self._package, declared)
        metaclass = self._named_class(kinds, child)
        if metaclass is None:
            found = "no xsi:type" if child.xsi_type is None else f"xsi:type {shown(child.xsi_type)}"
            known = {uri: prefix for prefix, uri in child.prefixes.items()}
            prefix = known.get(self._package.nsURI, self._package.nsPrefix)
            expected = ", ".join(f"{prefix}:{name}".removeprefix(":") for name in kinds)
            raise Defect("ConcreteType", f"has {found}; expected one of {expected}; choose one")
        return metaclass

    def _unknown(self, node: Node, name: str, finding: str, element: Node, what: str) -> None:
        known = slots(element.metaclass).items()
        names = [each for each, slot in known if slot.is_contained == (what == "element")]
        expected = listed(names, name) or f"no {what}s"
        finding = f"{finding}; expected {expected}; correct or delete it"
        self._report.add(node, "KnownFeature", finding)


def referred_files(tree: ModelTree) -> Iterator[tuple[Reference, str]]:
    """Yield the address part of every reference to another file."""
    for reference in tree.references:
        for target in reference.targets:
            if address := _address(target):
                yield reference, address


def resolve(tree: ModelTree, mission: ReadModel | None, report: Report) -> None:
    """Resolve all references of a model, and store their target nodes in it.

    ``mission`` is the mission that the model may refer to, or ``None``.
    """
    resolver = _Resolver(tree, mission, report)
    for reference in tree.references:
        resolver.resolve(reference)


class _Resolver:
    """Resolves the references of one model; looks up every file once."""

    def __init__(self, tree: ModelTree, mission: ReadModel | None, report: Report) -> None:
        self._tree = tree
        self._mission = mission
        self._report = report
        self._named: dict[tuple[Node, str], set[Node]] = {}
        self._file = cache(self._find_file)
        self._known = cache(_known)

    def resolve(self, reference: Reference) -> None:
        slot = reference.slot
        if not slot.many and len(reference.targets) > 1:
            report_count(reference.node, slot, len(reference.targets), self._report)
            return
        found: list[Node] = []
        for target in reference.targets:
            try:
                place = self._place(reference, target)
                if place is not None:
                    found.append(self._element(reference, target, *place))
            except Defect as defect:
                self._report.add(reference.node, defect.constraint, defect.finding)
        known = self._named.setdefault((reference.source, slot.name), set())
        for element in found:
            if element in known and slot.many:
                name = element.attributes.get("ID", element.metaclass.name)
                finding = f"names '{name}' twice in {slot.name}; expected each once; delete one"
                self._report.add(reference.node, "UniqueReference", finding)
            known.add(element)
        self._tree.resolved.append((reference, tuple(found)))

    def _element(self, reference: Reference, target: str, file: ModelFile, tree: ModelTree) -> Node:
        element = file.find(unquote(target.rpartition("#")[2]))
        wanted = reference.slot.type
        if element is not None and conforms(element.metaclass, wanted):
            return element
        expected = f"a {wanted.name}{self._known(tree, wanted, target)}; correct the reference"
        what = f"refers to {shown(target)} as {reference.slot.name}, which"
        if element is None:
            finding = f"{what} does not exist; expected the ID of {expected}"
            raise Defect("ResolvedReference", finding)
        raise Defect("ReferenceType", f"{what} is a {element.metaclass.name}; expected {expected}")

    def _place(self, reference: Reference, target: str) -> tuple[ModelFile, ModelTree] | None:
        """Return the file in which to search for a target, and the model that the file is part of.

        Return ``None`` if that is a broken mission, whose own defects are already reported.
        """
        here = self._tree.files.containing(reference.node)
        address = _address(target)
        if not address:
            return here, self._tree
        mission = self._mission
        tree = self._tree if mission is None else mission.tree
        file, is_mission = self._file(here.path.parent, address)
        if file is not None and tree is not None:
            return file, tree
        if tree is None and is_mission:
            return None
        own = "an element of this file" if mission is None else f"{mission.path.name}#ID"
        raise Defect(
            "LocalReference",
            f"refers to {shown(target)} as {reference.slot.name}; expected {own}, or one of a file "
            "that is part of the mission; correct the reference",
        )

    def _find_file(self, folder: Path, address: str) -> tuple[ModelFile | None, bool]:
        path = local_path(folder, address)
        if path is None:
            return None, False
        mission = self._mission
        is_mission = mission is not None and resolved_path(path) == resolved_path(mission.path)
        return self._tree.files.at(path), is_mission


def _address(target: str) -> str:
    return target.rpartition("#")[0]


def _known(tree: ModelTree, wanted: Any, target: str) -> str:
    """Return the IDs that would fit, for the message; the tree is complete by then."""
    ids = [name for name, element in tree.by_id.items() if conforms(element.metaclass, wanted)]
    return f" ({listed(ids, target.rpartition('#')[2])})" if ids else ""
