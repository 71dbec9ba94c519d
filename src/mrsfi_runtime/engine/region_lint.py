"""Finds errors in regions before a flight, without running or compiling them.

Errors are certain: a name or a field that does not exist ends a flight as soon as its line is
reached. Warnings concern only the compiled engine, and so functions marked ``@kernel``: a line
whose compiled code behaves differently than Python. The compiler itself reports code that does not
compile. The rest of a file, constants and tables included, stays plain Python on every engine.

Every warning was measured, CPython 3.11 against numba 0.68 on x86-64: see
``tests/conformance/test_region_lint.py``. Syntax without a rule behaved the same, such as
``//``, ``%``, ``round(x)``, ``math.sqrt`` and, on this processor family, ``math.sin``. Values that
are known only in flight, such as the argument of ``math.sqrt`` or the size of a product of names,
are left to the engine, which compares first ticks with the reference engine.

``_RULES`` are the warnings, ``_ERRORS`` the errors; ``lint_regions`` at the end applies both.
"""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from pkgutil import resolve_name
from textwrap import shorten
from types import MappingProxyType, ModuleType
from typing import Any, NamedTuple, TypeAlias

from pyflakes import messages
from pyflakes.checker import Checker

from mrsfi_runtime.engine.region_sources import (
    API,
    Kinds,
    Source,
    bound,
    element,
    fields,
    literal,
    sources,
)
from mrsfi_runtime.errors import Diagnostic, EvaluationError, Severity
from mrsfi_runtime.generated_code import unfilled_regions

RUNS, COMPILES_ALIKE = "RegionRuns", "RegionCompilesAlike"
"""Constraints of a line: it runs, else it is an error; it compiles to the same, else a warning."""

_LARGEST = 2**63 - 1

_LAST_BIT = "may differ in the last bit when compiled"
_SET_ORDER = "reads a set in another order when compiled; write sorted(…)"
_TEXT = "formats floats differently when compiled; compare numbers"
_TOO_LARGE = "does not fit into 64 bits and wraps when compiled; use smaller numbers"

_GAMMA = f"{_LAST_BIT}; read the values from a table of constants"
_MATH = f"{_LAST_BIT}; use the function of math, or read a table"
_SUM = "adds in another order when compiled; add in a loop"

_ROUNDED = (
    "arccos", "arcsin", "arcsinh", "arctan", "arctan2", "arctanh", "cbrt", "cosh", "exp", "exp2",
    "expm1", "log10", "log1p", "power", "sinh", "tan", "tanh",
)  # fmt: skip
_SUMS = ("average", "linalg.norm", "mean", "nanmean", "nansum", "std", "sum", "var")

NAMES: Mapping[str, str] = MappingProxyType(
    {
        "math.hypot": f"{_LAST_BIT}; write math.sqrt(x * x + y * y)",
        "math.gamma": _GAMMA,
        "math.lgamma": _GAMMA,
        **{f"numpy.{name}": _MATH for name in _ROUNDED},
        **{f"numpy.{name}": _SUM for name in _SUMS},
        "numpy.argsort": (
            "may order equal values differently when compiled; sort tuples of value and index"
        ),
    }
)
"""Warnings about library functions: the reason, and what to write instead."""

_DRAWS = (
    "draws other numbers when compiled, if it compiles at all; write randomness.uniform or "
    "randomness.choice, which draw the same numbers on every engine"
)


def remarks(function: ast.FunctionDef, source: Source) -> Iterator[tuple[int, str]]:
    """Yield lines and warnings of a function that will be compiled."""
    at = _Function(function, source)
    for node in at.nodes:
        for why in _reasons(node, at):
            text = ast.unparse(node).partition("\n")[0]
            shown = text if len(text) <= 50 else text[:50] + "..."
            yield getattr(node, "lineno", function.lineno), f"found `{shown}`, which {why}"


def _reasons(node: ast.AST, at: "_Function") -> Iterator[str]:
    name = at.dotted(node)
    if name in NAMES or name.startswith(("random.", "numpy.random.")):
        yield NAMES.get(name, _DRAWS)
    keys = {type(node).__name__}
    if isinstance(node, ast.Call):
        method = f".{node.func.attr}" if isinstance(node.func, ast.Attribute) else ""
        keys |= {at.dotted(node.func), method}
    for rule in _RULES:
        found = not keys.isdisjoint(rule.syntax.split()) and rule.applies(node, at)
        if found:
            yield rule.why.format(found)


class _Function(Kinds):
    def __init__(self, function: ast.FunctionDef, source: Source) -> None:
        super().__init__(function, source)
        self.nodes = [*ast.walk(function)]
        self.masked = {
            id(inner)
            for node in self.nodes
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd)
            if any(_is_mask(side) for side in (node.left, node.right))
            for inner in ast.walk(node)
        }

    def is_whole(self, node: ast.AST) -> bool:
        """Whether an expression is certainly no float."""
        return self.of(node) in (int, bool, str)


def _fits(number: float | None) -> bool:
    return not isinstance(number, int) or -_LARGEST - 1 <= number <= _LARGEST


def _is_mask(node: ast.AST) -> bool:
    mask = literal(node)
    return isinstance(mask, int) and 0 <= mask <= _LARGEST


def _is_bounded(node: ast.AST) -> bool:
    is_bounding = isinstance(node, ast.Call) and ast.unparse(node.func) in ("min", "max")
    return is_bounding or isinstance(node, ast.Name) or literal(node) is not None


def _power(node: ast.BinOp | ast.Call, at: _Function) -> str | None:
    base, exponent = node.args[:2] if isinstance(node, ast.Call) else (node.left, node.right)
    power = literal(exponent)
    if literal(node) is not None or power in (0, 1):
        return None
    if at.of(base) is at.of(exponent) is int:
        if power is not None and power >= 0:
            return None
        return (
            "is 0 when compiled if the exponent is below 0, and wraps beyond 64 bits; multiply in "
            "a loop"
        )
    if power is None:
        return "may differ when compiled; multiply"
    instead = {2: "write x * x", 0.5: "write math.sqrt(x)"}.get(power, "multiply")
    return f"{_LAST_BIT}; {instead}"


def _is_wide(node: ast.BinOp, at: _Function) -> bool:
    left, right = literal(node.left), literal(node.right)
    is_known = literal(node) is not None or float in map(at.of, (node.left, node.right))
    if is_known or id(node) in at.masked:
        return False
    if isinstance(node.op, ast.LShift):
        return right is None or right >= 32
    is_product = isinstance(node.op, ast.Mult)
    return is_product and any(isinstance(x, int) and abs(x) >= 2**32 for x in (left, right))


def _is_singleton(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and (node.value is None or isinstance(node.value, bool))


def _compares_objects(node: ast.Compare, _at: _Function) -> bool:
    pairs = zip(node.ops, pairwise([node.left, *node.comparators]), strict=True)
    return any(
        isinstance(operator, ast.Is | ast.IsNot) and not any(map(_is_singleton, sides))
        for operator, sides in pairs
    )


def _targets(node: ast.Assign | ast.AugAssign) -> Iterator[ast.AST]:
    for target, _ in bound(node):
        yield from target.elts if isinstance(target, ast.Tuple | ast.List) else [target]


def _cuts_off(node: ast.Assign | ast.AugAssign, at: _Function) -> bool:
    """Whether a float is stored where integers belong."""
    is_float = any(at.of(value) is float for _, value in bound(node))
    kept = [each for each in _targets(node) if isinstance(each, ast.Attribute | ast.Subscript)]
    return is_float and any(at.of(target) is int for target in kept)


def _copies(node: ast.Assign | ast.AugAssign, at: _Function) -> bool:
    """Whether a record is stored in a list of records."""
    lists = [target.value for target in _targets(node) if isinstance(target, ast.Subscript)]
    return any(fields(element(at.of(each))) for each in lists)


def _adds_floats(node: ast.Call, at: _Function) -> bool:
    first = node.args[0] if node.args else None
    is_whole = isinstance(first, ast.ListComp) and at.is_whole(first.elt)
    return not is_whole and element(at.of(first)) is not int


class Rule(NamedTuple):
    """A warning about some syntax: kinds of nodes, and calls of functions and ``.methods``.

    ``applies`` returns whether it applies to such a node of a function. ``why`` has the reason and
    what to write instead, with ``{}`` for the value that ``applies`` returned.
    """

    syntax: str
    applies: Callable[[Any, _Function], object]
    why: str


_RULES: Sequence[Rule] = (
    Rule("Name", lambda node, at: not _fits(at.constant(node.id)), _TOO_LARGE),
    Rule("Constant BinOp", lambda node, _: not _fits(literal(node)), _TOO_LARGE),
    Rule(
        "BinOp",
        _is_wide,
        "may need more than 64 bits, where compiled integers wrap; mask the result with `& "
        "0xFFFFFFFF`, or use smaller numbers",
    ),
    Rule("BinOp", lambda node, at: isinstance(node.op, ast.Pow) and _power(node, at), "{}"),
    Rule("pow math.pow", lambda node, at: len(node.args) == 2 and _power(node, at), "{}"),
    Rule(
        "UnaryOp",
        lambda node, at: isinstance(node.op, ast.Invert) and at.of(node.operand) is bool,
        "is always true in Python, but means `not` when compiled; write not",
    ),
    Rule(
        "Compare",
        _compares_objects,
        "compares objects in Python, but values when compiled; write == or !=, or compare indices",
    ),
    Rule(
        "Assign AugAssign",
        _cuts_off,
        "keeps the float in Python, but truncates it when compiled; write int(…) or round(…)",
    ),
    Rule(
        "Assign AugAssign",
        _copies,
        "copies a record when compiled, but gives one record two names in Python; assign field "
        "by field",
    ),
    Rule("For", lambda node, at: at.of(node.iter) is set, _SET_ORDER),
    Rule(
        "ListComp", lambda node, at: set in [at.of(one.iter) for one in node.generators], _SET_ORDER
    ),
    Rule("list tuple enumerate", lambda node, at: set in map(at.of, node.args[:1]), _SET_ORDER),
    Rule(".pop", lambda node, at: at.of(node.func.value) is set, _SET_ORDER),
    Rule(
        "sorted .sort",
        lambda node, _: "key" in [keyword.arg for keyword in node.keywords],
        "may order elements with equal keys differently when compiled; sort tuples, or make all "
        "keys different",
    ),
    Rule(
        "JoinedStr",
        lambda node, at: (
            not all(
                at.is_whole(part.value)
                for part in node.values
                if isinstance(part, ast.FormattedValue) and part.format_spec is None
            )
        ),
        _TEXT,
    ),
    Rule("str repr", lambda node, at: not all(map(at.is_whole, node.args[:1])), _TEXT),
    Rule(
        "round",
        lambda node, at: len(node.args) == 2 and at.of(node.args[0]) is not int,
        "may round halves differently when compiled; compare unrounded numbers, or write "
        "round(x * 100) / 100",
    ),
    Rule(
        "sum",
        _adds_floats,
        "may add floats differently when compiled than in Python 3.12 or later; add in a loop",
    ),
    Rule(
        "math.sqrt math.log",
        lambda node, _: [type(getattr(each, "op", None)) for each in node.args[:1]] == [ast.Sub],
        "is an error in Python, but NaN when compiled, if the difference is negative; write "
        "max(…, 0.0) around it",
    ),
    Rule(
        "math.acos math.asin",
        lambda node, _: not all(map(_is_bounded, node.args[:1])),
        "is an error in Python, but NaN when compiled, outside -1 … 1; write min(max(…, -1.0), "
        "1.0) around it",
    ),
)


_CERTAIN = (
    messages.UndefinedLocal,
    messages.InvalidPrintSyntax,
    messages.RaiseNotImplemented,
    messages.StringDotFormatInvalidFormat,
    messages.StringDotFormatMissingArgument,
    messages.StringDotFormatMixingAutomatic,
    messages.PercentFormatExpectedMapping,
    messages.PercentFormatExpectedSequence,
    messages.PercentFormatInvalidFormat,
    messages.PercentFormatMissingArgument,
    messages.PercentFormatMixedPositionalAndNamed,
    messages.PercentFormatPositionalCountMismatch,
    messages.PercentFormatUnsupportedFormatCharacter,
)
"""Findings of pyflakes that Python refuses as soon as it reaches the line."""

_Rule: TypeAlias = Callable[[Source], Iterator[tuple[int, str]]]


def lint_regions(directory: Path) -> tuple[Diagnostic, ...]:
    """Return all findings in a mission's regions, and in the team's files that they import."""
    return _findings(directory, {**_ERRORS, _compiled: COMPILES_ALIKE})


def require_sound_regions(directory: Path) -> None:
    """Raise an EvaluationError that lists the regions that cannot run, one a line."""
    errors = _findings(directory, _ERRORS)
    if errors:
        raise EvaluationError("\n".join(map(str, errors)))


def _findings(directory: Path, rules: Mapping[_Rule, str]) -> tuple[Diagnostic, ...]:
    found = (
        _diagnostic(source, line, constraint, message)
        for source in sources(directory)
        for rule, constraint in rules.items()
        for line, message in sorted(rule(source))
    )
    return tuple(dict.fromkeys((*unfilled_regions(directory), *found)))


def _diagnostic(source: Source, line: int, constraint: str, message: str) -> Diagnostic:
    severity: Severity = "warning" if constraint == COMPILES_ALIKE else "error"
    place = source.place(line)
    return Diagnostic(source.path, line, place, constraint, severity, f"{place}: {message}")


def _no_python(source: Source) -> Iterator[tuple[int, str]]:
    """Yield why a file is not valid Python; no other rule finds anything there."""
    if source.error is not None:
        what = source.error.msg if isinstance(source.error, SyntaxError) else str(source.error)
        yield getattr(source.error, "lineno", None) or 1, f"is not valid Python: {what}"


def _undefined(source: Source) -> Iterator[tuple[int, str]]:
    """Yield names that are defined nowhere, and other certain findings of pyflakes."""
    for finding in Checker(source.tree, str(source.path)).messages:
        if isinstance(finding, messages.UndefinedName):
            where = "" if source.regions is None else " in the region 'imports' or 'helpers'"
            text = f"found `{finding.message_args[0]}`, which is not defined; import or define it"
            yield finding.lineno, text + where
        elif isinstance(finding, _CERTAIN):
            yield finding.lineno, f"found an error: {finding.message % finding.message_args}"


def _missing(source: Source) -> Iterator[tuple[int, str]]:
    """Yield lines with a field that a record lacks, or a name that a module of mrsfi lacks."""
    for function in source.functions.values():
        kinds = Kinds(function, source)
        for node in ast.walk(function):
            if isinstance(node, ast.Attribute):
                owner, known = _known(node.value, kinds)
                if known and node.attr not in known:
                    yield node.lineno, _missing_name(node, owner, known)


def _known(node: ast.AST, kinds: Kinds) -> tuple[str, Sequence[str]]:
    """Return what an expression is, if that is certain, and which names it has."""
    kind = kinds.of(node)
    if fields(kind):
        return f"a {kind.__name__}", [*fields(kind)]
    dotted = kinds.dotted(node)
    if dotted == "math" or dotted.startswith(API):
        with suppress(ImportError, AttributeError):
            module = resolve_name(dotted)
            return dotted, dir(module) if isinstance(module, ModuleType) else ()
    return "", ()


def _missing_name(node: ast.Attribute, owner: str, known: Sequence[str]) -> str:
    near = get_close_matches(node.attr, known, 3) or [n for n in known if n[0] != "_"]
    has = shorten(", ".join(near), 120, placeholder=" …")
    return f"found `{ast.unparse(node)}`, but {owner} has no '{node.attr}'; it has {has}"


def _compiled(source: Source) -> Iterator[tuple[int, str]]:
    for function in source.kernels.values():
        for line, message in remarks(function, source):
            if source.regions is None or line in source.regions:
                yield line, message


_ERRORS: Mapping[_Rule, str] = dict.fromkeys((_no_python, _undefined, _missing), RUNS)
"""Rules whose findings prevent any flight."""
