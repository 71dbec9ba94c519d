"""The files of a model: what each holds, and which file a reference may mean.

A model may stand in several files, as Eclipse splits it: an element in place is replaced by
``<robots href="robots.xmi#r1"/>``, and ``robots.xmi`` has the robot as its root. Several roots
stand side by side in an ``<xmi:XMI>`` element, be they parts or a mission and its faults.

Notes
-----
References never leave the project, which is the tree of the folder of the model's first file, or
that of the nearest folder above it with a ``.project`` file. ``platform:/resource/NAME/rest`` is
``rest`` in the project NAME: the nearest folder, from the referring file upwards, that has that
name or whose ``.project`` file gives it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from m2t.diagnostics import FileLine, Report, shown
from m2t.read.nodes import MAX_BYTES, MAX_ELEMENTS, XMI, XSI, Node, Spelling, at, follow, read_xml

MAX_FILES = 1_000

ROOT_ATTRIBUTES = frozenset(
    {(XMI, "version"), (XSI, "schemaLocation"), (XSI, "noNamespaceSchemaLocation")}
)
"""Attributes with a namespace that may stand at the root of a file."""

_PROJECT = ".project"


@dataclass(slots=True, eq=False)
class ModelFile:
    """One file of a model; more than one root stands in an ``xmi:XMI`` element.

    ``spelling`` is what saving keeps of it beside its content; ``by_id`` and ``by_xmi_id`` have its
    checked elements. ``owners`` are the files, outermost first, that lead to it by containment,
    ``claimed`` its roots that belong to a model so far.
    """

    path: Path
    spelling: Spelling
    roots: tuple[Node, ...]
    by_id: dict[str, Node] = field(default_factory=dict, repr=False)
    by_xmi_id: dict[str, Node] = field(default_factory=dict, repr=False)
    owners: tuple["ModelFile", ...] = field(default=(), repr=False)
    claimed: set[Node] = field(default_factory=set, repr=False)
    _children: dict[tuple[Node, str], list[Node]] = field(default_factory=dict, repr=False)

    def roots_of(self, metaclass: Any) -> list[Node]:
        """Return the roots of a class."""
        wanted = (metaclass.ePackage.nsURI, metaclass.name)
        return [node for node in self.roots if (node.namespace, node.tag) == wanted]

    def root(self, fragment: str) -> Node | None:
        """Return the root that a fragment means: by xmi:id, by ID, or ``/``, ``/0``, ``/1``."""
        if fragment.startswith("/"):
            return at(self.roots, fragment[1:] or "0")
        named = (
            root for root in self.roots if fragment in (root.xmi_id, root.attributes.get("ID"))
        )
        return next(named, None)

    def find(self, fragment: str) -> Node | None:
        """Return the checked node that a fragment means: by xmi:id, by ID, or by path.

        A path is one such as ``//@goals.0/@messages.1``; before its second slash, it may have
        the number of a root.
        """
        if not fragment.startswith("/"):
            return self.by_xmi_id.get(fragment) or self.by_id.get(fragment)
        position, _, path = fragment[1:].partition("/")
        found = follow(at(self.roots, position or "0"), path, self._checked)
        return None if found is None or found.metaclass is None else found

    def _checked(self, node: Node, name: str) -> list[Node]:
        """Return the elements that a checked element contains as one feature; kept for reuse."""
        key = (node, name)
        if key not in self._children:
            self._children[key] = [
                child for child in node.tagged(name) if child.metaclass is not None
            ]
        return self._children[key]


class ModelFiles:
    """All files of the models being loaded; each is read once, but for one that is at hand."""

    def __init__(self, report: Report, known: ModelFile | None = None) -> None:
        self._report = report
        at_hand = () if known is None else (known,)
        self._files: dict[Path, ModelFile | None] = {resolved_path(f.path): f for f in at_hand}
        self._by_name: dict[Path, ModelFile] = {file.path: file for file in at_hand}
        self._n_bytes = 0
        self._n_elements = 0

    def __iter__(self) -> Iterator[ModelFile]:
        return iter(self._by_name.values())

    def containing(self, node: Node) -> ModelFile:
        """Return the file that a node stands in."""
        return self._by_name[node.path]

    def at(self, path: Path) -> ModelFile | None:
        """Return the file at a path if it has been read."""
        return self._files.get(resolved_path(path))

    def read(self, path: Path, owners: tuple[ModelFile, ...] = ()) -> ModelFile | None:
        """Read a file, unless that has been done; report what is wrong with it.

        ``owners`` are the files that lead to it by containment. ``None`` if it cannot be used.
        """
        key = resolved_path(path)
        if key not in self._files:
            self._files[key] = self._read(path, owners)
        return self._files[key]

    def _read(self, path: Path, owners: tuple[ModelFile, ...]) -> ModelFile | None:
        xml = read_xml(path, self._report)
        if xml is None:
            return None
        self._n_bytes += xml.n_bytes
        self._n_elements += xml.n_elements
        is_large = self._n_bytes > MAX_BYTES or self._n_elements > MAX_ELEMENTS
        if is_large or len(self._files) >= MAX_FILES:
            finding = (
                f"is one file too many: all files of a model have at most {MAX_FILES:,} files, "
                f"{MAX_BYTES:,} bytes and {MAX_ELEMENTS:,} elements; model less"
            )
            self._report.add(FileLine(path, 1), "FileSize", finding)
            return None
        file = ModelFile(path, xml.spelling, self._roots(xml.root), owners=owners)
        self._by_name[path] = file
        return file

    def _roots(self, root: Node) -> tuple[Node, ...]:
        """Return the root elements, and report what the element around several of them holds."""
        if (root.namespace, root.tag) != (XMI, "XMI"):
            return (root,)
        unknown = [shown(name) for name in root.attributes]
        unknown += [
            shown(f"{{{namespace}}}{name}")
            for namespace, name in root.qualified
            if (namespace, name) not in ROOT_ATTRIBUTES
        ]
        if unknown:
            finding = f"has attribute {unknown[0]}; expected xmi:version only; delete it"
            self._report.add(root, "KnownFeature", finding)
        if text := root.text.strip():
            finding = f"holds the text {shown(text)}; expected elements; delete it"
            self._report.add(root, "NoText", finding)
        if not root.children:
            finding = "is the root and holds nothing; expected a Mission; add one"
            self._report.add(root, "RootElement", finding)
        for child in root.children:
            child.parent = None
        return tuple(root.children)


def local_path(folder: Path, address: str) -> Path | None:
    """Return the path that the file part of a reference from a folder means.

    It is what stands before the ``#``: a relative address, or ``platform:/resource/NAME/...``; an
    address that is absolute, remote, or of an unknown project means none.
    """
    try:
        parts = urlsplit(address)
    except ValueError:
        return None
    path = unquote(parts.path)
    if parts.netloc or parts.query or "\x00" in path:
        return None
    if parts.scheme == "platform":
        return _platform_path(folder, path)
    if parts.scheme or path.startswith("/"):
        return None
    return folder / path


def contained_path(folder: Path, first: Path, address: str) -> Path | None:
    """Return the path of a part of a model; ``None`` if it lies outside the model's project.

    ``folder`` is that of the file that refers, ``first`` that of the file that the model begins in.
    """
    path = local_path(folder, address)
    if path is None:
        return None
    scopes = [first, _nearest(first, lambda place: (place / _PROJECT).is_file())]
    if address.startswith("platform:"):
        scopes.append(_project(folder, unquote(urlsplit(address).path)))
    target = resolved_path(path)
    is_inside = any(scope and target.is_relative_to(scope.resolve()) for scope in scopes)
    return path if is_inside else None


def _platform_path(folder: Path, path: str) -> Path | None:
    """Return the path that ``/resource/NAME/rest`` means."""
    kind, _, rest = path.removeprefix("/").partition("/")
    inside = rest.partition("/")[2].lstrip("/")
    project = _project(folder, path)
    if kind != "resource" or project is None or not inside or ".." in inside.split("/"):
        return None
    return project / inside


def _project(folder: Path, path: str) -> Path | None:
    """Return the folder of the project that ``/resource/NAME/rest`` names."""
    name = path.removeprefix("/").partition("/")[2].partition("/")[0]
    if not name:
        return None
    return _nearest(folder, lambda place: place.name == name or _declared_name(place) == name)


def _nearest(folder: Path, is_wanted: Callable[[Path], bool]) -> Path | None:
    here = folder.resolve()
    return next((place for place in (here, *here.parents) if is_wanted(place)), None)


def _declared_name(folder: Path) -> str | None:
    """Return the name that the ``.project`` file of a folder gives, if there is one."""
    path = folder / _PROJECT
    if not path.is_file():
        return None
    xml = read_xml(path, Report())
    names = [] if xml is None else xml.root.tagged("name")
    return names[0].text.strip() if names else None


def resolved_path(path: Path) -> Path:
    """Return a path without links; an endless link stays as it is and fails when it is read."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path.absolute()
