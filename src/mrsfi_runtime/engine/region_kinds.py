"""What can be told of the values in a region without running it: int, float, bool, set.

Fields of the state have the kinds that its records declare; a local name has one if all that is
ever assigned to it has.
"""

import ast
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from typing import get_args, get_type_hints

from mrsfi_runtime.kernel.state import State

INT, FLOAT, BOOL, SET, INTS = "int", "float", "bool", "set", "list of int"

_CALLS = {"int": INT, "len": INT, "float": FLOAT, "bool": BOOL, "set": SET, "round": INT}
_LISTS = {name: get_args(hint)[0] for name, hint in get_type_hints(State).items() if get_args(hint)}
_RECORDS = [kind for kind in _LISTS.values() if is_dataclass(kind)]

RECORD_LISTS = frozenset(name for name, kind in _LISTS.items() if is_dataclass(kind))
"""Fields of ``State`` that are lists of records."""

INT_LISTS = frozenset(_LISTS) - RECORD_LISTS
"""Fields of ``State`` that are lists of integers."""

FIELDS: Mapping[str, str] = {
    name: kind.__name__
    for record in (get_type_hints(State)["mission"], *_RECORDS)
    for name, kind in get_type_hints(record).items()
}
"""Kinds of the fields of records."""


def literal(node: ast.AST) -> int | float | None:
    """Return the number that an expression of literals stands for, if it is one."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, int | float) else None
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        value = literal(node.operand)
        return None if value is None else -value
    if isinstance(node, ast.BinOp):
        return _folded(node)
    return None


def _folded(node: ast.BinOp) -> int | float | None:
    left, right = literal(node.left), literal(node.right)
    if not isinstance(left, int) or not isinstance(right, int) or not 0 <= right < 2**12:
        return None
    if isinstance(node.op, ast.Pow):
        return int(left**right) if abs(left) < 2**12 else None
    return left << right if isinstance(node.op, ast.LShift) else None


class Kinds:
    """Kinds of the expressions of one function.

    Parameters
    ----------
    function
        The function.
    names
        Kinds of global names.
    """

    def __init__(self, function: ast.FunctionDef, names: Mapping[str, str | None]) -> None:
        self._names = dict(names)
        for argument in function.args.args:
            hint = argument.annotation
            is_known = isinstance(hint, ast.Name) and hint.id in (INT, FLOAT, BOOL)
            self._names[argument.arg] = hint.id if is_known else None  # type: ignore[union-attr]
        assigned = [*_assignments(function)]
        for n in range(4):  # a name may depend on itself, or on one assigned further down
            kinds: dict[str, list[str | None]] = {}
            for name, value in assigned:
                kind = self.of(value)
                if kind is not None or n:
                    kinds.setdefault(name, []).append(kind)
            self._names |= {name: _common(found) for name, found in kinds.items()}

    def of(self, node: ast.AST | None) -> str | None:
        """Return the kind of an expression, or ``None`` where it cannot be told."""
        found = None if node is None else literal(node)
        if found is not None:
            return type(found).__name__
        if isinstance(node, ast.Name):
            return self._names.get(node.id)
        if isinstance(node, ast.Attribute):
            return FIELDS.get(node.attr)
        if isinstance(node, ast.BinOp | ast.UnaryOp | ast.IfExp):
            return self._of_operation(node)
        return self._of_display(node)

    def _of_operation(self, node: ast.BinOp | ast.UnaryOp | ast.IfExp) -> str | None:
        if isinstance(node, ast.UnaryOp):
            return BOOL if isinstance(node.op, ast.Not) else self.of(node.operand)
        if isinstance(node, ast.IfExp):
            return _common([self.of(node.body), self.of(node.orelse)])
        left, right = self.of(node.left), self.of(node.right)
        if left == INTS and isinstance(node.op, ast.Mult):
            return INTS
        if FLOAT in (left, right) or isinstance(node.op, ast.Div):
            return FLOAT
        return INT if {left, right} <= {INT, BOOL} else None

    def _of_display(self, node: ast.AST | None) -> str | None:
        if isinstance(node, ast.Compare):
            return BOOL
        if isinstance(node, ast.Set | ast.SetComp):
            return SET
        if isinstance(node, ast.List):
            is_ints = node.elts and all(self.of(element) == INT for element in node.elts)
            return INTS if is_ints else None
        if isinstance(node, ast.Subscript):
            is_ints = isinstance(node.value, ast.Attribute) and node.value.attr in INT_LISTS
            return INT if is_ints and not isinstance(node.slice, ast.Slice) else None
        return self._of_call(node)

    def _of_call(self, node: ast.AST | None) -> str | None:
        if not isinstance(node, ast.Call):
            return None
        if isinstance(node.func, ast.Name):
            if node.func.id in ("abs", "min", "max"):
                return _common([self.of(argument) for argument in node.args])
            return _CALLS.get(node.func.id) if len(node.args) < 2 else None
        is_root = isinstance(node.func, ast.Attribute) and node.func.attr == "sqrt"
        return FLOAT if is_root else None


def _assignments(function: ast.FunctionDef) -> Iterator[tuple[str, ast.AST | None]]:
    """Yield the local names with what is assigned to them."""
    for node in ast.walk(function):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            yield from _bound(node.targets[0], node.value)
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id, node.value
        elif isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name):
            yield node.target.id, ast.BinOp(node.target, node.op, node.value)
        elif isinstance(node, ast.For | ast.comprehension):
            yield from _bound(node.target, _element(node.iter))


def _bound(target: ast.AST, value: ast.AST | None) -> Iterator[tuple[str, ast.AST | None]]:
    if isinstance(target, ast.Name):
        yield target.id, value
    else:
        for inner in ast.walk(target):
            if isinstance(inner, ast.Name) and isinstance(inner.ctx, ast.Store):
                yield inner.id, None


def _element(iterated: ast.AST) -> ast.AST | None:
    """Return an expression of the kind of what a loop runs over, if it can be told."""
    is_range = isinstance(iterated, ast.Call) and isinstance(iterated.func, ast.Name)
    if is_range and iterated.func.id == "range":  # type: ignore[attr-defined]
        return ast.Constant(0)
    if isinstance(iterated, ast.Attribute) and iterated.attr in INT_LISTS:
        return ast.Constant(0)
    return None


def _common(kinds: list[str | None]) -> str | None:
    """Return the kind that a name has if it may hold any of these: int and float make float."""
    found = set(kinds)
    if len(found) == 1:
        return found.pop()
    return FLOAT if found == {INT, FLOAT} else None
