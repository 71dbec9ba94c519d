"""Says which line of which region cannot be compiled, and why, in plain words."""

import ast
import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from textwrap import dedent
from types import FunctionType
from typing import Any

import numba

from mrsfi_runtime.engine.compiled.pipeline import Checked
from mrsfi_runtime.engine.compiled.regions import EFFECT, CompilationError, Region
from mrsfi_runtime.engine.compiled.views import arguments_of
from mrsfi_runtime.kernel.state import is_kernel
from mrsfi_runtime.markers import lines_in_regions

_PLACE = re.compile(r'File "([^"]+)", line (\d+)|Raised from (\S+) \((\d+)\)')

_NO_TEXT = "it makes a text; leave texts to the analysis"
_REASONS = (
    (r"Untyped global name '(\w+)'.*<class 'function'>", "'{0}' is not marked @kernel; mark it"),
    (
        r"Untyped global name '(\w+)'.*<class 'builtin_",
        "'{0}' of Python is not known to the compiler; write a loop, or leave it out",
    ),
    (
        r"Untyped global name '(\w+)'.*<class '(\w+)'>",
        "'{0}' is a global {1}; write a number, or a tuple of numbers",
    ),
    (
        r"a reflected (\w+).*? variable '(\w+)' in globals",
        "'{1}' is a global {0}; write a tuple of numbers",
    ),
    (r"NameError: name '(\w+)'", "'{0}' is not defined"),
    (r"Cannot unify (.+?) and (.+?) for '(\w+)", "'{2}' holds values of two types"),
    (r"^'(\w+)'$", "records have no '{0}'"),
    (r"\(UNPACK_EX\)", "it unpacks with a star; unpack by index"),
    (
        r"exception_match|Exception object",
        "it tells exceptions apart; write `except Exception:`, or test before instead",
    ),
    (
        r"Unknown attribute '(\w+)' of type Module\(<module '(\w+)'",
        "'{1}.{0}' is not known to the compiler; write the formula, or leave it out",
    ),
    (r"Unknown attribute '(\w+)' of type array", "a list has no '{0}' when compiled; write a loop"),
    (r"f-strings|'format' of type Literal|in function mod>[\s\S]*Literal\[str\]", _NO_TEXT),
    (r"<built-in function (min|max)>", "'{0}' takes numbers alone; write a loop"),
    (r"load_from_data_pointer", "it lists records; list their indices"),
    (r"Cannot type empty list", "of an empty list no type is known; keep what lasts in `ci`"),
    (
        r"of function Function\(<function (\w+) ",
        "'{0}' does not compile with what it is called with; a function cannot call itself",
    ),
)
"""What numba says, and what that is in plain words."""

_UNKNOWN: Mapping[type[ast.AST], str] = {
    ast.GeneratorExp: "a generator expression; write a loop",
    ast.SetComp: "a set comprehension; write a loop",
    ast.NamedExpr: "`:=`; assign on a line of its own",
    ast.With: "a `with`; leave it out: a region reads and commands `ci` alone",
    ast.Import: "an import; import in the region 'imports'",
    ast.ImportFrom: "an import; import in the region 'imports'",
    ast.Global: "a `global`; keep what lasts in the fields of `ci`",
    ast.ClassDef: "a class; write functions, or constants in the region 'helpers'",
    ast.Delete: "a `del`; leave the name alone",
}
"""What numba knows in no place, where it says little of why and now and then another line."""


def explain(
    directory: Path, region: Region, functions: Sequence[FunctionType], error: Exception
) -> CompilationError:
    """Return which line of a region, or of the functions it reaches, does not compile, and why."""
    for function in functions:
        for line, why in _unknown(function):
            return _error(directory, function, line, why)
    called: list[Any] = [region.function]
    if region.role == EFFECT:
        names = region.function.__code__.co_names
        called[:0] = [region.function.__globals__.get(name) for name in names]
    for function in filter(is_kernel, called):
        try:
            numba.njit(pipeline_class=Checked)(function).compile(arguments_of(region.role))
        except Exception as found:  # noqa: BLE001 - numba raises errors of any kind
            named = [
                int(line or other_line)
                for file, line, other, other_line in _PLACE.findall(str(found))
                if Path(file or other).name == Path(inspect.getfile(function)).name
            ]
            return _error(directory, function, named[-1] if named else None, _why(found))
    return _error(directory, region.function, None, _why(error))


def _unknown(function: FunctionType) -> Iterator[tuple[int, str]]:
    """Yield the lines of a team's function that no compiler would take, and why."""
    if not function.__module__.startswith("mrsfi_runtime."):
        with suppress(OSError, SyntaxError):  # no file, or a function within a line
            lines, first = inspect.getsourcelines(function)
            for node in ast.walk(ast.parse(dedent("".join(lines)))):
                if type(node) in _UNKNOWN:
                    line = first - 1 + getattr(node, "lineno", 1)
                    yield line, f"it has {_UNKNOWN[type(node)]}"


def _error(
    directory: Path, function: Callable[..., Any], line: int | None, why: str
) -> CompilationError:
    """Return an error with file, line and region; by default the first line of the region."""
    path = Path(inspect.getfile(function))
    lines, first = inspect.getsourcelines(function)
    regions = lines_in_regions(path.read_text(encoding="utf-8"))
    if line is None:
        line = next(filter(regions.get, range(first, first + len(lines))), first + 1)
    place = f"region {regions[line]}" if line in regions else f"function {function.__name__}"
    path = directory / path.name if path.parent == directory.absolute() else path
    return CompilationError(f"{path}:{line}: {place} cannot be compiled: {why}")


def _why(error: Exception) -> str:
    text = str(error) or type(error).__name__
    for pattern, words in _REASONS:
        match = re.search(pattern, text)
        if match:
            return words.format(*match.groups())
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[1 if len(lines) > 1 and "pipeline" in lines[0] else 0].partition(" Raised from")[0]
