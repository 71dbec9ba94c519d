"""Outlines of models, to compare: elements with ID, and all else as values of theirs."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import unquote

from m2t.check.structure import check_structure
from m2t.diagnostics import Report, shown
from m2t.metaclasses import Slot, concrete_classes, is_kind, slots
from m2t.metamodels import load_metamodels
from m2t.read.model_files import ModelFile, ModelFiles, local_path
from m2t.read.nodes import Node
from m2t.write.xmi import java_double
from mrsfi_runtime.errors import ModelError

Value: TypeAlias = str | None
"""Value of a feature as text; ``None`` if it is not set."""

Key: TypeAlias = tuple[str, str, int]
"""What makes an element the same in two models: class, ID, and number among those of that ID."""

_FILES = ("mission.xmi", "faults.xmi")
_WORDS = {"MotionSource": "motion source", "FaultSpecification": "fault specification"}


@dataclass(slots=True, eq=False)
class Outline:
    """An element with ID, or the root of a model, whose ID is empty.

    ``key`` makes it the same in two models. ``values`` are by feature, in the order of the
    metamodel, ``children`` the contained elements with ID by feature.
    """

    kind: str
    identity: str
    key: Key
    container: "Outline | None" = field(default=None, repr=False)
    values: dict[str, Value] = field(default_factory=dict)
    children: dict[str, list["Outline"]] = field(default_factory=dict, repr=False)

    @property
    def label(self) -> str:
        """Class and ID in words: ``motion source ms1``."""
        return f"{word(self.kind)} {self.identity}".rstrip()

    @property
    def about(self) -> str:
        """What a reader wants to know of an element that is new."""
        return next(filter(None, map(self.values.get, ("task", "type", "name"))), "")

    @property
    def below(self) -> Iterator["Outline"]:
        """The outlines directly below, in the order of the model."""
        return chain.from_iterable(self.children.values())

    def walk(self) -> Iterator["Outline"]:
        """Yield the outline and all below it, in the order of the model."""
        yield self
        for child in self.below:
            yield from child.walk()


def word(kind: str) -> str:
    """Return the name of a class as people write it: ``motion source``."""
    return _WORDS.get(kind, kind.lower())


def read_models(path: Path) -> dict[str, Outline]:
    """Return the outline of each root of a mission folder or file by name of its class.

    A file that cannot be read or is no model is a ``ModelError``.
    """
    names = [path / name for name in _FILES if (path / name).is_file()]
    paths = names if path.is_dir() else [path]
    if not paths:
        raise ModelError(f"{path}: holds neither {' nor '.join(_FILES)}; expected a mission folder")
    report = Report()
    files = ModelFiles(report)
    roots: list[Node] = []
    for each in paths:
        file = files.read(each)
        if file is None or not file.roots:
            report.require_no_errors()
        else:
            roots.extend(_roots(file, files))
    return {root.metaclass.name: _Outliner(files).outline(root, root.metaclass) for root in roots}


def _roots(file: ModelFile, files: ModelFiles) -> list[Node]:
    """Return the mission and the fault specification of a file, with all their parts in place."""
    known = load_metamodels()
    kinds = [kind for kind in (known.mission_class, known.faults_class) if file.roots_of(kind)]
    if not kinds:
        root = file.roots[0]
        raise ModelError(
            f"{file.path}:{root.line}: the root is {shown(root.tag)} of namespace "
            f"{shown(root.namespace)}; expected a mission or a fault specification of mrsfi; "
            "give the right file [RootElement]"
        )
    trees = [check_structure(file, kind, files, Report()) for kind in kinds]
    return [tree.root for tree in trees if tree is not None]


class _Outliner:
    """Makes the outlines of models; names what references lead to by ID wherever there is one."""

    def __init__(self, files: ModelFiles) -> None:
        self._files = files
        self._counts: Counter[tuple[str, str]] = Counter()

    def outline(self, node: Node, metaclass: Any, container: Outline | None = None) -> Outline:
        """Return the outline of an element; there is one root of a kind, whatever its ID."""
        identity = node.attributes.get("ID", "")
        place = (metaclass.name, "" if container is None else identity)
        key = (*place, self._counts[place])
        self._counts[place] += 1
        outline = Outline(metaclass.name, _plain(identity), key, container)
        kind = _kind(node)
        if container is None and kind != "Mission":
            outline.values["ID"] = outline.identity or None
        elif kind not in {"", metaclass.name}:
            outline.values["class"] = _plain(kind)
        self._fill(outline, node, metaclass, "")
        return outline

    def _fill(self, outline: Outline, node: Node, metaclass: Any, prefix: str) -> None:
        """Add the features of a node; those that are not known are added as they stand."""
        known = slots(metaclass)
        for name, slot in known.items():
            if slot.is_contained:
                self._contain(outline, node.tagged(name), slot, prefix)
            elif not slot.is_id:
                outline.values[prefix + name] = self._value(node, slot)
        for name, text in node.attributes.items():
            if name not in known:
                outline.values[prefix + name] = repr(text)
        for name in dict.fromkeys(child.tag for child in node.children if child.tag not in known):
            outline.values[prefix + name] = " ".join(map(_raw, node.tagged(name)))

    def _contain(self, outline: Outline, children: list[Node], slot: Slot, prefix: str) -> None:
        declared = slot.type
        if declared.name == "GoalTask":
            for child in children:
                kind = _kind(child)
                known = concrete_classes(declared.ePackage, declared)
                _append(outline, "task", _plain(kind))
                self._fill(outline, child, known.get(kind, declared), "task.")
        elif is_kind(declared, "FaultType"):
            for child in children:
                _append(outline, "type", declared.name)
                self._fill(outline, child, declared, "")
        elif any(known.is_id for known in slots(declared).values()):
            outline.children[prefix + slot.name] = [
                self.outline(child, declared, outline) for child in children
            ]
        else:
            given: Sequence[Node | None] = children or ([] if slot.many else [None])
            texts = [_compact(child, declared) for child in given]
            outline.values[prefix + slot.name] = " ".join(texts) or None

    def _value(self, node: Node, slot: Slot) -> Value:
        children = node.tagged(slot.name)
        given = node.attributes.get(slot.name)
        if slot.is_reference:
            texts = (given or "").split()
            texts += [child.attributes.get("href", child.text.strip()) for child in children]
            return " ".join(_plain(self._target(node, text)) for text in texts) or None
        texts = [] if given is None else [given]
        texts += [child.text for child in children]
        if slot.many:
            return " ".join(str(_literal(slot, text)) for text in texts) or None
        return _literal(slot, texts[0] if texts else None)

    def _target(self, node: Node, text: str) -> str:
        """Return the ID of what a reference of a node means, else the reference itself."""
        address, _, fragment = text.rpartition("#")
        fragment = unquote(fragment)
        path = local_path(node.path.parent, address) if address else node.path
        file = None if path is None else self._files.at(path)
        found = None if file is None else file.find(fragment)
        return fragment if found is None else found.attributes.get("ID", fragment)


def _kind(node: Node) -> str:
    if node.metaclass is not None:
        return str(node.metaclass.name)
    return (node.xsi_type or "").rpartition(":")[2]


def _append(outline: Outline, name: str, text: str) -> None:
    """Add what a valid model has once; one that has it twice shows both."""
    outline.values[name] = " ".join(filter(None, (outline.values.get(name), text)))


def _literal(slot: Slot, text: str | None) -> Value:
    """Return the value of an attribute in one spelling; numbers as Java writes them."""
    kind = slot.type.name
    if text is None:
        default = None if slot.feature.unsettable else slot.feature.get_default_value()
        return None if default is None else _literal(slot, str(default))
    if kind == "EString":
        return repr(text)
    try:
        if kind == "EDouble":
            return java_double(float(text))
        if kind == "EInt":
            return str(int(text))
    except (ValueError, ArithmeticError):
        return repr(text)
    return _plain(text.lower() if kind == "EBoolean" else text)


def _compact(node: Node | None, metaclass: Any) -> str:
    """Return an element without ID on one line: coordinates, a message field, a property."""
    known = slots(metaclass)
    given = {} if node is None else node.attributes
    texts = [_literal(slot, given.get(name)) or "none" for name, slot in known.items()]
    texts += [f"{name}={text!r}" for name, text in given.items() if name not in known]
    texts += [] if node is None else map(_raw, node.children)
    if metaclass.name == "Coordinates":
        return f"({', '.join(texts)})"
    if metaclass.name == "MessageData":
        return ":".join(text.strip("'") for text in texts)
    return "=".join(texts)


def _plain(text: str) -> str:
    """Return a name as it is, or quoted if it would be hard to read or to tell from others."""
    return text if text.isprintable() and " " not in text else repr(text)


def _raw(node: Node) -> str:
    attributes = "".join(f" {name}={text!r}" for name, text in node.attributes.items())
    return f"<{node.tag}{attributes}>{''.join(map(_raw, node.children))}"
