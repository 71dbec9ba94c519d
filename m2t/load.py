"""Load a mission folder: its mission and its faults, checked to the last attribute."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from m2t.constraints.faults import check_faults
from m2t.constraints.findings import Findings
from m2t.constraints.identity import check_identities
from m2t.constraints.mission import check_mission
from m2t.diagnostics import Diagnostic
from m2t.document import Node, Report, read_document
from m2t.instances import ModelLoader
from m2t.metamodels import load_metamodels
from m2t.references import Neighbour, local_path, referred_files, resolve
from m2t.structure import ModelTree, check_structure
from mrsfi_runtime.errors import ModelError

MISSION_XMI = "mission.xmi"
FAULTS_XMI = "faults.xmi"


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
        Files that they came from.
    nodes
        Element of the file, with its line, of every object of both models.
    """

    mission: Any
    faults: Any
    mission_path: Path
    faults_path: Path | None
    nodes: Mapping[Any, Node] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Inspection:
    """What loading found; ``models`` is ``None`` if an error stands in the way."""

    models: LoadedModels | None
    diagnostics: tuple[Diagnostic, ...]


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
    return loading.inspection()


def inspect_specification(path: Path) -> Inspection:
    """Load a fault specification and its mission; return everything that was found."""
    loading = _Loading()
    faults = loading.read_faults(path)
    if faults is None:
        return loading.inspection()
    paths = (local_path(path.parent, document) for _, document in referred_files(faults))
    named = next((found for found in paths if found is not None), path.parent / MISSION_XMI)
    loading.read_mission(named)
    loading.finish_faults()
    return loading.inspection()


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
class _File:
    """A file on its way: its nodes, and the root object once pyecore has loaded it."""

    path: Path
    tree: ModelTree | None
    root: Any = None


class _Loading:
    """Reads a mission and its faults: nodes first, objects once the nodes are sound.

    Constraints of sense are checked on objects, hence only on what is sound.
    """

    def __init__(self) -> None:
        self._report = Report()
        self._loader = ModelLoader()
        self._mission: _File | None = None
        self._faults: _File | None = None

    def read_mission(self, path: Path) -> None:
        """Read, check and load the mission."""
        n_errors = self._report.n_errors
        tree = self._read(path, load_metamodels().mission, "Mission")
        self._mission = _File(path, tree)
        if tree is None:
            return
        resolve(tree, None, self._report)
        check_identities(tree, self._report, become_names=True)
        tree.is_sound = self._report.n_errors == n_errors
        if tree.is_sound:
            self._mission.root = self._loader.load(tree)
            check_mission(self._mission.root, Findings(self._loader.nodes, self._report))

    def read_faults(self, path: Path) -> ModelTree | None:
        """Read faults up to their references, which need the mission."""
        n_errors = self._report.n_errors
        tree = self._read(path, load_metamodels().faults, "FaultSpecification")
        self._faults = _File(path, tree)
        if tree is not None:
            check_identities(tree, self._report, become_names=False)
            tree.is_sound = self._report.n_errors == n_errors
        return tree

    def finish_faults(self) -> None:
        """Resolve, load and check faults beside their mission."""
        faults, mission = self._faults, self._mission
        if faults is None or faults.tree is None or mission is None:
            return
        n_errors = self._report.n_errors
        resolve(faults.tree, Neighbour(mission.path, mission.tree), self._report)
        is_sound = faults.tree.is_sound and self._report.n_errors == n_errors
        if is_sound and mission.root is not None:
            faults.root = self._loader.load(faults.tree)
            findings = Findings(self._loader.nodes, self._report)
            check_faults(faults.root, mission.root.duration, findings)

    def inspection(self) -> Inspection:
        """Return what was found, with the models if no error stands in the way."""
        diagnostics = tuple(self._report)
        mission, faults = self._mission, self._faults
        if mission is None or self._report.n_errors:
            return Inspection(None, diagnostics)
        models = LoadedModels(
            mission=mission.root,
            faults=None if faults is None else faults.root,
            mission_path=mission.path,
            faults_path=None if faults is None else faults.path,
            nodes=self._loader.nodes,
        )
        return Inspection(models, diagnostics)

    def _read(self, path: Path, package: Any, class_name: str) -> ModelTree | None:
        root = read_document(path, self._report)
        if root is None:
            return None
        return check_structure(root, package, class_name, self._report)
