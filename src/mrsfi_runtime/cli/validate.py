"""The command ``mrsfi validate``."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi_runtime.cli.console import print_changes, print_json, tell
from mrsfi_runtime.cli.options import generated_option, mission_argument, tell_of_metamodels
from mrsfi_runtime.errors import EvaluationError, ModelError, UsageError, counted

if TYPE_CHECKING:
    from mrsfi.loading import Validated


@click.command(name="validate")
@mission_argument
@generated_option
@click.option("--json", "is_json", is_flag=True, help="Print the diagnostics for a script.")
@click.option("--fix", "is_fix", is_flag=True, help="Mend what has one remedy; show a diff first.")
@click.option("--yes", "is_agreed", is_flag=True, help="With --fix: write without asking.")
@click.option("--strict", "is_strict", is_flag=True, help="Take warnings for errors.")
@click.pass_context
def command(
    ctx: click.Context,
    /,
    mission: str,
    generated: Path | None,
    *,
    is_json: bool,
    is_fix: bool,
    is_agreed: bool,
    is_strict: bool,
) -> None:
    """Check the models of MISSION and print every defect.

    MISSION is the name of a folder in models/, the path of one, or a fault specification
    (.xmi), written by hand or found by search.

    \b
    Examples:
      mrsfi validate uuv_sampling
      mrsfi validate ../elsewhere/models/harbour
      mrsfi validate runs/uuv_sampling-a-1/critical/01.xmi
      mrsfi validate uuv_sampling --json | jq '.diagnostics[].constraint'
      mrsfi validate uuv_sampling --fix

    Each defect is one line: file, line, severity, what was found and what was expected, and
    the constraint. Errors of the models end with exit code 3, those of the generated code's
    regions alone with 6, warnings alone with 0, or as if they were errors with --strict. A name
    or a field that does not exist is such an error, whether or not a flight reaches it. A mission
    without errors is flown twice without faults, if its generated code is fresh: a flight that
    fails or differs is an error too, a goal that is violated even then is worth a warning. So is
    what the compiled engine could not compile in a region, or would compile to something else.

    With --fix, what has one sensible remedy is mended first: the change is shown as a diff, and
    written once you agree (--yes agrees in advance). Files are written as Eclipse writes them.
    Where an element was deleted, that takes away the references to it and what is incomplete
    without it.
    """
    from mrsfi.loading import n_errors, validate

    if is_fix and is_json:
        raise UsageError("--fix shows a diff and --json does not; give one of them")
    if is_agreed and not is_fix:
        raise UsageError("--yes agrees to what --fix would change; give both")
    tell_of_metamodels()
    if is_fix:
        _fix(mission, generated, is_agreed=is_agreed)
    found = validate(mission, generated, tell)
    if is_strict:
        found = found.strict()
    n_found = n_errors(found.diagnostics)
    n_warnings = len(found.diagnostics) - n_found
    if is_json:
        diagnostics = [{**asdict(each), "path": str(each.path)} for each in found.diagnostics]
        counts = {"n_errors": n_found, "n_warnings": n_warnings}
        print_json({"mission": found.name, **counts, "diagnostics": diagnostics})
    else:
        _print_lines(found, n_found, n_warnings)
    if n_found:
        ctx.exit(ModelError.exit_code if n_errors(found.models) else EvaluationError.exit_code)


def _fix(mission: str, generated: Path | None, *, is_agreed: bool) -> None:
    from mrsfi.loading import mending, write_mended

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


def _print_lines(found: "Validated", n_found: int, n_warnings: int) -> None:
    for each in found.diagnostics:
        click.echo(f"{each.path}:{each.line}: {each.severity}: {each.message} [{each.constraint}]")
    warnings = counted(n_warnings, "warnings")
    if n_found:
        click.echo(f"{found.name}: {counted(n_found, 'errors')}, {warnings}")
    else:
        held = (counted(number, nouns) for nouns, number in found.counts.items())
        click.echo(f"ok: {found.name}: {', '.join((*held, warnings))}")
