"""The command ``mrsfi import``."""

import re
from collections.abc import Iterator
from dataclasses import asdict
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mrsfi.models import import_published
from mrsfi.project import project
from mrsfi_runtime.cli.console import counted, print_json

if TYPE_CHECKING:
    from mrsfi.models import Imported, Note

_SHOWN_LINES = 8
_NOT_NAME = re.compile(r"[^A-Za-z0-9_.-]+", re.ASCII)


def import_model(file: Path, out: Path | None, *, force: bool, is_json: bool) -> None:
    """Turn a model published for the paper's prototype into a mission folder."""
    result = import_published(file, out or _usual_folder(file), is_forced=force)
    if is_json:
        print_json(_as_json(result))
        return
    for name in result.files:
        click.echo(f"written       {result.folder / name}")
    counts = ", ".join(counted(n, noun) for noun, n in result.counts.items())
    click.echo(f"kept          {counts}")
    click.echo(f"renamed       {counted(result.n_xmi_ids, 'xmi:ids')}, now IDs or places")
    for line in _lines(result.notes):
        click.echo(line)
    click.echo(f"next          mrsfi validate {result.folder}")


def _usual_folder(file: Path) -> Path:
    return project().models / (_NOT_NAME.sub("_", file.stem).strip("_.-") or "imported")


def _as_json(result: "Imported") -> dict[str, Any]:
    return {
        "folder": str(result.folder),
        "files": list(result.files),
        "counts": dict(result.counts),
        "n_xmi_ids": result.n_xmi_ids,
        "notes": [asdict(note) for note in result.notes],
    }


def _lines(notes: "tuple[Note, ...]") -> Iterator[str]:
    """Yield a line for each note, or for all notes that say the same."""

    def saying(note: "Note") -> tuple[str, str, str]:
        return note.kind, note.feature, note.message

    order = {key: position for position, key in enumerate(dict.fromkeys(map(saying, notes)))}
    for key, group in groupby(sorted(notes, key=lambda note: order[saying(note)]), saying):
        kind, feature, message = key
        same = list(group)
        if len(same) == 1:
            where = f"line {same[0].line}, {same[0].element}: {feature}"
        else:
            lines = ", ".join(str(note.line) for note in same[:_SHOWN_LINES])
            more = ", ..." if len(same) > _SHOWN_LINES else ""
            where = f"{feature} of {len(same)} elements (lines {lines}{more})"
        yield f"{kind:<12}  {where} {message}"
