"""Which file of the project a reference means.

Notes
-----
References never leave the project, which is the tree of the folder of the model's first file, or
that of the nearest folder above it with a ``.project`` file. ``platform:/resource/NAME/rest`` is
``rest`` in the project NAME: the nearest folder, from the referring file upwards, that has that
name or whose ``.project`` file gives it.
"""

from collections.abc import Callable
from pathlib import Path
from urllib.parse import unquote, urlsplit

from m2t.diagnostics import Report
from m2t.read.nodes import read_xml

_PROJECT = ".project"


def local_path(folder: Path, address: str) -> Path | None:
    """Return the path that the file part of a reference from a folder means.

    It is what stands before the ``#``: a relative address, or ``platform:/resource/NAME/...``; an
    address that is absolute, remote, or of an unknown project means none.
    """
    try:
        parts = urlsplit(address)
    except ValueError:
        return None
    path = unquote(parts.path)
    if parts.netloc or parts.query or "\x00" in path:
        return None
    if parts.scheme == "platform":
        return _platform_path(folder, path)
    if parts.scheme or path.startswith("/"):
        return None
    return folder / path


def contained_path(folder: Path, first: Path, address: str) -> Path | None:
    """Return the path of a part of a model; ``None`` if it lies outside the model's project.

    ``folder`` is that of the file that refers, ``first`` that of the file that the model begins in.
    """
    path = local_path(folder, address)
    if path is None:
        return None
    scopes = [first, _nearest(first, lambda place: (place / _PROJECT).is_file())]
    if address.startswith("platform:"):
        scopes.append(_project(folder, unquote(urlsplit(address).path)))
    target = resolved_path(path)
    is_inside = any(scope and target.is_relative_to(scope.resolve()) for scope in scopes)
    return path if is_inside else None


def _platform_path(folder: Path, path: str) -> Path | None:
    """Return the path that ``/resource/NAME/rest`` means."""
    kind, _, rest = path.removeprefix("/").partition("/")
    inside = rest.partition("/")[2].lstrip("/")
    project = _project(folder, path)
    if kind != "resource" or project is None or not inside or ".." in inside.split("/"):
        return None
    return project / inside


def _project(folder: Path, path: str) -> Path | None:
    """Return the folder of the project that ``/resource/NAME/rest`` names."""
    name = path.removeprefix("/").partition("/")[2].partition("/")[0]
    if not name:
        return None
    return _nearest(folder, lambda place: place.name == name or _declared_name(place) == name)


def _nearest(folder: Path, is_wanted: Callable[[Path], bool]) -> Path | None:
    """Return the nearest folder of a kind, from a folder upwards."""
    here = folder.resolve()
    return next((place for place in (here, *here.parents) if is_wanted(place)), None)


def _declared_name(folder: Path) -> str | None:
    """Return the name that the ``.project`` file of a folder gives, if there is one."""
    path = folder / _PROJECT
    if not path.is_file():
        return None
    xml = read_xml(path, Report())
    names = [] if xml is None else xml.root.tagged("name")
    return names[0].text.strip() if names else None


def resolved_path(path: Path) -> Path:
    """Return a path without links; an endless link stays as it is and fails when it is read."""
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path.absolute()
