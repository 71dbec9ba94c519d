"""The command ``mrsfi diff``."""

from dataclasses import asdict
from pathlib import Path

import click

from m2t.difference import difference
from mrsfi_runtime.cli.console import print_json
from mrsfi_runtime.errors import UsageError

_MODELS = Path("models")


def diff(old: str, new: str, *, is_json: bool) -> None:
    """Print how a model differs from an older one."""
    changes = difference(_model(old), _model(new))
    if is_json:
        print_json({"old": old, "new": new, "changes": [asdict(change) for change in changes]})
        return
    for change in changes:
        click.echo(change.text)
    if not changes:
        click.echo("no difference")


def _model(name: str) -> Path:
    """Return the path of a model: a file, or a mission folder by path or by name."""
    for path in (Path(name), _MODELS / name):
        if path.exists():
            return path
    raise UsageError(
        f"found no model '{name}'; expected a mission folder, its name, or an .xmi file"
    )
