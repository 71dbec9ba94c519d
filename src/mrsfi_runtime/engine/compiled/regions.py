"""Finds the regions that a team wrote, and all values that their machine code depends on.

``own_regions`` compares the code of a mission with what its generator writes. A region that only
calls the function of its goal's task is not compiled separately.

Machine code contains globals, defaults and constants as they were when it was compiled. So
``Reached`` writes all values that functions reach, at any depth, as a text; different values have
different texts. The cache's key depends on it. A value without such a text cannot be compiled.
"""

import builtins
import dis
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from enum import Enum, EnumMeta
from functools import partial
from hashlib import sha256
from pathlib import Path
from pkgutil import resolve_name
from types import (
    BuiltinMethodType,
    CodeType,
    EllipsisType,
    FunctionType,
    MethodType,
    ModuleType,
    NoneType,
)
from typing import Any, ClassVar, NamedTuple, TypeAlias

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.kernel.goal_tasks.table import FUNCTIONS, number
from mrsfi_runtime.kernel.state import is_kernel

ROLES = tuple(FUNCTIONS)
EFFECT = "apply"


class CompilationError(EvaluationError):
    """A region cannot be compiled; the message names file, line, region and reason."""


class Region(NamedTuple):
    """A function that a team wrote, and the place of its address among the calls of a state."""

    function: Callable[..., Any]
    role: str
    place: int


def own_regions(
    code: MissionCode, roles: Sequence[str] = ("check", "progress", "react")
) -> list[Region]:
    """Return the regions that a team wrote, in the order of their calls, and effects at last."""
    tasks = [number(goal.task) for goal in code.mission.goals]
    found = []
    goals: dict[str, int] = {}
    for role in roles:
        called = _called(code, role)
        if role == "check":
            goals = {name.removeprefix("check_"): g for g, (name, _) in enumerate(called)}
        listed = [goals.get(name.removeprefix(f"{role}_"), -1) for name, _ in called]
        is_needed = [role != "progress" or _default(role, task) is not None for task in tasks]
        needed = {g for g, each in enumerate(is_needed) if each}
        if listed != sorted(set(listed)) or not needed <= set(listed) <= set(range(len(tasks))):
            raise _odd(code, role)
        for g, (_, function) in zip(listed, called, strict=True):
            if not _is_default(function, role, g, tasks[g]):
                found.append(Region(function, role, len(ROLES) * g + ROLES.index(role)))
    if not _is_written(code.functions.apply, "def f(ci, inbox, fault):", []):
        found.append(Region(code.functions.apply, EFFECT, len(ROLES) * len(tasks)))
    return found


def measured_goals(code: MissionCode) -> tuple[bool, ...]:
    """Return which goals have a margin: those whose check and progress no team wrote."""
    goals, roles = range(len(code.mission.goals)), ("check", "progress")
    try:
        own = {each.place // len(ROLES) for each in own_regions(code, roles) if each.role in roles}
    except CompilationError:
        return tuple(False for _ in goals)
    return tuple(g not in own for g in goals)


def _default(role: str, task: int) -> Any:
    """Return what generated code calls for a role of a task; ``None`` if a team writes it."""
    return FUNCTIONS[role][task] if task < len(FUNCTIONS[role]) else None


def _called(code: MissionCode, role: str) -> list[tuple[str, Callable[..., Any]]]:
    function: Any = getattr(code.functions, role)
    if not isinstance(function, FunctionType):
        raise _odd(code, role)
    names = function.__code__.co_names
    if role == "check":
        numbers, names = names[1::2], names[::2]
        body = [
            f"violated[{g}] = 1 if {name}(view) else 0"
            for name, g in zip(names, numbers, strict=False)
        ]
        is_written = _is_written(function, "def f(view, violated):", body)
        is_written &= [function.__globals__.get(g) for g in numbers] == list(range(len(numbers)))
    else:
        view = (*function.__code__.co_varnames, "view")[0]
        is_written = _is_written(function, f"def f({view}):", [f"{name}({view})" for name in names])
    if not is_written or not function.__globals__.keys() >= set(names):
        raise _odd(code, role)
    return [(name, function.__globals__[name]) for name in names]


def _odd(code: MissionCode, role: str) -> CompilationError:
    return CompilationError(
        f"{code.directory}: '{role}' does not call the functions of the goals as generated code "
        "does; run `mrsfi generate`"
    )


def _is_default(function: Any, role: str, goal: int, task: int) -> bool:
    """Return whether a region only calls the function of its goal's task, by any name."""
    default = _default(role, task)
    names = function.__code__.co_names if is_kernel(function) else ()
    if default is None or len(names) < 2 or not function.__code__.co_varnames:
        return False
    *path, index = names
    view = function.__code__.co_varnames[0]
    returned = "return " if role == "check" else ""
    body = [f"{returned}{'.'.join(path)}({view}, {index})"]
    if not _is_written(function, f"def f({view}):", body):
        return False
    value = function.__globals__.get(path[0])
    for name in path[1:]:
        value = getattr(value, name, None)
    return value is default and function.__globals__.get(index) == goal


def _is_written(function: Any, head: str, body: list[str]) -> bool:
    """Return whether a function has this code, apart from its docstring."""
    if not isinstance(function, FunctionType):
        return False
    lines = [head, *([repr(function.__doc__)] if function.__doc__ else []), *body]
    names: dict[str, Any] = {}
    try:
        exec(compile("\n ".join(lines if len(lines) > 1 else [head, "pass"]), "", "exec"), names)
    except SyntaxError:
        return False
    kept = ("co_code", "co_names", "co_varnames", "co_consts", "co_freevars", "co_cellvars")
    alike: CodeType = names["f"].__code__
    return all(getattr(function.__code__, name) == getattr(alike, name) for name in kept)


_PLAIN = (bool, int, float, complex, str, bytes, range, slice, NoneType, EllipsisType)
_LIBRARIES = (f"{Path(os.__file__).parent}/", "/site-packages/", "/dist-packages/")
_KNOWN = {*sys.stdlib_module_names, "numba", "numpy", "mrsfi_runtime", "None"}  # in any key
_CODE = "argcount posonlyargcount kwonlyargcount flags code exceptiontable names varnames freevars"


_Write: TypeAlias = "Callable[[Reached, Any, frozenset[str]], str]"


class _UnknownError(Exception):
    """A value has no text; it never leaves this module."""


class Reached:
    """The values that functions reach: ``functions`` marked as kernels, each once, and ``text``.

    The text covers all that their machine code may contain, without called functions if it is not
    deep. A CompilationError names a value without a text, such as an object of a class.
    """

    def __init__(self, functions: Sequence[Callable[..., Any]], *, is_deep: bool = True) -> None:
        self._is_deep = is_deep
        self._extended = dict(_extensions())
        self.functions: list[FunctionType] = []
        self._numbers: dict[Any, int] = {}
        self._kept: list[Any] = []  # else another object could get the ID of a deleted one
        self.text = self._all(functions, frozenset())

    def _all(self, values: Any, names: frozenset[str]) -> str:
        return f"[{', '.join(self._of(value, names) for value in values)}]"

    def _of(self, value: Any, names: frozenset[str]) -> str:
        """Return a text that no other value has; of a module, only of the attributes ``names``."""
        kind = type(value)
        if id(value) in self._extended:
            raise _UnknownError(f"what {self._extended[id(value)]} replaces when compiled")
        if kind in _PLAIN or kind.__module__ == "numpy.dtypes":
            return f"{kind.__name__} {value!r}"
        np: Any = sys.modules.get("numpy")  # imported if there are values of it
        arrays = [(np.ndarray | np.generic, Reached._array)] if np else []
        for kinds, write in (*self._written, *arrays):
            if isinstance(value, kinds):
                return f"{kind.__module__}.{kind.__qualname__} {write(self, value, names)}"
        if hasattr(value, "py_func"):  # compiled by numba
            return f"{kind} {value.targetoptions} {self._once(value.py_func, names, Reached._deep)}"
        return _named(value)

    def _once(self, value: Any, names: frozenset[str], write: _Write) -> str:
        """Return the text of a value that may reach itself; from the second time on, a number."""
        key = (id(value), names if isinstance(value, ModuleType) else None)
        if key in self._numbers:
            return f"#{self._numbers[key]}"
        number = self._numbers[key] = len(self._kept)
        self._kept.append(value)
        try:
            return write(self, value, names)
        except _UnknownError:  # no text contains the values that it reached
            self._numbers = {each: n for each, n in self._numbers.items() if n < number}
            raise

    def _function(self, function: FunctionType, names: frozenset[str]) -> str:
        """Return the text of a function; unmarked functions are not compiled."""
        if is_kernel(function) and self.functions and not self._is_deep:
            return str(id(function))
        if is_kernel(function):
            return self._once(function, names, Reached._deep)
        return f"{function.__module__}.{function.__qualname__} {self._code(function.__code__)}"

    def _deep(self, function: FunctionType, _: frozenset[str]) -> str:
        self.functions.append(function)
        names = frozenset(names_of(function.__code__))
        for name in sorted((names | {""}) & self._extended.keys()):
            raise _refusal(function, f"{self._extended[name]} replaces '{name or 'operators'}'")
        read = {name: vars(builtins)[name] for name in names if hasattr(builtins, name)}
        read |= {n: function.__globals__[n] for n in names if n in function.__globals__}
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        with suppress(ValueError):  # nothing in it yet
            read |= {name: cell.cell_contents for name, cell in cells}
        read |= {f"default {n}": value for n, value in enumerate(function.__defaults__ or ())}
        read |= {f"default {n}": value for n, value in (function.__kwdefaults__ or {}).items()}
        read |= {f".{name}": value for name, value in vars(function).items()}
        texts = [
            f"{name}: {self._read(function, name, read[name], names)}" for name in sorted(read)
        ]
        return f"{self._code(function.__code__)} {{{', '.join(texts)}}}"

    def _read(self, function: FunctionType, name: str, value: Any, names: frozenset[str]) -> str:
        try:
            return self._of(value, names)
        except _UnknownError as error:
            if not _loads(function.__code__, name):  # a field of a record has the same name
                return "unknown"
            raise _refusal(function, f"it reads {error} by the name '{name}'") from None

    def _code(self, code: CodeType, _: frozenset[str] = frozenset()) -> str:
        """Return the text of a function's code, without file and line."""
        parts = [repr(getattr(code, f"co_{name}")) for name in _CODE.split()]
        return f"{' '.join(parts)} {self._all(code.co_consts, frozenset())}"

    def _module(self, module: ModuleType, names: frozenset[str]) -> str:
        known = vars(module)
        is_listed = type(module) is ModuleType and "__getattr__" not in known
        if not is_listed and module.__name__.partition(".")[0] not in _KNOWN:
            raise _UnknownError("a module that computes its attributes (__getattr__)")
        texts = (f"{name}: {self._of(known[name], names)}" for name in sorted(names & known.keys()))
        return f"{module.__name__} {{{', '.join(texts)}}}"

    def _array(self, array: Any, _: frozenset[str]) -> str:
        """Return the text of an array or a number of numpy."""
        if array.dtype.hasobject or type(array).__name__ == "MaskedArray":
            raise _UnknownError(f"an array of {array.dtype}")
        content = sha256(array.tobytes()).hexdigest()
        return f"{array.dtype!r} {array.shape} {array.strides} {content}"

    def _class(self, kind: type, names: frozenset[str]) -> str:
        """Return the name of a class, and the parts that numba uses: members or fields."""
        if type(kind).__module__.startswith("numba"):
            raise _UnknownError(f"the compiled class {kind.__qualname__}")
        known: Any = kind
        content: Any = [getattr(kind, "_fields", ()), getattr(kind, "_field_defaults", {})]
        if isinstance(kind, EnumMeta):
            content = [(name, member.value) for name, member in known.__members__.items()]
        return f"{kind.__module__}.{kind.__qualname__} {self._all(content, names)}"

    _written: ClassVar[Sequence[tuple[Any, _Write]]] = (
        (Enum, lambda self, each, names: self._all((type(each), each.name, each.value), names)),
        (tuple, lambda self, each, names: self._all((*getattr(each, "_fields", ()), *each), names)),
        (list, partial(_once, write=_all)),
        (dict, partial(_once, write=lambda self, each, names: self._all(each.items(), names))),
        (set | frozenset, lambda self, each, names: str(sorted(self._of(x, names) for x in each))),
        (CodeType, _code),
        (FunctionType, _function),
        (ModuleType, partial(_once, write=_module)),
        (type, partial(_once, write=_class)),
    )
    """How the values of some kinds are written; those that may reach themselves, only once."""


def _named(value: Any) -> str:
    """Return the name by which a library has a value."""
    is_bound = isinstance(value, BuiltinMethodType | MethodType)
    if is_bound and not isinstance(value.__self__, ModuleType | NoneType):
        return f"{_named(type(value.__self__))}.{value.__name__}"  # such as random.random
    module, name = getattr(value, "__module__", None), getattr(value, "__qualname__", None)
    file = getattr(sys.modules.get(module or ""), "__file__", None)
    is_found = False
    is_library = file is not None and any(library in file for library in _LIBRARIES)
    if is_library or module in sys.builtin_module_names:
        with suppress(ImportError, AttributeError):
            is_found = resolve_name(f"{module}:{name or value.__name__}") is value
    if not is_found:
        raise _UnknownError(f"an object of {type(value).__module__}.{type(value).__qualname__}")
    return f"{module}.{name}"


def _refusal(function: FunctionType, why: str) -> CompilationError:
    place = function.__code__.co_filename, function.__code__.co_firstlineno
    found = CompilationError(
        f"{place[0]}:{place[1]}: {function.__name__} cannot be compiled: {why}, and changes of it "
        "go undetected; expected numbers, texts, tuples, arrays, enums, or functions marked @kernel"
    )
    found.line = Path(place[0]), place[1]
    return found


def _extensions() -> Iterator[tuple[int | str, str]]:
    """Yield the functions and attributes whose compilation extensions of numba change, and which.

    A function is given by its ID, an attribute by its name, operators and built-ins by "".
    """
    templates: Any = sys.modules.get("numba.core.typing.templates")
    known = templates.builtin_registry if templates else None
    for template in (*known.functions, *known.attributes) if known else ():
        key = template.key
        for origin in (template, key, getattr(template, "_overload_func", key)):
            if _package(origin) not in _KNOWN and not is_kernel(origin):
                place = "" if _package(key) in ("builtins", "_operator") else id(key)
                yield getattr(template, "_attr", place), f"{origin.__module__}.{origin.__name__}"


def _package(value: object) -> str:
    return str(getattr(value, "__module__", "builtins")).partition(".")[0]


def names_of(code: CodeType) -> Iterator[str]:
    """Yield the names that a function does not define itself, those in comprehensions included."""
    yield from (*code.co_names, *code.co_freevars)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from names_of(inner)


def _loads(code: CodeType, name: str) -> bool:
    """Return whether a function reads a name that is no attribute; defaults are always read."""
    inner = [each for each in code.co_consts if isinstance(each, CodeType)]
    is_read = any(
        each.argval == name and each.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF")
        for each in dis.get_instructions(code)
    )
    return name.startswith("default ") or is_read or any(_loads(each, name) for each in inner)
