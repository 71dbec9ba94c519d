"""Load a mission folder: its mission and its faults, checked to the last attribute."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from m2t.check.references import Neighbour, referred_files, resolve
from m2t.check.structure import ModelTree, check_claims, check_structure
from m2t.constraints.faults import check_faults
from m2t.constraints.findings import Findings
from m2t.constraints.identity import check_identities
from m2t.constraints.mission import check_mission
from m2t.diagnostics import Diagnostic
from m2t.metamodels import load_metamodels
from m2t.objects import ModelLoader
from m2t.read.model_files import ModelFile, ModelFiles, local_path
from m2t.read.nodes import Node, Report
from mrsfi_runtime.errors import ModelError

MISSION_XMI = "mission.xmi"
FAULTS_XMI = "faults.xmi"

_ROOT_CLASSES = {"mission": "Mission", "faults": "FaultSpecification"}


@dataclass(frozen=True, slots=True)
class LoadedFile:
    """A file that a model came from, with what saving keeps of it.

    Attributes
    ----------
    path
        The file.
    encoding
        Encoding that it declares.
    roots
        Root objects of the file in its order: of a model, or parts of one.
    """

    path: Path
    encoding: str
    roots: tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class LoadedModels:
    """A mission, and the faults that go with it.

    Attributes
    ----------
    mission
        Root of the mission model, a pyecore object.
    faults
        Root of the fault model; ``None`` if the folder has none.
    mission_path, faults_path
        Files that they begin in; the same if both stand in one file.
    nodes
        Element of the file, with its line, of every object of both models.
    files
        All files that they came from, in the order in which they were read.
    xmi_ids
        The xmi:id of every object whose element has one.
    """

    mission: Any
    faults: Any
    mission_path: Path
    faults_path: Path | None
    nodes: Mapping[Any, Node] = field(repr=False)
    files: tuple[LoadedFile, ...] = field(default=(), repr=False)
    xmi_ids: Mapping[Any, str] = field(default_factory=dict, repr=False)


@dataclass(frozen=True, slots=True)
class Inspection:
    """What loading found.

    Attributes
    ----------
    models
        The models; ``None`` if an error stands in the way.
    diagnostics
        All defects of all files.
    draft
        The models although constraints of sense are broken, for whoever mends them; ``None`` if
        the structure of a file is broken.
    """

    models: LoadedModels | None
    diagnostics: tuple[Diagnostic, ...]
    draft: LoadedModels | None = field(default=None, repr=False)


def load_mission_folder(folder: Path) -> LoadedModels:
    """Load ``mission.xmi`` and, if it exists, ``faults.xmi`` of a mission folder.

    Parameters
    ----------
    folder
        The mission folder.

    Returns
    -------
    LoadedModels
        Models without an error; warnings are left to ``m2t.validate``.

    Raises
    ------
    ModelError
        With all errors of both files, one a line.
    """
    return _models_of(inspect_folder(folder))


def load_specification(path: Path) -> LoadedModels:
    """Load a fault specification and the mission that it refers to.

    Parameters
    ----------
    path
        File of a fault specification, written by hand or found by search.

    Returns
    -------
    LoadedModels
        The specification as ``faults``, with its mission.

    Raises
    ------
    ModelError
        With all errors of both files, one a line.
    """
    return _models_of(inspect_specification(path))


def inspect_folder(folder: Path) -> Inspection:
    """Load a mission folder and return everything that was found on the way."""
    loading = _Loading()
    mission_path, faults_path = folder / MISSION_XMI, folder / FAULTS_XMI
    loading.read_mission(mission_path)
    if _is_there(faults_path):
        loading.read_faults(faults_path)
        loading.finish_faults()
    elif loading.holds_faults(mission_path):
        loading.read_faults(mission_path)
        loading.finish_faults()
    return loading.inspection()


def inspect_specification(path: Path) -> Inspection:
    """Load a fault specification and its mission; return everything that was found."""
    loading = _Loading()
    faults = loading.read_faults(path)
    if faults is None:
        return loading.inspection()
    loading.read_mission(path if loading.holds_mission(path) else _mission_path(path, faults))
    loading.finish_faults()
    return loading.inspection()


def _mission_path(path: Path, faults: ModelTree) -> Path:
    """Return the file of the mission that a specification refers to.

    It is the first other file that a reference names, or, if that is a part of a mission, the
    nearest ``mission.xmi`` from the part's folder upwards.
    """
    own = {file.path.resolve() for file in faults.files}
    for reference, document in referred_files(faults):
        found = local_path(reference.node.path.parent, document)
        if found is not None and found.resolve() not in own:
            return _whole(found)
    return path.parent / MISSION_XMI


def _whole(path: Path) -> Path:
    """Return the mission file that a file belongs to: itself, unless it is only a part."""
    file = ModelFiles(Report()).read(path)
    package = load_metamodels().mission
    if file is None or file.roots_of(package.nsURI, "Mission"):
        return path
    places = (folder / MISSION_XMI for folder in path.resolve().parents)
    return next((place for place in places if place.is_file()), path)


def _models_of(inspection: Inspection) -> LoadedModels:
    if inspection.models is None:
        errors = [found for found in inspection.diagnostics if found.severity == "error"]
        raise ModelError("\n".join(str(found) for found in errors))
    return inspection.models


def _is_there(path: Path) -> bool:
    """Return whether a file exists, or at least something there that refuses to say so."""
    try:
        return path.exists()
    except OSError:
        return True


@dataclass(slots=True)
class _Model:
    """A model on its way: its nodes, and the root object once it is made."""

    path: Path
    tree: ModelTree | None
    root: Any = None


class _Loading:
    """Reads a mission and its faults: nodes first, objects once the nodes are sound.

    Constraints of sense are checked on objects, hence only on what is sound.
    """

    def __init__(self) -> None:
        self._report = Report()
        self._files = ModelFiles(self._report)
        self._loader = ModelLoader()
        self._mission: _Model | None = None
        self._faults: _Model | None = None

    def holds_faults(self, path: Path) -> bool:
        """Return whether a file that was read has faults beside what else it has."""
        file = self._files.at(path)
        return file is not None and bool(self._roots(file, load_metamodels().faults))

    def holds_mission(self, path: Path) -> bool:
        """Return whether a file that was read has a mission beside what else it has."""
        file = self._files.at(path)
        return file is not None and bool(self._roots(file, load_metamodels().mission))

    def read_mission(self, path: Path) -> None:
        """Read, check and load the mission."""
        n_unsound = self._n_unsound()
        tree = self._read(path, load_metamodels().mission)
        self._mission = _Model(path, tree)
        if tree is None:
            return
        resolve(tree, None, self._report)
        check_identities(tree, self._report, become_names=True)
        tree.is_sound = self._n_unsound() == n_unsound
        if tree.is_sound:
            self._mission.root = self._loader.load(tree)
            check_mission(self._mission.root, Findings(self._loader.nodes, self._report))

    def read_faults(self, path: Path) -> ModelTree | None:
        """Read faults up to their references, which need the mission."""
        n_unsound = self._n_unsound()
        tree = self._read(path, load_metamodels().faults)
        self._faults = _Model(path, tree)
        if tree is not None:
            check_identities(tree, self._report, become_names=False)
            tree.is_sound = self._n_unsound() == n_unsound
        return tree

    def finish_faults(self) -> None:
        """Resolve, load and check faults beside their mission."""
        faults, mission = self._faults, self._mission
        if faults is None or faults.tree is None or mission is None:
            return
        n_unsound = self._n_unsound()
        resolve(faults.tree, Neighbour(mission.path, mission.tree), self._report)
        is_sound = faults.tree.is_sound and self._n_unsound() == n_unsound
        if is_sound and mission.root is not None:
            faults.root = self._loader.load(faults.tree)
            findings = Findings(self._loader.nodes, self._report)
            check_faults(faults.root, mission.root.duration, findings)

    def inspection(self) -> Inspection:
        """Return what was found, with the models if no error stands in the way."""
        if not self._report.n_errors:
            check_claims(self._files, self._report)
        diagnostics = tuple(self._report)
        draft = self._draft()
        return Inspection(None if self._report.n_errors else draft, diagnostics, draft)

    def _draft(self) -> LoadedModels | None:
        """Return the models, flawless or not; ``None`` if objects of a file are missing."""
        mission, faults = self._mission, self._faults
        if mission is None or mission.root is None:
            return None
        if faults is not None and faults.root is None:
            return None
        return LoadedModels(
            mission=mission.root,
            faults=None if faults is None else faults.root,
            mission_path=mission.path,
            faults_path=None if faults is None else faults.path,
            nodes=self._loader.nodes,
            files=tuple(self._loaded_file(file) for file in self._files),
            xmi_ids=self._loader.xmi_ids,
        )

    def _n_unsound(self) -> int:
        """Return the number of errors that leave no sound objects.

        A reference that is named twice is none of them: the list of objects holds it once.
        """
        return sum(
            found.severity == "error" and found.constraint != "UniqueReference"
            for found in self._report
        )

    def _loaded_file(self, file: ModelFile) -> LoadedFile:
        roots = tuple(self._loader.instance(root) for root in file.roots)
        return LoadedFile(file.path, file.encoding, roots)

    def _roots(self, file: ModelFile, package: Any) -> list[Node]:
        return file.roots_of(package.nsURI, _ROOT_CLASSES[package.name])

    def _read(self, path: Path, package: Any) -> ModelTree | None:
        file = self._files.read(path)
        if file is None:
            return None
        class_name = _ROOT_CLASSES[package.name]
        return check_structure(file, package, class_name, self._files, self._report)
