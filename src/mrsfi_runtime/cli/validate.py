"""The command ``mrsfi validate``."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import click

from m2t.diagnostics import Diagnostic
from m2t.fixes import mend
from m2t.load import (
    Inspection,
    LoadedModels,
    inspect_folder,
    inspect_specification,
    load_mission_folder,
)
from m2t.write.xmi import write_atomically
from mrsfi_runtime.cli.console import counted, print_json, tell
from mrsfi_runtime.cli.folders import (
    MissionFolders,
    find_mission,
)
from mrsfi_runtime.cli.loading import load_fresh
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.region_lint import lint_regions
from mrsfi_runtime.errors import EvaluationError, ModelError, MrsfiError, UsageError

_LONGEST_FLIGHT = 100_000
"""Ticks that a validation flies at most, which takes a few seconds."""


def validate(
    ctx: click.Context,
    mission: str,
    generated: Path | None,
    *,
    is_json: bool,
    is_fix: bool,
    is_agreed: bool,
) -> None:
    """Check the models of a mission and print every defect."""
    if is_fix and is_json:
        raise UsageError("--fix shows a diff and --json does not; give one of them")
    if is_agreed and not is_fix:
        raise UsageError("--yes agrees to what --fix would change; give both")
    if is_fix:
        _fix(_inspect(mission, generated), is_agreed=is_agreed)
    if mission.endswith(".xmi"):
        name, diagnostics, counts = mission, inspect_specification(Path(mission)).diagnostics, ""
        code: tuple[Diagnostic, ...] = ()
    else:
        folders = find_mission(mission, generated)
        name, diagnostics = folders.name, inspect_folder(folders.models).diagnostics
        code, counts = _of_code(folders, is_sound=not _n_errors(diagnostics))
    exit_code = ModelError.exit_code if _n_errors(diagnostics) else EvaluationError.exit_code
    diagnostics = (*diagnostics, *code)
    if is_json:
        print_json(_as_json(name, diagnostics))
    else:
        _print_lines(name, diagnostics, counts)
    if _n_errors(diagnostics):
        ctx.exit(exit_code)


def _inspect(mission: str, generated: Path | None) -> Inspection:
    if mission.endswith(".xmi"):
        return inspect_specification(Path(mission))
    return inspect_folder(find_mission(mission, generated).models)


def _fix(inspection: Inspection, *, is_agreed: bool) -> None:
    """Show what fixing would change, and write it if the user agrees."""
    mending = mend(inspection)
    if mending is None:
        why = "" if inspection.draft else ": correct the errors of structure by hand first"
        click.echo(f"nothing to fix{why}")
        return
    for found, title in mending.fixed:
        click.echo(f"{found.path}:{found.line}: fix: {title} [{found.constraint}]")
    for path in mending.respelt:
        click.echo(f"{path}: is not as Eclipse writes it; layout and comments will be lost")
    for line in mending.difference:
        click.echo(line)
    if not is_agreed and not click.confirm("Write these changes?"):
        click.echo("nothing written")
        return
    for path, new in mending.contents.items():
        write_atomically(path, new)
        click.echo(f"fixed      {path}")


def _n_errors(diagnostics: Sequence[Diagnostic]) -> int:
    return sum(1 for diagnostic in diagnostics if diagnostic.severity == "error")


def _as_json(name: str, diagnostics: Sequence[Diagnostic]) -> dict[str, object]:
    n_errors = _n_errors(diagnostics)
    return {
        "mission": name,
        "n_errors": n_errors,
        "n_warnings": len(diagnostics) - n_errors,
        "diagnostics": [{**asdict(found), "path": str(found.path)} for found in diagnostics],
    }


def _print_lines(name: str, diagnostics: Sequence[Diagnostic], counts: str) -> None:
    for found in diagnostics:
        click.echo(
            f"{found.path}:{found.line}: {found.severity}: {found.message} [{found.constraint}]"
        )
    n_errors = _n_errors(diagnostics)
    warnings = counted(len(diagnostics) - n_errors, "warnings")
    if n_errors:
        click.echo(f"{name}: {counted(n_errors, 'errors')}, {warnings}")
    else:
        click.echo(f"ok: {name}: {counts}{warnings}")


def _counts(loaded: LoadedModels) -> str:
    """Return how many elements the models hold, as the beginning of a sentence."""
    mission = loaded.mission
    counts = [
        counted(len(mission.robots), "robots"),
        counted(len(mission.obstacles), "obstacles"),
        counted(len(mission.goals), "goals"),
        counted(sum(len(goal.messages) for goal in mission.goals), "messages"),
        counted(len(loaded.pool), "faults"),
    ]
    return ", ".join(counts) + ", "


def _of_code(folders: MissionFolders, *, is_sound: bool) -> tuple[tuple[Diagnostic, ...], str]:
    """Return what is wrong with the generated code, and what the models hold if they are sound."""
    regions = tuple(
        Diagnostic(
            path=found.path,
            line=found.line,
            element=found.place,
            constraint=found.constraint,
            severity="error" if found.is_error else "warning",
            message=f"{found.place}: {found.message}",
        )
        for found in lint_regions(folders.generated)
    )
    if not is_sound:
        return regions, ""
    loaded = load_mission_folder(folders.models)
    flown = () if _n_errors(regions) else _flown(folders, loaded)
    return (*flown, *regions), _counts(loaded)


def _flown(folders: MissionFolders, loaded: LoadedModels) -> tuple[Diagnostic, ...]:
    """Fly the mission without faults; return where it fails, or each goal that is violated."""
    if loaded.mission.duration > _LONGEST_FLIGHT:
        tell(f"not flown without faults: it lasts more than {_LONGEST_FLIGHT} ticks")
        return ()
    try:
        outcome = ReferenceEngine(load_fresh(folders), 1).evaluate(())
    except EvaluationError as error:
        path, line = error.line or (folders.generated, 1)
        message = str(error).removeprefix(f"{path}:{line}: ")
        element = f"mission '{folders.name}'"
        return (Diagnostic(path, line, element, "MissionFlies", "error", message),)
    except MrsfiError as error:  # stale code is no defect of the models
        tell(f"not flown without faults: {error}")
        return ()
    return tuple(
        Diagnostic(
            path=loaded.mission_path,
            line=loaded.nodes[goal].line,
            element=f"goals '{goal.ID}'",
            constraint="FaultFreeMission",
            severity="warning",
            message=(
                f"goals '{goal.ID}' is violated without any fault, at {believed} ticks as "
                f"believed and {true} in truth; expected none, so that search sees the work of "
                "faults only; make the goal easier or its reaction better"
            ),
        )
        for goal, believed, true in zip(
            loaded.mission.goals, outcome.believed, outcome.true, strict=True
        )
        if believed or true
    )
