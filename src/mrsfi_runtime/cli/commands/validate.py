"""What ``mrsfi validate`` takes."""

from typing import Any

import click

from mrsfi_runtime.cli.commands.missions import generated_option, mission_argument

_HELP = """Check the models of MISSION and print every defect.

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
without errors is flown once without faults, if its generated code is fresh: a flight that
fails is an error too, a goal that is violated even then is worth a warning. So is what the
compiled engine could not compile in a region, or would compile to something else.

With --fix, what has one sensible remedy is mended first: the change is shown as a diff, and
written once you agree (--yes agrees in advance). Files are written as Eclipse writes them.
Where an element was deleted, that takes away the references to it and what is incomplete
without it.
"""


@click.command(name="validate", help=_HELP)
@mission_argument
@generated_option
@click.option("--json", "is_json", is_flag=True, help="Print the diagnostics for a script.")
@click.option("--fix", "is_fix", is_flag=True, help="Mend what has one remedy; show a diff first.")
@click.option("--yes", "is_agreed", is_flag=True, help="With --fix: write without asking.")
@click.option("--strict", "is_strict", is_flag=True, help="Take warnings for errors.")
@click.pass_context
def command(ctx: click.Context, /, **given: Any) -> None:
    """Check the models of a mission and print every defect."""
    from mrsfi_runtime.cli.validate import validate

    validate(ctx, **given)
