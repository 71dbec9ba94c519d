"""The files that regions stand in: a mission's own, and those of the team that it imports.

They are read, never run.
"""

import ast
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from importlib.machinery import PathFinder
from pathlib import Path

from mrsfi_runtime.imported_copies import team_file
from mrsfi_runtime.markers import lines_in_regions
from mrsfi_runtime.unfilled import FILES


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
        return {bound: dotted for bound, dotted, _ in _imports(self.tree)}

    def place(self, line: int) -> str:
        """Return what a line belongs to, such as ``region 'g1.check'``."""
        if self.regions and line in self.regions:
            return f"region '{self.regions[line]}'"
        for name, function in self.functions.items():
            if function.lineno <= line <= (function.end_lineno or line):
                return f"function '{name}'"
        return f"module '{self.path.stem}'"


def sources(directory: Path, search_path: Sequence[str] | None = None) -> Iterator[Source]:
    """Yield the files of a mission that hold regions, and the team's files that they import.

    None where no code was generated yet; ``search_path`` is by default that of Python.
    """
    generated = [path for path in (directory / name for name in FILES) if path.is_file()]
    folders = sys.path if search_path is None else search_path
    paths = [*generated]
    for path in paths:  # which grows
        source = Source(path, has_regions=path in generated)
        yield source
        for _, _, dotted in _imports(source.tree):
            paths += [own for own in _own_files(dotted, folders) if own not in paths]


def _imports(tree: ast.Module) -> Iterator[tuple[str, str, str]]:
    """Yield the names that imports bind, what each stands for, and what is imported for that."""
    for node in tree.body:
        if isinstance(node, ast.Import):
            for name in node.names:
                top = name.name.partition(".")[0]
                yield name.asname or top, name.name if name.asname else top, name.name
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for name in node.names:
                dotted = f"{node.module}.{name.name}"
                yield name.asname or name.name, dotted, dotted


def _own_files(dotted: str, folders: Sequence[str]) -> Iterator[Path]:
    """Yield the team's files that an import runs, found as Python would: no library, none of ours.

    The last part of the name may be taken from a module, or be a module.
    """
    names = dotted.split(".")
    for depth in range(1, len(names) + 1):
        spec = PathFinder.find_spec(".".join(names[:depth]), folders)
        path = team_file(spec)
        if path is not None and path.suffix == ".py":
            yield path
        if spec is None or spec.submodule_search_locations is None:
            return
        folders = spec.submodule_search_locations
