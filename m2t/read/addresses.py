"""Which file of the project a reference means.

Notes
-----
References never leave the project, which is the tree of the folder of the model's first file, or
that of the nearest folder above it with a ``.project`` file. ``platform:/resource/NAME/rest`` is
``rest`` in the project NAME: the nearest folder, from the referring file upwards, that has that
name or whose ``.project`` file gives it.
"""

from pathlib import Path
from urllib.parse import unquote, urlsplit

from m2t.diagnostics import Report
from m2t.read.nodes import read_xml

_PROJECT = ".project"


def local_path(folder: Path, address: str) -> Path | None:
    """Return the path that the file part of a reference means.

    Parameters
    ----------
    folder
        Folder of the file that refers.
    address
        What stands before the ``#``: a relative address, or ``platform:/resource/NAME/...``.

    Returns
    -------
    Path or None
        The path; ``None`` if the address is absolute, remote, or of an unknown project.
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

    Parameters
    ----------
    folder
        Folder of the file that refers.
    first
        Folder of the file that the model begins in.
    address
        As for ``local_path``.
    """
    path = local_path(folder, address)
    if path is None:
        return None
    scopes = [first, _project_above(first)]
    if address.startswith("platform:"):
        name = _platform_parts(unquote(urlsplit(address).path))[1]
        scopes.append(_named_project(folder, name))
    target = resolved_path(path)
    is_inside = any(
        scope is not None and target.is_relative_to(scope.resolve()) for scope in scopes
    )
    return path if is_inside else None


def _platform_path(folder: Path, path: str) -> Path | None:
    kind, name, inside = _platform_parts(path)
    if kind != "resource" or not inside or ".." in inside.split("/"):
        return None
    project = _named_project(folder, name)
    return None if project is None else project / inside


def _platform_parts(path: str) -> tuple[str, str, str]:
    """Return the three parts of ``/resource/NAME/rest``."""
    kind, _, rest = path.removeprefix("/").partition("/")
    name, _, inside = rest.partition("/")
    return kind, name, inside.lstrip("/")


def _named_project(folder: Path, name: str) -> Path | None:
    if not name:
        return None
    here = folder.resolve()
    for candidate in (here, *here.parents):
        if candidate.name == name or _declared_name(candidate) == name:
            return candidate
    return None


def _project_above(folder: Path) -> Path | None:
    here = folder.resolve()
    return next((place for place in (here, *here.parents) if (place / _PROJECT).is_file()), None)


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
