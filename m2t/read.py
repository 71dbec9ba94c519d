"""Read the files of a model as nodes with line numbers, and collect the defects of models.

A ``Report`` only collects: checks continue after a defect, and loading asks at the end how many
errors there are. Every message ends with the name of its constraint. docs/constraints.md lists all
constraints with their meaning, in the order in which they are checked.

Malicious files do no harm: document types are refused, hence there are no entities, no external
files and no network access; size, number of elements and nesting are limited. Comments and
processing instructions are dropped, as Eclipse does.

A model may stand in several files, as Eclipse splits it: ``<robots href="robots.xmi#r1"/>``
replaces an element, and ``robots.xmi`` has the robot as its root. Several roots stand side by side
in an ``<xmi:XMI>`` element. Begin with ``Node`` and ``Report.add``, then ``read_xml`` for one file,
``ModelFiles`` for all files of a model, and the functions at the end for the addresses of files.

Notes
-----
The parser is expat: it stops at a document type before it reads the type's content, and
its line numbers stay right beyond line 65,535, where those of lxml are off by one.

References never leave the project: the tree of the folder of the model's first file, or of the
nearest folder above it with a ``.project`` file. ``platform:/resource/NAME/rest`` is ``rest`` in
the project NAME: the nearest folder, from the referring file upwards, that has that name or whose
``.project`` file gives it.
"""

import errno
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias
from urllib.parse import unquote, urlsplit
from xml.parsers import expat

from mrsfi_runtime.errors import Diagnostic, ModelError, Severity, nearest

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
ECORE = "http://www.eclipse.org/emf/2002/Ecore"

WARNINGS = (
    "IdWithoutSpaces", "AreaInsideMission", "RobotInsideMission", "RobotStartsClear",
    "RobotHasBattery", "SenderIsMember", "UniqueMessageField", "FieldOfSender",
    "AvoidCollisionMembers", "DeadlineInsideMission", "FigureInsideMission",
    "AsReactionsAssume", "FaultFieldCarried", "WindowInsideMission", "TriggerCanHappen",
)  # fmt: skip
"""Constraints whose defects do not stop loading; those of all others do."""

MAX_BYTES = 64 * 1024 * 1024
MAX_ELEMENTS = 500_000
MAX_DEPTH = 100


class Defect(Exception):  # noqa: N818 # models have defects
    """A violation of a named constraint, by an element or file that the caller knows.

    ``finding`` is the end of the message: the finding, the expectation, and the next step.
    """

    def __init__(self, constraint: str, finding: str) -> None:
        super().__init__(finding)
        self.constraint = constraint
        self.finding = finding


@dataclass(slots=True, eq=False)
class Node:
    """An XML element.

    ``attributes`` are those without a namespace; ``qualified`` the others, by namespace and
    name. ``prefixes`` are the namespaces in scope, by prefix. ``metaclass`` is the element's
    class in the metamodel, set when the node is checked.
    """

    path: Path
    line: int
    namespace: str
    tag: str
    parent: "Node | None" = field(repr=False)
    prefixes: Mapping[str, str] = field(repr=False)
    attributes: dict[str, str] = field(default_factory=dict)
    qualified: dict[tuple[str, str], str] = field(default_factory=dict)
    children: list["Node"] = field(default_factory=list, repr=False)
    text: str = ""
    metaclass: Any = field(default=None, repr=False)

    @property
    def description(self) -> str:
        """Name of the element in messages: ``robots 'r1'`` or ``center of missionArea 'a15'``."""
        tag = self.tag[:60]
        for key in ("ID", "name"):
            if key in self.attributes:
                return f"{tag} {shown(self.attributes[key])}"
        return tag if self.parent is None else f"{tag} of {self.parent.description}"

    @property
    def xmi_id(self) -> str | None:
        """Value of xmi:id, if there is one."""
        return self.qualified.get((XMI, "id"))

    @property
    def xsi_type(self) -> str | None:
        """Value of xsi:type, or else of xmi:type, if there is one."""
        return self.qualified.get((XSI, "type"), self.qualified.get((XMI, "type")))

    def tagged(self, tag: str) -> list["Node"]:
        """Return the elements of a tag directly below."""
        return [child for child in self.children if child.tag == tag]

    def walk(self) -> Iterator["Node"]:
        """Yield the element and all below it, in the order of the file."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True, slots=True)
class FileLine:
    """Place of a defect of a whole file."""

    path: Path
    line: int

    @property
    def description(self) -> str:
        """Name of the file."""
        return self.path.name


Place: TypeAlias = Node | FileLine
"""Place of an element in a file, and its name in messages."""


class Report:
    """Collects the diagnostics of one validation; ``n_errors`` of them stop loading.

    ``n_unsound`` of those prevent sound objects; a repeated reference does not, as the list of
    objects holds it once. ``n_dangling`` are references to missing elements: objects can be made
    without them. ``places`` maps objects to their places, and may grow.
    """

    def __init__(self, places: Mapping[Any, Place] = MappingProxyType({})) -> None:
        self.places = places
        self._found: dict[tuple[object, ...], Diagnostic] = {}
        self.n_errors = 0
        self.n_unsound = 0
        self.n_dangling = 0

    def place(self, element: Any) -> Place:
        """Return the place of an object; a place is returned unchanged."""
        return self.places.get(element, element)

    def add(self, element: Any, constraint: str, finding: str) -> None:
        """Add a defect of an object or a place; ``finding`` follows its name in the message."""
        place = self.place(element)
        key = (place, constraint, finding)
        if key in self._found:  # of a feature that several classes inherit, for example
            return
        is_error, name = constraint not in WARNINGS, place.description
        severity: Severity = "error" if is_error else "warning"
        found = Diagnostic(place.path, place.line, name, constraint, severity, f"{name} {finding}")
        self._found[key] = found
        self.n_errors += is_error
        self.n_unsound += is_error and constraint != "UniqueReference"
        self.n_dangling += constraint == "ResolvedReference"

    def require_no_errors(self) -> None:
        """Raise a ``ModelError`` with all errors so far, one per line, if there are any."""
        if self.n_errors:
            raise self.error()

    def error(self) -> ModelError:
        """Return an error with all errors so far, one per line."""
        return ModelError("\n".join(str(found) for found in self if found.severity == "error"))

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found.values())


def shown(text: str) -> str:
    """Return a text of a model for use in a message: quoted, on one line, shortened."""
    return repr(text if len(text) <= 60 else text[:60] + "...")


def listed(names: Sequence[str], found: str = "") -> str:
    """Return names for use in a message, with a suggestion of the intended one."""
    return ", ".join(names) + nearest(found, names)


def follow(
    node: Node | None, path: str, below: Callable[[Node, str], Sequence[Node]] = Node.tagged
) -> Node | None:
    """Return the node at a path of Eclipse; ``None`` if there is none.

    The path has steps such as ``@goals.0/@messages.1``; ``below`` returns the children of a node
    with a tag, among which a step chooses.
    """
    for step in path.split("/") if path.strip("/") else ():
        name, dot, index = step.removeprefix("@").partition(".")
        if node is None or not step.startswith("@"):
            return None
        node = at(below(node, name), index if dot else "0")
    return node


def at(nodes: Sequence[Node], position: str) -> Node | None:
    """Return the node at a position; ``None`` if there is none or the position is no number."""
    is_number = re.fullmatch(r"[0-9]{1,9}", position)
    return nodes[int(position)] if is_number and int(position) < len(nodes) else None


@dataclass(frozen=True, slots=True)
class Spelling:
    """Properties of a file that saving keeps, besides its content.

    ``encoding`` is the declared one, or else that of the byte order mark. ``schema_location`` is
    the value of xsi:schemaLocation, which Epsilon writes. ``line_end`` is that of the first line.
    """

    encoding: str
    schema_location: str | None = None
    line_end: str = "\n"


class XmlFile:
    """A file while it is read: the parser's handlers build its nodes and enforce the limits."""

    def __init__(self, path: Path) -> None:
        self.root: Node
        self.spelling: Spelling
        self.n_bytes = 0
        self.n_elements = 0
        self._path = path
        self._encoding = ""
        self._open: list[Node] = []
        self._prefixes: Mapping[str, str] = MappingProxyType({})
        self._parser = expat.ParserCreate(namespace_separator=" ")
        self._parser.buffer_text = True
        self._parser.XmlDeclHandler = self._declaration
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartNamespaceDeclHandler = self._namespace
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters

    @property
    def line(self) -> int:
        """Present line of the parser, from 1."""
        return self._parser.CurrentLineNumber

    def parse(self, content: bytes) -> None:
        """Build the nodes of the file."""
        self._parser.Parse(content, True)
        self.n_bytes = len(content)
        is_wide = content.startswith((b"\xff\xfe", b"\xfe\xff"))
        is_crlf = content[:4096].replace(b"\0", b"").partition(b"\n")[0].endswith(b"\r")
        self.spelling = Spelling(
            self._encoding or ("UTF-16" if is_wide else "UTF-8"),
            self.root.qualified.get((XSI, "schemaLocation")),
            "\r\n" if is_crlf else "\n",
        )

    def _declaration(self, _: str, encoding: str | None, __: int) -> None:
        self._encoding = (encoding or "").upper()  # as Eclipse writes it back

    def _doctype(self, *_: object) -> None:
        finding = "declares a document type; a model needs none; delete the <!DOCTYPE ...>"
        raise Defect("NoDocumentType", finding)

    def _namespace(self, prefix: str | None, uri: str | None) -> None:
        self._prefixes = {**self._prefixes, (prefix or ""): uri or ""}

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self.n_elements += 1
        if self.n_elements > MAX_ELEMENTS:
            raise Defect("FileSize", f"has more than {MAX_ELEMENTS:,} elements; split the model")
        if len(self._open) >= MAX_DEPTH:
            finding = f"nests more than {MAX_DEPTH} elements; expected fewer; correct it"
            raise Defect("FileSize", finding)
        namespace, _, tag = name.rpartition(" ")
        parent = self._open[-1] if self._open else None
        node = Node(self._path, self.line, namespace, tag, parent, self._prefixes)
        for key, value in attributes.items():
            uri, _, local = key.rpartition(" ")
            if uri:
                node.qualified[uri, local] = value
            else:
                node.attributes[local] = value
        if parent is None:
            self.root = node
        else:
            parent.children.append(node)
        self._open.append(node)

    def _end(self, _: str) -> None:
        node = self._open.pop()
        if node.parent is not None:
            self._prefixes = node.parent.prefixes

    def _characters(self, text: str) -> None:
        self._open[-1].text += text


def read_xml(path: Path, report: Report) -> XmlFile | None:
    """Read an XML file and report its defects; return ``None`` if it cannot be used."""
    xml = XmlFile(path)
    try:
        xml.parse(_content(path))
    except Defect as defect:
        report.add(FileLine(path, xml.line), defect.constraint, defect.finding)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        finding = f"is not well-formed XML: {reason}; correct it at this line"
        report.add(FileLine(path, error.lineno), "WellFormedXml", finding)
    except (LookupError, ValueError) as error:
        finding = f"has an encoding that cannot be read: {error}; save it as UTF-8"
        report.add(FileLine(path, 1), "WellFormedXml", finding)
    else:
        return xml
    return None


def read_root(path: Path, report: Report) -> Node:
    """Return the root element of an XML file; raise a ``ModelError`` if it cannot be used."""
    xml = read_xml(path, report)
    if xml is None:
        raise report.error()
    return xml.root


def _require_file(path: Path) -> None:
    """Refuse a pipe or a device, because opening one could block for ever."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "It is no file")


def _content(path: Path) -> bytes:
    try:
        _require_file(path)
        n_bytes = path.stat().st_size
        content = path.read_bytes() if n_bytes <= MAX_BYTES else b""
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", str(error)) or type(error).__name__
        finding = f"cannot be read: {reason}; expected a model file at this path"
        raise Defect("ReadableFile", finding) from error
    if n_bytes > MAX_BYTES:
        finding = f"has more than {MAX_BYTES:,} bytes; a model is far smaller; split it"
        raise Defect("FileSize", finding)
    return content


MAX_FILES = 1_000

ROOT_ATTRIBUTES = frozenset(
    {(XMI, "version"), (XSI, "schemaLocation"), (XSI, "noNamespaceSchemaLocation")}
)
"""Attributes with a namespace that the root of a file may have."""

_PROJECT = ".project"


@dataclass(slots=True, eq=False)
class ModelFile:
    """One file of a model; several roots stand in an ``xmi:XMI`` element.

    ``by_id`` and ``by_xmi_id`` have its checked elements. ``owners`` are the files that contain it,
    outermost first. ``claimed`` are the roots that belong to a model so far.
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
        """Return the root of a fragment: an xmi:id, an ID, or ``/``, ``/0``, ``/1``."""
        if fragment.startswith("/"):
            return at(self.roots, fragment[1:] or "0")
        ids = ((root, (root.xmi_id, root.attributes.get("ID"))) for root in self.roots)
        return next((root for root, known in ids if fragment in known), None)

    def find(self, fragment: str) -> Node | None:
        """Return the checked node of a fragment: an xmi:id, an ID, or a path.

        A path is like ``//@goals.0/@messages.1``; before its second slash, it may have the number
        of a root.
        """
        if not fragment.startswith("/"):
            return self.by_xmi_id.get(fragment) or self.by_id.get(fragment)
        position, _, path = fragment[1:].partition("/")
        found = follow(at(self.roots, position or "0"), path, self._checked)
        return None if found is None or found.metaclass is None else found

    def _checked(self, node: Node, name: str) -> list[Node]:
        """Return the checked elements that an element contains in one feature, cached."""
        key = (node, name)
        if key not in self._children:
            self._children[key] = [each for each in node.tagged(name) if each.metaclass is not None]
        return self._children[key]


class ModelFiles:
    """All files of the models being loaded; each is read once, except a given one."""

    def __init__(self, report: Report, known: ModelFile | None = None) -> None:
        self._report = report
        given = () if known is None else (known,)
        self._files: dict[Path, ModelFile | None] = {resolved_path(f.path): f for f in given}
        self._by_name: dict[Path, ModelFile] = {file.path: file for file in given}
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
        """Read a file once, and report its defects; return ``None`` if it cannot be used.

        ``owners`` are the files that contain it.
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
                f"exceeds a limit: a model has at most {MAX_FILES:,} files, "
                f"{MAX_BYTES:,} bytes and {MAX_ELEMENTS:,} elements in all; make it smaller"
            )
            self._report.add(FileLine(path, 1), "FileSize", finding)
            return None
        file = ModelFile(path, xml.spelling, self._roots(xml.root), owners=owners)
        self._by_name[path] = file
        return file

    def _roots(self, root: Node) -> tuple[Node, ...]:
        """Return the root elements, and report unexpected content of the ``xmi:XMI`` element."""
        if (root.namespace, root.tag) != (XMI, "XMI"):
            return (root,)
        others = [key for key in root.qualified if key not in ROOT_ATTRIBUTES]
        unknown = [*root.attributes, *(f"{{{namespace}}}{name}" for namespace, name in others)]
        if unknown:
            finding = f"has attribute {shown(unknown[0])}; expected xmi:version only; delete it"
            self._report.add(root, "KnownFeature", finding)
        if text := root.text.strip():
            finding = f"holds the text {shown(text)}; expected elements; delete it"
            self._report.add(root, "NoText", finding)
        if not root.children:
            finding = "is the root and is empty; expected a Mission; add one"
            self._report.add(root, "RootElement", finding)
        for child in root.children:
            child.parent = None
        return tuple(root.children)


def local_path(folder: Path, address: str) -> Path | None:
    """Return the path of an address in a reference from a folder; ``None`` if it has none.

    The address stands before the ``#``: relative, or ``platform:/resource/NAME/...``. An absolute
    or remote address, or one of an unknown project, has no path.
    """
    try:
        parts = urlsplit(address)
    except ValueError:
        return None
    path = unquote(parts.path)
    if parts.netloc or parts.query or "\x00" in path:
        return None
    if parts.scheme == "platform":  # /resource/NAME/rest
        kind, _, rest = path.removeprefix("/").partition("/")
        inside = rest.partition("/")[2].lstrip("/")
        project = _project(folder, path)
        is_known = kind == "resource" and inside and ".." not in inside.split("/")
        return project / inside if project is not None and is_known else None
    return None if parts.scheme or path.startswith("/") else folder / path


def contained_path(folder: Path, first: Path, address: str) -> Path | None:
    """Return the path of a part of a model; ``None`` if it lies outside the model's project.

    ``folder`` is that of the referring file, ``first`` that of the first file of the model.
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
    path = folder / _PROJECT
    xml = read_xml(path, Report()) if path.is_file() else None
    names = [] if xml is None else xml.root.tagged("name")
    return names[0].text.strip() if names else None


def resolved_path(path: Path) -> Path:
    """Return a path without links; a circular link stays and fails when it is read."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path.absolute()
