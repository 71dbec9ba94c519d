"""Warns of regions that would not compile, or compile to something else, without compiling.

Only functions that the compiled engine compiles are looked at: those marked ``@kernel`` in
regions of the collective intelligence, and in the team's own files from which it imports. The
rest of a file, constants and tables included, stays plain Python on every engine.
"""

import ast
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.machinery import PathFinder
from pathlib import Path

from mrsfi_runtime.engine.region_kinds import literal
from mrsfi_runtime.engine.region_rules import Surroundings, remarks

_BEGIN = re.compile(r"[ \t]*# protected region (\S+) (?:on|off) begin[ \t]*")
_END = re.compile(r"[ \t]*# protected region \S+ end[ \t]*")
_OURS = "mrsfi_runtime"


@dataclass(frozen=True, slots=True)
class RegionWarning:
    """A line that would not compile, or not alike.

    Attributes
    ----------
    path, line
        Where it stands.
    place
        Region or function that it stands in, such as ``region 'g1.check'``.
    does_compile
        Whether it compiles, to something else.
    message
        What was found, why it matters and what to write instead.
    """

    path: Path
    line: int
    place: str
    does_compile: bool
    message: str


def lint_regions(
    directory: Path, search_path: Sequence[str] | None = None
) -> tuple[RegionWarning, ...]:
    """Return warnings of the regions of a mission, and of the team's files that they import.

    Parameters
    ----------
    directory
        ``generated/<mission>``; where no code was generated yet there is nothing to warn of.
    search_path
        Folders in which imports are found, by default those of Python.
    """
    collective = directory / "collective_intelligence.py"
    if not collective.is_file():
        return ()
    folders = sys.path if search_path is None else search_path
    files = [collective]
    found: dict[RegionWarning, None] = {}
    for path in files:  # which grows
        text = path.read_text(encoding="utf-8", errors="replace")
        regions = _regions(text) if path is collective else None
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError) as error:
            line = getattr(error, "lineno", None) or 1
            place = _place(regions, line, "module")
            found[RegionWarning(path, line, place, False, f"is no Python: {error}")] = None
            continue
        found |= dict.fromkeys(_of_file(path, tree, regions))
        files += [own for own in _own_files(tree, folders) if own not in files]
    return tuple(found)


def _regions(text: str) -> dict[int, str]:
    """Return the region of every line that stands in one."""
    regions: dict[int, str] = {}
    region = ""
    for number, line in enumerate(text.split("\n"), start=1):
        begin = _BEGIN.fullmatch(line)
        if begin is not None:
            region = begin[1]
        elif _END.fullmatch(line):
            region = ""
        elif region:
            regions[number] = region
    return regions


def _place(regions: Mapping[int, str] | None, line: int, function: str) -> str:
    region = None if regions is None else regions.get(line)
    return f"function '{function}'" if region is None else f"region '{region}'"


def _of_file(
    path: Path, tree: ast.Module, regions: Mapping[int, str] | None
) -> Iterator[RegionWarning]:
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    around = _surroundings(tree, functions)
    for function in filter(_is_kernel, functions):
        for said in remarks(function, around):
            if regions is None or said.line in regions:
                place = _place(regions, said.line, function.name)
                yield RegionWarning(path, said.line, place, said.does_compile, said.message)


def _is_kernel(function: ast.FunctionDef) -> bool:
    return any(
        isinstance(decorator, ast.Name | ast.Attribute)
        and ast.unparse(decorator).rpartition(".")[2] == "kernel"
        for decorator in function.decorator_list
    )


def _surroundings(tree: ast.Module, functions: Sequence[ast.FunctionDef]) -> Surroundings:
    values = dict(_globals(tree))
    numbers = {name: literal(value) for name, value in values.items()}
    return Surroundings(
        imports=dict(_imports(tree)),
        kinds={
            name: None if number is None else type(number).__name__
            for name, number in numbers.items()
        },
        containers={
            name
            for name, value in values.items()
            if isinstance(value, ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp)
        },
        unmarked={function.name for function in functions if not _is_kernel(function)},
        large={
            name
            for name, number in numbers.items()
            if isinstance(number, int) and not -(2**63) <= number < 2**63
        },
    )


def _globals(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        if isinstance(node, ast.AnnAssign):
            targets = [node.target]
        value = getattr(node, "value", None)
        for target in targets:
            if isinstance(target, ast.Name) and value is not None:
                yield target.id, value


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
    top = module.partition(".")[0]
    if top == _OURS or top in sys.stdlib_module_names:
        return None
    places: Sequence[str] | None = folders
    spec = None
    name = ""
    for part in module.split("."):
        name = f"{name}.{part}" if name else part
        spec = None if places is None else PathFinder.find_spec(name, places)
        if spec is None:
            return None
        places = spec.submodule_search_locations
    is_source = spec is not None and spec.has_location and str(spec.origin).endswith(".py")
    return Path(str(spec.origin)) if spec is not None and is_source else None
