"""What in a function of a region would not compile, or would compile to something else.

Rules speak of what they can see: a value that only a flight knows, such as the argument of
``math.sqrt`` or the size of a product of names, is left to the engine, which repeats the first
evaluations on the reference engine.
"""

import ast
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise

from mrsfi_runtime.engine.region_kinds import Kind, Kinds, element, is_record_list, literal
from mrsfi_runtime.engine.region_names import remark_on
from mrsfi_runtime.engine.region_sources import Source

_CONTAINER = "is a global list, dict or set and cannot be compiled; write a tuple of numbers"
_HALVES = (
    "may round halves otherwise when compiled; compare unrounded numbers, or write round(x * "
    "100) / 100"
)
_ADDED = "may add floats otherwise from Python 3.12 on than when compiled; add in a loop"
_KEYS = (
    "may order elements of equal keys otherwise when compiled; sort tuples, or make every "
    "key another"
)
_WHOLE_POWER = (
    "is 0 when compiled if the exponent is below 0, and wraps beyond 64 bits; multiply in a loop"
)
_BELOW_ZERO = (
    "is an error in Python and NaN when compiled if the difference is below 0; write max(…, "
    "0.0) around it"
)
_BEYOND_ONE = (
    "is an error in Python and NaN when compiled beyond -1 and 1; write min(max(…, -1.0), "
    "1.0) around it"
)
_WRAPS = (
    "may need more than 64 bits, where compiled integers wrap; mask the result with `& "
    "0xFFFFFFFF`, or use smaller numbers"
)
_IDENTITY = (
    "compares values when compiled, and objects in Python; write == or !=, or compare indices"
)
_COPIED = (
    "copies a record when compiled, and makes two names of one in Python; assign field by field"
)
_HANDLER = "cannot be compiled; write `except Exception:`, or test before instead"
_DEFAULT = "cannot be compiled as a default; keep what lasts in the fields of `ci`"
_DIFFERS = "may differ in the last bit when compiled"
_SET_ORDER = "takes a set in another order when compiled; write sorted(…)"
_TEXT = "has another text when compiled if it is a float; compare numbers"
_CUT = "keeps the float in Python and cuts it off when compiled; write int(…) or round(…)"

_LARGEST = 2**63 - 1
_WIDE = 2**32
_SHOWN = 50
_LIST_METHODS = frozenset(
    ("append", "clear", "count", "extend", "index", "insert", "pop", "remove", "reverse")
)


def remarks(function: ast.FunctionDef, source: Source) -> Iterator[tuple[int, bool, str]]:
    """Yield what is to be said of a function that will be compiled.

    Yields
    ------
    tuple
        Line; whether it compiles, to something else; what was found, why it matters and what
        to write instead.
    """
    rules = _Rules(function, source)
    for node in ast.walk(function):
        for does_compile, found, why in rules.of(node):
            line = getattr(node, "lineno", function.lineno)
            yield line, does_compile, f"found `{_shown(found)}`, which {why}"


def _shown(node: ast.AST) -> str:
    text = ast.unparse(node).partition("\n")[0]
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."


Saying = tuple[bool, ast.AST, str]

_SYNTAX: Mapping[type[ast.AST], str] = {
    ast.GeneratorExp: "cannot be compiled; write a loop",
    ast.SetComp: "cannot be compiled; write a loop",
    ast.NamedExpr: "cannot be compiled; assign on a line of its own",
    ast.With: "cannot be compiled; leave it out: a region reads and commands `ci` alone",
    ast.Import: "cannot be compiled; import in the region 'imports'",
    ast.ImportFrom: "cannot be compiled; import in the region 'imports'",
    ast.Global: "cannot be compiled; keep what lasts in the fields of `ci`",
    ast.ClassDef: "cannot be compiled; write functions, or constants in the region 'helpers'",
    ast.Delete: "cannot be compiled; leave the name alone",
}


class _Rules:
    """The rules, by the kind of syntax that they look at."""

    def __init__(self, function: ast.FunctionDef, source: Source) -> None:
        self._function = function
        self._source = source
        self._kinds = Kinds(function, source)
        self._masked = {
            id(inner)
            for node in ast.walk(function)
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd)
            if any(_is_mask(side) for side in (node.left, node.right))
            for inner in ast.walk(node)
        }
        self._by_type: Mapping[type[ast.AST], Callable[..., Iterator[Saying]]] = {
            ast.Name: self._name,
            ast.Attribute: self._attribute,
            ast.Call: self._call,
            ast.BinOp: self._operation,
            ast.UnaryOp: self._inversion,
            ast.Compare: self._identity,
            ast.Constant: self._constant,
            ast.Assign: self._assignment,
            ast.AugAssign: self._assignment,
            ast.For: self._loop,
            ast.ListComp: self._list,
            ast.JoinedStr: self._text,
            ast.ExceptHandler: self._handler,
            ast.FunctionDef: self._defaults,
        }

    def of(self, node: ast.AST) -> Iterator[Saying]:
        """Yield what is to be said of one node."""
        if type(node) in _SYNTAX:
            yield False, node, _SYNTAX[type(node)]
        rule = self._by_type.get(type(node))
        if rule is not None:
            yield from rule(node)

    def _name(self, node: ast.Name) -> Iterator[Saying]:
        if node.id in self._kinds.local:
            return
        yield from self._remark(node)
        value = self._source.constants.get(node.id)
        if isinstance(value, ast.List | ast.Dict | ast.Set | ast.ListComp | ast.DictComp):
            yield False, node, _CONTAINER
        if node.id in self._source.functions.keys() - self._source.kernels.keys():
            yield False, node, "is not marked @kernel and cannot be compiled; mark it"
        number = None if value is None else literal(value)
        if isinstance(number, int) and not _fits(number):
            yield _too_large(node)

    def _attribute(self, node: ast.Attribute) -> Iterator[Saying]:
        yield from self._remark(node)

    def _remark(self, node: ast.AST) -> Iterator[Saying]:
        remark = remark_on(self._kinds.dotted(node))
        if remark is not None:
            yield remark.does_compile, node, f"{remark.why}; {remark.instead}"

    def _call(self, node: ast.Call) -> Iterator[Saying]:
        name = self._kinds.dotted(node.func)
        if name in ("pow", "math.pow") and len(node.args) == 2:
            yield from self._power(node, *node.args)
        elif name in ("math.sqrt", "math.log", "math.acos", "math.asin") and node.args:
            yield from self._domain(node, name)
        elif name == self._function.name:
            yield False, node, "calls its own function and cannot be compiled; write a loop"
        elif name in ("min", "max") and node.keywords:
            yield False, node, "cannot be compiled with keywords; write a loop"
        elif name == "round" and len(node.args) == 2 and not self._is_int(node.args[0]):
            yield True, node, _HALVES
        else:
            yield from self._call_of_container(node, name)

    def _call_of_container(self, node: ast.Call, name: str) -> Iterator[Saying]:
        first = node.args[0] if node.args else None
        kind = self._kinds.of(first)
        method = node.func.attr if isinstance(node.func, ast.Attribute) else ""
        if name == "sum" and not (isinstance(first, ast.ListComp) and self._is_whole(first.elt)):
            if element(kind) is not int:
                yield True, node, _ADDED
        elif name in ("list", "tuple", "enumerate") and kind is set:
            yield True, node, _SET_ORDER
        elif name in ("str", "repr") and not self._is_whole(first):
            yield True, node, _TEXT
        elif method:
            yield from self._method(node, node.func, method)  # type: ignore[arg-type]
        if (name == "sorted" or method == "sort") and any(k.arg == "key" for k in node.keywords):
            yield True, node, _KEYS

    def _method(self, node: ast.Call, function: ast.Attribute, method: str) -> Iterator[Saying]:
        owner = function.value
        is_of_state = isinstance(owner, ast.Attribute) and element(self._kinds.of(owner))
        if is_of_state and method in _LIST_METHODS:
            yield False, node, "cannot be compiled: lists of `ci` have no methods; write a loop"
        if method == "pop" and self._kinds.of(owner) is set:
            yield True, node, _SET_ORDER
        if method == "format":
            yield False, node, "cannot be compiled; leave texts to the analysis"

    def _operation(self, node: ast.BinOp) -> Iterator[Saying]:
        if isinstance(node.op, ast.Pow):
            yield from self._power(node, node.left, node.right)
        elif isinstance(node.op, ast.LShift | ast.Mult) and id(node) not in self._masked:
            yield from self._growth(node)
        elif isinstance(node.op, ast.Mod) and _is_text(node.left):
            yield False, node, "cannot be compiled; leave texts to the analysis"
        found = literal(node)
        if isinstance(found, int) and not _fits(found):
            yield _too_large(node)

    def _power(self, node: ast.AST, base: ast.AST, exponent: ast.AST) -> Iterator[Saying]:
        power = literal(exponent)
        if literal(node) is not None or power in (0, 1):
            return
        if self._is_int(base) and self._is_int(exponent):
            if power is None or power < 0:
                yield True, node, _WHOLE_POWER
            return
        instead = {2: "write x * x", 0.5: "write math.sqrt(x)"}.get(power or 0, "multiply")
        yield True, node, f"{'may differ' if power is None else _DIFFERS}; {instead}"

    def _domain(self, node: ast.Call, name: str) -> Iterator[Saying]:
        argument = node.args[0]
        is_difference = isinstance(argument, ast.BinOp) and isinstance(argument.op, ast.Sub)
        is_bounded = literal(argument) is not None or _is_call_of(argument, ("min", "max"))
        if name in ("math.sqrt", "math.log"):
            if is_difference:
                yield True, node, _BELOW_ZERO
        elif not is_bounded and not isinstance(argument, ast.Name):
            yield True, node, _BEYOND_ONE

    def _growth(self, node: ast.BinOp) -> Iterator[Saying]:
        if literal(node) is not None or float in map(self._kinds.of, (node.left, node.right)):
            return
        if isinstance(node.op, ast.LShift):
            count = literal(node.right)
            is_wide = count is None or count >= 32
        else:
            sides = [literal(side) for side in (node.left, node.right)]
            is_wide = any(isinstance(side, int) and abs(side) >= _WIDE for side in sides)
        if is_wide:
            yield True, node, _WRAPS

    def _inversion(self, node: ast.UnaryOp) -> Iterator[Saying]:
        if isinstance(node.op, ast.Invert) and self._kinds.of(node.operand) is bool:
            yield True, node, "is always true in Python and a `not` when compiled; write not"

    def _identity(self, node: ast.Compare) -> Iterator[Saying]:
        operands = [node.left, *node.comparators]
        for operator, (left, right) in zip(node.ops, pairwise(operands), strict=True):
            is_singleton = _is_singleton(left) or _is_singleton(right)
            if isinstance(operator, ast.Is | ast.IsNot) and not is_singleton:
                yield True, node, _IDENTITY

    def _constant(self, node: ast.Constant) -> Iterator[Saying]:
        if isinstance(node.value, int) and not _fits(node.value):
            yield _too_large(node)

    def _assignment(self, node: ast.Assign | ast.AugAssign) -> Iterator[Saying]:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        kind = self._kinds.of(
            node.value
            if isinstance(node, ast.Assign)
            else ast.BinOp(node.target, node.op, node.value)
        )
        for target in targets:
            inner = target.elts if isinstance(target, ast.Tuple | ast.List) else [target]
            for each in inner:
                yield from self._stored(node, each, kind)

    def _stored(self, node: ast.AST, target: ast.AST, kind: Kind) -> Iterator[Saying]:
        if isinstance(target, ast.Starred):
            yield False, node, "cannot be compiled; unpack by index"
        is_field = isinstance(target, ast.Attribute | ast.Subscript)
        if is_field and kind is float and self._is_int(target):
            yield True, node, _CUT
        if isinstance(target, ast.Subscript) and is_record_list(self._kinds.of(target.value)):
            yield True, node, _COPIED

    def _loop(self, node: ast.For) -> Iterator[Saying]:
        if self._kinds.of(node.iter) is set:
            yield True, node, _SET_ORDER

    def _list(self, node: ast.ListComp) -> Iterator[Saying]:
        first = node.generators[0]
        if any(self._kinds.of(one.iter) is set for one in node.generators):
            yield True, node, _SET_ORDER
        is_of_records = is_record_list(self._kinds.of(first.iter))
        if is_of_records and ast.dump(node.elt) == ast.dump(first.target).replace("Store", "Load"):
            yield False, node, "is a list of records and cannot be compiled; list their indices"

    def _text(self, node: ast.JoinedStr) -> Iterator[Saying]:
        for part in node.values:
            if not isinstance(part, ast.FormattedValue):
                continue
            if part.format_spec is not None or part.conversion != -1:
                yield False, node, "cannot be compiled; leave texts to the analysis"
            elif not self._is_whole(part.value):
                yield True, node, _TEXT

    def _is_int(self, node: ast.AST) -> bool:
        return self._kinds.of(node) is int

    def _is_whole(self, node: ast.AST | None) -> bool:
        return self._kinds.of(node) in (int, bool) or node is None or _is_text(node)

    def _handler(self, node: ast.ExceptHandler) -> Iterator[Saying]:
        is_general = node.type is None or self._kinds.dotted(node.type) == "Exception"
        if not is_general or node.name is not None:
            yield False, node, _HANDLER

    def _defaults(self, node: ast.FunctionDef) -> Iterator[Saying]:
        for default in node.args.defaults:
            if isinstance(default, ast.List | ast.Dict | ast.Set):
                yield False, default, _DEFAULT


def _fits(number: int) -> bool:
    return -_LARGEST - 1 <= number <= _LARGEST


def _too_large(node: ast.AST) -> Saying:
    return True, node, "does not fit into 64 bits and wraps; use smaller numbers"


def _is_mask(node: ast.AST) -> bool:
    mask = literal(node)
    return isinstance(mask, int) and 0 <= mask <= _LARGEST


def _is_singleton(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and (node.value is None or isinstance(node.value, bool))


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _is_call_of(node: ast.AST, names: tuple[str, ...]) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in names
