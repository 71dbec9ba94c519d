"""Load generated code, and check that it can fly.

Code can fly if it was generated for this world's rules, and if no region is empty that the user has
to fill: a check without a body would never find a violation. ``require_semantics`` and
``unfilled_regions`` check both without loading the code.

Generated code runs only within the fence of ``fence.py``. Its exceptions become an
``EvaluationError`` that names file and line (``failed``). The modules of each folder get unique
names, so that missions do not disturb each other.

Begin with ``load_code``.
"""

import ast
import json
import sys
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from importlib.machinery import ModuleSpec, SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, cast
from zlib import crc32

from mrsfi_runtime.cosimulation.lockstep import SimInterface, Simulation
from mrsfi_runtime.errors import Diagnostic, EvaluationError, GenerationError, WorkerLost
from mrsfi_runtime.fence import TimeLimitReached, fenced, importing, words
from mrsfi_runtime.files import MARKER, not_a_manifest
from mrsfi_runtime.kernel.flight import MissionFunctions
from mrsfi_runtime.model.fault_types import SEMANTICS, difference
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Topic


def require_semantics(directory: Path) -> None:
    """Refuse code that was generated for other rules of the world than those of this runtime.

    The ``GenerationError`` names both versions and the next step. A missing or broken manifest is
    such an error as well.
    """
    path = directory / "manifest.json"
    if not path.is_file():
        raise GenerationError(f"{path}: no such file; run `mrsfi generate` to make it")
    try:
        found = int(json.loads(path.read_bytes()).get("semantics", 1))  # the first had no number
    except (ValueError, TypeError, AttributeError) as error:
        broken = not_a_manifest(path, error)
        raise GenerationError(f"{broken} and run `mrsfi generate`") from error
    if found != SEMANTICS:
        remedy = "run `mrsfi generate`, then review the diff and your regions"
        raise GenerationError(
            f"{path}: {difference(found)}; {remedy if found < SEMANTICS else 'use a later mrsfi'}"
        )


def region_files(directory: Path) -> list[Path]:
    """Return the generated files that hold regions, if they are there."""
    paths = (directory / name for name in ("collective_intelligence.py", "fault_effects.py"))
    return [path for path in paths if path.is_file()]


def unfilled_regions(directory: Path) -> tuple[Diagnostic, ...]:
    """Return the regions of ``generated/<mission>`` that have to be filled before it can fly.

    A file that is missing, or is not Python, has none.
    """
    return tuple(found for path in region_files(directory) for found in _of_file(path))


def _of_file(path: Path) -> Iterator[Diagnostic]:
    text = path.read_text(encoding="utf-8", errors="replace")
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError):
        return
    lines = text.split("\n")
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef) or len(node.body) > 1:
            continue
        purpose = (ast.get_docstring(node) or "").partition("\n")[0]
        rest = enumerate(lines[node.end_lineno or 0 :], start=(node.end_lineno or 0) + 1)
        number, line = next(((n, line) for n, line in rest if line.strip()), (0, ""))
        marker = MARKER.fullmatch(line)
        if purpose and marker and marker["state"] and not marker["id"].endswith(".progress"):
            region = f"region '{marker['id']}'"
            what = f"{region}: is empty; expected the body of {node.name}, which is to: {purpose}"
            yield Diagnostic(path, number, region, "RegionFilled", "error", what)


@dataclass(frozen=True)
class MissionCode:
    """The generated code of one mission, loaded from a directory.

    ``truth`` are the topics of the robots' true states, in model order.
    """

    mission: Mission
    pool: FaultPool
    simulation: type[Simulation]
    interface: type[SimInterface]
    truth: tuple[Topic, ...]
    functions: MissionFunctions
    directory: Path


def load_code(directory: Path, pool: FaultPool | None = None) -> MissionCode:
    """Load the generated code of a mission, to fly its own pool or other faults.

    Code of another version or other rules is a ``GenerationError``. A region that is empty or keeps
    a file from being imported is an ``EvaluationError``.
    """
    require_semantics(directory)
    if found := unfilled_regions(directory):
        raise EvaluationError("\n".join(each.words for each in found))
    with fenced(lambda error: failed(error, directory, "cannot be loaded", directory)):
        collective = _module(directory, "collective_intelligence")
        siblings = ("topics", "sim_interface", "simulation")
        paths = [_generated(directory, stem) for stem in siblings]
        package = ModuleType(_name_of(*paths))
        package.__path__ = []  # so that other modules are not found
        sys.modules[package.__name__] = package
        topics, interface, simulation = (
            load_module(f"{package.__name__}.{path.stem}", path) for path in paths
        )
        return MissionCode(
            mission=_loaded(directory, "mission_loader", "load_mission"),
            pool=_loaded(directory, "fault_loader", "load_faults") if pool is None else pool,
            simulation=simulation.Simulation,
            interface=interface.SimInterface,
            truth=tuple(robot.truth for robot in topics.ROBOTS),
            functions=_functions(directory, collective, _module(directory, "fault_effects")),
            directory=directory,
        )


def _functions(directory: Path, collective: ModuleType, effects: ModuleType) -> MissionFunctions:
    *names, _ = MissionFunctions._fields
    try:
        own = {name: getattr(collective, name) for name in names}
    except AttributeError as error:
        raise GenerationError(
            f"{directory / 'collective_intelligence.py'}: found no function '{error.name}'; "
            f"expected {', '.join(names)} at its end; it was generated by an older version: "
            "run `mrsfi generate`"
        ) from None
    return MissionFunctions(**own, apply=effects.apply)


def _loaded(directory: Path, stem: str, function: str) -> Any:
    module = _module(directory, stem)
    try:
        return getattr(module, function)()
    except TypeError as error:
        raise GenerationError(
            f"{directory / stem}.py: was generated by another version of mrsfi ({error}); "
            "run `mrsfi generate` to make it again"
        ) from error


def mission_from_text(source: str) -> Mission:
    """Return the mission that the text of a generated mission loader describes."""
    return cast("Mission", _made("mission_loader.py", source, "load_mission"))


def pool_from_text(source: str) -> FaultPool:
    """Return the faults that the text of a generated fault loader describes."""
    return cast("FaultPool", _made("fault_loader.py", source, "load_faults"))


def _made(name: str, source: str, function: str) -> Any:
    namespace: dict[str, Any] = {}
    exec(compile(source, name, "exec"), namespace)
    return namespace[function]()


def _module(directory: Path, stem: str) -> ModuleType:
    """Import one generated file under a unique name.

    The name follows from the content, so that compiled code is found again in another folder.
    """
    path = _generated(directory, stem)
    return load_module(f"{_name_of(path)}_{stem}", path)


def _generated(directory: Path, stem: str) -> Path:
    path = directory / f"{stem}.py"
    if not path.is_file():
        raise GenerationError(f"{path}: no such file; run `mrsfi generate` to make it")
    return path


def _name_of(*paths: Path) -> str:
    content = b"".join(path.read_bytes() for path in paths)
    return f"mrsfi_generated_{sha256(content).hexdigest()[:16]}"


def load_module(name: str, path: Path) -> ModuleType:
    """Import a file under a name; if this fails, it is an ``EvaluationError``."""
    loader = _SourceLoader(name, str(path.absolute()))
    module = module_from_spec(cast("ModuleSpec", spec_from_loader(name, loader)))
    sys.modules[name] = module
    as_ours = partial(failed, directory=path.parent, what="cannot be imported", file=path)
    with fenced(as_ours), importing(path.parent, module):
        loader.exec_module(module)
    return module


def failed(
    error: BaseException, directory: Path, what: str, file: Path | None = None
) -> EvaluationError:
    """Return the error to raise for an exception in the code of a mission; ``what`` failed.

    It names the line in ``directory`` that is nearest to the exception, or else the file.
    """
    frames = [(f.filename, f.lineno or 1) for f in traceback.extract_tb(error.__traceback__)]
    if isinstance(error, SyntaxError):
        frames.append((error.filename or "", error.lineno or 1))
    lines = [
        (directory / Path(name).name, line)
        for name, line in frames
        if Path(name).parent == directory.absolute()
    ]
    place = f"{lines[-1][0]}:{lines[-1][1]}: " if lines else f"{file}: " if file else ""
    remedy = "; correct the region" if lines else ""
    text = words(error)
    if isinstance(error, ImportError) and error.name == "mrsfi_runtime.api":
        text = text.partition(" (")[0]
        remedy = (
            "; code of another version of mrsfi: run `mrsfi generate`, then correct the regions"
        )
    kind = WorkerLost if isinstance(error, TimeLimitReached) else EvaluationError
    found = kind(f"{place}{what}: {type(error).__name__}: {text}{remedy}")
    found.line = lines[-1] if lines else None
    return found


class _SourceLoader(SourceFileLoader):
    """Matches bytecode by the content of the source, because edits can occur within a second."""

    def get_code(self, fullname: str) -> CodeType | None:
        """Return the code; if the bytecode is damaged, from the source."""
        try:
            return super().get_code(fullname)
        except (EOFError, TypeError, ValueError):
            return self.source_to_code(self.get_data(self.path), self.path)

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Return a checksum in place of the time."""
        source = self.get_data(path)
        return {"mtime": crc32(source), "size": len(source)}
