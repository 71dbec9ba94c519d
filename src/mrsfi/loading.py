"""Check missions, and read fault specifications in files.

``read_specification`` reads a file of timed faults. ``validate`` checks the models, the regions and
a flight without faults; its diagnostics are those of ``m2t``.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from mrsfi.engines import Tell, from_here, silent
from mrsfi.folders import MissionFolders, find_mission, load_fresh, rendered
from mrsfi_runtime.engine.compiled.regions import CompilationError, Reached, own_regions
from mrsfi_runtime.engine.flights import ReferenceEngine, require_effects
from mrsfi_runtime.errors import (
    Diagnostic,
    EvaluationError,
    MrsfiError,
    ReplayMismatch,
    SpecificationError,
    UsageError,
)
from mrsfi_runtime.files import changing, settle, write_atomically
from mrsfi_runtime.generated_code import MissionCode, pool_from_text
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification, original
from mrsfi_runtime.model.mission import starvation

if TYPE_CHECKING:
    from m2t.models.fixes import Mending
    from m2t.models.load import Inspection, LoadedModels
    from mrsfi_runtime.analysis.report import SpecificationWriter


def load_models(path: Path) -> "LoadedModels":
    """Load the models of a mission folder, or a specification with its mission."""
    from m2t.models import load  # noqa: PLC0415 - slow

    is_file = path.suffix == ".xmi" or path.is_file()
    return load.load_specification(path) if is_file else load.load_mission_folder(path)


def specification_writer(
    source: "Path | Callable[[], LoadedModels]",
    put: Callable[[Path, bytes], object] = write_atomically,
) -> "SpecificationWriter":
    """Return a writer of specifications; it loads a mission folder when it is first called."""
    from m2t.models import load  # noqa: PLC0415 - slow

    models = cache(lambda: load_models(source) if isinstance(source, Path) else source())
    return lambda pool, timed, path, identifier, names: load.write_specification(
        models(), pool, timed, path, identifier=identifier, names=names, write=put
    )


@dataclass(frozen=True, slots=True)
class Written:
    """A fault specification in a file.

    ``models`` loads the file with its mission, once. ``unknown`` has the IDs of faults outside the
    pool, ``late`` a warning for each that ends beyond the mission.
    """

    models: "Callable[[], LoadedModels]"
    pool: FaultPool
    specification: Specification
    unknown: tuple[str, ...]
    late: tuple[str, ...]


def read_specification(path: Path, code: MissionCode, tell: Tell = silent) -> Written:
    """Return a written fault specification that can be flown; else a ``SpecificationError``.

    ``tell`` receives warnings, because it may be a specification of another mission.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file; expected a fault specification in XMI")
    models = cache(lambda: load_models(path))
    settle(*path.resolve().parents)
    (text,) = rendered(path, "fault_loader.py", models=models).values()
    pool = pool_from_text(text)
    try:
        require_effects(code.pool, pool)
        specification = Gate(code.mission, pool, code.pool.by_id).admitted(
            pool.written_specification()
        )
    except SpecificationError as error:
        lines = {each.ID: models().nodes[each].line for each in models().pool}
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


_LONGEST_FLIGHT = 100_000
"""Maximum duration in ticks that a validation flies; it takes a few seconds."""


@dataclass(frozen=True, slots=True)
class Validated:
    """The defects of a mission, or of a fault specification, and the numbers of its elements.

    ``code`` has the diagnostics of the generated code and of the flight without faults.
    """

    name: str
    models: tuple[Diagnostic, ...]
    code: tuple[Diagnostic, ...] = ()
    counts: Mapping[str, int] = field(default_factory=dict)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """All diagnostics, those of the models first."""
        return (*self.models, *self.code)

    def strict(self) -> "Validated":
        """Return the same with its warnings as errors."""
        models, code = (
            tuple(found._replace(severity="error") for found in some)
            for some in (self.models, self.code)
        )
        return replace(self, models=models, code=code)


def validate(mission: str, generated: Path | None = None, tell: Tell = silent) -> Validated:
    """Check the constraints of a mission and its regions, and fly it without faults.

    ``mission`` may also be an ``.xmi`` file with a fault specification. ``tell`` receives the
    reason if the mission is not flown.
    """
    from m2t.models import load  # noqa: PLC0415 - slow
    from mrsfi_runtime.engine.region_lint import lint_regions  # noqa: PLC0415 - brings pyflakes

    if mission.endswith(".xmi"):
        return Validated(mission, load.inspect_specification(Path(mission)).diagnostics)
    folders = find_mission(mission, generated)
    inspection = load.inspect_folder(folders.models)
    models = inspection.diagnostics
    regions = lint_regions(folders.generated)
    if n_errors(models):
        return Validated(folders.name, models, regions)
    loaded = inspection.require_models()
    flown = () if n_errors(regions) else _flown(folders, loaded, tell)
    counts = {
        "robots": len(loaded.mission.robots),
        "obstacles": len(loaded.mission.obstacles),
        "goals": len(loaded.mission.goals),
        "messages": sum(len(goal.messages) for goal in loaded.mission.goals),
        "faults": len(loaded.pool),
    }
    return Validated(folders.name, models, (*flown, *regions), counts)


def mending(mission: str, generated: Path | None = None) -> "tuple[Inspection, Mending | None]":
    """Return the diagnostics of models, and the repairs of all that have one sensible remedy."""
    from m2t.models import fixes, load  # noqa: PLC0415 - slow

    inspection = (
        load.inspect_specification(Path(mission))
        if mission.endswith(".xmi")
        else load.inspect_folder(find_mission(mission, generated).models)
    )
    return inspection, fixes.mend(inspection)


def write_mended(mended: "Mending") -> None:
    """Write all repaired files or none; refuse if one changed since it was read."""
    with changing(mended.folder) as change:
        for path in mended.contents:
            if path.read_bytes() != mended.before[path]:
                raise UsageError(f"{path}: was changed since it was read; fix it again")
        change.replace(mended.contents)


def n_errors(diagnostics: Sequence[Diagnostic]) -> int:
    """Return the number of errors among diagnostics."""
    return sum(diagnostic.severity == "error" for diagnostic in diagnostics)


def _flown(folders: MissionFolders, loaded: "LoadedModels", tell: Tell) -> Iterator[Diagnostic]:
    """Fly the mission twice without faults; yield errors, and goals that are violated."""
    if loaded.mission.duration > _LONGEST_FLIGHT:
        tell(f"not flown without faults: it lasts more than {_LONGEST_FLIGHT} ticks")
        return
    try:
        code = load_fresh(folders, loaded)
        engine = ReferenceEngine(code, 1)
        outcome = engine.evaluate(())
        if engine.evaluate(()) != outcome:
            from mrsfi_runtime.engine.compiled.engine import unrepeated  # noqa: PLC0415 - numpy

            raise unrepeated(engine, ())
    except (EvaluationError, ReplayMismatch) as error:
        path, line = getattr(error, "line", None) or (folders.generated, 1)
        message = str(error).removeprefix(f"{path}:{line}: ")
        element = f"mission '{folders.name}'"
        yield Diagnostic(path, line, element, "MissionFlies", "error", message)
        return
    except MrsfiError as error:  # stale code is no defect of the models
        tell(f"not flown without faults: {error}")
        return
    yield from _uncompiled(code)
    mission = code.mission
    counts = zip(outcome.believed, outcome.true, outcome.missed, strict=True)
    for element, goal, (believed, true, missed) in zip(
        loaded.mission.goals, mission.goals, counts, strict=True
    ):
        if believed or true or missed:
            held = starvation(mission, goal)
            advice = "let it react before that one" if held else "make the goal easier"
            message = (
                f"goals '{goal.id}' is violated without faults, in belief at {believed} ticks, in "
                f"truth at {true}{', and fails' if missed else ''}{held and ', '}{held}; expected "
                f"none, so that a search finds effects of faults only; {advice} or its reaction "
                "better"
            )
            place = loaded.mission_path, loaded.nodes[element].line
            yield Diagnostic(*place, f"goals '{goal.id}'", "FaultFreeMission", "warning", message)


def _uncompiled(code: MissionCode) -> Iterator[Diagnostic]:
    """Yield the regions that cannot be compiled because they read values that cannot be listed."""
    for region in own_regions(code):
        try:
            Reached([region.function])
        except CompilationError as error:
            path, line = error.line or (code.directory, 1)
            message = str(error).removeprefix(f"{path}:{line}: ")
            place = from_here(path), line, region.function.__name__
            yield Diagnostic(*place, "RegionCompiles", "warning", message)
