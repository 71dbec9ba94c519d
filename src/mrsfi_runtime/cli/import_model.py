"""The command ``mrsfi import``."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mrsfi_runtime.cli.console import print_json
from mrsfi_runtime.errors import counted

if TYPE_CHECKING:
    from mrsfi.models import Note

_SHOWN_LINES = 8
_NOT_NAME = re.compile(r"[^A-Za-z0-9_.-]+", re.ASCII)


@click.command(name="import")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path, exists=True))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Mission folder to make [default: models/ and the name of FILE].",
)
@click.option("--force", is_flag=True, help="Replace the models of an existing mission folder.")
@click.option("--json", "is_json", is_flag=True, help="Print the result for a script.")
def command(file: Path, out: Path | None, force: bool, is_json: bool) -> None:
    """Turn FILE, a model published for the paper's prototype, into a mission folder.

    FILE has a root Setup of namespace acs_project_setup, which holds a mission and its fault
    specifications. Every figure and reference is kept; xmi:id gives way to readable IDs: the
    element's own where it can be used, else one from its place, such as g1_area. The result is
    validated before anything is written; a model with an error ends with exit code 3, the line of
    FILE, and no folder.

    \b
    Examples:
      mrsfi import ~/downloads/mission.model
      mrsfi import published.xmi --out models/harbour
      mrsfi import published.xmi --out models/harbour --force     replace its models
      mrsfi import published.xmi --json | jq '.notes[] | select(.kind == "inconsistent")'

    \b
    What it lists, with the line of FILE:
      renamed       an ID that was missing, unusable or taken
      dropped       what the models here do not have: parentID, goal_ID, values of Zero types
      default       what the old format lacks or leaves out: the period of Patrol (a tenth of the
                    mission), the deadline of Visit (the last tick) and its tolerance (1.0), the
                    tolerance of Track (10.0) and of FixedDistanceBetweenRobots (1.0); an absent
                    number is 0, an absent sensor type GPS_POSITION
      inconsistent  what contradicts the rest of FILE, and every warning of `mrsfi validate`

    A FILE without fault specifications gets an empty faults.xmi, in which a search needs faults
    first. Also written: case_a.toml, and case_b.toml if there are goals for it, unless they exist.
    """
    from mrsfi.engines import project
    from mrsfi.models import import_published

    usual = project().models / (_NOT_NAME.sub("_", file.stem).strip("_.-") or "imported")
    result = import_published(file, out or usual, is_forced=force)
    if is_json:
        print_json({**asdict(result), "folder": str(result.folder)})
        return
    for name in result.files:
        click.echo(f"written       {result.folder / name}")
    counts = ", ".join(counted(n, noun) for noun, n in result.counts.items())
    click.echo(f"kept          {counts}")
    click.echo(f"renamed       {counted(result.n_xmi_ids, 'xmi:ids')}, now IDs or places")
    for line in _lines(result.notes):
        click.echo(line)
    click.echo(f"next          mrsfi validate {result.folder}")


def _lines(notes: "tuple[Note, ...]") -> Iterator[str]:
    alike: defaultdict[tuple[str, str, str], list[Note]] = defaultdict(list)
    for note in notes:
        alike[note.kind, note.feature, note.message].append(note)
    for (kind, feature, message), same in alike.items():
        if len(same) == 1:
            where = f"line {same[0].line}, {same[0].element}: {feature}"
        else:
            lines = ", ".join(str(note.line) for note in same[:_SHOWN_LINES])
            more = ", ..." if len(same) > _SHOWN_LINES else ""
            where = f"{feature} of {len(same)} elements (lines {lines}{more})"
        yield f"{kind:<12}  {where} {message}"
