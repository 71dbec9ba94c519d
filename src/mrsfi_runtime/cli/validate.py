"""The command ``mrsfi validate``."""

from dataclasses import asdict
from pathlib import Path

import click

from mrsfi.validation import Validated, mending, n_errors, write_mended
from mrsfi.validation import validate as validated
from mrsfi_runtime.cli.console import counted, print_changes, print_json, tell
from mrsfi_runtime.cli.metamodels import tell_of_metamodels
from mrsfi_runtime.errors import EvaluationError, ModelError, UsageError


def validate(
    ctx: click.Context,
    mission: str,
    generated: Path | None,
    *,
    is_json: bool,
    is_fix: bool,
    is_agreed: bool,
    is_strict: bool,
) -> None:
    """Check the models of a mission and print every defect."""
    if is_fix and is_json:
        raise UsageError("--fix shows a diff and --json does not; give one of them")
    if is_agreed and not is_fix:
        raise UsageError("--yes agrees to what --fix would change; give both")
    tell_of_metamodels()
    if is_fix:
        _fix(mission, generated, is_agreed=is_agreed)
    found = validated(mission, generated, tell)
    if is_strict:
        found = found.strict()
    if is_json:
        print_json(_as_json(found))
    else:
        _print_lines(found)
    if n_errors(found.diagnostics):
        ctx.exit(ModelError.exit_code if n_errors(found.models) else EvaluationError.exit_code)


def _fix(mission: str, generated: Path | None, *, is_agreed: bool) -> None:
    """Show what fixing would change, and write it if the user agrees."""
    inspection, mended = mending(mission, generated)
    if mended is None:
        why = "" if inspection.draft else ": correct the errors of structure by hand first"
        click.echo(f"nothing to fix{why}")
        return
    for found, title in mended.fixed:
        click.echo(f"{found.path}:{found.line}: fix: {title} [{found.constraint}]")
    print_changes(mended.respelt, mended.difference)
    if not is_agreed and not click.confirm("Write these changes?"):
        click.echo("nothing written")
        return
    write_mended(mended)
    for path in mended.contents:
        click.echo(f"fixed      {path}")


def _as_json(found: Validated) -> dict[str, object]:
    errors = n_errors(found.diagnostics)
    return {
        "mission": found.name,
        "n_errors": errors,
        "n_warnings": len(found.diagnostics) - errors,
        "diagnostics": [{**asdict(each), "path": str(each.path)} for each in found.diagnostics],
    }


def _print_lines(found: Validated) -> None:
    for each in found.diagnostics:
        click.echo(f"{each.path}:{each.line}: {each.severity}: {each.message} [{each.constraint}]")
    errors = n_errors(found.diagnostics)
    warnings = counted(len(found.diagnostics) - errors, "warnings")
    if errors:
        click.echo(f"{found.name}: {counted(errors, 'errors')}, {warnings}")
    else:
        held = (counted(number, nouns) for nouns, number in found.counts.items())
        click.echo(f"ok: {found.name}: {', '.join((*held, warnings))}")
