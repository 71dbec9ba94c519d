"""Functions that a team wrote for its search, named ``module:function`` in a campaign file.

Modules are found where Python looks, and in the current folder. What goes wrong in them is
told by file and line, as a mistake in what was given, not as a defect of mrsfi.
"""

import importlib
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.fence import fenced, words
from mrsfi_runtime.record.settings import CampaignSettings

T = TypeVar("T")

_NOT_WRITTEN_HERE = (
    str(Path(__file__).parents[1]),
    str(Path(importlib.__file__).parents[1]),
    sys.prefix,
    "<",
)
"""Where code lies that no team wrote: this package, Python's library, installed packages."""


def chosen(settings: CampaignSettings, key: str, table: Mapping[str, T]) -> T:
    """Return the entry of a table that a setting names, or the function of a user's module."""
    name = getattr(settings, key)
    where = settings.where(key)
    if ":" in name:
        return cast("T", user_function(name, where))
    if name not in table:
        known = expected(name, table, "'module:function' or one of")
        raise UsageError(f"{where}: found '{name}'; {known}")
    return table[name]


def user_function(name: str, where: str) -> Callable[..., Any]:
    """Return the function that ``module:function`` names; ``where`` is the file and key that do."""
    module_name, _, attribute = name.partition(":")
    if not all(part.isidentifier() for part in (*module_name.split("."), attribute)):
        raise UsageError(
            f"{where}: found '{name}'; expected 'module:function', such as 'my_search:creep'"
        )
    module = _imported(module_name, f"{where}: found '{name}'")
    found: Callable[..., Any] | None = getattr(module, attribute, None)
    if not callable(found):
        functions = [
            key
            for key, value in vars(module).items()
            if callable(value) and getattr(value, "__module__", None) == module.__name__
        ]
        known = ", ".join(functions) or "none"
        raise UsageError(
            f"{where}: found '{name}'; expected a function of {module.__file__}, which has: {known}"
        )
    return told_by_line(f"{where}: '{name}'")(found)


@contextmanager
def told_by_line(where: str) -> Iterator[None]:
    """Turn whatever a body or function raises into a ``UsageError`` with file and line."""

    def told(error: BaseException) -> UsageError:
        said = f"{type(error).__name__}: {words(error)}"
        return UsageError(f"{where} failed at {_place(error)}: {said}; correct it there")

    with fenced(told):
        yield


def _imported(name: str, where: str) -> ModuleType:
    folder = str(Path.cwd())
    sys.path.insert(0, folder)
    try:
        with told_by_line(f"{where}; its module"):
            return importlib.import_module(name)
    except UsageError as error:
        missing = error.__cause__
        if isinstance(missing, ModuleNotFoundError) and missing.name == name.partition(".")[0]:
            raise UsageError(
                f"{where}; expected a module '{name}' in the current folder, {folder}, or on "
                "Python's path; set PYTHONPATH to its folder"
            ) from error
        raise
    finally:
        sys.path.remove(folder)


def _place(error: BaseException) -> str:
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    written = [frame for frame in frames if not frame.filename.startswith(_NOT_WRITTEN_HERE)]
    frame = (written or frames)[-1]
    return f"{frame.filename}:{frame.lineno}"
