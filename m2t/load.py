"""Load a mission folder: its mission and its faults, checked to the last attribute."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from m2t.check.references import referred_files, resolve
from m2t.check.structure import ModelTree, ReadModel, check_claims, check_structure
from m2t.constraints.faults import check_faults
from m2t.constraints.identity import check_identities
from m2t.constraints.mission import check_mission
from m2t.diagnostics import Diagnostic, Findings, Report
from m2t.metamodels import load_metamodels
from m2t.objects import ModelLoader
from m2t.read.addresses import local_path
from m2t.read.model_files import ModelFiles
from m2t.read.nodes import Node
from mrsfi_runtime.errors import ModelError

MISSION_XMI = "mission.xmi"
FAULTS_XMI = "faults.xmi"


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
    """

    mission: Any
    faults: Any
    mission_path: Path
    faults_path: Path | None
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
        Models without an error; warnings are left to ``inspect_folder``.

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
    """Load a mission folder and return everything that was found on the way, mission first.

    Notes
    -----
    Constraints of sense are checked on a file whose structure is sound: what they would say
    about missing parts helps nobody.
    """
    loading = _Loading()
    mission_path, faults_path = folder / MISSION_XMI, folder / FAULTS_XMI
    mission = loading.read_mission(mission_path)
    faults = None
    if _is_there(faults_path):
        faults = loading.read_faults(faults_path)
    elif loading.holds(mission_path, load_metamodels().faults_class):
        faults = loading.read_faults(mission_path)
    return loading.inspection(mission, faults)


def inspect_specification(path: Path) -> Inspection:
    """Load a fault specification and its mission; return everything that was found."""
    loading = _Loading()
    faults = loading.read_faults(path)
    if faults.tree is None:
        return loading.inspection(None, faults)
    has_mission = loading.holds(path, load_metamodels().mission_class)
    mission = loading.read_mission(path if has_mission else _mission_path(path, faults.tree))
    return loading.inspection(mission, faults)


def _mission_path(path: Path, faults: ModelTree) -> Path:
    """Return the file of the mission that a specification refers to.

    It is the first other file that a reference names, or, if that is a part of a mission, the
    nearest ``mission.xmi`` from the part's folder upwards.
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


class _Loading:
    """Reads a mission and its faults: nodes first, objects once the nodes are sound.

    Constraints of sense are checked on objects, hence only on what is sound.
    """

    def __init__(self) -> None:
        self._report = Report()
        self._files = ModelFiles(self._report)
        self._loader = ModelLoader()
        self._findings = Findings(self._loader.nodes, self._report)

    def holds(self, path: Path, metaclass: Any) -> bool:
        """Return whether a file that was read has a model of a class beside what else it has."""
        file = self._files.at(path)
        return file is not None and bool(file.roots_of(metaclass))

    def read_mission(self, path: Path) -> ReadModel:
        """Read, check and load the mission."""
        mission = self._read(path, load_metamodels().mission_class, become_names=True)
        self._load(mission, None)
        if mission.root is not None:
            check_mission(mission.root, self._findings)
        return mission

    def read_faults(self, path: Path) -> ReadModel:
        """Read faults up to their references, which need the mission."""
        return self._read(path, load_metamodels().faults_class, become_names=False)

    def inspection(self, mission: ReadModel | None, faults: ReadModel | None) -> Inspection:
        """Load and check faults beside their mission; return all that was found of both."""
        if faults is not None and mission is not None:
            self._load(faults, mission)
            if faults.root is not None:
                check_faults(faults.root, mission.root.duration, self._findings)
        if not self._report.n_errors:
            check_claims(self._files, self._report)
        draft = self._draft(mission, faults)
        diagnostics = tuple(self._report)
        return Inspection(None if self._report.n_errors else draft, diagnostics, draft)

    def _read(self, path: Path, metaclass: Any, *, become_names: bool) -> ReadModel:
        n_unsound = self._report.n_unsound
        file = self._files.read(path)
        model = ReadModel(path)
        if file is not None:
            model.tree = check_structure(file, metaclass, self._files, self._report)
        if model.tree is not None:
            check_identities(model.tree, self._report, become_names=become_names)
        model.is_sound = self._report.n_unsound == n_unsound
        return model

    def _load(self, model: ReadModel, mission: ReadModel | None) -> None:
        """Resolve the references of a model; make its objects if it is sound, and its mission."""
        if model.tree is None:
            return
        n_unsound = self._report.n_unsound
        resolve(model.tree, mission, self._report)
        model.is_sound &= self._report.n_unsound == n_unsound
        if model.is_sound and (mission is None or mission.root is not None):
            model.root = self._loader.load(model.tree)

    def _draft(self, mission: ReadModel | None, faults: ReadModel | None) -> LoadedModels | None:
        """Return the models, flawless or not; ``None`` if objects of a file are missing."""
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
            files=tuple(
                LoadedFile(
                    file.path, file.encoding, tuple(map(self._loader.objects.get, file.roots))
                )
                for file in self._files
            ),
        )
