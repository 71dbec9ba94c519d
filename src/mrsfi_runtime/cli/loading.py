"""What flies: the code of missions, and fault specifications in files."""

from pathlib import Path

from m2t.generate import fault_loader_text
from m2t.load import LoadedModels, load_specification
from mrsfi_runtime.cli.folders import MissionFolders
from mrsfi_runtime.engine.region_lint import require_sound_regions
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.mission import MissionCode, load_code, pool_from_text
from mrsfi_runtime.model.faults import FaultPool


def load_fresh(folders: MissionFolders) -> MissionCode:
    """Load the generated code of a mission, which must be fresh, and whose regions must be sound.

    Raises
    ------
    GenerationError
        If it is stale, or not generated yet.
    EvaluationError
        If a region is not sound, or the code cannot be loaded.
    """
    folders.require_fresh()
    require_sound_regions(folders.generated)
    return load_code(folders.generated)


def read_specification(path: Path) -> tuple[LoadedModels, FaultPool]:
    """Return a written fault specification, and its faults with windows and values.

    Raises
    ------
    UsageError
        If there is no such file.
    ModelError
        If it cannot be used.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file; expected a fault specification in XMI")
    models = load_specification(path)
    return models, pool_from_text(fault_loader_text(models))
