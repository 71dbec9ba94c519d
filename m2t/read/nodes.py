"""Read XML into nodes that know their line, without trusting the file.

There are no document types, hence no entities, no external files and no network; size,
number of elements and nesting are limited. Comments and processing instructions are
dropped, as Eclipse does.

Notes
-----
The parser is expat: it stops at a document type before it reads the type's content, and
its line numbers stay right beyond line 65,535, where those of lxml are off by one.
"""

import errno
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.parsers import expat

from m2t.diagnostics import CONSTRAINTS, Diagnostic, shown

MAX_BYTES = 64 * 1024 * 1024
MAX_ELEMENTS = 500_000
MAX_DEPTH = 100

_SHOWN_TAG = 60
_BLOCK = 1024 * 1024

_NO_PREFIXES: Mapping[str, str] = MappingProxyType({})


@dataclass(slots=True, eq=False)
class Node:
    """An XML element.

    ``attributes`` are those without a namespace; ``qualified`` the others, by namespace and
    name. ``prefixes`` are the namespaces in force, by prefix. ``metaclass`` is the class of
    the metamodel that the element is an object of, once that is known.
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
        tag = self.tag[:_SHOWN_TAG]
        for key in ("ID", "name"):
            if key in self.attributes:
                return f"{tag} {shown(self.attributes[key])}"
        return tag if self.parent is None else f"{tag} of {self.parent.description}"


@dataclass(frozen=True, slots=True)
class Document:
    """A file that was read: its root element, the encoding it declares, and its size."""

    root: Node
    encoding: str
    n_bytes: int
    n_elements: int


class Report:
    """Collects the diagnostics of one validation."""

    def __init__(self) -> None:
        self._found: list[Diagnostic] = []
        self._n_errors = 0

    def add(self, node: Node, constraint: str, finding: str) -> None:
        """Add a defect of an element; ``finding`` completes a sentence that begins with it."""
        severity = CONSTRAINTS[constraint].severity
        element = node.description
        message = f"{element} {finding}"
        self._add(Diagnostic(node.path, node.line, element, constraint, severity, message))

    def add_file(self, path: Path, line: int, constraint: str, finding: str) -> None:
        """Add a defect of a whole file."""
        severity = CONSTRAINTS[constraint].severity
        self._add(Diagnostic(path, line, path.name, constraint, severity, finding))

    def _add(self, found: Diagnostic) -> None:
        self._found.append(found)
        self._n_errors += found.severity == "error"

    @property
    def n_errors(self) -> int:
        """Number of defects found so far that stop loading."""
        return self._n_errors

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(self._found)


class _RefusedError(Exception):
    """The document breaks a limit; carries line, constraint and finding."""

    def __init__(self, line: int, constraint: str, finding: str) -> None:
        super().__init__(finding)
        self.line = line
        self.constraint = constraint
        self.finding = finding


class _TreeBuilder:
    """Handlers of the parser, which build the nodes and enforce the limits."""

    def __init__(self, path: Path) -> None:
        self.root: Node | None = None
        self.encoding = ""
        self.n_elements = 0
        self._path = path
        self._open: list[Node] = []
        self._prefixes: Mapping[str, str] = _NO_PREFIXES
        self._parser = expat.ParserCreate(namespace_separator=" ")
        self._parser.buffer_text = True
        self._parser.XmlDeclHandler = self._declaration
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartNamespaceDeclHandler = self._namespace
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._characters

    def parse(self, content: bytes) -> None:
        self._parser.Parse(content, True)

    def _declaration(self, _: str, encoding: str | None, __: int) -> None:
        self.encoding = (encoding or "").upper()  # as Eclipse writes it back

    def _doctype(self, *_: object) -> None:
        finding = "declares a document type; a model needs none; delete the <!DOCTYPE ...>"
        raise _RefusedError(self._parser.CurrentLineNumber, "NoDocumentType", finding)

    def _namespace(self, prefix: str | None, uri: str | None) -> None:
        self._prefixes = {**self._prefixes, (prefix or ""): uri or ""}

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        line = self._parser.CurrentLineNumber
        self._require_limits(line)
        namespace, _, tag = name.rpartition(" ")
        parent = self._open[-1] if self._open else None
        node = Node(self._path, line, namespace, tag, parent, self._prefixes)
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

    def _require_limits(self, line: int) -> None:
        self.n_elements += 1
        if self.n_elements > MAX_ELEMENTS:
            finding = f"has more than {MAX_ELEMENTS:,} elements; split the model"
            raise _RefusedError(line, "FileSize", finding)
        if len(self._open) >= MAX_DEPTH:
            finding = f"nests more than {MAX_DEPTH} elements; no model needs that; correct it"
            raise _RefusedError(line, "FileSize", finding)


def read_document(path: Path, report: Report) -> Node | None:
    """Read an XML file; report what is wrong with it.

    Parameters
    ----------
    path
        The file.
    report
        Takes the diagnostics.

    Returns
    -------
    Node or None
        The root element; ``None`` if the file cannot be used.
    """
    document = read_encoded(path, report)
    return None if document is None else document.root


def read_encoded(path: Path, report: Report) -> Document | None:
    """Read an XML file as ``read_document`` does, with its encoding and size."""
    content = _read_bytes(path, report)
    if content is None:
        return None
    builder = _TreeBuilder(path)
    try:
        builder.parse(content)
    except _RefusedError as refused:
        finding = f"{path.name} {refused.finding}"
        report.add_file(path, refused.line, refused.constraint, finding)
        return None
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        finding = f"{path.name} is not well-formed XML: {reason}; correct it at this line"
        report.add_file(path, error.lineno, "WellFormedXml", finding)
        return None
    except (LookupError, ValueError) as error:
        finding = f"{path.name} has an encoding that cannot be read: {error}; save it as UTF-8"
        report.add_file(path, 1, "WellFormedXml", finding)
        return None
    if builder.root is None:
        return None
    encoding = builder.encoding or _detected(content)
    return Document(builder.root, encoding, len(content), builder.n_elements)


def _detected(content: bytes) -> str:
    """Return the encoding of a file that declares none, as the byte order mark tells it."""
    return "UTF-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "UTF-8"


def _require_file(path: Path) -> None:
    """Refuse a pipe or a device: opening one could wait for ever."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "It is no file")


def _blocks(path: Path) -> Iterator[bytes]:
    """Yield the content of a file block by block, until it is read or larger than allowed."""
    n_bytes = 0
    with path.open("rb") as stream:
        while n_bytes <= MAX_BYTES and (block := stream.read(_BLOCK)):
            n_bytes += len(block)
            yield block


def _read_bytes(path: Path, report: Report) -> bytes | None:
    """Return the content of a file unless it is missing or too large."""
    try:
        _require_file(path)
        content = b"".join(_blocks(path))
    except OSError as error:
        reason = error.strerror or type(error).__name__
        finding = f"{path.name} cannot be read: {reason}; expected a model file at this path"
        report.add_file(path, 1, "ReadableFile", finding)
        return None
    except ValueError as error:
        finding = f"{path.name} cannot be read: {error}; expected a model file at this path"
        report.add_file(path, 1, "ReadableFile", finding)
        return None
    if len(content) > MAX_BYTES:
        finding = f"{path.name} has more than {MAX_BYTES:,} bytes; a model is far smaller; split it"
        report.add_file(path, 1, "FileSize", finding)
        return None
    return content
