"""What can be told of the values in a region without running it.

A kind is a type as an annotation gives it, such as ``float``, ``RobotState`` or ``list[int]``;
``None`` is what cannot be told. Fields have the kinds that the records of the state declare; a
local name has one if all that is ever assigned to it has.
"""

import ast
from collections.abc import Callable, Iterator, Mapping, MutableSequence, Sequence
from contextlib import suppress
from dataclasses import is_dataclass
from difflib import get_close_matches
from functools import cache
from pkgutil import resolve_name
from textwrap import shorten
from types import ModuleType
from typing import Any, TypeAlias, get_args, get_origin, get_type_hints

from mrsfi_runtime.engine.region_sources import Source
from mrsfi_runtime.kernel.injections import OwnFault
from mrsfi_runtime.kernel.state import State

Kind: TypeAlias = Any

_API = "mrsfi_runtime.api."
_NUMBERS: Mapping[str, Kind] = {"int": int, "float": float, "bool": bool}
_CALLS: Mapping[str, Kind] = {**_NUMBERS, "len": int, "round": int, "set": set, "sqrt": float}
_FIRST = ast.Constant(0)
_LONGEST = 120  # letters of the names that are told


@cache
def fields(record: Kind) -> Mapping[str, Kind]:
    """Return the kinds of a record's fields."""
    return get_type_hints(record)


def is_record(kind: Kind) -> bool:
    """Return whether a kind is a record of the state, or the state."""
    return is_dataclass(kind)


def element(kind: Kind) -> Kind:
    """Return the kind of what a list or a tuple holds."""
    origin: Kind = get_origin(kind)
    return get_args(kind)[0] if origin in (list, tuple, MutableSequence) else None


_RECORDS: Mapping[str, Kind] = {f"{_API}State": State, f"{_API}OwnFault": OwnFault}
"""Records that arguments of regions are annotated with."""

_FIELDS: Mapping[str, Kind] = {
    **fields(State),
    **{
        name: field
        for kind in fields(State).values()
        if is_record(record := element(kind) or kind)
        for name, field in fields(record).items()
    },
}
"""Kinds of fields by name alone, where the record cannot be told."""


def literal(node: ast.AST | None) -> int | float | None:
    """Return the number that an expression of literals stands for, if it is one."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return number
        case ast.UnaryOp(op=ast.USub()):
            value = literal(node.operand)
            return None if value is None else -value
        case ast.BinOp(op=ast.Pow() | ast.LShift()):
            return _folded(node.op, literal(node.left), literal(node.right))
    return None


def _folded(op: ast.operator, left: float | None, right: float | None) -> int | None:
    if not isinstance(left, int) or not isinstance(right, int) or not 0 <= right < 2**12:
        return None
    if isinstance(op, ast.LShift):
        return left << right
    return int(left**right) if abs(left) < 2**12 else None


class Kinds:
    """Kinds of the expressions of one function of a file.

    ``local`` are its arguments and the names that it assigns to, ``names`` the kinds of what names
    hold.
    """

    def __init__(self, function: ast.FunctionDef, source: Source) -> None:
        self._imports = source.imports
        self.names: dict[str, Kind] = {
            name: type(number)
            for name, value in source.constants.items()
            if (number := literal(value)) is not None
        }
        arguments = dict(_arguments(function, self._imports))
        assigned = [*_assignments(function)]
        self.local = {*arguments, *(name for name, _ in assigned)}
        for n in range(4):  # a name may depend on itself, or on one assigned further down
            kinds: dict[str, list[Kind]] = {name: [kind] for name, kind in arguments.items()}
            for name, value in assigned:
                kind = self.of(value)
                if kind is not None or n:
                    kinds.setdefault(name, []).append(kind)
            self.names |= {name: _common(found) for name, found in kinds.items()}

    def dotted(self, node: ast.AST) -> str:
        """Return the dotted name that an expression stands for; empty if it is none."""
        if isinstance(node, ast.Attribute):
            parent = self.dotted(node.value)
            return f"{parent}.{node.attr}" if parent else ""
        if not isinstance(node, ast.Name) or node.id in self.local:
            return ""
        return self._imports.get(node.id, node.id)

    def of(self, node: ast.AST | None) -> Kind:
        """Return the kind of an expression, or ``None`` where it cannot be told."""
        number = literal(node)
        if number is not None:
            return type(number)
        kind_of = _KIND_OF.get(type(node))
        return None if kind_of is None else kind_of(self, node)


def _of_field(node: ast.Attribute, owner: Kind) -> Kind:
    return (fields(owner) if is_record(owner) else _FIELDS).get(node.attr)


def _of_operation(node: ast.BinOp, left: Kind, right: Kind) -> Kind:
    if left == list[int] and isinstance(node.op, ast.Mult):
        return left
    if float in (left, right) or isinstance(node.op, ast.Div):
        return float
    return int if {left, right} <= {int, bool} else None


def _of_call(node: ast.Call, arguments: Sequence[Kind]) -> Kind:
    if isinstance(node.func, ast.Attribute):
        return float if node.func.attr == "sqrt" else None
    name = ast.unparse(node.func)
    if name in ("abs", "min", "max"):
        return _common(arguments)
    return _CALLS.get(name) if len(arguments) < 2 else None


def _common(kinds: Sequence[Kind]) -> Kind:
    """Return the kind that a name has if it may hold any of these: int and float make float."""
    found = set(kinds)
    if len(found) == 1:
        return found.pop()
    return float if found == {int, float} else None


_KIND_OF: Mapping[type, Callable[[Kinds, Any], Kind]] = {
    ast.Name: lambda kinds, node: kinds.names.get(node.id),
    ast.Attribute: lambda kinds, node: _of_field(node, kinds.of(node.value)),
    ast.Subscript: lambda kinds, node: (
        kinds.of(node.value) if isinstance(node.slice, ast.Slice) else element(kinds.of(node.value))
    ),
    ast.Call: lambda kinds, node: _of_call(node, [*map(kinds.of, node.args)]),
    ast.BinOp: lambda kinds, node: _of_operation(node, kinds.of(node.left), kinds.of(node.right)),
    ast.UnaryOp: lambda kinds, node: (
        bool if isinstance(node.op, ast.Not) else kinds.of(node.operand)
    ),
    ast.Compare: lambda *_: bool,
    ast.Set: lambda *_: set,
    ast.SetComp: lambda *_: set,
    ast.IfExp: lambda kinds, node: _common([kinds.of(node.body), kinds.of(node.orelse)]),
    ast.List: lambda kinds, node: list[int] if {*map(kinds.of, node.elts)} == {int} else None,
}
"""How the kind of an expression follows from those of its parts."""


def _arguments(function: ast.FunctionDef, imports: Mapping[str, str]) -> Iterator[tuple[str, Kind]]:
    """Yield the arguments with their kinds; one that is called ``ci`` needs no annotation."""
    for argument in (*function.args.args, *function.args.kwonlyargs):
        hint = argument.annotation
        name = hint.id if isinstance(hint, ast.Name) else ""
        is_state = hint is None and argument.arg == "ci"
        annotated = _RECORDS.get(imports.get(name, ""), _NUMBERS.get(name))
        yield argument.arg, State if is_state else annotated


def _assignments(function: ast.FunctionDef) -> Iterator[tuple[str, ast.AST | None]]:
    """Yield the local names with what is assigned to them; ``None`` where that cannot be told."""
    values = {
        id(target): value
        for node in ast.walk(function)
        for target, value in bound(node)
        if isinstance(target, ast.Name)
    }
    for node in ast.walk(function):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, values.get(id(node))
        elif isinstance(node, ast.Lambda | ast.FunctionDef) and node is not function:
            yield from ((argument.arg, None) for argument in node.args.args)


def bound(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST | None]]:
    """Yield what a node assigns to, and what is assigned, if that can be told."""
    match node:
        case ast.Assign():
            yield from ((target, node.value) for target in node.targets)
        case ast.AnnAssign() | ast.NamedExpr():
            yield node.target, node.value
        case ast.AugAssign():
            yield node.target, ast.BinOp(node.target, node.op, node.value)
        case ast.For() | ast.comprehension():
            is_range = isinstance(node.iter, ast.Call) and ast.unparse(node.iter.func) == "range"
            yield node.target, _FIRST if is_range else ast.Subscript(node.iter, _FIRST)


def missing(source: Source) -> Iterator[tuple[int, str]]:
    """Yield lines that ask a record for a field, or a module of ours for a name, in vain."""
    for function in source.functions.values():
        kinds = Kinds(function, source)
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute):
                owner, known = _known(node.value, kinds)
                if known and node.attr not in known:
                    yield node.lineno, _missed(node, owner, known)


def _known(node: ast.AST, kinds: Kinds) -> tuple[str, Sequence[str]]:
    """Return what an expression is, if that is certain, and which names it has."""
    kind = kinds.of(node)
    if is_record(kind):
        return f"a {kind.__name__}", [*fields(kind)]
    dotted = kinds.dotted(node)
    if dotted == "math" or dotted.startswith(_API):
        with suppress(ImportError, AttributeError):
            module = resolve_name(dotted)
            return dotted, dir(module) if isinstance(module, ModuleType) else ()
    return "", ()


def _missed(node: ast.Attribute, owner: str, known: Sequence[str]) -> str:
    near = get_close_matches(node.attr, known, 3) or [n for n in known if n[0] != "_"]
    has = shorten(", ".join(near), _LONGEST, placeholder=" …")
    return f"found `{ast.unparse(node)}`, but {owner} has no '{node.attr}'; it has {has}"
