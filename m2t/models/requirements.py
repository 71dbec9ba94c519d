"""Requirements in ReqIF files: into the model of a mission, and results back into the file.

ReqIF (OMG, version 1.2) is the exchange format of requirements tools. A SPEC-OBJECT has values,
named by their definitions. One with a text is a requirement here; others, such as headings, are
left alone, and so is all else in the file, also what mrsfi does not know.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from lxml import etree

from m2t.metaclasses import contained, slots
from m2t.metamodels import load_metamodels
from m2t.models.check import require_value
from m2t.read import Defect, Report, read_root, shown
from mrsfi_runtime.errors import ModelError, expected

_RESULT = "Result of mrsfi"
_NEW = {"LAST-CHANGE": "2026-11-28T00:00:00Z", "LONG-NAME": _RESULT}  # LAST-CHANGE of this line
_INLINE = {"a", "abbr", "b", "big", "cite", "code", "em", "i", "q", "small", "span", "strong"}
_INLINE |= {"sub", "sup", "tt", "u"}


@dataclass(frozen=True, slots=True)
class ReqifRequirement:
    """A requirement of a file, with the ID and the text that it has in the model of a mission."""

    id: str
    text: str
    path: Path
    element: Any

    def error(self, finding: str) -> ModelError:
        """Return the error that it cannot be used."""
        own = shown(self.element.get("IDENTIFIER", ""))
        return ModelError(f"{self.path}:{self.element.sourceline}: SPEC-OBJECT {own} {finding}")


class ReqifFile:
    """A ReqIF file and its ``requirements``, by the names of the values of their text and ID.

    A file that cannot be used raises a ``ModelError``.
    """

    def __init__(
        self, path: Path, text: str = "ReqIF.Text", identity: str = "ReqIF.ForeignID"
    ) -> None:
        self._path = path
        if read_root(path, Report()).tag != "REQ-IF":  # refuses document types and huge files
            raise ModelError(f"{path}: is no ReqIF file; expected <REQ-IF> as its root element")
        parser = etree.XMLParser(resolve_entities=False, strip_cdata=False, huge_tree=True)
        self._tree = etree.parse(path, parser)
        self._by_id = {each.get("IDENTIFIER"): each for each in self._tree.iter("{*}*")}
        self.requirements = tuple(self._requirements(text, identity))
        if not self.requirements:
            own = self._tree.iterfind(".//{*}SPEC-OBJECT-TYPE/{*}SPEC-ATTRIBUTES/*")
            names = sorted({each.get("LONG-NAME", "") for each in own} - {"", text})
            what = f"{path}: found no SPEC-OBJECT with a value named '{text}'"
            raise ModelError(f"{what}; {expected(text, names, 'one of these names as --text:')}")

    def _requirements(self, text: str, identity: str) -> Iterator[ReqifRequirement]:
        known: dict[str, ReqifRequirement] = {}
        for element in self._tree.iterfind(".//{*}SPEC-OBJECTS/{*}SPEC-OBJECT"):
            of = {self._name(value): value for value in element.iterfind("{*}VALUES/{*}*")}
            named = model_id(_text(of.get(identity)) or element.get("IDENTIFIER", ""))
            found = ReqifRequirement(named, _text(of.get(text)), self._path, element)
            if not found.text:
                continue
            if (first := known.setdefault(named, found)) is not found:
                raise found.error(
                    f"gets the ID '{named}', as does the one in line {first.element.sourceline}; "
                    "expected different ones; correct one, or name another value as --id"
                )
            yield found

    def _name(self, value: Any) -> str:
        """Return the name of a value, which its definition has."""
        definition = self._by_id.get(value.findtext("{*}DEFINITION/*", "").strip())
        return "" if definition is None else str(definition.get("LONG-NAME", ""))

    def with_results(self, results: Mapping[str, str]) -> bytes:
        """Return the file with the results of all its requirements, by ID, as values of theirs."""
        try:
            for each in self.requirements:
                self._add_result(each.element, results[each.id])
        except AttributeError as error:  # of None
            what = f"{self._path}: lacks the type of a requirement or its definitions"
            raise ModelError(f"{what}; expected a file that ReqIF's schema allows") from error
        encoding = self._tree.docinfo.encoding or "UTF-8"
        written = etree.tostring(self._tree, encoding=encoding, xml_declaration=True)
        return cast("bytes", written)

    def _add_result(self, element: Any, result: str) -> None:
        for value in element.iterfind("{*}VALUES/{*}*"):
            if self._name(value) == _RESULT:
                value.set("THE-VALUE", result)
                return
        kind = self._by_id.get(element.findtext("{*}TYPE/*", "").strip())
        value = _added(element.find("{*}VALUES"), "ATTRIBUTE-VALUE-STRING", {"THE-VALUE": result})
        definition = _added(value, "DEFINITION", {})
        _added(definition, "ATTRIBUTE-DEFINITION-STRING-REF", {}).text = self._definition(kind)

    def _definition(self, kind: Any) -> str:
        """Return the identifier of the result's definition in a type, and add it if it is new."""
        attributes = kind.find("{*}SPEC-ATTRIBUTES")
        for each in attributes.iterfind(f"*[@LONG-NAME='{_RESULT}']"):
            return str(each.get("IDENTIFIER"))
        datatype, named = "mrsfi-result", {"IDENTIFIER": "mrsfi-result", **_NEW}
        if datatype not in self._by_id:
            place, limited = self._tree.find(".//{*}DATATYPES"), {**named, "MAX-LENGTH": "100"}
            self._by_id[datatype] = _added(place, "DATATYPE-DEFINITION-STRING", limited)
        named["IDENTIFIER"] += f"-{kind.get('IDENTIFIER')}"
        own = _added(attributes, "ATTRIBUTE-DEFINITION-STRING", named)
        _added(_added(own, "TYPE", {}), "DATATYPE-DEFINITION-STRING-REF", {}).text = datatype
        return named["IDENTIFIER"]


def _added(parent: Any, tag: str, attributes: dict[str, str]) -> Any:
    """Return an element of ReqIF that is added to the end of another one."""
    return etree.SubElement(parent, etree.QName(etree.QName(parent).namespace, tag), attributes)


def _text(value: Any) -> str:
    """Return a value as one line of text; tags of XHTML inside a line divide no words."""
    if value is None:
        return ""
    parts = [value.get("THE-VALUE", "")]
    for part in value.iterfind("{*}THE-VALUE"):
        for event, each in etree.iterwalk(part, events=("start", "end", "comment", "pi")):
            is_element = event in {"start", "end"}
            parts += " " * (is_element and etree.QName(each).localname not in _INLINE)
            parts.append((each.text if event == "start" else each.tail) or "")
    return " ".join("".join(parts).split())


def model_id(text: str) -> str:
    """Return the ID that a requirement gets in the model of a mission.

    Examples
    --------
    >>> model_id("SYS/001"), model_id("12"), model_id("_a1")
    ('SYS_001', 'R12', 'R_a1')
    """
    legal = re.sub(r"[^A-Za-z0-9_.-]+", "_", text)
    return legal if legal[:1].isalpha() else f"R{legal}"


def update(mission: Any, requirements: Iterable[ReqifRequirement]) -> Mapping[str, tuple[str, ...]]:
    """Add requirements to a mission, or change their texts, and return their IDs by what was done.

    Those that the mission alone has are ``kept``.
    """
    metaclass = load_metamodels().mission.getEClassifier("Requirement")
    own = {each.ID: each for each in mission.requirements}
    others = {each.ID for each in contained(mission) if "ID" in slots(each.eClass)} - {*own}
    found: dict[str, list[str]] = {"added": [], "changed": [], "unchanged": []}
    for each in requirements:
        try:
            for name, text in (("ID", each.id), ("text", each.text)):
                require_value(slots(metaclass)[name], text)
        except Defect as defect:
            raise each.error(defect.finding) from defect
        if each.id in others:
            what = f"gets the ID '{each.id}', which another element of the mission has"
            raise each.error(f"{what}; expected a free one; rename that element: mrsfi rename")
        known = own.pop(each.id, None)
        if known is None:
            mission.requirements.append(metaclass(ID=each.id, text=each.text))
            found["added"].append(each.id)
        else:
            found["unchanged" if known.text == each.text else "changed"].append(each.id)
            known.text = each.text
    return {name: tuple(ids) for name, ids in {**found, "kept": own}.items()}
