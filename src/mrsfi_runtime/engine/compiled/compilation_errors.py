"""Says which line of which region cannot be compiled, and why, in plain words."""

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

from mrsfi_runtime.engine.compiled.likeness import Checked
from mrsfi_runtime.engine.compiled.reach import CompilationError, is_kernel
from mrsfi_runtime.engine.compiled.regions import EFFECT, Region
from mrsfi_runtime.engine.compiled.views import arguments_of
from mrsfi_runtime.markers import MARKER

_PLACE = re.compile(r'File "([^"]+)", line (\d+)|Raised from (\S+) \((\d+)\)')

_REASONS = (
    (r"Untyped global name '(\w+)'.*<class 'function'>", "'{0}' is not marked @kernel"),
    (r"Untyped global name '(\w+)'.*<class '(\w+)'>", "'{0}' is a global {1}; expected a number"),
    (r"NameError: name '(\w+)'", "'{0}' is not defined"),
    (r"Cannot unify (.+?) and (.+?) for '(\w+)", "'{2}' holds values of two types"),
    (r"^'(\w+)'$", "records have no '{0}'"),
)


def explain(directory: Path, region: Region, error: Exception) -> CompilationError:
    """Return which line of a region does not compile, by what numba said of the whole."""
    called: list[Any] = [region.function]
    if region.role == EFFECT:
        names = region.function.__code__.co_names
        called[:0] = [region.function.__globals__.get(name) for name in names]
    for function in filter(is_kernel, called):
        try:
            numba.njit(pipeline_class=Checked)(function).compile(arguments_of(region.role))
        except Exception as found:  # noqa: BLE001 - numba raises errors of any kind
            where = _where(directory, function, str(found))
            return CompilationError(f"{where} cannot be compiled: {_why(found)}")
    where = _where(directory, region.function, "")
    return CompilationError(f"{where} cannot be compiled: {_why(error)}")


def _where(directory: Path, function: Callable[..., Any], text: str) -> str:
    """Return file, line and region of what numba complains of."""
    path = Path(inspect.getfile(function))
    lines, first = inspect.getsourcelines(function)
    begins = [
        (n, found["id"])
        for n, line in enumerate(lines)
        if (found := MARKER.match(line)) and found["state"]
    ]
    n_before, region = begins[0] if begins else (0, function.__name__)
    named = [
        int(line or other_line)
        for file, line, other, other_line in _PLACE.findall(text)
        if Path(file or other).name == path.name
    ]
    line = named[-1] if named else first + n_before + 1
    path = directory / path.name if path.parent == directory.absolute() else path
    return f"{path}:{line}: region {region}"


def _why(error: Exception) -> str:
    text = str(error)
    for pattern, words in _REASONS:
        match = re.search(pattern, text)
        if match:
            return words.format(*match.groups())
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[1 if len(lines) > 1 and "pipeline" in lines[0] else 0].partition(" Raised from")[0]
