"""Models as entries to compare: elements with ID, and all else as values of theirs."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias
from urllib.parse import unquote

from m2t.check.split_models import find_part
from m2t.diagnostics import shown
from m2t.metamodels import (
    conforms,
    features,
    is_contained,
    is_reference,
    lineage,
    load_metamodels,
    reference_type,
)
from m2t.read.model_files import XMI, XSI, ModelFiles, local_path
from m2t.read.nodes import Node, Report, read_document
from m2t.write.xmi import java_double
from mrsfi_runtime.errors import ModelError

Value: TypeAlias = str | None
"""Value of a feature as text; ``None`` if it is not set."""

_FILES = ("mission.xmi", "faults.xmi")
_WORDS: Mapping[str, str] = MappingProxyType(
    {"MotionSource": "motion source", "FaultSpecification": "fault specification"}
)


@dataclass(slots=True, eq=False)
class Entry:
    """An element with ID, or the root of a model.

    Attributes
    ----------
    kind
        Name of its class.
    identity
        Its ID; empty without one.
    key
        What makes it the same in two models: class, ID, and number among those of that ID.
    about
        What a reader wants to know of an element that is new.
    container
        Element that contains it.
    values
        Values by feature, in the order of the metamodel.
    children
        Contained elements with ID by feature.
    """

    kind: str
    identity: str
    key: tuple[str, str, int]
    container: "Entry | None" = field(default=None, repr=False)
    about: str = ""
    values: dict[str, Value] = field(default_factory=dict)
    children: dict[str, list["Entry"]] = field(default_factory=dict, repr=False)

    @property
    def label(self) -> str:
        """Class and ID in words: ``motion source ms1``."""
        return f"{_WORDS.get(self.kind, self.kind.lower())} {self.identity}".rstrip()

    def walk(self) -> Iterator["Entry"]:
        """Yield the entry and all below it, in the order of the model."""
        yield self
        for children in self.children.values():
            for child in children:
                yield from child.walk()


def read_models(path: Path) -> dict[str, Entry]:
    """Read the models of a mission folder or of a file.

    Parameters
    ----------
    path
        Mission folder, or file that holds a mission, a fault specification or both.

    Returns
    -------
    dict
        Entry of each root by name of its class.

    Raises
    ------
    ModelError
        If a file cannot be read or is no model.
    """
    names = [path / name for name in _FILES if (path / name).is_file()]
    paths = names if path.is_dir() else [path]
    if not paths:
        message = f"{path}: holds neither {' nor '.join(_FILES)}; expected a mission folder"
        raise ModelError(message)
    files = ModelFiles(Report())
    roots = [root for each in paths for root in _roots(each, files)]
    for root in roots:
        _insert_parts(root, _root_class(root), files)
    targets = _Targets(files, roots)
    return {root.tag: _Entries(targets).root(root) for root in roots}


def _roots(path: Path, files: ModelFiles) -> list[Node]:
    """Return the missions and fault specifications of a file."""
    report = Report()
    document = read_document(path, report)
    errors = [str(found) for found in report if found.severity == "error"]
    file = files.read(path)
    if document is None or file is None or errors:
        raise ModelError("\n".join(errors))
    roots = [root for root in file.roots if _root_class(root) is not None]
    if not roots:
        message = (
            f"{path}:{document.line}: the root is {shown(document.tag)} of namespace "
            f"{shown(document.namespace)}; expected a mission or a fault specification of mrsfi; "
            "give the right file [RootElement]"
        )
        raise ModelError(message)
    return roots


def _root_class(root: Node) -> Any:
    packages = load_metamodels()
    for package, name in ((packages.mission, "Mission"), (packages.faults, "FaultSpecification")):
        if (root.namespace, root.tag) == (package.nsURI, name):
            return package.getEClassifier(name)
    return None


def _insert_parts(node: Node, metaclass: Any, files: ModelFiles) -> None:
    """Put the roots of other files in the places that they stand for; keep those not found."""
    contained = {feature.name: feature for feature in features(metaclass) if is_contained(feature)}
    for position, child in enumerate(node.children):
        feature = contained.get(child.tag)
        if feature is None:
            continue
        inserted, kind = child, reference_type(feature)
        if "href" in child.attributes:
            part = find_part(child, kind, metaclass.ePackage, files, Report())
            if part is None:
                continue
            inserted, kind = part
            inserted.tag, inserted.parent = child.tag, node
            inserted.qualified[XSI, "type"] = kind.name
            node.children[position] = inserted
        _insert_parts(inserted, kind, files)


class _Targets:
    """Names what references lead to, by ID wherever there is one."""

    def __init__(self, files: ModelFiles, roots: Sequence[Node]) -> None:
        self._files = files
        self._by_xmi_id: dict[str, Node] = {}
        for node in (node for root in roots for node in _nodes(root)):
            identity = node.qualified.get((XMI, "id"))
            if identity is not None:
                self._by_xmi_id.setdefault(identity, node)

    def name(self, node: Node, text: str) -> str:
        """Return the ID of what a reference of a node means, else the reference itself."""
        document, _, fragment = text.rpartition("#")
        fragment = unquote(fragment)
        target = self._by_xmi_id.get(fragment)
        if target is None and fragment.startswith("/"):
            target = self._by_path(node, document, fragment)
        return fragment if target is None else target.attributes.get("ID", fragment)

    def _by_path(self, node: Node, document: str, fragment: str) -> Node | None:
        """Follow a path such as ``//@goals.0/@messages.1``."""
        path = local_path(node.path.parent, document) if document else node.path
        file = None if path is None else self._files.at(path)
        _, root, *steps = fragment.split("/")
        found = None if file is None else file.root_at(root)
        for step in filter(None, steps):
            found = None if found is None else _child(found, step.removeprefix("@"))
        return found


def _child(node: Node, step: str) -> Node | None:
    name, _, index = step.partition(".")
    children = [child for child in node.children if child.tag == name]
    position = int(index) if index.isdecimal() and len(index) < 10 else 0
    return children[position] if position < len(children) else None


class _Entries:
    """Makes the entries of one model."""

    def __init__(self, targets: _Targets) -> None:
        self._targets = targets
        self._counts: Counter[tuple[str, str]] = Counter()

    def root(self, node: Node) -> Entry:
        """Return the entry of a root; there is one of a kind, whatever its ID."""
        metaclass = _root_class(node)
        identity = _plain(node.attributes.get("ID", ""))
        entry = Entry(metaclass.name, identity, (metaclass.name, "", 0))
        if metaclass.name != "Mission":
            entry.values["ID"] = entry.identity or None
        self._fill(entry, node, metaclass, "")
        return entry

    def _entry(self, node: Node, metaclass: Any, container: Entry) -> Entry:
        identity = node.attributes.get("ID", "")
        place = (metaclass.name, identity)
        key = (*place, self._counts[place])
        self._counts[place] += 1
        entry = Entry(metaclass.name, _plain(identity), key, container)
        kind = node.qualified.get((XSI, "type"), "").rpartition(":")[2]
        if kind not in {"", metaclass.name}:
            entry.values["class"] = _plain(kind)
        self._fill(entry, node, metaclass, "")
        entry.about = _about(entry)
        return entry

    def _fill(self, entry: Entry, node: Node, metaclass: Any, prefix: str) -> None:
        """Add the features of a node; those that are not known are added as they stand."""
        known = {feature.name: feature for feature in features(metaclass)}
        for name, feature in known.items():
            if getattr(feature, "iD", False):
                continue
            if is_contained(feature):
                self._contain(entry, node, feature, prefix)
            else:
                entry.values[prefix + name] = self._value(node, feature)
        for name, text in node.attributes.items():
            if name not in known:
                entry.values[prefix + name] = repr(text)
        for name in dict.fromkeys(child.tag for child in node.children if child.tag not in known):
            found = [child for child in node.children if child.tag == name]
            entry.values[prefix + name] = " ".join(map(_raw, found))

    def _contain(self, entry: Entry, node: Node, feature: Any, prefix: str) -> None:
        name, declared = feature.name, reference_type(feature)
        children = [child for child in node.children if child.tag == name]
        if declared.name == "GoalTask":
            self._task(entry, feature, children)
        elif any(kind.name == "FaultType" for kind in lineage(declared)):
            self._fault_type(entry, feature, children)
        elif _has_id(declared):
            entry.children[prefix + name] = [
                self._entry(child, declared, entry) for child in children
            ]
        else:
            given: Sequence[Node | None] = children or ([] if feature.many else [None])
            texts = [_compact(child, declared) for child in given]
            entry.values[prefix + name] = " ".join(texts) or None

    def _task(self, entry: Entry, feature: Any, children: list[Node]) -> None:
        declared = reference_type(feature)
        for child in children:
            kind = child.qualified.get((XSI, "type"), "").rpartition(":")[2]
            found = declared.ePackage.getEClassifier(kind)
            is_class = hasattr(found, "eStructuralFeatures") and conforms(found, declared)
            _append(entry, "task", _plain(kind))
            self._fill(entry, child, found if is_class else declared, "task.")

    def _fault_type(self, entry: Entry, feature: Any, children: list[Node]) -> None:
        for child in children:
            metaclass = reference_type(feature)
            _append(entry, "type", metaclass.name)
            self._fill(entry, child, metaclass, "")

    def _value(self, node: Node, feature: Any) -> Value:
        name = feature.name
        children = [child for child in node.children if child.tag == name]
        if is_reference(feature):
            texts = node.attributes.get(name, "").split()
            texts += [child.attributes.get("href", child.text.strip()) for child in children]
            return " ".join(_plain(self._targets.name(node, text)) for text in texts) or None
        if feature.many:
            texts = [text for text in (node.attributes.get(name),) if text is not None]
            texts += [child.text for child in children]
            return " ".join(str(_literal(feature, text)) for text in texts) or None
        text = node.attributes.get(name, children[0].text if children else None)
        return _literal(feature, text)


def _about(entry: Entry) -> str:
    for name in ("task", "type", "name"):
        value = entry.values.get(name)
        if value is not None:
            return value
    return ""


def _append(entry: Entry, name: str, text: str) -> None:
    """Add what a valid model has once; one that has it twice shows both."""
    entry.values[name] = " ".join(filter(None, (entry.values.get(name), text)))


def _has_id(metaclass: Any) -> bool:
    return any(getattr(feature, "iD", False) for feature in features(metaclass))


def _literal(feature: Any, text: str | None) -> Value:
    """Return the value of an attribute in one spelling; numbers as Java writes them."""
    kind = feature.eType.name
    if text is None:
        default = None if feature.unsettable else feature.get_default_value()
        return None if default is None else _literal(feature, str(default))
    if kind == "EString":
        return repr(text)
    try:
        if kind == "EDouble":
            return java_double(float(text))
        if kind == "EInt":
            return str(int(text))
    except (ValueError, ArithmeticError):
        return repr(text)
    return _plain(text)


def _compact(node: Node | None, metaclass: Any) -> str:
    """Return an element without ID on one line: coordinates, a message field, a property."""
    texts = []
    for feature in features(metaclass):
        text = None if node is None else node.attributes.get(feature.name)
        texts.append(_literal(feature, text) or "none")
    if node is not None:
        texts.extend(_strange(node, metaclass))
    if metaclass.name == "Coordinates":
        return f"({', '.join(texts)})"
    if metaclass.name == "MessageData":
        return ":".join(text.strip("'") for text in texts)
    return "=".join(texts)


def _strange(node: Node, metaclass: Any) -> Iterator[str]:
    """Yield what the metamodel does not know of an element."""
    known = {feature.name for feature in features(metaclass)}
    for name, text in node.attributes.items():
        if name not in known:
            yield f"{name}={text!r}"
    yield from map(_raw, node.children)


def _plain(text: str) -> str:
    """Return a name as it is, or quoted if it would be hard to read or to tell from others."""
    return text if text.isprintable() and " " not in text else repr(text)


def _raw(node: Node) -> str:
    """Return an element that the metamodel does not know, as it stands."""
    attributes = "".join(f" {name}={text!r}" for name, text in node.attributes.items())
    return f"<{node.tag}{attributes}>{''.join(map(_raw, node.children))}"


def _nodes(node: Node) -> Iterator[Node]:
    yield node
    for child in node.children:
        yield from _nodes(child)
