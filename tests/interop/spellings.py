"""Other spellings of a model: the same content as somebody might type it, or another tool write."""

import random
from collections.abc import Iterator, Mapping

from lxml import etree
from pyecore.ecore import EClass

from m2t.metaclasses import features
from m2t.metamodels import load_metamodels
from tests.support.features import is_contained, is_reference

_XSI = "http://www.w3.org/2001/XMLSchema-instance"
_FEATURES = {
    feature.name: feature
    for package in load_metamodels().packages
    for metaclass in package.eClassifiers
    if isinstance(metaclass, EClass)
    for feature in features(metaclass)
}
_REFERENCES = {name for name, feature in _FEATURES.items() if is_reference(feature)}
_COORDINATES = {
    name
    for name, feature in _FEATURES.items()
    if is_contained(feature) and feature.eType.name == "Coordinates"
}


def respelt(content: bytes, seed: int) -> bytes:
    """Return a file with the same content in another spelling.

    Attributes and children of different features change places; defaults, namespaces and types
    are written where nobody needs them; references become paths; comments, processing
    instructions, tabs and CRLF come in.
    """
    rng = random.Random(seed)
    encoding = content[:60].decode("ascii").split('"')[3]
    root = etree.fromstring(content)
    paths = dict(_paths(root, "/"))
    _respell(root, paths, rng)
    etree.indent(root, space="\t")
    package = etree.QName(root).namespace
    respelt_root = etree.Element(root.tag, dict(root.attrib), nsmap={"xsi": _XSI, **root.nsmap})
    respelt_root.text = root.text
    respelt_root.extend(list(root))
    body = etree.tostring(respelt_root, encoding="unicode")
    prefix = f"<?xml version='1.0' encoding='{encoding}'?>\n<!-- {package} -->\n<?tool before?>\n"
    text = f"{prefix}{body}\n<!-- after -->\n".replace("\n", "\r\n")
    return text.encode(encoding, errors="xmlcharrefreplace")


def _respell(element: etree._Element, paths: Mapping[str, str], rng: random.Random) -> None:
    attributes = [(key, _value(str(key), str(text), paths, rng)) for key, text in element.items()]
    if element.tag in _COORDINATES:
        zero = rng.choice(["0.0", "0", ".0", "0e0"])
        attributes.extend((axis, zero) for axis in "xyz" if axis not in element.attrib)
    rng.shuffle(attributes)
    element.attrib.clear()
    element.attrib.update(attributes)
    children = list(element)
    for child in children:
        _respell(child, paths, rng)
        child.tail = None
    _mix(element, children, rng)
    element.text = None
    if children:
        element.insert(rng.randrange(len(element) + 1), etree.Comment(f" a <{element.tag}> & "))
        element.insert(rng.randrange(len(element) + 1), etree.ProcessingInstruction("tool", "x"))


def _mix(element: etree._Element, children: list[etree._Element], rng: random.Random) -> None:
    """Let features change places; the order within a feature means something and stays."""
    places = [child.tag for child in children]
    rng.shuffle(places)
    queues = {tag: [child for child in children if child.tag == tag] for tag in places}
    for tag in places:
        element.append(queues[tag].pop(0))


def _value(name: str, text: str, paths: Mapping[str, str], rng: random.Random) -> str:
    """Return a reference as paths, and a number with what Java allows around it."""
    if name in _REFERENCES and rng.random() < 0.5:
        return " ".join(paths[identity] for identity in text.split(" "))
    feature = _FEATURES.get(name)
    if feature is None or is_reference(feature) or feature.name in ("name", "value", "type"):
        return text
    if feature.eType.name == "EDouble" and "E" not in text and rng.random() < 0.5:
        return f"{text}00"
    return text


def _paths(element: etree._Element, path: str) -> Iterator[tuple[str, str]]:
    """Yield the ID and the path of every element below one."""
    if "ID" in element.attrib:
        yield str(element.attrib["ID"]), path
    counts: dict[str, int] = {}
    for child in element:
        feature = _FEATURES[str(child.tag)]
        number = counts.setdefault(str(child.tag), 0)
        counts[str(child.tag)] += 1
        step = f"@{child.tag}.{number}" if feature.many else f"@{child.tag}"
        yield from _paths(child, f"{'/' if path == '/' else path}/{step}")
