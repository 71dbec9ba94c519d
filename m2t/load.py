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
from m2t.metamodels import load_metamodels
from m2t.references import Neighbour, local_path, referred_files, resolve
from m2t.structure import ModelTree, build
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
    report = Report()
    mission_path, faults_path = folder / MISSION_XMI, folder / FAULTS_XMI
    mission = _load_mission(mission_path, report)
    if not _is_there(faults_path):
        return _inspection(mission, None, mission_path, None, report)
    faults = _load_faults(faults_path, report)
    _complete_faults(faults, Neighbour(mission_path, mission), report)
    return _inspection(mission, faults, mission_path, faults_path, report)


def inspect_specification(path: Path) -> Inspection:
    """Load a fault specification and its mission; return everything that was found."""
    report = Report()
    faults = _load_faults(path, report)
    mission_path = path.parent / MISSION_XMI
    if faults is not None:
        paths = (local_path(path.parent, document) for _, document in referred_files(faults))
        mission_path = next((found for found in paths if found is not None), mission_path)
    mission = _load_mission(mission_path, report) if faults is not None else None
    _complete_faults(faults, Neighbour(mission_path, mission), report)
    return _inspection(mission, faults, mission_path, path, report)


def _models_of(inspection: Inspection) -> LoadedModels:
    if inspection.models is None:
        errors = [found for found in inspection.diagnostics if found.severity == "error"]
        raise ModelError("\n".join(str(found) for found in errors))
    return inspection.models


def _read(path: Path, package: Any, class_name: str, report: Report) -> ModelTree | None:
    root = read_document(path, report)
    return None if root is None else build(root, package, class_name, report)


def _is_there(path: Path) -> bool:
    """Return whether a file exists, or at least something there that refuses to say so."""
    try:
        return path.exists()
    except OSError:
        return True


def _load_mission(path: Path, report: Report) -> ModelTree | None:
    """Load a mission; constraints of sense are checked once its structure is sound."""
    n_errors = report.n_errors
    tree = _read(path, load_metamodels().mission, "Mission", report)
    if tree is None:
        return None
    resolve(tree, None, report)
    findings = Findings(tree.nodes, report)
    check_identities(tree, findings, become_names=True)
    tree.is_sound = report.n_errors == n_errors
    if tree.is_sound:
        check_mission(tree.root, findings)
    return tree


def _load_faults(path: Path, report: Report) -> ModelTree | None:
    """Load faults up to their references, which need the mission."""
    n_errors = report.n_errors
    tree = _read(path, load_metamodels().faults, "FaultSpecification", report)
    if tree is not None:
        check_identities(tree, Findings(tree.nodes, report), become_names=False)
        tree.is_sound = report.n_errors == n_errors
    return tree


def _complete_faults(tree: ModelTree | None, neighbour: Neighbour, report: Report) -> None:
    """Resolve and check faults; constraints of sense need a sound mission and structure."""
    if tree is None:
        return
    n_errors = report.n_errors
    resolve(tree, neighbour, report)
    tree.is_sound = tree.is_sound and report.n_errors == n_errors
    if tree.is_sound and neighbour.tree is not None and neighbour.tree.is_sound:
        duration = neighbour.tree.root.duration
        check_faults(tree.root, duration, Findings(tree.nodes, report))


def _inspection(
    mission: ModelTree | None,
    faults: ModelTree | None,
    mission_path: Path,
    faults_path: Path | None,
    report: Report,
) -> Inspection:
    diagnostics = tuple(report)
    if mission is None or report.n_errors:
        return Inspection(None, diagnostics)
    nodes = {**mission.nodes, **(faults.nodes if faults is not None else {})}
    fault_root = faults.root if faults is not None else None
    models = LoadedModels(mission.root, fault_root, mission_path, faults_path, nodes)
    return Inspection(models, diagnostics)
