"""Resolve the references of a model, inside its file and into the mission's file."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from m2t.diagnostics import shown
from m2t.document import Node, Report
from m2t.metamodels import conforms, reference_type
from m2t.structure import ModelTree, Reference

_INDEX = re.compile(r"[0-9]{1,9}", re.ASCII)


@dataclass(frozen=True, slots=True)
class Neighbour:
    """Another file that references may lead to."""

    path: Path
    tree: ModelTree | None


def referred_files(tree: ModelTree) -> Iterator[tuple[Reference, str]]:
    """Return the file part of every reference that leads out of its own file."""
    for reference in tree.references:
        for target in reference.targets:
            document = _document(target)
            if document:
                yield reference, document


def local_path(folder: Path, document: str) -> Path | None:
    """Return the path that the file part of a reference means; ``None`` if it is not local."""
    try:
        parts = urlsplit(document)
    except ValueError:
        return None
    if parts.scheme or parts.netloc or parts.query or "\x00" in unquote(parts.path):
        return None
    return folder / unquote(parts.path)


def resolve(tree: ModelTree, neighbour: Neighbour | None, report: Report) -> None:
    """Find the nodes that all references of a model lead to.

    Parameters
    ----------
    tree
        The model; takes the resolved references.
    neighbour
        The mission's file, if the model may refer to it.
    report
        Takes the diagnostics.
    """
    named: dict[tuple[Node, str], set[Node]] = {}
    for reference in tree.references:
        _resolve_one(tree, neighbour, reference, named, report)


def _resolve_one(
    tree: ModelTree,
    neighbour: Neighbour | None,
    reference: Reference,
    named: dict[tuple[Node, str], set[Node]],
    report: Report,
) -> None:
    feature = reference.feature
    if not feature.many and len(reference.targets) > 1:
        report.add(
            reference.node,
            "SingleValue",
            f"has {len(reference.targets)} {feature.name}; expected one; delete the others",
        )
        return
    found = [
        element
        for target in reference.targets
        if (element := _element(tree, neighbour, reference, target, report)) is not None
    ]
    known = named.setdefault((reference.source, feature.name), set())
    for element in found:
        if element in known and feature.many:
            report.add(
                reference.node,
                "UniqueReference",
                f"names {_named(element)} twice in {feature.name}; expected each once; delete one",
            )
        known.add(element)
    tree.resolved.append((reference, tuple(found)))


def _element(
    tree: ModelTree,
    neighbour: Neighbour | None,
    reference: Reference,
    target: str,
    report: Report,
) -> Node | None:
    """Return the element that a target means, if it exists and is of the right class."""
    document = _document(target)
    fragment = unquote(target.rpartition("#")[2])
    if document:
        if neighbour is None or not _is_same_file(reference, document, neighbour.path):
            wanted = "an element of this file" if neighbour is None else f"{neighbour.path.name}#ID"
            report.add(
                reference.node,
                "LocalReference",
                f"refers to {shown(target)} as {reference.feature.name}; expected {wanted}; "
                "correct the reference",
            )
            return None
        if neighbour.tree is None:  # its own defects are reported already
            return None
        tree = neighbour.tree
    element = find(tree, fragment)
    wanted_class = reference_type(reference.feature)
    if element is None:
        report.add(
            reference.node,
            "ResolvedReference",
            f"refers to {shown(target)} as {reference.feature.name}, which does not exist; "
            f"expected the ID of a {wanted_class.name}{_known(tree, wanted_class)}; "
            "correct the reference",
        )
        return None
    if not conforms(element.metaclass, wanted_class):
        report.add(
            reference.node,
            "ReferenceType",
            f"refers to {shown(target)} as {reference.feature.name}, which is a "
            f"{element.metaclass.name}; expected a {wanted_class.name}"
            f"{_known(tree, wanted_class)}; correct the reference",
        )
        return None
    return element


def find(tree: ModelTree, fragment: str) -> Node | None:
    """Return the node that a fragment means: by xmi:id, by ID, or by path."""
    if fragment.startswith("/"):
        return _find_by_path(tree, fragment)
    return tree.by_xmi_id.get(fragment) or tree.by_id.get(fragment)


def _find_by_path(tree: ModelTree, fragment: str) -> Node | None:
    """Follow a path of Eclipse such as ``//@goals.0/@messages.1``."""
    _, root, *steps = fragment.split("/")
    if root not in ("", "0"):
        return None
    node = tree.root
    for step in steps if any(steps) else []:
        name, dot, index = step.removeprefix("@").rpartition(".")
        if not dot:
            name, index = index, "0"
        if not step.startswith("@") or not _INDEX.fullmatch(index):
            return None
        choices = [
            child for child in node.children if child.tag == name and child.metaclass is not None
        ]
        if int(index) >= len(choices):
            return None
        node = choices[int(index)]
    return node


def _document(target: str) -> str:
    return target.rpartition("#")[0]


def _is_same_file(reference: Reference, document: str, path: Path) -> bool:
    referred = local_path(reference.node.path.parent, document)
    return referred is not None and referred.resolve() == path.resolve()


def _known(tree: ModelTree, wanted: Any) -> str:
    """Return the IDs that would fit, for the message."""
    ids = [name for name, element in tree.by_id.items() if conforms(element.metaclass, wanted)]
    listed = ", ".join(ids[:12]) + (", ..." if len(ids) > 12 else "")
    return f" ({listed})" if ids else ""


def _named(element: Node) -> str:
    return f"'{element.attributes.get('ID', element.metaclass.name)}'"
