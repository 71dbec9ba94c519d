"""The files that regions stand in: a mission's own, and those of the team that it imports.

They are read, never run.
"""

import ast
import re
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from importlib.machinery import PathFinder
from pathlib import Path

from mrsfi_runtime.unfilled import FILES

_BEGIN = re.compile(r"[ \t]*# protected region (\S+) (?:on|off) begin[ \t]*")
_END = re.compile(r"[ \t]*# protected region \S+ end[ \t]*")
_OURS = "mrsfi_runtime"


class Source:
    """A file of Python.

    Parameters
    ----------
    path
        Where it is.
    has_regions
        Whether it is generated, so that only its regions are the team's.
    """

    def __init__(self, path: Path, *, has_regions: bool = False) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8", errors="replace")
        self.regions = dict(_regions(self.text)) if has_regions else None

    @cached_property
    def tree(self) -> ast.Module:
        """Its syntax.

        Raises
        ------
        SyntaxError, ValueError
            If it is no Python.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python says them again when it loads the file
            tree = ast.parse(self.text)
            compile(tree, str(self.path), "exec")  # finds a `return` outside of functions, say
        return tree

    @cached_property
    def functions(self) -> Mapping[str, ast.FunctionDef]:
        """Its functions by name, but for those inside others."""
        return {node.name: node for node in self.tree.body if isinstance(node, ast.FunctionDef)}

    @cached_property
    def kernels(self) -> Mapping[str, ast.FunctionDef]:
        """The functions that the compiled engine compiles: those marked ``@kernel``."""
        return {name: node for name, node in self.functions.items() if _is_kernel(node)}

    @cached_property
    def constants(self) -> Mapping[str, ast.expr]:
        """What is assigned to its global names."""
        return dict(_constants(self.tree))

    @cached_property
    def imports(self) -> Mapping[str, str]:
        """The dotted names that imported names stand for."""
        return dict(_imports(self.tree))

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

    Parameters
    ----------
    directory
        ``generated/<mission>``; nothing is yielded where no code was generated yet.
    search_path
        Folders in which imports are found, by default those of Python.
    """
    generated = [path for path in (directory / name for name in FILES) if path.is_file()]
    paths = [*generated]
    for path in paths:  # which grows
        source = Source(path, has_regions=path in generated)
        yield source
        try:
            tree = source.tree
        except (SyntaxError, ValueError):
            continue
        folders = sys.path if search_path is None else search_path
        paths += [own for own in _own_files(tree, folders) if own not in paths]


def _regions(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines that stand in regions, each with its region."""
    region = ""
    for number, line in enumerate(text.split("\n"), start=1):
        begin = _BEGIN.fullmatch(line)
        if begin is not None:
            region = begin[1]
        elif _END.fullmatch(line):
            region = ""
        elif region:
            yield number, region


def _is_kernel(function: ast.FunctionDef) -> bool:
    return any(
        isinstance(decorator, ast.Name | ast.Attribute)
        and ast.unparse(decorator).rpartition(".")[2] == "kernel"
        for decorator in function.decorator_list
    )


def _constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            if isinstance(target, ast.Name):
                yield target.id, node.value


def _imports(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names that imports bind, each with the dotted name that it stands for."""
    for node in tree.body:
        if isinstance(node, ast.Import):
            for name in node.names:
                top = name.name.partition(".")[0]
                yield (name.asname, name.name) if name.asname else (top, top)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for name in node.names:
                yield name.asname or name.name, f"{node.module}.{name.name}"


def _own_files(tree: ast.Module, folders: Sequence[str]) -> Iterator[Path]:
    """Yield the files of the team that are imported: no library, nothing of ours."""
    for module in _imported_modules(tree):
        path = _file_of(module, folders)
        if path is not None and "site-packages" not in path.parts:
            yield path


def _imported_modules(tree: ast.Module) -> Iterator[str]:
    """Yield the dotted names that imports may mean; a name taken from a module may be one."""
    for node in tree.body:
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
            yield from (f"{node.module}.{name.name}" for name in node.names)


def _file_of(module: str, folders: Sequence[str]) -> Path | None:
    """Return the source of a module, found as Python would, without running anything."""
    first, *rest = module.split(".")
    if first == _OURS or first in sys.stdlib_module_names:
        return None
    spec = PathFinder.find_spec(first, folders)
    for depth, _ in enumerate(rest, 2):
        if spec is None or spec.submodule_search_locations is None:
            return None
        name = ".".join(module.split(".")[:depth])
        spec = PathFinder.find_spec(name, spec.submodule_search_locations)
    is_source = spec is not None and spec.has_location and str(spec.origin).endswith(".py")
    return Path(str(spec.origin)) if spec is not None and is_source else None
