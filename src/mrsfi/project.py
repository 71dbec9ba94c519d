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
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.project_file import SETTINGS, project_metamodels, root, settings
from mrsfi_runtime.transport.topics import ROS_VERSIONS


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
    given, node = settings(file) if file.is_file() else ({}, None)
    ros, own = given.get("ros", 1), project_metamodels()
    if type(ros) is not int or ros not in ROS_VERSIONS:
        raise UsageError(f"{file}: found ros = {ros!r}; expected 1 or 2")
    models, generated, runs = (
        from_here(file.parent / given.get(name, name)) for name in ("models", "generated", "runs")
    )
    return Project(models, generated, runs, own and from_here(own), ros, node)


def from_here(path: Path) -> Path:
    """Return a path as short as a user would write it: relative, unless that is no shorter way."""
    relative = Path(os.path.relpath(path))
    return relative if len(relative.parts) < len(path.parts) else path
