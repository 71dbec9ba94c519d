"""Resolve the references of a model, inside its file and into the mission's file."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from m2t.check.structure import ModelTree, ReadModel, Reference, report_count
from m2t.diagnostics import Defect, Report, listed, shown
from m2t.metaclasses import conforms
from m2t.read.model_files import ModelFile, local_path, resolved_path
from m2t.read.nodes import Node


def referred_files(tree: ModelTree) -> Iterator[tuple[Reference, str]]:
    """Return the file part of every reference that leads out of its own file."""
    for reference in tree.references:
        for target in reference.targets:
            address = _address(target)
            if address:
                yield reference, address


def resolve(tree: ModelTree, mission: ReadModel | None, report: Report) -> None:
    """Find the nodes that all references of a model lead to; the model takes them.

    ``mission`` is the mission, if the model may refer to it.
    """
    resolver = _Resolver(tree, mission, report)
    for reference in tree.references:
        resolver.resolve(reference)


class _Resolver:
    """Resolves the references of one model; asks for every file once."""

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
        found = tuple(self._elements(reference))
        known = self._named.setdefault((reference.source, slot.name), set())
        for element in found:
            if element in known and slot.many:
                name = element.attributes.get("ID", element.metaclass.name)
                finding = f"names '{name}' twice in {slot.name}; expected each once; delete one"
                self._report.add(reference.node, "UniqueReference", finding)
            known.add(element)
        self._tree.resolved.append((reference, found))

    def _elements(self, reference: Reference) -> Iterator[Node]:
        """Yield the elements that the targets mean, if they exist and are of the right class."""
        for target in reference.targets:
            try:
                place = self._place(reference, target)
                if place is not None:
                    yield self._element(reference, target, *place)
            except Defect as defect:
                self._report.add(reference.node, defect.constraint, defect.finding)

    def _element(self, reference: Reference, target: str, file: ModelFile, tree: ModelTree) -> Node:
        element = file.find(unquote(target.rpartition("#")[2]))
        wanted = reference.slot.type
        if element is not None and conforms(element.metaclass, wanted):
            return element
        expected = f"a {wanted.name}{self._known(tree, wanted, target)}; correct the reference"
        what = f"refers to {shown(target)} as {reference.slot.name}, which"
        if element is None:
            raise Defect(
                "ResolvedReference", f"{what} does not exist; expected the ID of {expected}"
            )
        raise Defect("ReferenceType", f"{what} is a {element.metaclass.name}; expected {expected}")

    def _place(self, reference: Reference, target: str) -> tuple[ModelFile, ModelTree] | None:
        """Return the file that a target is looked for in, and the model that it is part of.

        It is ``None`` if that is a mission that is broken: its own defects are reported already.
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
    """Return the IDs that would fit, for the message; a tree is complete by now."""
    ids = [name for name, element in tree.by_id.items() if conforms(element.metaclass, wanted)]
    return f" ({listed(ids, target.rpartition('#')[2])})" if ids else ""
