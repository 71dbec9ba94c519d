"""Import a model that was published for the paper's prototype as a mission folder.

The file is XMI; its root ``Setup`` contains a mission and fault specifications. Most features have
the same names as in mrsfi. Tables list the names that differ, and values for features that the old
format lacks. Unknown content is dropped with a note. All else keeps its text and its references,
and ``m2t.models.check`` checks it by the same rules as ``mrsfi validate``.

``import_published``, at the end, has the steps in order; begin there. ``PublishedReader`` converts
the nodes of the file to nodes of our metamodels, and ``give_ids`` names their elements. The folder
also gets campaign files for the paper's two cases.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from m2t.metaclasses import BOUNDS, Slot, concrete_classes, identifier, slots, snake_case
from m2t.metamodels import load_metamodels
from m2t.models.check import DOUBLE, MAX_NAME_LENGTH, ModelTree, Reference, check_structure, resolve
from m2t.models.constraints import check_faults, check_mission
from m2t.models.load import FAULTS_XMI, Objects
from m2t.models.write import dumps
from m2t.read import (
    XMI,
    XSI,
    ModelFile,
    ModelFiles,
    Node,
    Report,
    Spelling,
    follow,
    read_root,
    shown,
)
from mrsfi_runtime.errors import ModelError, UsageError
from mrsfi_runtime.files import changing, whole_folder
from mrsfi_runtime.project_file import MISSION_XMI

Kind: TypeAlias = Literal["renamed", "dropped", "default", "inconsistent"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""ID given or changed; content dropped; value filled in; contradiction in the model."""


@dataclass(frozen=True, slots=True)
class Note:
    """A remark on an imported model for the user; ``line`` is a line of the published file.

    ``element`` is like ``robots 'r1'``, ``feature`` an attribute of it, a child, or ``ID``;
    ``message`` gives the finding and the change that the import made.
    """

    kind: Kind
    line: int
    element: str
    feature: str
    message: str


class Notes(list[Note]):
    """The notes of one import; its report gives the places of objects."""

    def __init__(self, report: Report) -> None:
        super().__init__()
        self._report = report

    def add(self, kind: Kind, element: Any, feature: str, message: str) -> None:
        """Add a note about an object or a node of the published file."""
        place = self._report.place(element)
        self.append(Note(kind, place.line, place.description, feature, message))


def give_ids(root: Node, notes: Notes) -> None:
    """Set the ID of every element below the root of a model whose nodes know their classes.

    IDs are unique, also as names in Python; ``notes`` receive every new or changed ID. An element
    keeps a usable ID; of several with the same ID, the first does. A fault without ID takes its
    name. Other elements get an ID from their place, such as ``g1_area`` or ``r1_sensor_2``.
    """
    identified = [node for node in root.walk() if _has(node, "ID")]
    namer = _Namer(notes)
    for node in [node for node in identified if not namer.keeps_own(node)]:
        namer.derive(node)
    for node in identified:
        if _has(node, "name") and not node.attributes.get("name"):
            node.attributes["name"] = node.attributes["ID"]
            notes.add("default", node, "name", "is absent; set to the ID")


class _Namer:
    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._taken: set[str] = set()
        self._kept: set[str] = set()
        self._numbers: dict[str, count[int]] = defaultdict(lambda: count(2))

    def keeps_own(self, node: Node) -> bool:
        own = _own(node)
        is_usable = own is not None and re.fullmatch(r"[A-Za-z][A-Za-z0-9_.-]{0,99}", own)
        if own is None or not is_usable or not self._take(own):
            return False
        self._kept.add(own)
        if "ID" not in node.attributes:
            self._notes.add("renamed", node, "ID", "has no ID; its ID is now its name")
        node.attributes["ID"] = own
        return True

    def derive(self, node: Node) -> None:
        own = _own(node)
        legal = re.sub(r"[^A-Za-z0-9_.-]+", "_", own or "").strip("_.-")[:80]
        if legal and not legal[0].isalpha():
            legal = f"{snake_case(node.metaclass.name)}_{legal}"
        base = new = legal or _place(node)
        while not self._take(new):
            new = f"{base}_{next(self._numbers[base])}"
        node.attributes["ID"] = new
        if own is None:
            self._notes.add("renamed", node, "ID", f"has no ID; is now {new}")
            return
        self._notes.add("renamed", node, "ID", f"{shown(own)} is now {new}")
        if own in self._kept:
            message = f"{shown(own)} is the ID of more than one element; the first keeps it"
            self._notes.add("inconsistent", node, "ID", message)

    def _take(self, identity: str) -> bool:
        n_taken = len(self._taken)
        with suppress(ModelError):
            self._taken.add(identifier(identity))
        return len(self._taken) > n_taken


def _own(node: Node) -> str | None:
    """Return the ID of an element in the file; that of a fault without one is its name."""
    name = node.attributes.get("name") if node.metaclass.name == "Fault" else None
    return node.attributes.get("ID", name)


def _place(node: Node) -> str:
    """Return a name for an element from its place, such as ``g1_area`` or ``robot_1``."""
    container, kind = node.parent, snake_case(node.metaclass.name)
    if container is None:
        return kind
    is_many = slots(container.metaclass)[node.tag].many
    position = container.tagged(node.tag).index(node) + 1
    word = f"{kind}_{position}" if is_many else snake_case(node.tag)
    if container.parent is None:
        return word
    return f"{container.attributes['ID'] if _has(container, 'ID') else _place(container)}_{word}"


def _has(node: Node, name: str) -> bool:
    return node.metaclass is not None and name in slots(node.metaclass)


SETUP_NAMESPACE = "acs_project_setup"
NAMESPACES = frozenset({"", SETUP_NAMESPACE, "acs_project_mission", "acs_project_fault"})
ROOT = "Setup"

RENAMED: Mapping[str, Mapping[str, str]] = {
    "Message": {"from": "sender", "to": "receiver"},
    "Fault": {"probability": "likelihood"},
}
"""Old names of features with the new ones, by class."""

WRAPPED: Mapping[str, Mapping[str, str]] = {
    "Goal": {"members": "goalMembers", "dependentGoals": "dependencies", "area": "goalArea"}
}
"""Features that the old format nests one level deeper, by class, with their old name."""

OPTIONAL = frozenset(
    {"header", "name", "distanceUnit", "timeUnit", "energyUnit"}
    | {"integrityLevel", "rationale", "reference"}
)
"""Texts that stay unset if the file does not give them; optional unsettable numbers do as well."""

USUAL: Mapping[str, str] = {"EDouble": "0.0", "EInt": "0", "EString": ""}
"""Value of any other absent attribute, by its type."""

DEFAULTS: Mapping[tuple[str, str], Callable[[int], str]] = {
    ("Patrol", "period"): lambda duration: str(max(1, duration // 10)),
    ("Visit", "deadline"): lambda duration: str(max(1, duration - 1)),
    ("Visit", "tolerance"): lambda _: "1.0",
    ("Track", "tolerance"): lambda _: "10.0",
    ("FixedDistanceBetweenRobots", "tolerance"): lambda _: "1.0",
    ("Sensor", "type"): lambda _: "GPS_POSITION",
}
"""Values of attributes that the old format lacks or leaves out, given the mission's duration.

Patrol: a tenth of the mission. Visit: the last tick of the mission, and the radius of a robot.
Track: ten distance units. FixedDistanceBetweenRobots: one unit. A sensor without type has the first
literal, and any other absent number is 0, both as in Eclipse.
"""


_COPIED = ("Area", "Coordinates")
"""Classes whose elements are copied where the old format refers to one."""


class _Given:
    """Content of an element in the file; converted parts are removed, and the rest is dropped."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.attributes = dict(node.attributes)
        self.children: dict[str, list[Node]] = {}
        for child in node.children:
            name = child.tag if child.namespace in NAMESPACES else f"{child.namespace} {child.tag}"
            self.children.setdefault(name, []).append(child)

    def take_children(self, name: str) -> list[Node]:
        return self.children.pop(name, [])

    def rename(self, old: str, new: str) -> None:
        """Rename a feature; if both names are given, it gets two values."""
        again = self.take_children(old)
        if old in self.attributes:
            text = self.attributes.pop(old)
            if self.attributes.setdefault(new, text) is not text:
                again.append(_made(self.node, new, None, text=text))
        if again:
            self.children.setdefault(new, []).extend(again)

    def unwrap(self, name: str, inner: str) -> Iterator["_Given"]:
        """Move the content of wrappers up; yield each wrapper with its remaining content."""
        lifted: list[Node] = []
        for node in self.take_children(name):
            wrapper = _Given(node)
            if inner in wrapper.attributes:
                texts = (self.attributes.get(name, ""), wrapper.attributes.pop(inner))
                self.attributes[name] = " ".join(texts).strip()
            elif inner not in wrapper.children and (
                wrapper.attributes or wrapper.children or node.text.strip()
            ):
                lifted.append(node)
                continue
            lifted.extend(wrapper.take_children(inner))
            yield wrapper
        if lifted:
            self.children[name] = lifted


@dataclass(slots=True, eq=False)
class PublishedFile(ModelFile):
    """A model of a published file, checked as a separate file; ``seek`` resolves references."""

    seek: Callable[[str], Node | None] = field(kw_only=True, repr=False)

    def find(self, fragment: str) -> Node | None:
        """Return the node of a fragment anywhere in the published file."""
        return self.seek(fragment)


class PublishedReader:
    """Reads the elements of one published file; ``by_xmi_id`` has those with an xmi:id.

    ``origins`` receives the source node of every new node. Content that cannot be converted is
    noted as it is read.
    """

    def __init__(self, root: Node, origins: dict[Any, Node], report: Report, notes: Notes) -> None:
        self._origins = origins
        self._root = root
        self._report = report
        self._notes = notes
        self._read: dict[Node, Node] = {}
        self._elsewhere: list[Reference] = []
        self._checked_xmi_ids: dict[str, Node] = {}
        self.by_xmi_id: dict[str, Node] = {}
        self._by_id: dict[str, list[Node]] = {}
        for node in root.walk():
            if "ID" in node.attributes:
                self._by_id.setdefault(node.attributes["ID"], []).append(node)
            if node.xmi_id is not None:
                self.by_xmi_id.setdefault(node.xmi_id, node)

    def model(self, node: Node, metaclass: Any) -> Node:
        """Return the root of a model, without referenced areas and coordinates."""
        root = _made(node, metaclass.name, None)
        root.namespace = metaclass.ePackage.nsURI
        return self._element(root, node, metaclass)

    def copy_elsewhere(self, root: Node) -> None:
        """Copy referenced areas and coordinates; report references to other files."""
        tree = ModelTree(root, self._files(root), references=self._elsewhere)
        resolve(tree, None, self._report)
        points_first = sorted(tree.resolved, key=lambda each: each[0].slot.type.name == "Area")
        for reference, targets in points_first:
            if reference.slot.type.name in _COPIED:
                for target in targets:
                    self._copy(target, reference.source, reference.slot.name, reference.node)

    def checked(self, root: Node) -> ModelTree:
        """Check the nodes of a model like those of any other model, and return it."""
        files = self._files(root)
        tree = check_structure(files.containing(root), root.metaclass, files, self._report)
        assert tree is not None  # the root is of that class
        resolve(tree, None, self._report)
        return tree

    def _files(self, root: Node) -> ModelFiles:
        """Return the one file of a model; xmi:ids are unique over all models."""
        ids = self._checked_xmi_ids
        file = PublishedFile(root.path, Spelling("UTF-8"), (root,), by_xmi_id=ids, seek=self._find)
        return ModelFiles(self._report, file)

    def drop_rest(self) -> None:
        """Note the content of the root that is not converted."""
        given = _Given(self._root)
        for name in ("mission", "specification"):
            given.take_children(name)
        self._drop(given, "")

    def _copy(self, target: Node, parent: Node, tag: str, node: Node) -> None:
        made = self._add(parent, node, tag)
        made.metaclass = target.metaclass
        made.attributes = {name: text for name, text in target.attributes.items() if name != "ID"}
        for child in target.children:
            self._copy(child, made, child.tag, node)

    def _add(self, parent: Node, node: Node, tag: str, text: str = "") -> Node:
        """Add a child to a new node, and store its source node."""
        made = _made(node, tag, parent, text=text)
        self._origins[made] = node
        parent.children.append(made)
        return made

    def _element(self, made: Node, node: Node, metaclass: Any) -> Node:
        made.metaclass = metaclass
        made.prefixes = {"": metaclass.ePackage.nsURI}
        if node.xmi_id is not None:
            made.qualified[XMI, "id"] = node.xmi_id
        self._origins[made] = node
        self._read[node] = made
        given = self._given(node, metaclass.name)
        for slot in slots(metaclass).values():
            if slot.name == "task":
                self._tasks(made, slot, given)
            if slot.is_contained:
                self._parts(made, slot, given)
            elif slot.is_reference:
                self._refer(made, slot, given)
            else:
                self._values(made, slot, given)
        self._drop(given, metaclass.name)
        return made

    def _given(self, node: Node, class_name: str) -> _Given:
        """Return what the file says of an element, in features of the names and depth of ours."""
        given = _Given(node)
        for old, new in RENAMED.get(class_name, {}).items():
            given.rename(old, new)
        for name, inner in WRAPPED.get(class_name, {}).items():
            for wrapper in given.unwrap(name, inner):
                self._drop(wrapper, "")
        return given

    def _tasks(self, goal: Node, slot: Slot, given: _Given) -> None:
        """Convert the task, for which the old format has one of nine containments, not a class."""
        known = concrete_classes(slot.type.ePackage, slot.type)
        for node in given.take_children(slot.name):
            wrapper = _Given(node)
            names = {tag: tag[:1].upper() + tag[1:] for tag in wrapper.children}
            for tag in [tag for tag, name in names.items() if name in known]:
                for child in wrapper.take_children(tag):
                    self._part(goal, slot, child, names[tag])
            if len(wrapper.children) < len(names):
                self._drop(wrapper, "")
            else:
                given.children.setdefault(slot.name, []).append(node)

    def _parts(self, made: Node, slot: Slot, given: _Given) -> None:
        is_copied = slot.type.name in _COPIED
        text = given.attributes.pop(slot.name, "")
        if text and is_copied:
            self._elsewhere.append(Reference(made, slot, given.node, tuple(text.split())))
        elif text:
            made.attributes[slot.name] = text
        for child in given.take_children(slot.name):
            href = child.attributes.get("href")
            if href is None:
                self._part(made, slot, child)
                continue
            self._elsewhere.append(Reference(made, slot, child, (href,)))
            if not is_copied:
                self._add(made, child, slot.name).attributes["href"] = href

    def _part(self, made: Node, slot: Slot, child: Node, name: str = "") -> None:
        """Add a contained element of the named class, or else of its xsi:type."""
        part = self._add(made, child, slot.name)
        if name := name or (child.xsi_type or "").rpartition(":")[2]:
            part.qualified[XSI, "type"] = name
        known = concrete_classes(slot.type.ePackage, slot.type)
        self._element(part, child, known.get(name, slot.type))

    def _refer(self, made: Node, slot: Slot, given: _Given) -> None:
        if slot.name in given.attributes:
            made.attributes[slot.name] = given.attributes.pop(slot.name)
        for child in given.take_children(slot.name):
            rest = _Given(child)
            href = rest.attributes.pop("href", None)
            for target in (child.text.split() or [""]) if href is None else [href]:
                self._add(made, child, slot.name).attributes["href"] = target
            self._drop(rest, "")
        if slot.name in made.attributes or made.tagged(slot.name):
            return
        for other in (*given.attributes, *given.children):  # of a fault with another kind of target
            if slot.name.startswith("affected") and other.startswith("affected"):
                finding = f"has {other}, so that the file is of an older metamodel"
                advice = f"expected {slot.name}; correct it"
                self._report.add(made, "KnownFeature", f"{finding}; {advice}")

    def _values(self, made: Node, slot: Slot, given: _Given) -> None:
        """Convert the values of an attribute; a child element may become the attribute."""
        children = given.take_children(slot.name)
        texts = [child.text.strip() for child in children]
        text = given.attributes.pop(slot.name, None)
        if text is None and texts and not slot.many:
            text = texts[0]
            self._drop(_Given(children.pop(0)), "")
        elif text is None and not texts and not slot.is_id:
            text = self._default(made, slot, given.node)
        if text is not None:
            made.attributes[slot.name] = _whole(text) if slot.type.name == "EInt" else text
        for child in children:
            self._add(made, child, slot.name, child.text.strip())
            self._drop(_Given(child), "")

    def _default(self, made: Node, slot: Slot, node: Node) -> str | None:
        """Return and note the value of an absent attribute; ``None`` if it stays unset."""
        is_optional = slot.feature.unsettable and not slot.lower_bound
        if is_optional or slot.name in OPTIONAL or slot.name.endswith(BOUNDS):
            return None
        special = DEFAULTS.get((made.metaclass.name, slot.name))
        if special is not None:  # the mission is read first; 0 if its duration is wrong
            duration = next(iter(self._origins)).attributes.get("duration", "")
            text = special(int(duration) if duration.isdecimal() else 0)
            meaning = "; set to {}"
        elif slot.type.name in USUAL and made.metaclass.name != "MessageData":
            text = USUAL[slot.type.name]
            meaning = ", which means {} in Eclipse" if text else ", which means empty"
        else:
            return None
        self._notes.add("default", node, slot.name, f"is absent{meaning.format(text)}")
        return text

    def _find(self, fragment: str) -> Node | None:
        """Return the new node of a source node: by xmi:id, path, or an ID that only one has."""
        found = self.by_xmi_id.get(fragment)
        if found is None and fragment.startswith("/"):
            found = follow(self._root, fragment.partition("/")[2].partition("/")[2])
        elif found is None:
            named = self._by_id.get(fragment, [])
            found = named[0] if len(named) == 1 else None
        return None if found is None else self._read.get(found)

    def _drop(self, given: _Given, class_name: str) -> None:
        node = given.node
        for name, text in given.attributes.items():
            self._drop_attribute(node, name, text, class_name)
        for (namespace, name), text in node.qualified.items():
            if namespace != XMI and (namespace, name) != (XSI, "type") and node.parent is not None:
                self._notes.add("dropped", node, name, f"is in no metamodel ({shown(text)})")
        for child in [child for kept in given.children.values() for child in kept]:
            is_ours = child.namespace in NAMESPACES
            what = "an unknown element" if is_ours else "an element of another namespace"
            self._notes.add("dropped", child, child.tag, f"is {what}")
        if node.text.strip() and class_name:
            message = f"is text between elements ({shown(node.text.strip())})"
            self._notes.add("dropped", node, "text", message)

    def _drop_attribute(self, node: Node, name: str, text: str, class_name: str) -> None:
        reason, contradiction = f"is an unknown attribute ({shown(text)})", ""
        if name in ("parentID", "goal_ID"):
            reason, holder = "repeats the container's ID", node.parent
            known = () if holder is None else (holder.attributes.get("ID"), holder.xmi_id)
            if holder is not None and any(known) and text not in known:
                contradiction = f"is {shown(text)}, but {holder.description} contains it"
                contradiction += "; kept it there"
        elif name in ("VAL", "CAPACITY") and class_name.startswith("Zero"):
            reason = "is zero by the type of the fault"
            if not re.fullmatch(r"[+-]?(0*\.?0*)", text.strip()):
                contradiction = f"is {shown(text)} in a fault of type {class_name}; read as zero"
        elif name == "ID":
            reason = "nothing refers to the element by ID"
        self._notes.add("dropped", node, name, reason)
        if contradiction:
            self._notes.add("inconsistent", node, name, contradiction)


def _made(node: Node, tag: str, parent: Node | None, text: str = "") -> Node:
    return Node(node.path, node.line, "", tag, parent, node.prefixes, text=text)


def _whole(text: str) -> str:
    """Return a whole number as integers are written: Java writes a double of 1000 as 1000.0."""
    number = float(text) if DOUBLE.fullmatch(text) else 0.5
    return str(int(number)) if number.is_integer() and abs(number) < 2.0**53 else text


_CASE = """\
# Written by `mrsfi import`. {about}

[search]
algorithm = "paper"      # paper | random | drift
population = 20
generations = 50
faults = 20
crossover = 0.7
mutation = 0.7
selection = "roulette"
{fitness}
seed = 1
mission_seed = 1
"""
_CASE_A = {
    "about": "Case study A of the paper (section V-B 1): fitness function (1).",
    "fitness": 'fitness = "weighted"     # equation (1): '
    "0.3 x all violations + 0.7 x distinct violated goals",
}
_ABOUT_B = """\
Case study B of the paper (section V-B 1): fitness function (2)
# on one collision-focused and one energy-focused goal."""
_FITNESS_B = """\
fitness = "focused"      # equation (2): violations of the chosen goals
goals = [{goals}]"""


@dataclass(frozen=True, slots=True)
class Imported:
    """Result of an import.

    ``n_xmi_ids`` elements had an xmi:id. ``counts`` has the number of elements of the result by
    kind, ``notes`` all content that was renamed, dropped, filled in or found inconsistent.
    """

    folder: Path
    files: tuple[str, ...]
    counts: Mapping[str, int]
    n_xmi_ids: int
    notes: tuple[Note, ...]


def import_published(path: Path, folder: Path, *, is_forced: bool = False) -> Imported:
    """Turn a published file, one ``Setup`` with mission and fault specifications, into a folder.

    The first specification becomes ``faults.xmi``, an empty pool if there is none, any other
    ``faults_<ID>.xmi``. ``is_forced`` replaces the models of a mission folder that exists; its
    other files stay. A file that cannot be read or a model that is not valid is a ``ModelError``
    with all errors, one a line, and nothing is written; a folder that must not be replaced or
    cannot be written is a ``UsageError``.
    """
    is_there = folder.exists() or folder.is_symlink()
    if is_there and not is_forced:
        what = f"{folder}: exists already; name another folder with --out, or replace its models"
        raise UsageError(f"{what} with --force")
    if is_there and not (folder / MISSION_XMI).is_file():
        what = f"{folder}: exists but is no mission folder: it contains no {MISSION_XMI}"
        raise UsageError(f"{what}; name another with --out")
    origins: dict[Any, Node] = {}
    report = Report(origins)
    notes = Notes(report)
    setup = read_root(path, report)
    if (setup.namespace, setup.tag) != (SETUP_NAMESPACE, ROOT):
        finding = (
            f"of namespace {shown(setup.namespace)} is the root; expected {ROOT} of namespace "
            f"{SETUP_NAMESPACE}, as in the files published for the paper's prototype; models of "
            "mrsfi need no import"
        )
        report.add(setup, "RootElement", finding)
        report.require_no_errors()
    reader = PublishedReader(setup, origins, report, notes)
    roots = _roots(setup, reader, report)
    if not roots[0].attributes.get("name"):
        roots[0].attributes["name"] = folder.name[:MAX_NAME_LENGTH]
        notes.add("default", roots[0], "name", f"is absent; set to {folder.name}")
    for root in roots:
        give_ids(root, notes)
    trees = [reader.checked(root) for root in roots]
    report.require_no_errors()
    objects = Objects()
    mission, *specifications = map(objects.root, trees)
    origins.update((element, origins[node]) for element, node in objects.nodes.items())
    if not specifications:
        specifications.append(load_metamodels().faults_class(ID="faults"))
        origins[specifications[0]] = setup
        # A pool for the user to fill, so that the mission folder is complete.
        message = f"is absent; {FAULTS_XMI} is an empty pool; a search needs faults in it"
        notes.add("default", setup, "specification", message)
    check_mission(mission, report)
    for pool in specifications:
        check_faults(pool, mission.duration, report)
    report.require_no_errors()
    notes += [
        Note("inconsistent", found.line, found.element, found.constraint, found.message)
        for found in report
    ]
    kinds = ("robots", "servers", "obstacles", "goals")
    counts = {kind: len(getattr(mission, kind)) for kind in kinds}
    counts["messages"] = sum(len(goal.messages) for goal in mission.goals)
    counts["faults"] = sum(len(root.faults) for root in specifications)
    return Imported(
        folder=folder,
        files=_write(mission, specifications, folder),
        n_xmi_ids=len(reader.by_xmi_id),
        counts=counts,
        notes=tuple(sorted(notes, key=lambda note: (KINDS.index(note.kind), note.line))),
    )


def _roots(setup: Node, reader: PublishedReader, report: Report) -> list[Node]:
    missions = setup.tagged("mission")
    if len(missions) != 1:
        finding = f"has {len(missions) or 'no'} mission; expected one; split the file"
        report.add(setup, "RequiredFeature" if not missions else "SingleValue", finding)
        report.require_no_errors()
    known = load_metamodels()
    roots = [reader.model(missions[0], known.mission_class)]
    roots += [reader.model(child, known.faults_class) for child in setup.tagged("specification")]
    reader.drop_rest()
    reader.copy_elsewhere(roots[0])
    report.require_no_errors()
    return roots


def _write(mission: Any, specifications: list[Any], folder: Path) -> tuple[str, ...]:
    """Write all files or none; campaign files only where there are none."""
    contents = {MISSION_XMI: dumps(mission)}
    for number, root in enumerate(specifications, 1):
        name = FAULTS_XMI if number == 1 else f"faults_{root.ID}.xmi"
        if name in contents:
            name = f"faults_{number}_{root.ID}.xmi"
        contents[name] = dumps(root, hrefs={mission: MISSION_XMI})
    cases = _campaign_files(mission)
    contents |= {name: text for name, text in cases.items() if not (folder / name).exists()}
    if folder.exists():
        with changing(folder) as change:
            change.replace({folder / name: content for name, content in contents.items()})
    else:
        with whole_folder(folder) as new:
            for name, content in contents.items():
                (new / name).write_bytes(content)
    return tuple(contents)


def _campaign_files(mission: Any) -> dict[str, bytes]:
    """Return the campaign files of a mission by name: ``case_a.toml``, and maybe ``case_b.toml``.

    Case b takes both a goal that avoids collisions and one about energy; it names the first each.
    """
    files = {"case_a.toml": _CASE.format_map(_CASE_A)}
    firsts = {goal.task.eClass.name: goal.ID for goal in reversed(mission.goals)}
    energy, collisions = map(firsts.get, ("SufficientEnergy", "AvoidCollision"))
    if collisions and energy:
        fitness = _FITNESS_B.format(goals=f'"{collisions}", "{energy}"')  # IDs need no quoting
        files["case_b.toml"] = _CASE.format(about=_ABOUT_B, fitness=fitness)
    return {name: text.encode("ascii") for name, text in files.items()}
