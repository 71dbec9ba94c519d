"""The one door to generated code."""

import importlib.util
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any
from zlib import crc32

from mrsfi_runtime.errors import EvaluationError, GenerationError, SpecificationError
from mrsfi_runtime.hosting.sides import Check, Reaction, SimInterface, Simulation
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Topic


@dataclass(frozen=True)
class MissionCode:
    """The generated code of one mission, loaded.

    Attributes
    ----------
    mission, pool
        What the loaders return.
    simulation, interface
        The generated classes.
    truth
        Topics of the robots' true states, in model order.
    checks, reactions
        The goal functions in model order.
    directory
        Where the code was loaded from.
    """

    mission: Mission
    pool: FaultPool
    simulation: type[Simulation]
    interface: type[SimInterface]
    truth: tuple[Topic, ...]
    checks: tuple[Check, ...]
    reactions: tuple[Reaction, ...]
    directory: Path


def load_code(directory: Path) -> MissionCode:
    """Load the generated code of a mission from its folder.

    Parameters
    ----------
    directory
        ``generated/<mission>`` or the copy of it in a campaign folder.

    Raises
    ------
    GenerationError
        If a file is missing.
    EvaluationError
        If a file cannot be imported, because of an edited region, say.
    """
    collective = _module(directory, "collective_intelligence")
    simulation = _module(directory, "simulation")
    return MissionCode(
        mission=_module(directory, "mission_loader").load_mission(),
        pool=_module(directory, "fault_loader").load_faults(),
        simulation=simulation.Simulation,
        interface=_module(directory, "sim_interface").SimInterface,
        truth=tuple(getattr(simulation, "TRUTH", ())),  # campaigns of older versions have none
        checks=tuple(collective.CHECKS),
        reactions=tuple(collective.REACTIONS),
        directory=directory,
    )


def pool_from_text(source: str) -> FaultPool:
    """Return the faults that the text of a generated fault loader describes."""
    namespace: dict[str, Any] = {}
    exec(compile(source, "fault_loader.py", "exec"), namespace)
    pool = namespace["load_faults"]()
    if not isinstance(pool, FaultPool):
        message = f"load_faults() returned {type(pool).__name__}; expected a FaultPool"
        raise SpecificationError(message)
    return pool


def _module(directory: Path, stem: str) -> ModuleType:
    """Import one generated file under a name of its own; no other folder's code is touched.

    The name follows from the content, so that compiled code is found again in another folder.
    """
    path = directory / f"{stem}.py"
    if not path.is_file():
        message = f"{path}: no such file; run `mrsfi generate` to make it"
        raise GenerationError(message)
    return load_module(f"mrsfi_generated_{sha256(path.read_bytes()).hexdigest()[:16]}_{stem}", path)


def load_module(name: str, path: Path) -> ModuleType:
    """Import a file under a name, as it stands now.

    Raises
    ------
    EvaluationError
        If it cannot be imported.
    """
    loader = _SourceLoader(name, str(path.absolute()))
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    if spec is None or spec.loader is None:
        message = f"{path}: not a Python module"
        raise EvaluationError(message)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        message = f"{path}: cannot be imported: {type(error).__name__}: {error}"
        raise EvaluationError(message) from error
    return module


class _SourceLoader(SourceFileLoader):
    """Matches bytecode by what the source holds, where Python takes its second; edits are quick."""

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Return a checksum in the place of the time."""
        source = self.get_data(path)
        return {"mtime": crc32(source), "size": len(source)}
