"""A seeded mutator of mission folders: it goes by the metamodels and knows no constraint.

Every mutant takes a few *changes* of one *feature* from a shuffled deck of all of them, so that a
run of some hundred mutants changes every feature in every way, and chance decides the rest:
which model, which element, which value, and what comes together.
"""

import copy
import keyword
import random
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from lxml import etree
from pyecore.ecore import EClass, EEnum

from m2t.metaclasses import conforms, features, lineage
from m2t.metamodels import load_metamodels
from tests.support.features import is_contained, is_reference, reference_type
from tests.support.models.copies import FAULTS, MISSION

_TYPE = "{http://www.w3.org/2001/XMLSchema-instance}type"
_ODD_TEXTS = ("", "1x", "it's", "back\\slash", "\N{SNOWMAN}", "\xa0\u2028\ufeff", "no such word")


@dataclass(frozen=True, slots=True)
class Part:
    """An element of a file, its class, and the feature that contains it; ``None`` for a root."""

    element: etree._Element
    metaclass: Any
    feature: Any

    @property
    def parent(self) -> etree._Element:
        found = self.element.getparent()
        assert found is not None
        return found


@dataclass(frozen=True, slots=True)
class Models:
    """Both files of a mission folder on their way to a mutant."""

    trees: tuple[etree._ElementTree, ...]
    rng: random.Random

    def parts(self) -> Iterator[Part]:
        """Yield all elements of both files."""
        for tree in self.trees:
            yield from _parts(tree.getroot(), _root_class(tree.getroot()), None)

    def having(self, feature: Any) -> list[Part]:
        """Return the elements whose class has a feature."""
        return [part for part in self.parts() if feature in features(part.metaclass)]

    def ids(self, metaclass: Any) -> list[str]:
        """Return the IDs of the elements of a class."""
        found = (part for part in self.parts() if conforms(part.metaclass, metaclass))
        return [part.element.attrib["ID"] for part in found if "ID" in part.element.attrib]

    def values(self, feature: Any) -> list[str]:
        """Return what attributes of a feature's type hold anywhere."""
        return [
            part.element.attrib[known.name]
            for part in self.parts()
            for known in features(part.metaclass)
            if known.eType is feature.eType and known.name in part.element.attrib
        ]


Change = Callable[[Models, Any], bool]
"""Changes one place of a feature; answers whether there was one."""


class Mutator:
    """Makes mutants of mission folders, one after the other.

    Parameters
    ----------
    seed
        The same seed makes the same mutants of the same folders.
    """

    def __init__(self, seed: int) -> None:
        self._rng = random.Random(seed)
        self._deck: list[tuple[Any, Change]] = []

    def mutate(self, folder: Path) -> None:
        """Change one to three features of the models of a folder."""
        paths = [path for path in (folder / MISSION, folder / FAULTS) if path.exists()]
        parser = etree.XMLParser(remove_blank_text=True)
        models = Models(tuple(etree.parse(path, parser) for path in paths), self._rng)
        for _ in range(self._rng.choice((1, 2, 2, 3))):
            self._play(models)
        for path, tree in zip(paths, models.trees, strict=True):
            etree.indent(tree)
            encoding = tree.docinfo.encoding
            content = etree.tostring(tree, encoding=encoding, xml_declaration=True)
            path.write_bytes(content)

    def _play(self, models: Models) -> None:
        """Make the next change of the deck that the models have a place for, in up to four."""
        if not self._deck:
            self._deck = [(group, change) for group in _groups() for change in _changes(group[0])]
            self._rng.shuffle(self._deck)
        for position, (group, change) in enumerate(self._deck):
            known = [feature for feature in group if models.having(feature)]
            n_places = self._rng.randint(1, 4) if known else 0
            n_changed = sum(change(models, self._rng.choice(known)) for _ in range(n_places))
            if n_changed:
                del self._deck[position]
                return
        self._deck.clear()


def _groups() -> list[list[Any]]:
    """Return all features, with those in one group that subclasses share or that exclude others."""
    groups: dict[tuple[str, ...], list[Any]] = {}
    for package in load_metamodels().packages:
        for metaclass in package.eClassifiers:
            for feature in metaclass.eStructuralFeatures if isinstance(metaclass, EClass) else ():
                key = (lineage(metaclass)[0].name, feature.name, feature.eType.name)
                if is_contained(feature) and not feature.many:
                    key = (metaclass.name, lineage(reference_type(feature))[0].name)
                groups.setdefault(key, []).append(feature)
    return list(groups.values())


def _changes(feature: Any) -> tuple[Change, ...]:
    """Return the changes of a feature; those of a list take turns by chance."""
    if is_contained(feature):
        additions = (partial(_add, kind=kind) for kind in _kinds(reference_type(feature)))
        return (*additions, _remove, _one_of(_double, _move, _copy))
    if is_reference(feature):
        return (_refer, _refer, _one_of(_lose, _remove))
    if isinstance(feature.eType, EEnum):
        return (_one_of(_choose, _remove),)
    if feature.eType.name == "EString":
        return (_respell, _space, _one_of(_reword, _reserve), _one_of(_borrow, _lengthen, _remove))
    return (_lower, _exchange, _one_of(_borrow, _exceed, _halve, _remove))


def _one_of(*changes: Change) -> Change:
    """Return a change that is one of several, in an order that chance decides."""

    def change(models: Models, feature: Any) -> bool:
        order = models.rng.sample(changes, len(changes))
        return any(change(models, feature) for change in order)

    return change


def _given(values: Callable[[Models, Any], Sequence[str]]) -> Change:
    """Return a change that gives an attribute one of some values."""
    return lambda models, feature: _set(models, feature, values(models, feature))


def _spelt_otherwise(spell: Callable[[str], str]) -> Change:
    """Return a change that gives an attribute the value of another element, spelt otherwise."""
    return _given(
        lambda models, feature: [
            spell(part.element.get(feature.name, "")) for part in models.having(feature)
        ]
    )


def _beyond(_: Models, feature: Any) -> Sequence[str]:
    return ("2147483647",) if feature.eType.name == "EInt" else ("NaN", "-Infinity", "1.0E13")


def _halve(models: Models, feature: Any) -> bool:
    return feature.eType.name == "EDouble" and _set(models, feature, ("0.5", "2.5"))


_lower = _given(lambda *_: ("-1", "-7", "0"))
_exceed = _given(_beyond)
_choose = _given(lambda _, feature: [literal.name for literal in feature.eType.eLiterals])
_reword = _given(lambda *_: _ODD_TEXTS)
_reserve = _given(lambda *_: keyword.kwlist)
_lengthen = _given(lambda *_: ("x" * 201, "x" * 2001, "\U0001f916" * 150))
_borrow = _given(Models.values)
_respell = _spelt_otherwise(str.swapcase)
_space = _spelt_otherwise("{} 2".format)


def _set(models: Models, feature: Any, values: Sequence[str]) -> bool:
    part = models.rng.choice(models.having(feature))
    if not values:
        return False
    new = models.rng.choice(values)
    old = part.element.attrib.get(feature.name)
    part.element.attrib[feature.name] = new
    if feature.name == "ID" and old is not None:
        _rename(models, old, new)
    return True


def _rename(models: Models, old: str, new: str) -> None:
    """Let references follow an ID, as they do in an editor."""
    for part in models.parts():
        for feature in filter(is_reference, features(part.metaclass)):
            text = part.element.get(feature.name)
            if text is not None:
                names = [new if name == old else name for name in text.split()]
                part.element.set(feature.name, " ".join(names))
            for link in part.element.findall(feature.name):
                document, _, name = link.get("href", "").partition("#")
                link.set("href", f"{document}#{new if name == old else name}")


def _exchange(models: Models, feature: Any) -> bool:
    """Exchange the values of two attributes of one type in one element."""
    pairs = [
        (part.element, other.name)
        for part in models.having(feature)
        for other in features(part.metaclass)
        if other.eType is feature.eType
        and other is not feature
        and {feature.name, other.name} <= set(part.element.attrib)
    ]
    if not pairs:
        return False
    element, name = models.rng.choice(pairs)
    old = element.attrib[feature.name]
    element.attrib[feature.name], element.attrib[name] = element.attrib[name], old
    return True


def _refer(models: Models, feature: Any) -> bool:
    """Refer to other elements of the right class."""
    ids = models.ids(reference_type(feature))
    if not ids:
        return False
    n_targets = models.rng.choice((1, 1, 1, 2, len(ids))) if feature.many else 1
    chosen = models.rng.sample(ids, min(n_targets, len(ids)))
    _link(models.rng.choice(models.having(feature)), feature, chosen)
    return True


def _lose(models: Models, feature: Any) -> bool:
    """Refer to something that is not there; only another file may lack it and still load."""
    links = [
        link
        for part in models.having(feature)
        for link in part.element.findall(feature.name)
        if "#" in link.get("href", "")
    ]
    if not links:
        return False
    link = models.rng.choice(links)
    link.set("href", f"{link.get('href')}-lost")
    return True


def _link(part: Part, feature: Any, ids: list[str]) -> None:
    """Refer to elements by ID: in an attribute, or by links into the mission."""
    if part.metaclass.ePackage is reference_type(feature).ePackage:
        part.element.set(feature.name, " ".join(name.replace(" ", "") for name in ids))
        return
    for link in part.element.findall(feature.name):
        part.element.remove(link)
    for name in ids:
        etree.SubElement(part.element, feature.name, href=f"{MISSION}#{name}")


def _remove(models: Models, feature: Any) -> bool:
    """Remove all that an element has of a feature."""
    given = [part.element for part in models.having(feature) if _is_given(part.element, feature)]
    if not given:
        return False
    element = models.rng.choice(given)
    element.attrib.pop(feature.name, None)
    for child in element.findall(feature.name):
        element.remove(child)
    return True


def _add(models: Models, feature: Any, kind: Any) -> bool:
    """Put a new element into a feature; it takes the place of an only one."""
    part = models.rng.choice(models.having(feature))
    if not feature.many:
        for child in part.element.findall(feature.name):
            part.element.remove(child)
    _grow(models, part.element, feature, kind)
    return True


def _double(models: Models, feature: Any) -> bool:
    parts = [part for part in models.parts() if part.feature is feature]
    if not parts or not feature.many:
        return False
    part = models.rng.choice(parts)
    part.element.addnext(copy.deepcopy(part.element))
    return True


def _move(models: Models, feature: Any) -> bool:
    """Move an element to another one of its container's class."""
    parts = [part for part in models.parts() if part.feature is feature]
    if not parts:
        return False
    part = models.rng.choice(parts)
    others = [
        other.element
        for other in models.having(feature)
        if other.element is not part.parent
        and (feature.many or other.element.find(feature.name) is None)
    ]
    if not others:
        return False
    models.rng.choice(others).append(part.element)
    return True


def _copy(models: Models, feature: Any) -> bool:
    """Make an element what another one of its class is; it keeps its ID."""
    parts = [part for part in models.parts() if part.feature is feature]
    if not parts:
        return False
    part = models.rng.choice(parts)
    same = [other for other in models.parts() if other.metaclass is part.metaclass]
    other = models.rng.choice(same).element
    identity = part.element.get("ID")
    part.element.attrib.clear()
    part.element.attrib.update(other.attrib)
    if identity is not None:
        part.element.set("ID", identity)
    return True


def _kinds(declared: Any) -> list[Any]:
    """Return the classes that an element of a declared class may have."""
    return [
        kind
        for kind in declared.ePackage.eClassifiers
        if isinstance(kind, EClass) and not kind.abstract and conforms(kind, declared)
    ]


def _grow(models: Models, parent: etree._Element, feature: Any, kind: Any) -> None:
    """Add an element with all that its class requires and some of the rest."""
    element = etree.SubElement(parent, feature.name)
    if kind is not reference_type(feature):
        element.set(_TYPE, f"{kind.ePackage.nsPrefix}:{kind.name}")
    part = Part(element, kind, feature)
    for wanted in features(kind):
        if wanted.lowerBound > 0 or models.rng.random() < 0.2:
            _fill(models, part, wanted)


def _fill(models: Models, part: Part, feature: Any) -> None:
    if is_contained(feature):
        for _ in range(max(1, feature.lowerBound)):
            kinds = _kinds(reference_type(feature))
            _grow(models, part.element, feature, models.rng.choice(kinds))
    elif is_reference(feature):
        ids = models.ids(reference_type(feature))
        n_targets = models.rng.randint(1, len(ids)) if feature.many and ids else min(1, len(ids))
        _link(part, feature, models.rng.sample(ids, n_targets))
    else:
        part.element.set(feature.name, _value(models, feature))


def _value(models: Models, feature: Any) -> str:
    if isinstance(feature.eType, EEnum):
        return str(models.rng.choice(list(feature.eType.eLiterals)).name)
    if feature.name == "ID":
        return f"new{models.rng.randrange(10**6)}"
    known = [part.element.get(feature.name) for part in models.having(feature)]
    given = [value for value in known if value is not None]
    return models.rng.choice(given) if given else "1"


def _is_given(element: etree._Element, feature: Any) -> bool:
    return feature.name in element.attrib or element.find(feature.name) is not None


def _root_class(root: etree._Element) -> Any:
    name = etree.QName(root)
    packages = {package.nsURI: package for package in load_metamodels().packages}
    return packages[name.namespace].getEClassifier(name.localname)


def _parts(element: etree._Element, metaclass: Any, feature: Any) -> Iterator[Part]:
    yield Part(element, metaclass, feature)
    contained = {known.name: known for known in features(metaclass) if is_contained(known)}
    for child in element:
        known = contained.get(child.tag)
        if known is not None:
            yield from _parts(child, _class_of(child, reference_type(known)), known)


def _class_of(element: etree._Element, declared: Any) -> Any:
    kind = re.sub(r"^.*:", "", element.get(_TYPE, ""))
    return declared.ePackage.getEClassifier(kind) if kind else declared
