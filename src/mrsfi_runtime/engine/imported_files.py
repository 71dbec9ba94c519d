"""The files of a team that code imports, found without running it."""

import ast
import re
from collections.abc import Iterable, Iterator
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path

from mrsfi_runtime.engine.region_sources import Source
from mrsfi_runtime.imported_copies import team_file
from mrsfi_runtime.unfilled import FILES

_LONGEST = 200  # letters of a text that may be the name of a file
_UNLIKELY = re.compile(r"^/|\.\.|[\0\n]|\.py$")


def imported_files(directory: Path, modules: Iterable[str] = ()) -> dict[str, Path]:
    """Return the files that generated code and some modules may import, by where Python finds each.

    Import statements lead to them, wherever they stand; what is read as it is imported comes with
    them if a text of the module names a file beside it.
    """
    found: dict[str, Path] = {}
    names = [*modules]
    for file in (directory / name for name in FILES):
        names += _named(Source(file).tree, "") if file.is_file() else ()
    for name in names:  # which grows
        for spec in _specs(name):
            path = team_file(spec)
            is_package = spec.submodule_search_locations is not None
            place = Path(*spec.name.split("."), *["__init__"] * is_package).parent
            if path is None or str(place / path.name) in found:
                continue
            tree = Source(path).tree if path.suffix == ".py" else ast.Module([], [])
            names += _named(tree, spec.name if is_package else spec.name.rpartition(".")[0])
            for text in (path.name, *_texts(tree)):
                if (path.parent / text).is_file():
                    found[str(place / text)] = path.parent / text
    return found


def _specs(name: str) -> Iterator[ModuleSpec]:
    """Yield a module of a dotted name, and all that it is part of, as far as they can be found."""
    first, *rest = name.split(".")
    try:
        spec = find_spec(first)  # the one that is loaded, or else the one that would be
    except (ImportError, ValueError):  # of what has no file, such as the script that runs
        return
    while spec is not None:
        yield spec
        if not rest or spec.submodule_search_locations is None:
            return
        part, *rest = rest
        spec = PathFinder.find_spec(f"{spec.name}.{part}", spec.submodule_search_locations)


def _named(tree: ast.Module, package: str) -> Iterator[str]:
    """Yield the dotted names that the import statements of a module may import."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and (package or not node.level):
            above = package.rsplit(".", node.level - 1)[0] if node.level else ""
            module = ".".join(part for part in (above, node.module) if part)
            yield from (f"{module}.{name.name}" for name in node.names)


def _texts(tree: ast.Module) -> Iterator[str]:
    """Yield the texts of a module that may name a file beside it."""
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and len(text) < _LONGEST and not _UNLIKELY.search(text):
            yield text
