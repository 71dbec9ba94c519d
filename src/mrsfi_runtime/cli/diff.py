"""The command ``mrsfi diff``."""

from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from mrsfi_runtime.cli.console import print_json
from mrsfi_runtime.errors import UsageError


@click.command(name="diff")
@click.argument("old", metavar="OLD")
@click.argument("new", metavar="NEW")
@click.option("--json", "is_json", is_flag=True, help="Print the changes for a script.")
def command(old: str, new: str, is_json: bool) -> None:
    """Print how model NEW differs from model OLD, in the words of the model.

    OLD and NEW are mission folders, or files of a mission or of faults. Elements are matched by
    ID, and by what they say where one was renamed; what only looks different (order of
    attributes, comments, 4 for 4.0) is no difference. The models need not be valid.

    \b
    Examples:
      mrsfi diff uuv_sampling tight_margins
      mrsfi diff models/uuv_sampling ../elsewhere/models/uuv_sampling
      git show HEAD:models/uuv_sampling/mission.xmi > old.xmi
      mrsfi diff old.xmi models/uuv_sampling/mission.xmi
      mrsfi diff old.xmi uuv_sampling --json | jq '.changes[].element'

    \b
    What it prints:
      robot r2: speed 4.0 → 6.0
      goal g3: members r2 r3 r1 → r2 r3
      goal g7 added (Patrol)
      sensor s4 moved from robot r2 to robot r1
      robot r1 renamed scout
      goals reordered: g1 g2 g3 → g2 g1 g3
      fault f9: NEW_X 200.0 → 250.0

    Order is that of NEW, mission before faults. Equal models give `no difference`. The exit code
    is 0 either way.
    """
    from mrsfi.models import difference

    with TemporaryDirectory(prefix="mrsfi-diff-") as kept:
        changes = difference(_model(old, Path(kept) / "old"), _model(new, Path(kept) / "new"))
    if is_json:
        print_json({"old": old, "new": new, "changes": [asdict(change) for change in changes]})
        return
    for change in changes:
        click.echo(change.text)
    if not changes:
        click.echo("no difference")


def _model(name: str, kept: Path) -> Path:
    from mrsfi.engines import project
    from mrsfi.models import piped

    for path in (Path(name), project().models / name):
        if path.is_fifo():
            return piped(path, kept)
        if path.exists():
            return path
    raise UsageError(
        f"found no model '{name}'; expected a mission folder, its name, or an .xmi file"
    )
