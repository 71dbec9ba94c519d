"""Save loaded models: every file as Eclipse would, and only what changed."""

from collections.abc import Callable, Container, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from m2t.line_difference import unified_difference
from m2t.load import LoadedFile, LoadedModels
from m2t.write.xmi import dumps_file
from mrsfi_runtime.files import changing


@dataclass(frozen=True, slots=True)
class Edit:
    """What an edit of loaded models changes in their files; nothing is written.

    ``contents`` and ``before`` have the files that change, ``difference`` their unified diff.
    ``respelt`` change beyond the edit, as they are not spelt as Eclipse writes them. ``folder`` is
    that of the mission.
    """

    folder: Path
    contents: Mapping[Path, bytes]
    before: Mapping[Path, bytes]
    difference: tuple[str, ...]
    respelt: tuple[Path, ...]


def save(models: LoadedModels) -> tuple[Path, ...]:
    """Write loaded models back to their files, all of them or none; return those that changed.

    Models that cannot be saved are a ``ModelError``, files that cannot be written a ``UsageError``.
    """
    contents = saved(models)
    changed = {path: new for path, new in contents.items() if path.read_bytes() != new}
    with changing(models.mission_path.parent) as change:
        change.replace(changed)
    return tuple(changed)


def saved(models: LoadedModels) -> dict[Path, bytes]:
    """Return the content of each file that saving would write, in the order of reading.

    Every file keeps its encoding, its line ends, its xsi:schemaLocation, its roots and the xmi:ids
    of its elements; new elements get none. Comments are dropped, as Eclipse does. A model that
    refers to an object outside the files, or holds a character that XML cannot, is a
    ``ModelError``.
    """
    xmi_ids = models.xmi_ids
    return {
        file.path: dumps_file(
            file.roots, file.spelling, addresses(models, file.path.parent, without=file), xmi_ids
        )
        for file in models.files
    }


def edited(
    models: LoadedModels,
    edit: Callable[[LoadedModels], object],
    *,
    loaded: Container[Path] = (),
    without: Container[Path] = (),
) -> Edit:
    """Carry out an edit of the objects of models, and return what it changes.

    ``loaded`` are files of which loading has left out something already, ``without`` resolved
    paths of files that somebody else sees to.
    """
    unedited = saved(models)
    before = {path: path.read_bytes() for path in unedited}
    edit(models)
    contents = {
        path: new
        for path, new in saved(models).items()
        if new != before[path]
        and (path in loaded or new != unedited[path])
        and path.resolve() not in without
    }
    respelt = [path for path in contents if path not in loaded and unedited[path] != before[path]]
    lines: list[str] = []
    for file in models.files:
        if (path := file.path) in contents:
            versions = (before[path], contents[path])
            old, new = (each.decode(file.spelling.encoding, "replace") for each in versions)
            named = str(path)
            lines += unified_difference(old.splitlines(), new.splitlines(), named, named, "")
    return Edit(models.mission_path.parent, contents, before, tuple(lines), tuple(respelt))


def addresses(
    models: LoadedModels, folder: Path, *, without: LoadedFile | None = None
) -> Mapping[Any, str]:
    """Return the relative address of every file of loaded models, by its root objects.

    ``folder`` is that of the file that refers, and ``without`` the one that is left out: itself.
    """
    return {
        root: quote(file.seen_from(folder))
        for file in models.files
        if file is not without
        for root in file.roots
    }
