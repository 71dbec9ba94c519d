"""Load a mission folder with all its checks, and save loaded models.

Objects are built directly from checked nodes. pyecore's reader is not used: it accepts most defects
of a file and fails on others. All defects of all files are collected. Objects are made only of a
file whose structure is sound, apart from references to missing elements.

Begin with ``LoadedModels`` and ``_Loading``. Then come saving (every changed file as Eclipse would
write it), writing a fault specification from a search, and models as objects of the static
classes, for scripts that edit them.

References
----------
Source paper, section III-A, step 6, and section III-B b).
"""

import gc
import os
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import ModuleType
from typing import Any
from urllib.parse import quote

from pyecore.resources import URI, ResourceSet

from m2t.metaclasses import copies, put, slots
from m2t.metamodels import load_metamodels, meaning
from m2t.models.check import (
    ModelTree,
    ReadModel,
    check_claims,
    check_structure,
    referred_files,
    resolve,
)
from m2t.models.constraints import check_faults, check_identities, check_mission, fault_types
from m2t.models.write import dumps, dumps_file, unified_difference
from m2t.read import ModelFiles, Node, Report, Spelling, local_path
from mrsfi_runtime.errors import Diagnostic, ModelError, SpecificationError, expected
from mrsfi_runtime.files import changing, settle, write_atomically
from mrsfi_runtime.model.faults import FaultPool, Specification, numbered, timed_fault
from mrsfi_runtime.project_file import MISSION_XMI, metamodels_chosen

FAULTS_XMI = "faults.xmi"


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """A file of a loaded model, with the spelling that saving keeps.

    ``roots`` are the root objects of the file in its order: of a model, or parts of one.
    """

    path: Path
    spelling: Spelling
    roots: tuple[Any, ...]

    def seen_from(self, folder: Path) -> str:
        """Return the relative path of the file from a folder, with slashes."""
        return Path(os.path.relpath(self.path.resolve(), folder.resolve())).as_posix()


@dataclass(frozen=True, slots=True)
class LoadedModels:
    """Root of a mission model and that of the faults, ``None`` if the folder has none.

    The mission begins in ``mission_path``. ``nodes`` has the XML element, with its line, of every
    object of both; ``files`` are all their files, in the order in which they were read.
    """

    mission: Any
    faults: Any
    mission_path: Path
    nodes: Mapping[Any, Node] = field(repr=False)
    files: tuple[LoadedFile, ...] = field(default=(), repr=False)

    @property
    def xmi_ids(self) -> Mapping[Any, str]:
        """The xmi:id of every object whose element has one."""
        found = ((element, node.xmi_id) for element, node in self.nodes.items())
        return {element: identity for element, identity in found if identity is not None}

    @property
    def pool(self) -> tuple[Any, ...]:
        """All faults in model order; none without a fault model."""
        return () if self.faults is None else tuple(self.faults.faults)


@dataclass(frozen=True, slots=True)
class Inspection:
    """Result of loading: all defects of all files, and the models if they can be made.

    ``draft`` are the models even if they break constraints of sense, so that fixes can edit them;
    ``None`` if the structure of a file is broken. If only references to missing elements break it,
    ``remains`` are the models without these references.
    """

    diagnostics: tuple[Diagnostic, ...]
    draft: LoadedModels | None = field(default=None, repr=False)
    remains: LoadedModels | None = field(default=None, repr=False)

    def require_models(self) -> LoadedModels:
        """Return the models; raise a ``ModelError`` with all errors, if there are any."""
        errors = [found for found in self.diagnostics if found.severity == "error"]
        if errors or self.draft is None:
            raise ModelError("\n".join(map(str, errors)))
        return self.draft


@metamodels_chosen()
def load_mission_folder(folder: Path) -> LoadedModels:
    """Load ``mission.xmi`` and, if it exists, ``faults.xmi`` of a mission folder.

    All errors of both files raise one ``ModelError``, one per line; for warnings, use
    ``inspect_folder``. The metamodels are those of the project that the working folder is in.
    """
    return inspect_folder(folder).require_models()


@metamodels_chosen()
def load_specification(path: Path) -> LoadedModels:
    """Load a fault specification, as ``faults``, and the mission that it refers to.

    All errors of both files, one per line, raise a ``ModelError``. The metamodels are those of the
    project that the working folder is in.
    """
    return inspect_specification(path).require_models()


def inspect_folder(folder: Path) -> Inspection:
    """Load a mission folder and return all findings, mission first.

    Constraints of sense are checked only on a file whose structure is sound: findings about missing
    parts would not help.
    """
    settle(folder)
    faults_path = folder / FAULTS_XMI
    return _Loading().inspect(folder / MISSION_XMI, faults_path if _is_there(faults_path) else None)


def inspect_specification(path: Path) -> Inspection:
    """Load a fault specification and its mission; return all findings."""
    settle(*(place for place in path.resolve().parents if (place / MISSION_XMI).is_file()))
    report = Report()
    files = ModelFiles(report)
    file = files.read(path)
    known = load_metamodels()
    faults = None if file is None else check_structure(file, known.faults_class, files, report)
    if file is None or faults is None:
        return Inspection(tuple(report))
    has_mission = file.roots_of(known.mission_class)
    return _Loading().inspect(path if has_mission else _mission_path(path, faults), path)


def _mission_path(path: Path, faults: ModelTree) -> Path:
    """Return the file of the mission that a specification refers to.

    It is the first other file that a reference names. If that file is a part of a mission, it is
    the nearest ``mission.xmi`` from the part's folder upwards.
    """
    own = {file.path.resolve() for file in faults.files}
    for reference, address in referred_files(faults):
        found = local_path(reference.node.path.parent, address)
        if found is not None and found.resolve() not in own:
            return _whole(found)
    return path.parent / MISSION_XMI


def _whole(path: Path) -> Path:
    """Return the mission file that a file belongs to: itself, unless it is only a part."""
    file = ModelFiles(Report()).read(path)
    if file is None or file.roots_of(load_metamodels().mission_class):
        return path
    places = (folder / MISSION_XMI for folder in path.resolve().parents)
    return next((place for place in places if place.is_file()), path)


def _is_there(path: Path) -> bool:
    """Return whether a file exists; also true if the system refuses to tell."""
    try:
        return path.exists()
    except OSError:
        return True


@contextmanager
def _uncollected() -> Iterator[None]:
    """Disable garbage collection in the body: it is slow, and a large model has no garbage."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


class Objects:
    """Makes objects of checked nodes; ``nodes`` and ``by_node`` map one to the other."""

    def __init__(self) -> None:
        self.nodes: dict[Any, Node] = {}
        self.by_node: dict[Node, Any] = {}
        self._resources = ResourceSet()

    def root(self, tree: ModelTree) -> Any:
        """Return the root object of a sound model; models that it refers to must be made before."""
        uri = URI(f"{tree.root.metaclass.ePackage.nsPrefix}.xmi")
        resource = self._resources.create_resource(uri)
        resource.append(self._built(tree.root, resource.uuid_dict))
        for reference, targets in tree.resolved:
            for target in targets:
                put(self.by_node[reference.source], reference.slot, self.by_node[target])
        return self.by_node[tree.root]

    def _built(self, node: Node, by_id: dict[str, Any]) -> Any:
        built = node.metaclass()
        self.nodes[built] = node
        self.by_node[node] = built
        known = slots(node.metaclass)
        texts = [
            (known[name], each)
            for name, text in node.attributes.items()
            for each in (text.split() if known[name].many else [text])
        ]
        texts += [(known[child.tag], child.text) for child in node.children]
        for slot, text in texts:
            if not slot.holds_elements:
                put(built, slot, slot.type.from_string(text))
            if slot.is_id:
                by_id[text] = built
        for child in node.children:
            if known[child.tag].is_contained:
                put(built, known[child.tag], self._built(child, by_id))
        return built


class _Loading:
    """Reads a mission and its faults: nodes first, objects once the nodes are sound."""

    def __init__(self) -> None:
        self._objects = Objects()
        self._report = Report(self._objects.nodes)
        self._files = ModelFiles(self._report)

    @_uncollected()
    def inspect(self, mission_path: Path, faults_path: Path | None) -> Inspection:
        """Load a mission and its faults, which may stand in the mission's file.

        Constraints of sense are checked on objects, hence only on sound models.
        """
        known = load_metamodels()
        mission = self._load(mission_path, known.mission_class, None)
        if mission.root is not None and mission.is_whole:
            check_mission(mission.root, self._report)
        file = self._files.read(mission_path)
        if faults_path is None and file is not None and file.roots_of(known.faults_class):
            faults_path = mission_path
        faults = None
        if faults_path is not None:
            faults = self._load(faults_path, known.faults_class, mission)
        is_whole = mission.is_whole and (faults is None or faults.is_whole)
        if faults is not None and faults.root is not None and is_whole:
            check_faults(faults.root, mission.root.duration, self._report)
        if not self._report.n_errors:
            check_claims(self._files, self._report)
        made = self._made(mission, faults)
        found = tuple(self._report)
        return Inspection(found, draft=made) if is_whole else Inspection(found, remains=made)

    def _load(self, path: Path, metaclass: Any, mission: ReadModel | None) -> ReadModel:
        """Check the nodes of a model; make its objects if it is sound, and its mission."""
        report = self._report
        n_unsound, n_dangling = report.n_unsound, report.n_dangling
        model = ReadModel(path)
        file = self._files.read(path)
        if file is not None:
            model.tree = check_structure(file, metaclass, self._files, report)
        if model.tree is not None:
            check_identities(model.tree, report, become_names=mission is None)
            resolve(model.tree, mission, report)
            model.is_whole = report.n_dangling == n_dangling
            is_sound = report.n_unsound - n_unsound == report.n_dangling - n_dangling
            if is_sound and (mission is None or mission.root is not None):
                model.root = self._objects.root(model.tree)
        return model

    def _made(self, mission: ReadModel, faults: ReadModel | None) -> LoadedModels | None:
        """Return the models, flawless or not; ``None`` if objects of a file are missing."""
        if mission.root is None or (faults is not None and faults.root is None):
            return None
        by_node = self._objects.by_node
        return LoadedModels(
            mission=mission.root,
            faults=None if faults is None else faults.root,
            mission_path=mission.path,
            nodes=self._objects.nodes,
            files=tuple(
                LoadedFile(each.path, each.spelling, tuple(map(by_node.get, each.roots)))
                for each in self._files
            ),
        )


@dataclass(frozen=True, slots=True)
class Edit:
    """Changes of an edit of loaded models to their files; nothing is written.

    ``contents`` and ``before`` have the changed files, ``difference`` their unified diff. Files in
    ``respelt`` change beyond the edit, because Eclipse would spell them differently. ``folder`` is
    the mission folder.
    """

    folder: Path
    contents: Mapping[Path, bytes]
    before: Mapping[Path, bytes]
    difference: tuple[str, ...]
    respelt: tuple[Path, ...]


def save(models: LoadedModels) -> tuple[Path, ...]:
    """Write loaded models back to their files, all of them or none; return those that changed.

    Unsaveable models raise a ``ModelError``, unwritable files a ``UsageError``.
    """
    contents = saved(models)
    changed = {path: new for path, new in contents.items() if path.read_bytes() != new}
    with changing(models.mission_path.parent) as change:
        change.replace(changed)
    return tuple(changed)


def saved(models: LoadedModels) -> dict[Path, bytes]:
    """Return the content of each file that saving would write, in the order of reading.

    Every file keeps its encoding, its line ends, its xsi:schemaLocation, its roots and the xmi:ids
    of its elements; new elements get none. Comments are dropped, as Eclipse does. A reference to an
    object outside the files, or a character that XML forbids, raises a ``ModelError``.
    """
    xmi_ids = models.xmi_ids
    return {
        file.path: dumps_file(
            file.roots, file.spelling, addresses(models, file.path.parent, without=file), xmi_ids
        )
        for file in models.files
    }


def edited(
    models: LoadedModels,
    edit: Callable[[LoadedModels], object],
    *,
    loaded: Container[Path] = (),
    without: Container[Path] = (),
) -> Edit:
    """Carry out an edit of the objects of models, and return its changes.

    ``loaded`` are files from which loading has already left something out, ``without`` resolved
    paths of files that the caller handles.
    """
    unedited = saved(models)
    before = {path: path.read_bytes() for path in unedited}
    edit(models)
    contents = {
        path: new
        for path, new in saved(models).items()
        if new != before[path]
        and (path in loaded or new != unedited[path])
        and path.resolve() not in without
    }
    respelt = [path for path in contents if path not in loaded and unedited[path] != before[path]]
    lines: list[str] = []
    for file in models.files:
        if (path := file.path) in contents:
            versions = (before[path], contents[path])
            old, new = (each.decode(file.spelling.encoding, "replace") for each in versions)
            named = str(path)
            lines += unified_difference(old.splitlines(), new.splitlines(), named, named, "")
    return Edit(models.mission_path.parent, contents, before, tuple(lines), tuple(respelt))


def addresses(
    models: LoadedModels, folder: Path, *, without: LoadedFile | None = None
) -> Mapping[Any, str]:
    """Return the relative address of every file of loaded models, by its root objects.

    ``folder`` is that of the referring file, which ``without`` leaves out.
    """
    return {
        root: quote(file.seen_from(folder))
        for file in models.files
        if file is not without
        for root in file.roots
    }


@metamodels_chosen()
def write_specification(
    models: Path | LoadedModels,
    pool: FaultPool,
    specification: Specification,
    path: Path,
    *,
    identifier: str,
    names: Sequence[str] | None = None,
    write: Callable[[Path, bytes], object] = write_atomically,
) -> None:
    """Write timed faults of a pool as XMI, in their order, to a file that is replaced as a whole.

    ``models`` is the mission folder, or the models loaded from it, whose ``faults.xmi`` has the
    faults, with values where the pool has no parameter of a name; ``identifier`` is the ID of the
    specification. ``names`` are the IDs of the timed faults, by default those of ``numbered``;
    display names are those of the models. Triggers that faults wait for are copied, and triggers of
    effects refer to the timed faults. A fault that the models lack, or that the gate refuses,
    raises a ``SpecificationError``.
    """
    models = load_mission_folder(models) if isinstance(models, Path) else models
    folder = models.mission_path.parent
    originals = {fault.ID: fault for fault in models.pool}
    root = load_metamodels().faults_class()
    root.ID = identifier
    names = numbered(timed.fault for timed in specification) if names is None else names
    for name, timed in zip(names, specification, strict=True):
        if timed.fault not in originals:
            what = f"fault '{timed.fault}' is not in the pool of {folder}"
            raise SpecificationError(f"{what}; {expected(timed.fault, originals)}")
        original = originals[timed.fault]
        fault = copies([original])[original]
        (kind,) = fault_types(fault)
        means, given = meaning(kind), pool[timed.fault].kind.named(timed.values)
        usual = {known.name: getattr(kind, known.name) for known in means.parameters}
        fitting = timed_fault(timed.fault, means, timed.start, timed.finish, {**usual, **given})
        fault.ID, fault.start, fault.finish = name, fitting.start, fitting.finish
        for known, value in zip(means.parameters, fitting.values, strict=True):
            if known.name in given:
                is_integer = slots(kind.eClass)[known.name].type.name == "EInt"
                setattr(kind, known.name, int(value) if is_integer else value)
        root.faults.append(fault)
    _set_triggers(models, root, specification)
    hrefs = addresses(models, path.parent)
    write(path, dumps(root, hrefs=hrefs, xmi_ids=models.xmi_ids))


def _set_triggers(models: LoadedModels, root: Any, specification: Specification) -> None:
    """Let timed faults wait for copies of the models' triggers, as the specification says."""
    known = {} if models.faults is None else {each.ID: each for each in models.faults.triggers}
    waited = [timed.trigger for timed in specification]
    for trigger in waited:
        if trigger and trigger not in known:
            what = f"trigger '{trigger}' is not in the pool of {models.mission_path.parent}"
            raise SpecificationError(f"{what}; {expected(trigger, known)}")
    made = copies(known[each] for each in known if each in waited)
    root.triggers.extend(made[known[each]] for each in known if each in waited)
    for original, copy in made.items():
        if original in known.values():
            sources = {fault.ID for fault in original.faults}
            copy.faults.clear()
            pairs = zip(root.faults, specification, strict=True)
            copy.faults.extend(fault for fault, timed in pairs if timed.fault in sources)
    for fault, trigger in zip(root.faults, waited, strict=True):
        fault.trigger = made[known[trigger]] if trigger else None


def with_classes(models: LoadedModels, *packages: ModuleType) -> LoadedModels:
    """Return a copy of loaded models whose objects belong to the static classes.

    ``packages`` are the modules ``mission`` and ``faults`` of ``generated/metamodel``; if none has
    the class of an object, this raises a ``ModelError``. ``m2t.models.load`` saves the copy like
    the original, with new elements of the same classes.
    """
    classifiers = {
        (package.nsURI, name): classifier
        for package in packages
        for name, classifier in package.eClassifiers.items()
    }

    def known(classifier: Any) -> Any:
        key = (classifier.ePackage.nsURI, classifier.name)
        if key not in classifiers:
            raise ModelError(
                f"{classifier.name} of {key[0]} is no static class; expected the packages of the "
                "models; name them all, or run `python -m m2t.classes generated/metamodel`"
            )
        return classifiers[key]

    made = copies([root for root in (models.mission, models.faults) if root is not None], known)
    return replace(
        models,
        mission=made[models.mission],
        faults=None if models.faults is None else made[models.faults],
        nodes={made[element]: node for element, node in models.nodes.items()},
        files=tuple(
            replace(file, roots=tuple(made[root] for root in file.roots)) for file in models.files
        ),
    )
