"""The project file, the metamodels of a project, and the installed versions."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from mrsfi_runtime.errors import UsageError

SETTINGS, MISSION_XMI = "mrsfi.toml", "mission.xmi"
"""Files by which a project, and a folder of models, are known."""

FOLDERS = ("metamodels", "models", "generated", "runs")
DETECTIONS = ("never", "late", "in time")
"""How a collective intelligence may detect what breaks a goal, the worst first."""

CHOSEN = "MRSFI_METAMODELS"
"""Environment variable with the folder of the metamodels, for this process and those it starts."""


def root() -> Path:
    """Return the root of the project of the working folder."""
    here = Path.cwd()
    return next((place for place in (here, *here.parents) if (place / SETTINGS).is_file()), here)


def project_metamodels() -> Path | None:
    """Return the folder of the project's metamodels, if it has any.

    Settings that cannot be read, or name a folder without metamodels, are a ``UsageError``.
    """
    file = root() / SETTINGS
    named = settings(file)[0].get("metamodels") if file.is_file() else None
    folder = file.parent / (named or "metamodels")
    has_own = all((folder / name).is_file() for name in ("mission.ecore", "faults.ecore"))
    if named and not has_own:
        raise UsageError(
            f"{file}: found metamodels = '{named}'; expected a folder that has "
            "mission.ecore and faults.ecore"
        )
    return folder if has_own else None


def choose_metamodels() -> bool:
    """Let this process read the project's metamodels; return whether it has any to choose."""
    metamodels = None if CHOSEN in os.environ else project_metamodels()
    if metamodels is None:
        return False
    os.environ[CHOSEN] = str(metamodels.resolve())
    return True


@contextmanager
def metamodels_chosen() -> Iterator[None]:
    """Let the body read the project's metamodels, if it has any."""
    is_chosen = choose_metamodels()
    try:
        yield
    finally:
        if is_chosen:
            del os.environ[CHOSEN]


def _require_numbers(file: Path, table: dict[str, Any]) -> None:
    """Refuse a table [fmea] that gives other numbers than those of likelihoods and detections."""
    numbers, real = [str(number) for number in range(1, 11)], {int, float}
    rules: dict[str, tuple[Any, ...]] = {
        "occurrence": (numbers, real, 0, 1, "rising likelihoods 0 … 1 for numbers 1 to 10"),
        "detection": (DETECTIONS, {int}, 1, 10, f"1 to 10 for {', '.join(DETECTIONS)}"),
    }
    for name, given in table.items():
        if name not in rules:
            raise UsageError(f"{file}: [fmea]: found '{name}'; expected {' or '.join(rules)}")
        keys, kinds, low, high, wanted = rules[name]
        is_known = isinstance(given, dict) and {*given} <= {*keys}
        values: list[Any] = [given[key] for key in keys if key in given] if is_known else [None]
        is_valid = all(type(each) in kinds and low <= each <= high for each in values)
        if not is_valid or (keys is numbers and values != sorted({*values})):
            raise UsageError(f"{file}: [fmea]: found {name} = {given!r}; expected {wanted}")


def settings(file: Path) -> tuple[dict[str, Any], dict[str, Any] | None, dict[str, Any]]:
    """Return the tables [project], [node] and [fmea] of a settings file."""
    import tomllib  # noqa: PLC0415 - many projects have none

    try:
        document = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{file}: cannot be read: {error}; expected settings in TOML") from error
    table, node = document.get("project", {}), document.get("node")
    for name, found in document.items():
        if name not in {"project", "node", "fmea"} or not isinstance(found, dict):
            known = "expected the tables [project], [node] and [fmea]"
            raise UsageError(f"{file}: found '{name}'; {known}")
    for name, value in table.items():
        if name not in (*FOLDERS, "ros"):
            known = ", ".join((*FOLDERS, "ros"))
            raise UsageError(f"{file}: found '{name}'; expected one of {known}")
        if name in FOLDERS and (not isinstance(value, str) or not value):
            raise UsageError(f"{file}: found {name} = {value!r}; expected the name of a folder")
    _require_numbers(file, document.get("fmea", {}))
    return dict(table), node, document.get("fmea", {})


def installed_version(name: str) -> str:
    """Return the version of a distribution, or of python; mrsfi may be not installed."""
    import platform  # noqa: PLC0415 - as below
    from importlib import metadata  # noqa: PLC0415 - takes half as long as `mrsfi --help`

    if name == "python":
        return platform.python_version()
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"
