"""Says what is wrong with regions, before anything flies and without running or compiling them.

Errors are certain: a name or a field that does not exist ends a flight as soon as its line is
reached. Warnings are for the compiled engine alone, and so of functions marked ``@kernel``: a
line that would compile to something else. What does not compile, the compiler says. The rest of a
file, constants and tables included, stays plain Python on every engine.
"""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from pkgutil import resolve_name
from textwrap import shorten
from types import ModuleType
from typing import TypeAlias

from pyflakes import messages
from pyflakes.checker import Checker

from mrsfi_runtime.engine.region_kinds import API, Kinds, fields
from mrsfi_runtime.engine.region_rules import remarks
from mrsfi_runtime.engine.region_sources import Source, sources
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.readiness import COMPILES_ALIKE, RUNS, RegionFinding, unfilled_regions

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
"""What pyflakes finds that Python refuses as soon as it reaches the line."""

_LONGEST = 120  # letters of the names that are told

_Rule: TypeAlias = Callable[[Source], Iterator[tuple[int, str]]]


def lint_regions(directory: Path) -> tuple[RegionFinding, ...]:
    """Return what is wrong with the regions of a mission, and the team's files they import."""
    return _found(directory, {**_ERRORS, _compiled: COMPILES_ALIKE})


def require_sound_regions(directory: Path) -> None:
    """Raise EvaluationError of all regions that cannot run, one a line."""
    errors = _found(directory, _ERRORS)
    if errors:
        raise EvaluationError("\n".join(map(str, errors)))


def _found(directory: Path, rules: Mapping[_Rule, str]) -> tuple[RegionFinding, ...]:
    found = (
        RegionFinding(source.path, line, source.place(line), message, constraint)
        for source in sources(directory)
        for rule, constraint in rules.items()
        for line, message in sorted(rule(source))
    )
    return tuple(dict.fromkeys((*unfilled_regions(directory), *found)))


def _no_python(source: Source) -> Iterator[tuple[int, str]]:
    """Yield why a file is no Python; no other rule finds anything there."""
    if source.error is not None:
        what = source.error.msg if isinstance(source.error, SyntaxError) else str(source.error)
        yield getattr(source.error, "lineno", None) or 1, f"is no Python: {what}"


def _undefined(source: Source) -> Iterator[tuple[int, str]]:
    """Yield names that are defined nowhere, and what else pyflakes is sure of."""
    for said in Checker(source.tree, str(source.path)).messages:
        if isinstance(said, messages.UndefinedName):
            where = "" if source.regions is None else " in the region 'imports' or 'helpers'"
            found = f"found `{said.message_args[0]}`, which is not defined; import or define it"
            yield said.lineno, found + where
        elif isinstance(said, _CERTAIN):
            yield said.lineno, f"found a mistake: {said.message % said.message_args}"


def _missing(source: Source) -> Iterator[tuple[int, str]]:
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
    if fields(kind):
        return f"a {kind.__name__}", [*fields(kind)]
    dotted = kinds.dotted(node)
    if dotted == "math" or dotted.startswith(API):
        with suppress(ImportError, AttributeError):
            module = resolve_name(dotted)
            return dotted, dir(module) if isinstance(module, ModuleType) else ()
    return "", ()


def _missed(node: ast.Attribute, owner: str, known: Sequence[str]) -> str:
    near = get_close_matches(node.attr, known, 3) or [n for n in known if n[0] != "_"]
    has = shorten(", ".join(near), _LONGEST, placeholder=" …")
    return f"found `{ast.unparse(node)}`, but {owner} has no '{node.attr}'; it has {has}"


def _compiled(source: Source) -> Iterator[tuple[int, str]]:
    for function in source.kernels.values():
        for line, message in remarks(function, source):
            if source.regions is None or line in source.regions:
                yield line, message


_ERRORS: Mapping[_Rule, str] = dict.fromkeys((_no_python, _undefined, _missing), RUNS)
"""What a region must not have if anything is to fly."""
