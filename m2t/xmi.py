"""Write models as Eclipse EMF writes them, so that a save by script is a save by Eclipse.

pyecore's own serializer is not used: it orders features differently, writes default values
and truncates the file before it knows that it can write the new content.
"""

import os
import re
import tempfile
from collections.abc import Iterator, Mapping
from decimal import Decimal
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pyecore.ecore import EEnum

from m2t.metamodels import features, is_contained, is_reference, reference_type
from mrsfi_runtime.errors import ModelError

_XMI_NAMESPACE = "http://www.omg.org/XMI"
_XSI_NAMESPACE = "http://www.w3.org/2001/XMLSchema-instance"
_NO_HREFS: Mapping[Any, str] = MappingProxyType({})

_ATTRIBUTE_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", '"': "&quot;", "\t": "&#x9;", "\n": "&#xA;", "\r": "&#xD;"}
)
_TEXT_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", "\r": "&#xD;"})
_NO_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def dumps(root: Any, encoding: str = "ASCII", *, hrefs: Mapping[Any, str] = _NO_HREFS) -> bytes:
    """Return a model as the bytes of an XMI file.

    Parameters
    ----------
    root
        Root object of the model.
    encoding
        Encoding that the file declares; what it lacks becomes a character reference.
    hrefs
        Relative addresses of the other files that the model refers to, by their root object.

    Returns
    -------
    bytes
        The file, with LF line ends.

    Raises
    ------
    ModelError
        If the model refers to an object of a file that ``hrefs`` does not know, or holds a
        character that XML cannot.

    Notes
    -----
    References inside the file and across files name elements by ID; without an ID, or with
    one that holds a space, by path. Elements are never given an xmi:id.
    """
    writer = _Writer(root, hrefs)
    body = "".join(line + "\n" for line in writer.document())
    return _encoded(f'<?xml version="1.0" encoding="{encoding}"?>\n{body}', encoding)


def _encoded(text: str, encoding: str) -> bytes:
    """Return text in an encoding, with hexadecimal references for what it lacks, as EMF does."""
    if not text.isascii():
        text = "".join(
            character if _has(encoding, character) else f"&#x{ord(character):x};"
            for character in text
        )
    return text.encode(encoding)


def _has(encoding: str, character: str) -> bool:
    try:
        character.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file as a whole: after a crash it has either its old or its new content.

    Parameters
    ----------
    path
        The file; its folder exists.
    content
        The new content.
    """
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        temporary.chmod(path.stat().st_mode & 0o777 if path.exists() else 0o644)
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def java_double(value: float) -> str:
    """Return a number as Java's ``Double.toString`` spells it.

    Examples
    --------
    >>> java_double(250.0), java_double(1e-5), java_double(12345678.9)
    ('250.0', '1.0E-5', '1.23456789E7')
    """
    if value == 0:
        return "-0.0" if str(value).startswith("-") else "0.0"
    shortest = repr(value)
    if float(f"{value:.1e}") == value:  # Java never shows fewer than two digits
        shortest = f"{value:.1e}"
    sign, digits, exponent = Decimal(shortest).as_tuple()
    text = "".join(map(str, digits)).rstrip("0") or "0"
    point = len(digits) + int(exponent)
    minus = "-" if sign else ""
    if 1e-3 <= abs(value) < 1e7:
        if point <= 0:
            return f"{minus}0.{'0' * -point}{text}"
        return f"{minus}{text[:point].ljust(point, '0')}.{text[point:] or '0'}"
    return f"{minus}{text[0]}.{text[1:] or '0'}E{point - 1}"


class _Writer:
    """Writes one model; remembers which namespaces it needed for xsi:type."""

    def __init__(self, root: Any, hrefs: Mapping[Any, str]) -> None:
        self._root = root
        self._hrefs = hrefs
        self._uses_xsi = False
        self._namespaces = {root.eClass.ePackage.nsPrefix: root.eClass.ePackage.nsURI}

    def document(self) -> Iterator[str]:
        """Return the lines of the root element."""
        attributes, lines = self._content(self._root, "  ")
        metaclass = self._root.eClass
        xsi = f' xmlns:xsi="{_XSI_NAMESPACE}"' if self._uses_xsi else ""
        namespaces = "".join(
            f' xmlns:{prefix}="{uri}"' for prefix, uri in sorted(self._namespaces.items())
        )
        head = f' xmi:version="2.0" xmlns:xmi="{_XMI_NAMESPACE}"{xsi}{namespaces}{attributes}'
        return _element("", f"{metaclass.ePackage.nsPrefix}:{metaclass.name}", head, lines)

    def _content(self, element: Any, indent: str) -> tuple[str, list[str]]:
        """Return the attributes of an element as one text, and the lines of its children."""
        attributes: list[str] = []
        lines: list[str] = []
        for feature in features(element.eClass):
            value = element.eGet(feature)
            if is_contained(feature):
                lines.extend(self._contained(feature, _as_list(feature, value), indent))
            elif is_reference(feature):
                self._refer(feature, _as_list(feature, value), indent, attributes, lines)
            elif feature.many:
                texts = (_escaped(_text(feature, entry), _TEXT_ESCAPES) for entry in value)
                lines.extend(f"{indent}<{feature.name}>{text}</{feature.name}>" for text in texts)
            elif _is_written(element, feature, value):
                text = _escaped(_text(feature, value), _ATTRIBUTE_ESCAPES)
                attributes.append(f' {feature.name}="{text}"')
        return "".join(attributes), lines

    def _contained(self, feature: Any, values: list[Any], indent: str) -> Iterator[str]:
        for value in values:
            attributes, lines = self._content(value, indent + "  ")
            kind = self._type(feature, value)
            yield from _element(indent, feature.name, kind + attributes, lines)

    def _refer(
        self,
        feature: Any,
        values: list[Any],
        indent: str,
        attributes: list[str],
        lines: list[str],
    ) -> None:
        """Refer by attribute within the file, by elements as soon as one value is outside."""
        if not values:
            return
        if all(value.eRoot() is self._root for value in values):
            text = _escaped(" ".join(_fragment(value) for value in values), _ATTRIBUTE_ESCAPES)
            attributes.append(f' {feature.name}="{text}"')
            return
        for value in values:
            href = _escaped(f"{self._address(value)}#{_fragment(value)}", _ATTRIBUTE_ESCAPES)
            kind = self._type(feature, value)
            lines.append(f'{indent}<{feature.name}{kind} href="{href}"/>')

    def _type(self, feature: Any, value: Any) -> str:
        """Return xsi:type where the declared class does not say it."""
        if value.eClass is reference_type(feature):
            return ""
        package = value.eClass.ePackage
        self._uses_xsi = True
        self._namespaces[package.nsPrefix] = package.nsURI
        return f' xsi:type="{package.nsPrefix}:{value.eClass.name}"'

    def _address(self, value: Any) -> str:
        root = value.eRoot()
        if root is self._root:
            return ""
        if root not in self._hrefs:
            raise ModelError(
                f"{self._root.eClass.name} refers to '{_fragment(value)}' of another "
                f"{root.eClass.name}; expected one whose file is known; give its address"
            )
        return self._hrefs[root]


def _element(indent: str, name: str, attributes: str, lines: list[str]) -> Iterator[str]:
    if not lines:
        yield f"{indent}<{name}{attributes}/>"
        return
    yield f"{indent}<{name}{attributes}>"
    yield from lines
    yield f"{indent}</{name}>"


def _as_list(feature: Any, value: Any) -> list[Any]:
    if feature.many:
        return list(value)
    return [] if value is None else [value]


def _is_written(element: Any, feature: Any, value: Any) -> bool:
    """Return whether Eclipse would write an attribute: set, and not equal to the default."""
    if value is None:
        return False
    if feature.unsettable:
        return bool(element.eIsSet(feature))
    return bool(value != feature.get_default_value())


def _text(feature: Any, value: Any) -> str:
    if isinstance(feature.eType, EEnum):
        return str(value.name)
    if feature.eType.name == "EDouble":
        return java_double(float(value))
    return str(value)


def _escaped(text: str, escapes: Mapping[int, str]) -> str:
    if _NO_XML.search(text):
        raise ModelError(
            f"text {text[:60]!a} holds a character that XML cannot; expected printable text; "
            "delete the character"
        )
    return text.translate(escapes)


def _fragment(element: Any) -> str:
    """Return how references name an element: by ID, else by path."""
    for feature in features(element.eClass):
        if getattr(feature, "iD", False):
            identity = element.eGet(feature)
            if identity and not re.search(r"\s|^/", identity):
                return str(identity)
    return _path(element)


def _path(element: Any) -> str:
    container = element.eContainer()
    if container is None:
        return "/"
    feature = element.eContainmentFeature()
    index = f".{list(container.eGet(feature)).index(element)}" if feature.many else ""
    parent = _path(container)
    return f"{'/' if parent == '/' else parent}/@{feature.name}{index}"
