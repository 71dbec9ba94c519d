"""The command ``mrsfi diff``."""

from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from mrsfi.models import difference, piped
from mrsfi.project import project
from mrsfi_runtime.cli.console import print_json
from mrsfi_runtime.errors import UsageError


def diff(old: str, new: str, *, is_json: bool) -> None:
    """Print how a model differs from an older one."""
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
    """Return the path of a model: a file, or a mission folder by path or by name.

    What comes from a pipe, which can be read once and is no file, is kept in a folder.
    """
    for path in (Path(name), project().models / name):
        if path.is_fifo():
            return piped(path, kept)
        if path.exists():
            return path
    raise UsageError(
        f"found no model '{name}'; expected a mission folder, its name, or an .xmi file"
    )
