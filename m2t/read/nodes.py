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
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.parsers import expat

from m2t.diagnostics import Defect, FileLine, Report, shown

XMI = "http://www.omg.org/XMI"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
ECORE = "http://www.eclipse.org/emf/2002/Ecore"


MAX_BYTES = 64 * 1024 * 1024
MAX_ELEMENTS = 500_000
MAX_DEPTH = 100

_INDEX = re.compile(r"[0-9]{1,9}", re.ASCII)
_SHOWN_TAG = 60


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


def follow(
    node: Node | None, path: str, below: Callable[[Node, str], Sequence[Node]] = Node.tagged
) -> Node | None:
    """Return the node that a path of Eclipse leads to; ``None`` if it leads nowhere.

    The path has steps such as ``@goals.0/@messages.1``; ``below`` gives the elements of a tag,
    directly below a node, that a step chooses from.
    """
    for step in path.split("/") if path.strip("/") else ():
        name, dot, index = step.removeprefix("@").partition(".")
        if node is None or not step.startswith("@"):
            return None
        node = at(below(node, name), index if dot else "0")
    return node


def at(nodes: Sequence[Node], position: str) -> Node | None:
    """Return the node at a position of a path; ``None`` if there is none or it is no number."""
    is_number = _INDEX.fullmatch(position) is not None
    return nodes[int(position)] if is_number and int(position) < len(nodes) else None


@dataclass(frozen=True, slots=True)
class Spelling:
    """What saving keeps of a file beside its content.

    ``encoding`` is declared or, without that, told by the byte order mark; ``schema_location`` is
    the value of xsi:schemaLocation, which Epsilon writes; ``line_end`` is that of the first line.
    """

    encoding: str
    schema_location: str | None = None
    line_end: str = "\n"


class XmlFile:
    """A file being read: handlers of the parser build its nodes and enforce the limits."""

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
        """Line that the parser has come to, from 1."""
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
        raise Defect(
            "NoDocumentType",
            "declares a document type; a model needs none; delete the <!DOCTYPE ...>",
        )

    def _namespace(self, prefix: str | None, uri: str | None) -> None:
        self._prefixes = {**self._prefixes, (prefix or ""): uri or ""}

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._require_limits()
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

    def _require_limits(self) -> None:
        self.n_elements += 1
        if self.n_elements > MAX_ELEMENTS:
            raise Defect("FileSize", f"has more than {MAX_ELEMENTS:,} elements; split the model")
        if len(self._open) >= MAX_DEPTH:
            raise Defect(
                "FileSize", f"nests more than {MAX_DEPTH} elements; no model needs that; correct it"
            )


def read_xml(path: Path, report: Report) -> XmlFile | None:
    """Read an XML file; report what is wrong with it. ``None`` if it cannot be used."""
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
    """Refuse a pipe or a device: opening one could wait for ever."""
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "It is no file")


def _content(path: Path) -> bytes:
    """Return the content of a file unless it is missing or too large."""
    try:
        _require_file(path)
        n_bytes = path.stat().st_size
        content = path.read_bytes() if n_bytes <= MAX_BYTES else b""
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", str(error)) or type(error).__name__
        raise Defect(
            "ReadableFile", f"cannot be read: {reason}; expected a model file at this path"
        ) from error
    if n_bytes > MAX_BYTES:
        raise Defect(
            "FileSize", f"has more than {MAX_BYTES:,} bytes; a model is far smaller; split it"
        )
    return content
