"""Where a team's project keeps its models, generated code, campaigns and metamodels.

A file ``mrsfi.toml`` at the root of a project says so; commands find it from any folder inside::

    [project]
    metamodels = "metamodels"
    models = "models"
    generated = "generated"
    runs = "runs"
    ros = 1

What it leaves out has these values. Without such a file the working folder is the root. A second
table, ``[node]``, says what a team's own node hears and says (``cosimulation.node.mapping``).
"""

import os
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.transport.dialect import ROS_VERSIONS

SETTINGS = "mrsfi.toml"
_FOLDERS = ("metamodels", "models", "generated", "runs")
_METAMODELS = ("mission.ecore", "faults.ecore")
_CHOSEN = "MRSFI_METAMODELS"
"""Environment variable with the folder of the metamodels, for this process and those it starts."""


@dataclass(frozen=True, slots=True)
class Project:
    """The folders of a project, each as short as a user would write it.

    ``metamodels`` are those of the team; ``None`` if the project has none. ``ros`` is the version
    of ROS that its rosbridge server speaks, ``node`` what it says of its own node.
    """

    models: Path
    generated: Path
    runs: Path
    metamodels: Path | None
    ros: int
    node: Mapping[str, Any] | None


def project() -> Project:
    """Return the project that the working folder is in.

    Settings that cannot be read, or that mean nothing, are a ``UsageError``.
    """
    file = root() / SETTINGS
    given, node = _settings(file) if file.is_file() else ({}, None)
    found = {name: from_here(file.parent / given.get(name, name)) for name in _FOLDERS}
    metamodels = found["metamodels"]
    has_own = all((metamodels / name).is_file() for name in _METAMODELS)
    if "metamodels" in given and not has_own:
        raise UsageError(
            f"{file}: found metamodels = '{given['metamodels']}'; expected a folder that has "
            f"{' and '.join(_METAMODELS)}"
        )
    return Project(
        found["models"],
        found["generated"],
        found["runs"],
        metamodels if has_own else None,
        given.get("ros", 1),
        node,
    )


def root() -> Path:
    """Return the root of the project that the working folder is in."""
    here = Path.cwd()
    return next((place for place in (here, *here.parents) if (place / SETTINGS).is_file()), here)


def choose_metamodels() -> bool:
    """Let this process read the metamodels of the project; return whether it has any to choose."""
    metamodels = None if _CHOSEN in os.environ else project().metamodels
    if metamodels is None:
        return False
    os.environ[_CHOSEN] = str(metamodels.resolve())
    return True


@contextmanager
def metamodels_chosen() -> Iterator[None]:
    """Let everything in the body read the metamodels of the project, if it has any of its own."""
    is_chosen = choose_metamodels()
    try:
        yield
    finally:
        if is_chosen:
            del os.environ[_CHOSEN]


def _settings(file: Path) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Return what a settings file says, name by name, and its node."""
    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{file}: cannot be read: {error}; expected settings in TOML") from error
    table, node = document.get("project", {}), document.get("node")
    for name, found in document.items():
        if name not in {"project", "node"} or not isinstance(found, dict):
            raise UsageError(f"{file}: found '{name}'; expected the tables [project] and [node]")
    for name, value in table.items():
        _require(file, name, value)
    return dict(table), node


def _require(file: Path, name: str, value: Any) -> None:
    """Refuse a setting that means nothing."""
    if name == "ros":
        if type(value) is not int or value not in ROS_VERSIONS:
            raise UsageError(f"{file}: found ros = {value!r}; expected 1 or 2")
    elif name not in _FOLDERS:
        expected = ", ".join((*_FOLDERS, "ros"))
        raise UsageError(f"{file}: found '{name}'; expected one of {expected}")
    elif not isinstance(value, str) or not value:
        raise UsageError(f"{file}: found {name} = {value!r}; expected the name of a folder")


def from_here(path: Path) -> Path:
    """Return a path as short as a user would write it: relative, unless that is no shorter way."""
    relative = Path(os.path.relpath(path))
    return relative if len(relative.parts) < len(path.parts) else path
