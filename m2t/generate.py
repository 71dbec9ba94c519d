"""Generate the middleware of a mission: models in, files out.

Every file is a task of its own: a visitor computes what its template needs, the template
says how it reads, ``emit`` merges the text with hand-written code and writes it.

References
----------
Source paper, section III-D, the model-to-text transformations.
"""

import hashlib
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from m2t.emit import GenerationPlan, plan_files
from m2t.environment import remark, template_environment
from m2t.line_difference import unified_difference
from m2t.load import LoadedModels, load_mission_folder
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, metamodel_folder
from m2t.protected_regions import text_lines
from m2t.visitors import (
    collective_intelligence,
    fault_effects,
    fault_loader,
    mission_loader,
    topics,
)
from mrsfi_runtime.errors import GenerationError, UsageError
from mrsfi_runtime.files import changing

VISITORS: Mapping[str, Callable[[LoadedModels], Mapping[str, Any]]] = {
    "mission_loader.py": mission_loader.visit,
    "fault_loader.py": fault_loader.visit,
    "fault_effects.py": fault_effects.visit,
    "topics.py": topics.visit,
    "sim_interface.py": lambda _: {},  # goes through the rows of topics.py, as the next does
    "simulation.py": lambda _: {},
    "collective_intelligence.py": collective_intelligence.visit,
}
"""The visitor of each generated file, whose template has the name of the file.

It computes what the template needs, free of metamodel objects.
"""


def generate(models: Path, target: Path, *, force: bool = False) -> GenerationPlan:
    """Bring the generated code of a mission up to date; say what was written and removed.

    Edits outside protected regions are refused unless forced. Errors of the models are a
    ``ModelError``; hand-written code in danger, or a file that cannot be written, is a
    ``GenerationError``. A folder of models that cannot be written is locked by that of the code.
    """
    place = models if os.access(models, os.W_OK) else target
    with changing(place) as change:
        planned = plan(models, target, force=force)
        try:
            change.replace(planned.changes)
        except UsageError as error:
            raise GenerationError(f"{error}; mend the cause and generate again") from error
    return planned


def plan(models: Path | LoadedModels, target: Path, *, force: bool = False) -> GenerationPlan:
    """Return what ``generate`` would do with a mission folder, or with what was loaded from one."""
    loaded = load_mission_folder(models) if isinstance(models, Path) else models
    return plan_files(target, rendered(loaded), sources(loaded), force=force)


def stale(models: Path | LoadedModels, target: Path) -> tuple[str, ...]:
    """Return the files that ``generate`` would write or remove, empty if all is up to date."""
    return plan(models, target).stale


def diff(models: Path, target: Path) -> str:
    """Return what ``generate`` would change, as a unified diff without the manifest.

    File names are relative to the target folder, old ones below ``a/``, new ones below ``b/``.
    """
    planned = plan(models, target)
    return "".join(
        _difference(name, planned.existing.get(name), planned.contents.get(name))
        for name in (*planned.written, *planned.removed)
    )


def rendered(loaded: LoadedModels) -> dict[str, str]:
    """Return the text of every generated file by name, as its template renders it."""
    return {name: rendered_file(name, loaded) for name in VISITORS}


def rendered_file(name: str, loaded: LoadedModels) -> str:
    """Return the text of one; a fault loader is also that of any written specification."""
    template = template_environment().get_template(f"{name}.j2")
    mission = remark(loaded.mission_path.resolve().parent.name)
    header = f"# Generated from mission {mission} by {template.name}.\n"
    protected = "# Edit inside protected regions only.\n"
    return header + protected + template.render(VISITORS[name](loaded))


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


def sources(
    loaded: LoadedModels, contents: Mapping[Path, bytes] = MappingProxyType({})
) -> dict[str, str]:
    """Return the SHA-256 of all files of models and of metamodels, line ends apart.

    ``contents`` are those that files are going to have in place of what stands in them.
    """
    folder, metamodels = loaded.mission_path.parent, metamodel_folder()
    paths = {file.seen_from(folder): file.path for file in loaded.files}
    paths |= {name: metamodels / name for name in (MISSION_FILE, FAULTS_FILE)}
    return {
        name: hashlib.sha256(content.replace(b"\r\n", b"\n")).hexdigest()
        for name, path in paths.items()
        for content in (contents.get(path) or path.read_bytes(),)
    }
