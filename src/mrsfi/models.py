"""What m2t does with models and says of them, for the command line and for scripts."""

from pathlib import Path
from typing import Any

from m2t.difference import Change, difference
from m2t.generate import diff as generation_difference
from m2t.generate import generate
from m2t.importing.importer import Imported, import_published
from m2t.importing.notes import Note
from m2t.read.nodes import MAX_BYTES
from m2t.write.xmi import dumps, write_atomically
from mrsfi_runtime.errors import UsageError

__all__ = [
    "MAX_BYTES",
    "Change",
    "Imported",
    "Note",
    "difference",
    "generate",
    "generation_difference",
    "import_published",
    "write_models",
]


def write_models(folder: Path | str, mission: Any, faults: Any) -> None:
    """Write models into a mission folder, as Eclipse would, in place of those that stand there.

    Parameters
    ----------
    folder
        Made if it is missing.
    mission, faults
        Roots, of the static classes of ``generated/metamodel``.

    Raises
    ------
    ModelError
        If an element refers to one that is in neither model.
    UsageError
        If the folder cannot be made or written.
    """
    place = Path(folder)
    contents = {
        "mission.xmi": dumps(mission),
        "faults.xmi": dumps(faults, hrefs={mission: "mission.xmi"}),
    }
    try:
        place.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            write_atomically(place / name, content)
    except OSError as error:
        raise UsageError(f"{place}: cannot be written: {error.strerror}") from error
