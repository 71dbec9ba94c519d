"""The files of regions, and the kinds of the values in them; all are read, never run.

``sources`` yields the files that hold regions, and the files of the team that those import, each a
``Source``. ``Kinds`` then infers the kinds of the expressions of one function. A kind is a type as
an annotation gives it, such as ``float``, ``RobotState`` or ``list[int]``; ``None`` is an unknown
one. Fields have the kinds that the records of the state declare. A local name has a kind only if
the function assigns the same expression to it everywhere.
"""

import ast
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from dataclasses import is_dataclass
from functools import cache, cached_property
from importlib.machinery import ModuleSpec, PathFinder
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

from mrsfi_runtime.fence import team_file
from mrsfi_runtime.files import lines_in_regions
from mrsfi_runtime.generated_code import region_files
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.state import State


class Source:
    """A file of Python; if it is generated, only its regions are the team's.

    ``regions`` has the region of each line inside one; ``None`` if the whole file is the team's.
    ``tree`` is empty if the file is not valid Python; ``error`` is the reason.
    """

    def __init__(self, path: Path, *, has_regions: bool = False) -> None:
        self.path = path
        text = path.read_text(encoding="utf-8", errors="replace")
        self.regions = lines_in_regions(text) if has_regions else None
        self.tree = ast.Module([], [])
        self.error: SyntaxError | ValueError | None = None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python repeats them when it loads the file
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
        """The expressions that are assigned to its global names."""
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

    All import statements count, also those inside functions. A data file beside a module is
    included if a text in the module names it.
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
    """Yield the packages and the module of a dotted name, as far as they can be found."""
    first, *rest = name.split(".")
    try:
        spec = find_spec(first)  # of the loaded module, or else of the one that would be loaded
    except (ImportError, ValueError):  # of a module without a file, such as the running script
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
    is_unlikely = re.compile(r"^/|\.\.|[\0\n]|\.py$").search
    for node in ast.walk(tree):
        text = node.value if isinstance(node, ast.Constant) else None
        if isinstance(text, str) and len(text) < 200 and not is_unlikely(text):
            yield text


Kind: TypeAlias = Any

API = "mrsfi_runtime.api."
_NUMBERS: Mapping[str, Kind] = {"int": int, "float": float, "bool": bool}
_CALLS: Mapping[str, Kind] = {
    **_NUMBERS, "len": int, "range": list[int], "round": int, "set": set, "math.sqrt": float,
}  # fmt: skip
_ANNOTATIONS: Mapping[str, Kind] = {**_NUMBERS, f"{API}State": State, f"{API}OwnFault": OwnFault}
_GREATEST = 2**12  # the largest number whose powers are evaluated


@cache
def fields(kind: Kind) -> Mapping[str, Kind]:
    """Return the kinds of the fields of the state or of a record in it; otherwise none."""
    return get_type_hints(kind) if is_dataclass(kind) else {}


def element(kind: Kind) -> Kind:
    """Return the kind of what a list or a tuple holds."""
    origin: Kind = get_origin(kind)
    return get_args(kind)[0] if origin in (list, tuple, MutableSequence) else None


_FIELDS: Mapping[str, Kind] = {
    name: kind
    for record in (State, OwnFault, *(element(kind) or kind for kind in fields(State).values()))
    for name, kind in fields(record).items()
}
"""Kinds of fields: those of one name have one kind, whatever record they stand in."""


def literal(node: ast.AST | None) -> int | float | None:
    """Return the number that an expression of literals stands for, if it is one."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return number
        case ast.UnaryOp(op=ast.USub()):
            value = literal(node.operand)
            return None if value is None else -value
        case ast.BinOp(ast.Constant(int() as n), ast.LShift(), ast.Constant(int() as k)):
            return n << k if k < _GREATEST else None
        case ast.BinOp(ast.Constant(int() as n), ast.Pow(), ast.Constant(int() as k)):
            return int(n**k) if max(n, k) < _GREATEST else None
    return None


def bound(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST | None]]:
    """Yield the targets of a node's assignments, each with its value, if that is known."""
    match node:
        case ast.Assign():
            yield from ((target, node.value) for target in node.targets)
        case ast.AnnAssign() | ast.NamedExpr():
            yield node.target, node.value
        case ast.AugAssign():
            yield node.target, ast.BinOp(node.target, node.op, node.value)
        case ast.For() | ast.comprehension():
            yield node.target, ast.Subscript(node.iter, ast.Constant(0))


class Kinds:
    """Kinds of the expressions of one function of a file.

    ``local`` has the kinds of its arguments and of the names that it assigns to.
    """

    def __init__(self, function: ast.FunctionDef, source: Source) -> None:
        self._imports, self._constants = source.imports, source.constants
        nodes = [*ast.walk(function)]
        values = {id(target): value for node in nodes for target, value in bound(node)}
        held: dict[str, dict[str, ast.AST | None]] = {}
        named = [node for node in nodes if isinstance(node, ast.arg | ast.Name)]
        for node in sorted(named, key=lambda node: (node.lineno, node.col_offset)):
            if isinstance(node, ast.arg):
                held.setdefault(node.arg, {})[ast.dump(node)] = node
            elif isinstance(node.ctx, ast.Store):
                value = values.get(id(node))
                held.setdefault(node.id, {})[ast.dump(value) if value else ""] = value
        self.local: dict[str, Kind] = dict.fromkeys(held)
        for name, found in held.items():
            self.local[name] = self.of(*found.values()) if len(found) == 1 else None

    def dotted(self, node: ast.AST | None) -> str:
        """Return the dotted name that an expression stands for; empty if it is none."""
        if isinstance(node, ast.Attribute):
            parent = self.dotted(node.value)
            return f"{parent}.{node.attr}" if parent else ""
        if not isinstance(node, ast.Name) or node.id in self.local:
            return ""
        return self._imports.get(node.id, node.id)

    def constant(self, name: str) -> int | float | None:
        """Return the number that a name of the file stands for, if it is one."""
        return None if name in self.local else literal(self._constants.get(name))

    def of(self, node: ast.AST | None) -> Kind:
        """Return the kind of an expression; ``None`` if it is unknown."""
        number = literal(node)
        if number is not None:
            return type(number)
        kind_of = _KIND_OF.get(type(node))
        return None if kind_of is None else kind_of(self, node)


def _of_name(kinds: Kinds, node: ast.Name) -> Kind:
    number = kinds.constant(node.id)
    return kinds.local.get(node.id) if number is None else type(number)


def _of_argument(kinds: Kinds, node: ast.arg) -> Kind:
    is_state = node.annotation is None and node.arg == "ci"  # which needs none
    return State if is_state else _ANNOTATIONS.get(kinds.dotted(node.annotation))


def _of_part(kinds: Kinds, node: ast.Subscript) -> Kind:
    whole = kinds.of(node.value)
    return whole if isinstance(node.slice, ast.Slice) else element(whole)


def _of_operation(kinds: Kinds, node: ast.BinOp) -> Kind:
    left, right = kinds.of(node.left), kinds.of(node.right)
    if left == list[int] and isinstance(node.op, ast.Mult):
        return left
    if float in (left, right) or isinstance(node.op, ast.Div):
        return float
    return int if {left, right} <= {int, bool} else None


def _of_call(kinds: Kinds, node: ast.Call) -> Kind:
    name = kinds.dotted(node.func)
    if name in ("abs", "min", "max"):
        return _common(kinds, node.args)
    return None if name == "round" and len(node.args) > 1 else _CALLS.get(name)


def _common(kinds: Kinds, nodes: Sequence[ast.AST]) -> Kind:
    """Return the kind of a value that may be any of these: int and float make float."""
    found = {*map(kinds.of, nodes)}
    if len(found) == 1:
        return found.pop()
    return float if found == {int, float} else None


_KIND_OF: Mapping[type, Callable[[Kinds, Any], Kind]] = {
    ast.Constant: lambda _, node: type(node.value),
    ast.arg: _of_argument,
    ast.Name: _of_name,
    ast.Attribute: lambda kinds, node: (  # attributes of modules are no fields
        None if kinds.dotted(node) else _FIELDS.get(node.attr)
    ),
    ast.Subscript: _of_part,
    ast.Call: _of_call,
    ast.BinOp: _of_operation,
    ast.UnaryOp: lambda kinds, node: (
        bool if isinstance(node.op, ast.Not) else kinds.of(node.operand)
    ),
    ast.Compare: lambda *_: bool,
    ast.Set: lambda *_: set,
    ast.IfExp: lambda kinds, node: _common(kinds, [node.body, node.orelse]),
    ast.List: lambda kinds, node: list[int] if {*map(kinds.of, node.elts)} == {int} else None,
}
"""How the kind of an expression follows from those of its parts."""
