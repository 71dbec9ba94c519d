"""Models: difference, import, requirements and writing, for the command line and for scripts."""

from collections.abc import Mapping
from filecmp import cmpfiles
from pathlib import Path
from typing import Any

from m2t.metamodels import FAULTS_FILE, MISSION_FILE, installed_metamodels, metamodel_folder
from m2t.models.difference import difference as difference  # noqa: PLC0414 - for importers, as below
from m2t.models.importing import Note as Note  # noqa: PLC0414
from m2t.models.importing import import_published as import_published  # noqa: PLC0414
from m2t.models.load import FAULTS_XMI, edited, load_mission_folder
from m2t.models.requirements import ReqifFile as ReqifFile  # noqa: PLC0414
from m2t.models.requirements import update
from m2t.models.write import dumps
from m2t.read import MAX_BYTES
from mrsfi_runtime.files import changing
from mrsfi_runtime.project_file import MISSION_XMI


def own_metamodels() -> Path | None:
    """Return the folder of the metamodels that are read if they differ from those of mrsfi."""
    read, ours = metamodel_folder(), installed_metamodels()
    names = (MISSION_FILE, FAULTS_FILE)  # an error is reported when they are read
    _, *others = cmpfiles(read, ours, names, shallow=False)
    return read if any(others) else None


def piped(pipe: Path, folder: Path) -> Path:
    """Write the content of a pipe, which can be read once, into a new folder; return the file."""
    folder.mkdir()
    file = folder / "pipe.xmi"
    with pipe.open("rb") as content:
        file.write_bytes(content.read(MAX_BYTES + 1))
    return file


def import_requirements(folder: Path, file: ReqifFile) -> Mapping[str, tuple[str, ...]]:
    """Add the requirements of a ReqIF file to the mission in a folder, or update them, and write.

    Return their IDs by what was done: ``added``, ``changed``, ``unchanged``, or ``kept`` although
    the file lacks them; and the files ``written``. A requirement that the model cannot have raises
    a ``ModelError``.
    """
    done: dict[str, tuple[str, ...]] = {}
    with changing(folder) as change:
        models = load_mission_folder(folder)
        edit = edited(models, lambda _: done.update(update(models.mission, file.requirements)))
        change.replace(edit.contents)
    return {**done, "written": tuple(map(str, edit.contents))}


def write_models(folder: Path | str, mission: Any, faults: Any) -> None:
    """Write models into a mission folder, as Eclipse would; replace those that are there.

    Parameters
    ----------
    folder
        Made if it is missing.
    mission, faults
        Roots, of the static classes of ``generated/metamodel``.

    Raises
    ------
    ModelError
        If an element refers to one outside both models.
    UsageError
        If the folder cannot be made or written.
    """
    place = Path(folder)
    with changing(place) as change:
        change.replace(
            {
                place / MISSION_XMI: dumps(mission),
                place / FAULTS_XMI: dumps(faults, hrefs={mission: MISSION_XMI}),
            }
        )
