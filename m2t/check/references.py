"""Resolve the references of a model, inside its file and into the mission's file."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from m2t.check.structure import ModelTree, ReadModel, Reference
from m2t.diagnostics import Defect, Report, shown
from m2t.metamodels import conforms
from m2t.read.addresses import local_path, resolved_path
from m2t.read.model_files import ModelFile
from m2t.read.nodes import Node


def referred_files(tree: ModelTree) -> Iterator[tuple[Reference, str]]:
    """Return the file part of every reference that leads out of its own file."""
    for reference in tree.references:
        for target in reference.targets:
            address = _address(target)
            if address:
                yield reference, address


def resolve(tree: ModelTree, mission: ReadModel | None, report: Report) -> None:
    """Find the nodes that all references of a model lead to.

    Parameters
    ----------
    tree
        The model; takes the resolved references.
    mission
        The mission, if the model may refer to it.
    report
        Takes the diagnostics.
    """
    resolver = _Resolver(tree, mission, report)
    for reference in tree.references:
        resolver.resolve(reference)


@dataclass(frozen=True, slots=True)
class _Place:
    """Where the target of a reference is looked for: a file, and the model that it is part of."""

    file: ModelFile
    tree: ModelTree


class _Resolver:
    """Resolves the references of one model; asks for every file once."""

    def __init__(self, tree: ModelTree, mission: ReadModel | None, report: Report) -> None:
        self._tree = tree
        self._mission = mission
        self._report = report
        self._named: dict[tuple[Node, str], set[Node]] = {}
        self._files: dict[tuple[Path, str], Path | None] = {}
        self._listed: dict[tuple[bool, Any], str] = {}

    def resolve(self, reference: Reference) -> None:
        """Find the nodes of one reference."""
        slot = reference.slot
        if not slot.many and len(reference.targets) > 1:
            self._report.add(
                reference.node,
                "SingleValue",
                f"has {len(reference.targets)} {slot.name}; expected one; delete the others",
            )
            return
        found = tuple(self._elements(reference))
        known = self._named.setdefault((reference.source, slot.name), set())
        for element in found:
            if element in known and slot.many:
                self._report.add(
                    reference.node,
                    "UniqueReference",
                    f"names {_named(element)} twice in {slot.name}; expected each once; delete one",
                )
            known.add(element)
        self._tree.resolved.append((reference, found))

    def _elements(self, reference: Reference) -> Iterator[Node]:
        """Yield the elements that the targets mean, if they exist and are of the right class."""
        for target in reference.targets:
            try:
                place = self._place(reference, target)
                if place is not None:
                    yield self._element(reference, target, place)
            except Defect as defect:
                self._report.add(reference.node, defect.constraint, defect.finding)

    def _element(self, reference: Reference, target: str, place: _Place) -> Node:
        element = find(place.file, unquote(target.rpartition("#")[2]))
        wanted = reference.slot.type
        if element is not None and conforms(element.metaclass, wanted):
            return element
        expected = f"a {wanted.name}{self._known(place.tree, wanted)}; correct the reference"
        what = f"refers to {shown(target)} as {reference.slot.name}, which"
        if element is None:
            finding = f"{what} does not exist; expected the ID of {expected}"
            raise Defect("ResolvedReference", finding)
        finding = f"{what} is a {element.metaclass.name}; expected {expected}"
        raise Defect("ReferenceType", finding)

    def _place(self, reference: Reference, target: str) -> _Place | None:
        """Return where a target is looked for; ``None`` if that is a mission that is broken."""
        here = self._tree.files.containing(reference.node)
        address = _address(target)
        if not address:
            return _Place(here, self._tree)
        path = self._path(here, address)
        tree = self._tree if self._mission is None else self._mission.tree
        file = None if path is None else self._tree.files.at_resolved(path)
        if file is not None and tree is not None:
            return _Place(file, tree)
        is_mission = self._mission is not None and path == resolved_path(self._mission.path)
        if tree is None and is_mission:  # its own defects are reported already
            return None
        mission = self._mission
        own = "an element of this file" if mission is None else f"{mission.path.name}#ID"
        finding = (
            f"refers to {shown(target)} as {reference.slot.name}; expected {own}, or one of a file "
            "that is part of the mission; correct the reference"
        )
        raise Defect("LocalReference", finding)

    def _path(self, here: ModelFile, address: str) -> Path | None:
        """Return the path without links that an address means; kept for reuse."""
        key = (here.path, address)
        if key not in self._files:
            path = local_path(here.path.parent, address)
            self._files[key] = None if path is None else resolved_path(path)
        return self._files[key]

    def _known(self, tree: ModelTree, wanted: Any) -> str:
        """Return the IDs that would fit, for the message; a tree is complete by now."""
        key = (tree is self._tree, wanted)
        if key not in self._listed:
            self._listed[key] = _known(tree, wanted)
        return self._listed[key]


def find(file: ModelFile, fragment: str) -> Node | None:
    """Return the checked node that a fragment means: by xmi:id, by ID, or by path."""
    if fragment.startswith("/"):
        found = file.at_path(fragment, file.checked_children)
        return None if found is None or found.metaclass is None else found
    return file.by_xmi_id.get(fragment) or file.by_id.get(fragment)


def _address(target: str) -> str:
    return target.rpartition("#")[0]


def _known(tree: ModelTree, wanted: Any) -> str:
    """Return the IDs that would fit, for the message."""
    ids = [name for name, element in tree.by_id.items() if conforms(element.metaclass, wanted)]
    listed = ", ".join(ids[:12]) + (", ..." if len(ids) > 12 else "")
    return f" ({listed})" if ids else ""


def _named(element: Node) -> str:
    return f"'{element.attributes.get('ID', element.metaclass.name)}'"
