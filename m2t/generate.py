"""Generate the middleware of a mission: models in, files out.

Every file is a task of its own: a visitor computes what its template needs, the template
says how it reads, ``emit`` merges the text with hand-written code and writes it.

References
----------
Source paper, section III-D, the model-to-text transformations.
"""

import hashlib
import os
from functools import cache
from pathlib import Path

from jinja2 import Environment

from m2t.emit import GenerationPlan, GenerationResult, plan_files, write
from m2t.environment import template_environment
from m2t.line_difference import unified_difference
from m2t.load import LoadedModels, load_mission_folder
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, metamodel_folder
from m2t.protected_regions import text_lines
from m2t.visitors.base import ModelVisitor
from m2t.visitors.collective_intelligence import CollectiveIntelligenceVisitor
from m2t.visitors.fault_effects import FaultEffectsVisitor
from m2t.visitors.fault_loader import FaultLoaderVisitor
from m2t.visitors.mission_loader import MissionLoaderVisitor
from m2t.visitors.sim_interface import SimInterfaceVisitor
from m2t.visitors.simulation import SimulationVisitor
from m2t.visitors.topics import TopicsVisitor

VISITORS: tuple[type[ModelVisitor], ...] = (
    MissionLoaderVisitor,
    FaultLoaderVisitor,
    FaultEffectsVisitor,
    TopicsVisitor,
    SimInterfaceVisitor,
    SimulationVisitor,
    CollectiveIntelligenceVisitor,
)
"""One visitor per generated file."""


def generate(models: Path, target: Path, *, force: bool = False) -> GenerationResult:
    """Bring the generated code of a mission up to date.

    Parameters
    ----------
    models
        Mission folder with ``mission.xmi`` and ``faults.xmi``.
    target
        Folder for the generated files.
    force
        Overwrite edits outside protected regions.

    Returns
    -------
    GenerationResult
        Which files were written, left as they were, and removed.

    Raises
    ------
    ModelError
        With all errors of the models.
    GenerationError
        If hand-written code would be lost, or a file cannot be written.
    """
    return write(plan(models, target, force=force))


def plan(models: Path, target: Path, *, force: bool = False) -> GenerationPlan:
    """Return what ``generate`` would do with the same arguments; write nothing."""
    loaded = load_mission_folder(models)
    rendered = {str(kind.target): _render(kind(), loaded) for kind in VISITORS}
    return plan_files(target, rendered, _sources(loaded), force=force)


def stale(models: Path, target: Path) -> tuple[str, ...]:
    """Return the files that ``generate`` would write or remove, empty if all is up to date."""
    return plan(models, target).stale


def diff(models: Path, target: Path) -> str:
    """Return what ``generate`` would change, as a unified diff without the manifest.

    File names are relative to the target folder, old ones below ``a/``, new ones below ``b/``.
    """
    planned = plan(models, target)
    return "".join(
        _difference(name, planned.existing.get(name), planned.contents.get(name))
        for name in (*planned.changed, *planned.gone)
    )


def fault_loader_text(loaded: LoadedModels) -> str:
    """Return the text of the fault loader for a fault pool or any written specification."""
    return _render(FaultLoaderVisitor(), loaded)


def _render(visitor: ModelVisitor, loaded: LoadedModels) -> str:
    template = _environment().get_template(visitor.template)
    folder = loaded.mission_path.resolve().parent.name
    return template.render(visitor.context(loaded), mission=folder)


@cache
def _environment() -> Environment:
    return template_environment()


def _difference(name: str, old: str | None, new: str | None) -> str:
    lines = unified_difference(
        text_lines(old or ""),
        text_lines(new or ""),
        "/dev/null" if old is None else f"a/{name}",
        "/dev/null" if new is None else f"b/{name}",
    )
    return "".join(
        line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines
    )


def _sources(loaded: LoadedModels) -> dict[str, str]:
    """Return the SHA-256 of all files of models and of metamodels, line ends apart."""
    metamodels = metamodel_folder()
    folder = loaded.mission_path.parent
    paths = {_source_name(file.path, folder): file.path for file in loaded.files}
    paths |= {name: metamodels / name for name in (MISSION_FILE, FAULTS_FILE)}
    return {
        name: hashlib.sha256(path.read_bytes().replace(b"\r\n", b"\n")).hexdigest()
        for name, path in paths.items()
    }


def _source_name(path: Path, folder: Path) -> str:
    """Return the name of a model's file, relative to its folder; parts may lie elsewhere."""
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
