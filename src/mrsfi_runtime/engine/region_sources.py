"""The files that regions stand in: a mission's own, and those of the team that it imports.

They are read, never run.
"""

import ast
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path

from mrsfi_runtime.imported_copies import team_file
from mrsfi_runtime.markers import lines_in_regions
from mrsfi_runtime.readiness import region_files

_LONGEST = 200  # letters of a text that may be the name of a file
_UNLIKELY = re.compile(r"^/|\.\.|[\0\n]|\.py$")


class Source:
    """A file of Python; if it is generated, only its regions are the team's.

    ``regions`` has the region of each line that stands in one, ``None`` where all is the team's;
    ``tree`` is empty if it is no Python, ``error`` says why.
    """

    def __init__(self, path: Path, *, has_regions: bool = False) -> None:
        self.path = path
        text = path.read_text(encoding="utf-8", errors="replace")
        self.regions = lines_in_regions(text) if has_regions else None
        self.tree = ast.Module([], [])
        self.error: SyntaxError | ValueError | None = None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python says them again when it loads the file
            try:
                tree = ast.parse(text)
                compile(tree, str(path), "exec")  # finds a `return` outside of functions, say
            except (SyntaxError, ValueError) as error:
                self.error = error
            else:
                self.tree = tree

    @cached_property
    def functions(self) -> Mapping[str, ast.FunctionDef]:
        """Its functions by name, but for those inside others."""
        return {node.name: node for node in self.tree.body if isinstance(node, ast.FunctionDef)}

    @cached_property
    def kernels(self) -> Mapping[str, ast.FunctionDef]:
        """The functions that the compiled engine compiles: those marked ``@kernel``."""
        return {
            name: function
            for name, function in self.functions.items()
            if "kernel" in [ast.unparse(each).split(".")[-1] for each in function.decorator_list]
        }

    @cached_property
    def constants(self) -> Mapping[str, ast.expr]:
        """What is assigned to its global names."""
        return {
            target.id: node.value
            for node in self.tree.body
            if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None
            for target in (node.targets if isinstance(node, ast.Assign) else [node.target])
            if isinstance(target, ast.Name)
        }

    @cached_property
    def imports(self) -> Mapping[str, str]:
        """The dotted names that imported names stand for."""
        found: dict[str, str] = {}
        for node in self.tree.body:
            if isinstance(node, ast.Import):
                for name in node.names:
                    top = name.name.partition(".")[0]
                    found[name.asname or top] = name.name if name.asname else top
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                found |= {
                    each.asname or each.name: f"{node.module}.{each.name}" for each in node.names
                }
        return found

    def place(self, line: int) -> str:
        """Return what a line belongs to, such as ``region 'g1.check'``."""
        if self.regions and line in self.regions:
            return f"region '{self.regions[line]}'"
        for name, function in self.functions.items():
            if function.lineno <= line <= (function.end_lineno or line):
                return f"function '{name}'"
        return f"module '{self.path.stem}'"


def sources(directory: Path) -> Iterator[Source]:
    """Yield the files of a mission that hold regions, if any, and the team's that they import."""
    for path in region_files(directory):
        yield Source(path, has_regions=True)
    for path in imported_files(directory).values():
        if path.suffix == ".py":
            yield Source(path)


def imported_files(directory: Path, modules: Iterable[str] = ()) -> dict[str, Path]:
    """Return the files that generated code and some modules may import, by where Python finds each.

    Import statements lead to them, wherever they stand; what is read as it is imported comes with
    them if a text of the module names a file beside it.
    """
    found: dict[str, Path] = {}
    names = [*modules]
    for file in region_files(directory):
        names += _named(Source(file).tree, "")
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
