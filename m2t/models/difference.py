"""The difference between two models in terms of model elements, for reviews.

Models are compared element by element: elements with ID by class and ID, wherever they stand;
coordinates, message fields and properties as values; the task of a goal and the type of a fault
feature by feature. An element with a new ID and otherwise equal content was renamed; references to
it do not count as changed. Line breaks, comments, order of attributes, spelling of numbers, and the
way in which a reference names its target are ignored.

``read_models`` makes an outline of each model: its elements with ID, and all else as their values.
``difference`` compares outlines; ``renamed`` finds elements with a new ID.

Notes
-----
The files need not be valid, because a review may concern the defect. They must be well-formed.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, Literal, TypeAlias
from urllib.parse import unquote

from m2t.metaclasses import Slot, concrete_classes, is_kind, slots
from m2t.metamodels import load_metamodels
from m2t.models.check import check_structure
from m2t.models.write import java_double
from m2t.read import ModelFile, ModelFiles, Node, Report, local_path, shown
from mrsfi_runtime.errors import ModelError

Value: TypeAlias = str | None
"""Value of a feature as text; ``None`` if it is not set."""

Key: TypeAlias = tuple[str, str, int]
"""Identity of an element in two models: class, ID, and number among those of that ID."""

_FILES = ("mission.xmi", "faults.xmi")
_WORDS = {"MotionSource": "motion source", "FaultSpecification": "fault specification"}


@dataclass(slots=True, eq=False)
class Outline:
    """An element with ID, or the root of a model, whose ID is empty.

    ``key`` identifies it in both models. ``values`` are by feature, in the order of the metamodel,
    ``children`` are the contained elements with ID, by feature.
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
        """Short description of a new element."""
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
    """Return the name of a class in words: ``motion source``."""
    return _WORDS.get(kind, kind.lower())


def read_models(path: Path) -> dict[str, Outline]:
    """Return the outline of each root of a mission folder or file by name of its class.

    A file that cannot be read or is no model raises a ``ModelError``.
    """
    names = [path / name for name in _FILES if (path / name).is_file()]
    paths = names if path.is_dir() else [path]
    if not paths:
        raise ModelError(f"{path}: has neither {' nor '.join(_FILES)}; expected a mission folder")
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
    """Makes the outlines of models; names targets of references by ID if they have one."""

    def __init__(self, files: ModelFiles) -> None:
        self._files = files
        self._counts: Counter[tuple[str, str]] = Counter()

    def outline(self, node: Node, metaclass: Any, container: Outline | None = None) -> Outline:
        """Return the outline of an element; a root is identified by its class, not its ID."""
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
        self._fill(outline, node, metaclass)
        return outline

    def _fill(self, outline: Outline, node: Node, metaclass: Any, prefix: str = "") -> None:
        """Add the features of a node; unknown ones are added as written."""
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
                self._fill(outline, child, declared)
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
        """Return the ID of a reference's target, or else the reference itself."""
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
    """Add a value that a valid model has once; if there are two, show both."""
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
    """Return a name, quoted if it contains spaces or unprintable characters."""
    return text if text.isprintable() and " " not in text else repr(text)


def _raw(node: Node) -> str:
    attributes = "".join(f" {name}={text!r}" for name, text in node.attributes.items())
    return f"<{node.tag}{attributes}>{''.join(map(_raw, node.children))}"


What: TypeAlias = Literal["changed", "added", "removed", "moved", "renamed", "reordered"]


@dataclass(frozen=True, slots=True)
class Change:
    """One difference; ``text`` describes it in one line.

    ``element`` is class and ID, such as ``robot r2``; if elements of ``feature`` were reordered, it
    is their container. ``feature`` may be empty. ``old`` and ``new`` are values of the feature, the
    containers of a moved element, or IDs in order.
    """

    what: What
    element: str
    feature: str
    old: str
    new: str
    text: str


def difference(old: Path, new: Path) -> tuple[Change, ...]:
    """Return the changes from an older model; both are a mission folder or an ``.xmi`` file.

    A file is compared with the model of its kind, mission or faults, in a folder; without a common
    kind, this raises a ``ModelError``. Changes are in the order of the new model, mission first;
    removed elements come before those that remained in the same place.
    """
    olds, news = read_models(old), read_models(new)
    shared = olds.keys() & news.keys()
    kinds = {*olds, *news} if old.is_dir() and new.is_dir() else shared
    if not kinds:
        found = (
            f"{' and '.join(f'a {kind}' for kind in outlines) or 'no model'} in {path}"
            for outlines, path in ((olds, old), (news, new))
        )
        advice = "expected two models of the same kind; give the right files"
        raise ModelError(f"found {' and '.join(found)}; {advice}")
    ordered = sorted(kinds, key=lambda name: name != "Mission")
    both = [(olds[kind], news[kind]) for kind in ordered if kind in shared]
    pairs = renamed(both)
    before = {now.key: earlier.identity for now, earlier in pairs.items()}
    rename([root for root, _ in both], pairs)
    changes: list[Change] = []
    for kind in ordered:
        if kind in shared:
            comparison = _Comparison(olds[kind], news[kind], before)
            changes.extend(comparison.compare(olds[kind], news[kind]))
        else:
            what: What = "added" if kind in news else "removed"
            root = news.get(kind) or olds[kind]
            text = f"{root.label} {what} ({sum(1 for _ in root.walk()) - 1} elements)"
            changes.append(Change(what, root.label, "", "", "", text))
    return tuple(changes)


class _Comparison:
    """Compares two models of a kind, with the place of each element in both.

    ``before`` are the old IDs of renamed elements.
    """

    def __init__(self, old: Outline, new: Outline, before: Mapping[Key, str]) -> None:
        self._before = before
        self._old = {outline.key: outline for outline in old.walk()}
        self._new = {outline.key: outline for outline in new.walk()}

    def compare(self, old: Outline, new: Outline) -> Iterator[Change]:
        for name in dict.fromkeys((*new.values, *old.values)):
            before, after = old.values.get(name), new.values.get(name)
            if before != after:
                was, now = ("none" if value is None else value for value in (before, after))
                text = f"{new.label}: {name} {was} → {now}"
                yield Change("changed", new.label, name, was, now, text)
        for name in dict.fromkeys((*new.children, *old.children)):
            yield from self._compare_children(name, old, new)

    def _compare_children(self, name: str, old: Outline, new: Outline) -> Iterator[Change]:
        before, after = old.children.get(name, []), new.children.get(name, [])
        for outline in before:
            if outline.key not in self._new:
                yield _placed("removed", outline, "from")
        for outline in after:
            yield from self._compare_element(outline, new)
        stayed = {outline.key for outline in before} & {outline.key for outline in after}
        orders = [[each for each in outlines if each.key in stayed] for outlines in (before, after)]
        if [each.key for each in orders[0]] != [each.key for each in orders[1]]:
            before_ids, after_ids = (
                " ".join([each.identity for each in order][:12]) + " ..." * (len(order) > 12)
                for order in orders
            )
            where = f"{new.label}: " if new.container is not None else ""
            text = f"{where}{name} reordered: {before_ids} → {after_ids}"
            yield Change("reordered", new.label, name, before_ids, after_ids, text)

    def _compare_element(self, outline: Outline, container: Outline) -> Iterator[Change]:
        earlier = self._old.get(outline.key)
        if earlier is None:
            yield _placed("added", outline, "to")
            yield from self._moved_into(outline)
            return
        if (known := self._before.get(outline.key)) is not None:
            text = f"{word(outline.kind)} {known} renamed {outline.identity}"
            yield Change("renamed", outline.label, "ID", known, outline.identity, text)
        source = earlier.container
        are_roots = source is not None and source.container is container.container is None
        if source is not None and source.key != container.key and not are_roots:
            text = f"{outline.label} moved from {source.label} to {container.label}"
            yield Change("moved", outline.label, "", source.label, container.label, text)
        yield from self.compare(earlier, outline)

    def _moved_into(self, added: Outline) -> Iterator[Change]:
        """Yield the changes of existing elements that moved into an added one."""
        for outline in added.below:
            if outline.key in self._old:
                yield from self._compare_element(outline, added)
            else:
                yield from self._moved_into(outline)


def _placed(what: What, outline: Outline, preposition: str) -> Change:
    container = outline.container
    is_inside = container is not None and container.container is not None
    place = container.label if container is not None and is_inside else ""
    where = f" {preposition} {place}" if is_inside else ""
    about = f" ({outline.about})" if outline.about and what == "added" else ""
    old, new = (place, "") if what == "removed" else ("", place)
    return Change(what, outline.label, "", old, new, f"{outline.label} {what}{where}{about}")


def renamed(roots: Sequence[tuple[Outline, Outline]]) -> dict[Outline, Outline]:
    """Return renamed elements of older models, by their new versions.

    A removed and an added element in the same place are one renamed element if their content is
    equal; references to renamed elements count as equal.
    """
    olds, news = [old for old, _ in roots], [new for _, new in roots]
    gone, added = _without(olds, news), _without(news, olds)
    found: dict[Outline, Outline] = {}
    for old, new in roots:
        found |= _within(old, new, gone, added)
    return found


def rename(roots: Iterable[Outline], pairs: Mapping[Outline, Outline]) -> None:
    """Give elements of the older model their new IDs, also in references."""
    names = {old.identity: new.identity for new, old in pairs.items()}
    for new, old in pairs.items():
        old.identity, old.key = new.identity, new.key
    for root in roots:
        for outline in root.walk():
            outline.values = {
                name: value and " ".join(names.get(word, word) for word in value.split(" "))
                for name, value in outline.values.items()
            }


def _without(roots: Sequence[Outline], others: Sequence[Outline]) -> dict[str, Outline]:
    """Return the elements of models whose ID no element of other models has, by ID."""
    known = {outline.identity for other in others for outline in other.walk()}
    every = (outline for root in roots for outline in root.walk())
    return {each.identity: each for each in every if each.identity and each.identity not in known}


def _within(
    old: Outline, new: Outline, gone: Mapping[str, Outline], added: Mapping[str, Outline]
) -> dict[Outline, Outline]:
    """Return the renamed elements below an element that both models have."""
    found: dict[Outline, Outline] = {}
    for name, after in new.children.items():
        before = old.children.get(name, [])
        lost = [each for each in before if gone.get(each.identity) is each]
        for each in after:
            if added.get(each.identity) is not each:
                continue
            sought = _signature(each, added)
            same = next((one for one in lost if _signature(one, gone) == sought), None)
            if same is not None:
                lost.remove(same)
                found[each] = same
    kept = {each.key: each for each in old.below}
    for each in new.below:
        earlier = found.get(each, kept.get(each.key))
        if earlier is not None:
            found |= _within(earlier, each, gone, added)
    return found


def _signature(outline: Outline, own: Mapping[str, Outline]) -> tuple[object, ...]:
    """Return the content of an element without ``own``, the IDs that only its model has."""
    values = tuple(
        (name, None if value is None else _hidden(value, own))
        for name, value in outline.values.items()
    )
    inside = tuple(
        (name, tuple(_signature(child, own) for child in children))
        for name, children in outline.children.items()
    )
    return (outline.kind, _hidden(outline.identity, own), values, inside)


def _hidden(text: str, own: Mapping[str, Outline]) -> str:
    """Return a text without IDs that only one model has, in references or names."""
    return " ".join("•" if word.strip("'") in own else word for word in text.split(" "))
