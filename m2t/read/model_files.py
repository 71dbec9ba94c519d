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

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, urlsplit

from m2t.diagnostics import shown
from m2t.read.nodes import MAX_BYTES, MAX_ELEMENTS, Node, Report, read_encoded

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"

MAX_FILES = 1_000

_PROJECT = ".project"
_ROOT_ATTRIBUTES = frozenset(
    {(XMI, "version"), (XSI, "schemaLocation"), (XSI, "noNamespaceSchemaLocation")}
)


@dataclass(slots=True, eq=False)
class ModelFile:
    """One file of a model.

    Attributes
    ----------
    path
        The file, as messages name it.
    encoding
        Encoding that it declares.
    roots
        Its root elements in order; more than one in an ``xmi:XMI`` element.
    by_id, by_xmi_id
        Its checked elements by ID and by xmi:id.
    owners
        Files, outermost first, that lead to this one by containment.
    claimed
        Roots that belong to a model so far.
    """

    path: Path
    encoding: str
    roots: tuple[Node, ...]
    by_id: dict[str, Node] = field(default_factory=dict, repr=False)
    by_xmi_id: dict[str, Node] = field(default_factory=dict, repr=False)
    owners: tuple["ModelFile", ...] = field(default=(), repr=False)
    claimed: set[Node] = field(default_factory=set, repr=False)
    _children: dict[tuple[Node, str], list[Node]] = field(default_factory=dict, repr=False)

    def roots_of(self, namespace: str, class_name: str) -> list[Node]:
        """Return the roots of a class."""
        wanted = (namespace, class_name)
        return [node for node in self.roots if (node.namespace, node.tag) == wanted]

    def root(self, fragment: str) -> Node | None:
        """Return the root that a fragment means: by xmi:id, by ID, or ``/``, ``/0``, ``/1``."""
        if fragment.startswith("/"):
            return self.root_at(fragment[1:])
        for root in self.roots:
            if fragment in (root.qualified.get((XMI, "id")), root.attributes.get("ID")):
                return root
        return None

    def root_at(self, position: str) -> Node | None:
        """Return the root at a position of a path; none given means the first."""
        index = position or "0"
        if not (index.isascii() and index.isdigit()) or len(index) > 9:
            return None
        return self.roots[int(index)] if int(index) < len(self.roots) else None

    def checked_children(self, node: Node, name: str) -> list[Node]:
        """Return the elements that a checked element contains as one feature; kept for reuse."""
        key = (node, name)
        if key not in self._children:
            self._children[key] = [
                child
                for child in node.children
                if child.tag == name and child.metaclass is not None
            ]
        return self._children[key]


class ModelFiles:
    """All files of the models being loaded; each is read once."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._files: dict[Path, ModelFile | None] = {}
        self._by_name: dict[Path, ModelFile] = {}
        self._n_bytes = 0
        self._n_elements = 0

    def __iter__(self) -> Iterator[ModelFile]:
        return iter(self._by_name.values())

    def containing(self, node: Node) -> ModelFile:
        """Return the file that a node stands in."""
        return self._by_name[node.path]

    def at(self, path: Path) -> ModelFile | None:
        """Return the file at a path if it has been read."""
        return self.at_resolved(resolved_path(path))

    def at_resolved(self, path: Path) -> ModelFile | None:
        """Return the file at a path without links if it has been read."""
        return self._files.get(path)

    def read(self, path: Path, owners: tuple[ModelFile, ...] = ()) -> ModelFile | None:
        """Read a file, unless that has been done; report what is wrong with it.

        Parameters
        ----------
        path
            The file.
        owners
            Files that lead to it by containment.

        Returns
        -------
        ModelFile or None
            The file; ``None`` if it cannot be used.
        """
        key = resolved_path(path)
        if key not in self._files:
            self._files[key] = self._read(path, owners)
        return self._files[key]

    def _read(self, path: Path, owners: tuple[ModelFile, ...]) -> ModelFile | None:
        document = read_encoded(path, self._report)
        if document is None:
            return None
        self._n_bytes += document.n_bytes
        self._n_elements += document.n_elements
        if self._breaks_limits():
            finding = (
                f"{path.name} is one file too many: all files of a model have at most "
                f"{MAX_FILES:,} files, {MAX_BYTES:,} bytes and {MAX_ELEMENTS:,} elements; "
                "model less"
            )
            self._report.add_file(path, 1, "FileSize", finding)
            return None
        file = ModelFile(path, document.encoding, self._roots(document.root), owners=owners)
        self._by_name[path] = file
        return file

    def _breaks_limits(self) -> bool:
        too_large = self._n_bytes > MAX_BYTES or self._n_elements > MAX_ELEMENTS
        return too_large or len(self._files) >= MAX_FILES

    def _roots(self, root: Node) -> tuple[Node, ...]:
        """Return the root elements, and report what the element around several of them holds."""
        if (root.namespace, root.tag) != (XMI, "XMI"):
            return (root,)
        unknown = [shown(name) for name in root.attributes]
        unknown += [
            shown(f"{{{namespace}}}{name}")
            for namespace, name in root.qualified
            if (namespace, name) not in _ROOT_ATTRIBUTES
        ]
        if unknown:
            finding = f"has attribute {unknown[0]}; expected xmi:version only; delete it"
            self._report.add(root, "KnownFeature", finding)
        if root.text.strip():
            finding = f"holds the text {shown(root.text.strip())}; expected elements; delete it"
            self._report.add(root, "NoText", finding)
        if not root.children:
            finding = "is the root and holds nothing; expected a Mission; add one"
            self._report.add(root, "RootElement", finding)
        for child in root.children:
            child.parent = None
        return tuple(root.children)


def is_root_attribute(namespace: str, name: str) -> bool:
    """Return whether an attribute with a namespace may stand at the root of a file."""
    return (namespace, name) in _ROOT_ATTRIBUTES


def local_path(folder: Path, document: str) -> Path | None:
    """Return the path that the file part of a reference means.

    Parameters
    ----------
    folder
        Folder of the file that refers.
    document
        What stands before the ``#``: a relative address, or ``platform:/resource/NAME/...``.

    Returns
    -------
    Path or None
        The path; ``None`` if the address is absolute, remote, or of an unknown project.
    """
    try:
        parts = urlsplit(document)
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


def contained_path(file: ModelFile, document: str) -> Path | None:
    """Return the path of a part of a model; ``None`` if it lies outside the model's project."""
    path = local_path(file.path.parent, document)
    if path is None:
        return None
    first = (file.owners or (file,))[0].path.parent
    scopes = [first, _project_above(first)]
    if document.startswith("platform:"):
        name = _platform_parts(unquote(urlsplit(document).path))[1]
        scopes.append(_named_project(file.path.parent, name))
    target = resolved_path(path)
    is_inside = any(
        scope is not None and target.is_relative_to(scope.resolve()) for scope in scopes
    )
    return path if is_inside else None


def _platform_path(folder: Path, path: str) -> Path | None:
    kind, name, inside = _platform_parts(path)
    if kind != "resource" or not inside or ".." in inside.split("/"):
        return None
    project = _named_project(folder, name)
    return None if project is None else project / inside


def _platform_parts(path: str) -> tuple[str, str, str]:
    """Return the three parts of ``/resource/NAME/rest``."""
    kind, _, rest = path.removeprefix("/").partition("/")
    name, _, inside = rest.partition("/")
    return kind, name, inside.lstrip("/")


def _named_project(folder: Path, name: str) -> Path | None:
    if not name:
        return None
    here = folder.resolve()
    for candidate in (here, *here.parents):
        if candidate.name == name or _declared_name(candidate) == name:
            return candidate
    return None


def _project_above(folder: Path) -> Path | None:
    here = folder.resolve()
    return next((place for place in (here, *here.parents) if (place / _PROJECT).is_file()), None)


def _declared_name(folder: Path) -> str | None:
    """Return the name that the ``.project`` file of a folder gives, if there is one."""
    path = folder / _PROJECT
    if not path.is_file():
        return None
    document = read_encoded(path, Report())
    if document is None:
        return None
    names = (child.text.strip() for child in document.root.children if child.tag == "name")
    return next(names, None)


def resolved_path(path: Path) -> Path:
    """Return a path without links; an endless link stays as it is and fails when it is read."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path.absolute()
