"""Write models as Eclipse EMF writes them, so that scripts and Eclipse save the same bytes.

pyecore's serializer is not used: it orders features differently, writes default values, and
truncates the file before it has the new content. Begin with ``dumps``.

``unified_difference`` compares long files in time proportional to their length; ``difflib`` checks
the whole file for every changed line. As in a patience diff, lines that occur once in both files
divide them, and the parts between them are divided again. The difference is correct for any two
files, and equals that of ``difflib`` for short ones.
"""

import re
from bisect import bisect_left
from collections import Counter, defaultdict, deque
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from difflib import SequenceMatcher
from functools import cache
from itertools import groupby
from types import MappingProxyType
from typing import Any

from pyecore.ecore import EEnum

from m2t.metaclasses import Slot, slots, values
from m2t.read import XMI, XSI, Spelling
from mrsfi_runtime.errors import ModelError
from mrsfi_runtime.files import write_atomically as write_atomically  # noqa: PLC0414 - for scripts

_ATTRIBUTE_ESCAPES = str.maketrans(
    {"&": "&amp;", "<": "&lt;", '"': "&quot;", "\t": "&#x9;", "\n": "&#xA;", "\r": "&#xD;"}
)
_TEXT_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", "\r": "&#xD;"})
_NO_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def dumps(
    root: Any,
    encoding: str = "ASCII",
    *,
    hrefs: Mapping[Any, str] = MappingProxyType({}),
    xmi_ids: Mapping[Any, str] = MappingProxyType({}),
) -> bytes:
    """Return a model as the bytes of an XMI file, with LF line ends.

    Characters that ``encoding`` lacks become character references. ``hrefs`` are the relative
    addresses of other files, by their root objects; a contained root among them is written as a
    reference to its file. References name elements by xmi:id, else by ID; without either, or with
    a space in the ID, by path. A reference to a file that is not in ``hrefs``, or a character that
    XML forbids, raises a ``ModelError``.
    """
    return dumps_file((root,), Spelling(encoding), hrefs, xmi_ids)


def dumps_file(
    roots: Sequence[Any], spelling: Spelling, hrefs: Mapping[Any, str], xmi_ids: Mapping[Any, str]
) -> bytes:
    """Return a file with any number of roots as ``dumps`` does; several stand in ``xmi:XMI``."""
    lines = _Writer(roots, hrefs, xmi_ids, spelling.schema_location).lines()
    whole = (f'<?xml version="1.0" encoding="{spelling.encoding}"?>', *lines, "")
    text, encoding = spelling.line_end.join(whole), spelling.encoding
    lacking = (each for each in set(text) if not each.encode(encoding, "ignore"))
    text = text.translate({ord(each): f"&#x{ord(each):x};" for each in lacking})  # as EMF does
    if encoding.upper() == "UTF-16":  # as in Java: big-endian after a byte order mark
        return b"\xfe\xff" + text.encode("UTF-16-BE")
    return text.encode(encoding)


def java_double(value: float) -> str:
    """Return a number as Java's ``Double.toString`` spells it.

    Examples
    --------
    >>> java_double(250.0), java_double(1e-5), java_double(12345678.9)
    ('250.0', '1.0E-5', '1.23456789E7')
    """
    if value == 0 or 1e-3 <= abs(value) < 1e7:
        return repr(value)
    two_digits = f"{value:.1e}"  # Java never shows fewer
    shortest = Decimal(two_digits if float(two_digits) == value else repr(value))
    mantissa, _, exponent = f"{shortest.normalize():e}".partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}E{int(exponent)}"


class _Writer:
    """Writes one file, and collects the namespaces that it needs for xsi:type."""

    def __init__(
        self,
        roots: Sequence[Any],
        hrefs: Mapping[Any, str],
        xmi_ids: Mapping[Any, str],
        schema_location: str | None,
    ) -> None:
        self._roots = roots
        self._schema_location = schema_location
        self._addresses: dict[Any, str] = {**dict.fromkeys(roots, ""), **hrefs}
        self._xmi_ids = xmi_ids
        self._uses_xsi = schema_location is not None
        self._namespaces = {
            root.eClass.ePackage.nsPrefix: root.eClass.ePackage.nsURI for root in roots
        }
        self._tops: dict[Any, Any] = {root: root for root in self._addresses}
        self._starts = dict(_starts(roots, hrefs))
        self._positions = cache(lambda of, name: {each: n for n, each in enumerate(of.eGet(name))})

    def lines(self) -> Iterator[str]:
        indent = "  " if len(self._roots) > 1 else ""
        elements = [(_tag(root), *self._content(root, indent)) for root in self._roots]
        if len(elements) == 1:
            ((tag, attributes, inner),) = elements
            return _element_lines("", tag, self._head() + attributes, inner)
        lines = [line for element in elements for line in _element_lines(indent, *element)]
        return _element_lines("", "xmi:XMI", self._head(), lines)

    def _head(self) -> str:
        xsi = f' xmlns:xsi="{XSI}"' if self._uses_xsi else ""
        namespaces = "".join(
            f' xmlns:{prefix}="{uri}"' for prefix, uri in sorted(self._namespaces.items())
        )
        location = self._schema_location
        schemas = "" if location is None else _attribute("xsi:schemaLocation", location)
        return f' xmi:version="2.0" xmlns:xmi="{XMI}"{xsi}{namespaces}{schemas}'

    def _content(self, element: Any, indent: str) -> tuple[str, list[str]]:
        identity = self._xmi_ids.get(element)
        attributes = [] if identity is None else [_attribute("xmi:id", identity)]
        lines: list[str] = []
        indent += "  "
        for slot in slots(element.eClass).values():
            feature = slot.feature
            if not slot.many and not element.eIsSet(feature):
                continue
            held = values(element, slot)
            if slot.is_contained:
                lines.extend(self._contained(slot, held, indent))
            elif slot.is_reference:
                self._require_addresses(element, slot, held)
                if any(self._address(value) for value in held):  # one is outside the file
                    lines += [self._reference(slot, each, indent) for each in held]
                    continue
                fragments = " ".join(map(self._fragment, held))
                attributes += [_attribute(slot.name, fragments)] if held else []
            elif slot.many:
                texts = (_escaped(_text(slot, value), _TEXT_ESCAPES) for value in held)
                lines.extend(f"{indent}<{slot.name}>{text}</{slot.name}>" for text in texts)
            elif held and _is_written(feature, held[0]):
                attributes.append(_attribute(slot.name, _text(slot, held[0])))
        return "".join(attributes), lines

    def _contained(self, slot: Slot, held: list[Any], indent: str) -> Iterator[str]:
        for value in held:
            if value in self._starts:  # the root of another file
                yield self._reference(slot, value, indent)
                continue
            kind = self._type(slot, value)
            attributes, lines = self._content(value, indent)
            yield from _element_lines(indent, slot.name, kind + attributes, lines)

    def _reference(self, slot: Slot, value: Any, indent: str) -> str:
        href = _attribute("href", f"{self._address(value)}#{self._fragment(value)}")
        return f"{indent}<{slot.name}{self._type(slot, value)}{href}/>"

    def _type(self, slot: Slot, value: Any) -> str:
        """Return xsi:type if the class differs from the declared one."""
        if value.eClass is slot.type:
            return ""
        package = value.eClass.ePackage
        self._uses_xsi = True
        self._namespaces[package.nsPrefix] = package.nsURI
        return f' xsi:type="{_tag(value)}"'

    def _require_addresses(self, element: Any, slot: Slot, held: list[Any]) -> None:
        """Refuse a reference to an object that is in no known file, such as a deleted one."""
        for value in held:
            top = self._top(value)
            if top not in self._addresses:
                where = "no model" if top is value else f"another {top.eClass.name}"
                raise ModelError(
                    f"{element.eClass.name} '{self._fragment(element)}' refers by {slot.name} to "
                    f"{value.eClass.name} '{self._fragment(value)}', which is part of {where}; "
                    "expected one of the model's files; delete the reference if the target is "
                    "deleted, or give the address of its file"
                )

    def _address(self, value: Any) -> str:
        return self._addresses[self._top(value)]

    def _top(self, value: Any) -> Any:
        if value not in self._tops:
            container = value.eContainer()
            self._tops[value] = value if container is None else self._top(container)
        return self._tops[value]

    def _fragment(self, element: Any) -> str:
        """Return the fragment of an element in references: its xmi:id, its ID, or else its path."""
        known = slots(element.eClass).values()
        ids = (element.eGet(slot.feature) for slot in known if slot.is_id)
        name = self._xmi_ids.get(element, next(ids, None))
        return str(name) if name and not re.search(r"\s|^/", name) else self._path(element)

    def _path(self, element: Any) -> str:
        container = element.eContainer()
        if container is None or self._top(element) is element:
            return str(self._starts.get(element, "/"))
        feature = element.eContainmentFeature()
        index = f".{self._positions(container, feature)[element]}" if feature.many else ""
        parent = self._path(container)
        return f"{'/' if parent == '/' else parent}/@{feature.name}{index}"


def _starts(roots: Sequence[Any], hrefs: Mapping[Any, str]) -> Iterator[tuple[Any, str]]:
    """Yield the path of every root in its file: ``/``, or its number if there are several."""
    files: dict[str, list[Any]] = {"": list(roots)}
    for root, address in hrefs.items():
        files.setdefault(address, []).append(root)
    for entries in files.values():
        for number, root in enumerate(entries):
            yield root, f"/{number}" if len(entries) > 1 else "/"


def _attribute(name: str, value: str) -> str:
    return f' {name}="{_escaped(value, _ATTRIBUTE_ESCAPES)}"'


def _tag(root: Any) -> str:
    return f"{root.eClass.ePackage.nsPrefix}:{root.eClass.name}"


def _element_lines(indent: str, name: str, attributes: str, lines: list[str]) -> Iterator[str]:
    if not lines:
        yield f"{indent}<{name}{attributes}/>"
        return
    yield f"{indent}<{name}{attributes}>"
    yield from lines
    yield f"{indent}</{name}>"


def _is_written(feature: Any, value: Any) -> bool:
    """Return whether Eclipse would write an attribute that is set: unless it is the default."""
    if feature.unsettable:
        return True
    return bool(value != feature.get_default_value()) or str(value) == "-0.0"


def _text(slot: Slot, value: Any) -> str:
    if isinstance(slot.type, EEnum):
        return str(value.name)
    if slot.type.name == "EDouble":
        return java_double(float(value))
    return str(value).lower() if slot.type.name == "EBoolean" else str(value)


def _escaped(text: str, escapes: Mapping[int, str]) -> str:
    """Return a text with escapes for XML; refuse characters that XML forbids."""
    if _NO_XML.search(text):
        found = f"text {text[:60]!a} contains a character that XML forbids; expected printable text"
        raise ModelError(f"{found}; delete the character")
    return text.translate(escapes)


SHORT = 400
"""Number of lines up to which files are compared undivided."""


def unified_difference(
    old: Sequence[str], new: Sequence[str], old_name: str, new_name: str, line_end: str = "\n"
) -> Iterator[str]:
    """Yield the lines of the unified difference, as ``difflib.unified_diff`` does.

    ``line_end`` ends the lines of header and hunks; it is empty if the compared lines have none.
    """
    for number, group in enumerate(_Aligned(old, new).get_grouped_opcodes()):
        if number == 0:
            yield f"--- {old_name}{line_end}"
            yield f"+++ {new_name}{line_end}"
        (_, old_first, _, new_first, _), (_, _, old_last, _, new_last) = group[0], group[-1]
        ranges = f"-{_range(old_first, old_last)} +{_range(new_first, new_last)}"
        yield f"@@ {ranges} @@{line_end}"
        for what, old_first, old_last, new_first, new_last in group:
            mark = " " if what == "equal" else "-"
            yield from (f"{mark}{line}" for line in old[old_first:old_last])
            if what != "equal":
                yield from (f"+{line}" for line in new[new_first:new_last])


def _range(first: int, last: int) -> str:
    length = last - first
    begin = first + 1 if length else first
    return f"{begin}" if length == 1 else f"{begin},{length}"


class _Aligned(SequenceMatcher[str]):
    """A matcher whose runs of equal lines are computed in advance."""

    def __init__(self, old: Sequence[str], new: Sequence[str]) -> None:
        super().__init__(None, (), ())
        pairs = enumerate(_pairs(old, new))
        runs = [[*run] for _, run in groupby(pairs, lambda each: [p - each[0] for p in each[1]])]
        blocks = [(*run[0][1], len(run)) for run in runs]
        self.matching_blocks = [*blocks, (len(old), len(new), 0)]


def _pairs(old: Sequence[str], new: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Yield the places of equal lines in both files, in order."""
    anchors = [] if max(len(old), len(new)) <= SHORT else _anchors(old, new)
    if not anchors:
        for a, b, length in SequenceMatcher(None, old, new).get_matching_blocks():
            yield from zip(range(a, a + length), range(b, b + length), strict=True)
        return
    begin = (0, 0)
    for a, b in anchors:
        yield from _pairs_between(old, new, begin, (a, b))
        yield a, b
        begin = (a + 1, b + 1)
    yield from _pairs_between(old, new, begin, (len(old), len(new)))


def _pairs_between(
    old: Sequence[str], new: Sequence[str], begin: tuple[int, int], end: tuple[int, int]
) -> Iterator[tuple[int, int]]:
    if begin[0] < end[0] and begin[1] < end[1]:
        for a, b in _pairs(old[begin[0] : end[0]], new[begin[1] : end[1]]):
            yield begin[0] + a, begin[1] + b


def _anchors(old: Sequence[str], new: Sequence[str]) -> list[tuple[int, int]]:
    """Return positions of lines that occur once in both files: the longest run in the same order.

    Without such lines, use those that occur equally often in both files.
    """
    counts_old, counts_new = Counter(old), Counter(new)
    alike = {line for line, count in counts_old.items() if counts_new[line] == count}
    dividing = {line for line in alike if counts_old[line] == 1} or alike
    places: dict[str, deque[int]] = defaultdict(deque)
    for n, line in enumerate(new):
        places[line].append(n)
    pairs = [(n, places[line].popleft()) for n, line in enumerate(old) if line in dividing]
    ends: list[int] = []  # the least end of an increasing run, by its length
    chosen: list[int] = []  # the pair that has it
    before: list[int] = []  # by pair, the one before it in its run; -1 if none
    for k, (_, place) in enumerate(pairs):
        length = bisect_left(ends, place)
        before.append(chosen[length - 1] if length else -1)
        ends[length : length + 1] = [place]
        chosen[length : length + 1] = [k]
    run = []
    k = chosen[-1] if chosen else -1
    while k >= 0:
        run.append(pairs[k])
        k = before[k]
    return run[::-1]
