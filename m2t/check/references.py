"""Resolve the references of a model, inside its file and into the mission's file."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

from m2t.check.structure import ModelTree, ReadModel, Reference
from m2t.diagnostics import Report, shown
from m2t.metamodels import conforms
from m2t.read.addresses import local_path, resolved_path
from m2t.read.model_files import ModelFile
from m2t.read.nodes import Node

if TYPE_CHECKING:
    from pathlib import Path


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
        elements = (self._element(reference, target) for target in reference.targets)
        found = tuple(element for element in elements if element is not None)
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

    def _element(self, reference: Reference, target: str) -> Node | None:
        """Return the element that a target means, if it exists and is of the right class."""
        address = _address(target)
        is_known, place = self._place(reference, address)
        if not is_known:
            own = self._mission is None
            wanted = "an element of this file" if own else f"{self._mission_name()}#ID"
            self._report.add(
                reference.node,
                "LocalReference",
                f"refers to {shown(target)} as {reference.slot.name}; expected {wanted}, or "
                "one of a file that is part of the mission; correct the reference",
            )
        if place is None:
            return None
        element = find(place.file, unquote(target.rpartition("#")[2]))
        wanted_class = reference.slot.type
        if element is None or not conforms(element.metaclass, wanted_class):
            self._report_element(reference, target, element, self._known(place.tree, wanted_class))
            return None
        return element

    def _report_element(
        self, reference: Reference, target: str, element: Node | None, known: str
    ) -> None:
        what = f"refers to {shown(target)} as {reference.slot.name}, which"
        wanted = reference.slot.type.name
        if element is None:
            self._report.add(
                reference.node,
                "ResolvedReference",
                f"{what} does not exist; expected the ID of a {wanted}{known}; "
                "correct the reference",
            )
        else:
            self._report.add(
                reference.node,
                "ReferenceType",
                f"{what} is a {element.metaclass.name}; expected a {wanted}{known}; "
                "correct the reference",
            )

    def _place(self, reference: Reference, address: str) -> tuple[bool, _Place | None]:
        """Return whether a file may be referred to, and where it is if it can be used."""
        files = self._tree.files
        here = files.containing(reference.node)
        if not address:
            return True, _Place(here, self._tree)
        key = (reference.node.path, address)
        if key not in self._files:
            path = local_path(here.path.parent, address)
            self._files[key] = None if path is None else resolved_path(path)
        path = self._files[key]
        if path is None:
            return False, None
        if self._mission is not None and self._mission.tree is None:
            # its own defects are reported already
            return path == resolved_path(self._mission.path), None
        file = files.at_resolved(path)
        tree = self._tree if self._mission is None else self._mission.tree
        return (False, None) if file is None or tree is None else (True, _Place(file, tree))

    def _known(self, tree: ModelTree, wanted: Any) -> str:
        """Return the IDs that would fit, for the message; a tree is complete by now."""
        key = (tree is self._tree, wanted)
        if key not in self._listed:
            self._listed[key] = _known(tree, wanted)
        return self._listed[key]

    def _mission_name(self) -> str:
        return "mission.xmi" if self._mission is None else self._mission.path.name


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
