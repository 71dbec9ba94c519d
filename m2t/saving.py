"""Save loaded models: every file as Eclipse would, and only what changed."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

from m2t.line_difference import unified_difference
from m2t.load import LoadedFile, LoadedModels
from m2t.write.xmi import dumps_file
from mrsfi_runtime.files import changing


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
            file.roots,
            file.spelling,
            hrefs=addresses(models, file.path.parent, without=file),
            xmi_ids=xmi_ids,
        )
        for file in models.files
    }


def difference(
    models: LoadedModels, old: Mapping[Path, bytes], new: Mapping[Path, bytes]
) -> Iterator[str]:
    """Yield the lines of the unified diff of files, each read in its own encoding."""
    for file in models.files:
        if file.path in new:
            before, after = (
                versions[file.path].decode(file.spelling.encoding, "replace").splitlines()
                for versions in (old, new)
            )
            yield from unified_difference(before, after, str(file.path), str(file.path), "")


def addresses(
    models: LoadedModels, folder: Path, *, without: LoadedFile | None = None
) -> Mapping[Any, str]:
    """Return the relative address of every file of loaded models, by its root objects.

    ``folder`` is that of the file that refers, and ``without`` the one that is left out: itself.
    """
    here = folder.resolve()
    return {
        root: quote(Path(os.path.relpath(file.path.resolve(), here)).as_posix())
        for file in models.files
        if file is not without
        for root in file.roots
    }
