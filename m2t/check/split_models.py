"""Parts of a model that stand in files of their own, as Eclipse splits it.

``<robots href="robots.xmi#r1"/>`` stands for a root of ``robots.xmi``.
"""

from collections.abc import Mapping
from typing import Any
from urllib.parse import unquote

from m2t.diagnostics import Defect, shown
from m2t.metaclasses import concrete_classes
from m2t.read.addresses import contained_path
from m2t.read.model_files import ModelFile, ModelFiles
from m2t.read.nodes import Node


def find_part(child: Node, declared: Any, package: Any, files: ModelFiles) -> tuple[Node, Any]:
    """Return the root of another file that an element with an href stands for, and its class.

    The root takes the element's tag and parent, and has to fit the ``declared`` class of the
    containment. ``files`` takes its file. An element that stands for no such root, or for one that
    something else contains, raises a ``Defect``.
    """
    if set(child.attributes) != {"href"} or child.children or child.text.strip():
        raise Defect(
            "ContainedElement",
            f"has an href and more; expected <{child.tag[:60]} href=...> alone; correct it",
        )
    target = child.attributes["href"]
    address, _, fragment = target.rpartition("#")
    file = _file(child, address, files)
    root = file.root(unquote(fragment))
    if root is None or root in file.claimed:
        found = "is no root of that file" if root is None else "is contained already"
        raise Defect(
            "ContainedElement",
            f"stands for {shown(target)}, which {found}; expected a root of "
            f"{file.path.name} that stands nowhere else; correct the href",
        )
    file.claimed.add(root)
    metaclass = _metaclass(child, root, declared, package)
    root.tag, root.namespace, root.parent = child.tag, "", child.parent
    return root, metaclass


def named_class(package: Any, kinds: Mapping[str, Any], node: Node) -> Any:
    """Return the one of some classes that an xsi:type names; ``None`` if it names none."""
    prefix, _, name = (node.xsi_type or "").rpartition(":")
    return kinds.get(name) if node.prefixes.get(prefix) == package.nsURI else None


def _file(child: Node, address: str, files: ModelFiles) -> ModelFile:
    """Return the file of a part; refuse one outside the project, and circles of files."""
    what = f"stands for {shown(child.attributes['href'])}"
    here = files.containing(child)
    first = (*here.owners, here)[0].path.parent
    path = contained_path(here.path.parent, first, address) if address else None
    if path is None:
        raise Defect(
            "LocalReference" if address else "ContainedElement",
            f"{what}; expected the root of another file, by a relative address inside the "
            "mission's project; move that file there, or the element here",
        )
    owners = (*here.owners, here)
    known = files.at(path)
    if known is not None and known in owners:
        circle = " > ".join(owner.path.name for owner in (*owners[owners.index(known) :], known))
        raise Defect(
            "ContainedElement",
            f"{what}, which closes a circle of files ({circle}); expected files that lead "
            "downwards only; move the element into place",
        )
    file = files.read(path, owners)
    if file is None:  # what is wrong with it is reported there
        raise Defect("ContainedElement", f"{what}, a file that cannot be used; correct it")
    return file


def _metaclass(child: Node, root: Node, declared: Any, package: Any) -> Any:
    """Return the class of a part; refuse one that the feature may not hold."""
    kinds = concrete_classes(package, declared)
    found = kinds.get(root.tag) if root.namespace == package.nsURI else None
    if found is not None and (
        child.xsi_type is None or named_class(package, kinds, child) is found
    ):
        return found
    expected = ", ".join(kinds)
    raise Defect(
        "ConcreteType",
        f"stands for {shown(child.attributes['href'])}, which is a {root.tag[:60]}; expected "
        f"one of {expected}, the same as xsi:type if that is given; correct the href",
    )
