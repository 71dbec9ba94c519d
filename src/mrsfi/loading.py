"""What flies: the code of missions, and fault specifications in files."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from m2t.generate import rendered_file
from m2t.load import LoadedModels, load_mission_folder, load_specification
from m2t.specification import write_specification
from mrsfi.engines import Tell, silent
from mrsfi.folders import MissionFolders
from mrsfi_runtime.engine.flights import require_effects
from mrsfi_runtime.errors import SpecificationError, UsageError
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.generated_code import MissionCode, load_code, pool_from_text
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification, original

if TYPE_CHECKING:
    from mrsfi_runtime.analysis.report import SpecificationWriter


def load_fresh(folders: MissionFolders, loaded: LoadedModels | None = None) -> MissionCode:
    """Load the generated code of a mission, which must be fresh, with sound regions."""
    from mrsfi_runtime.engine.region_lint import (  # noqa: PLC0415 - brings pyflakes
        require_sound_regions,
    )

    folders.require_fresh(loaded)
    require_sound_regions(folders.generated)
    return load_code(folders.generated)


def specification_writer(
    source: Path | LoadedModels, put: Callable[[Path, bytes], object] = write_atomically
) -> "SpecificationWriter":
    """Return what writes specifications of a pool; a mission folder is loaded for the first."""
    models = cache(lambda: load_mission_folder(source) if isinstance(source, Path) else source)
    return lambda rows, path, identifier, names: write_specification(
        models(), rows, path, identifier=identifier, names=names, write=put
    )


@dataclass(frozen=True, slots=True)
class Written:
    """A fault specification in a file.

    ``models`` is as it was loaded, with its mission; ``unknown`` are the faults that the pool of
    the mission does not have, by ID; ``late`` says of each that ends beyond the mission that it
    does.
    """

    models: LoadedModels
    pool: FaultPool
    specification: Specification
    unknown: tuple[str, ...]
    late: tuple[str, ...]


def read_specification(path: Path, code: MissionCode, tell: Tell = silent) -> Written:
    """Return a written fault specification, which must be one that can be flown.

    A SpecificationError names the lines of the faults. What is odd is told: it may be a
    specification of another mission.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file; expected a fault specification in XMI")
    models = load_specification(path)
    pool = pool_from_text(rendered_file("fault_loader.py", models))
    try:
        require_effects(code.pool, pool)
        specification = Gate(code.mission, pool, code.pool.by_id).admitted(
            pool.written_specification()
        )
    except SpecificationError as error:
        lines = {each.ID: models.nodes[each].line for each in models.pool}
        named = ", ".join(str(lines[fault]) for fault in error.faults if fault in lines)
        where = f"{path}:{named}" if named else path
        raise SpecificationError(f"{where}: {error}", error.faults) from error
    known = code.pool.by_id
    unknown = tuple(each.id for each in pool if original(each.id, known) not in known)
    late = tuple(
        f"{path}: fault '{timed.fault}' has the window {timed.start} … {timed.finish}, "
        f"which ends beyond the mission; its last tick is {code.mission.duration - 1}"
        for timed in specification
        if timed.finish >= code.mission.duration
    )
    if unknown:
        tell(f"{path}: not in the pool, flown as written: {', '.join(unknown)}")
    for oddity in late:
        tell(oddity)
    return Written(models, pool, specification, unknown, late)
