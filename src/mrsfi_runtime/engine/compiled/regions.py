"""Which regions of a mission a team wrote: those that are not what their goal's task says."""

from collections.abc import Callable, Sequence
from types import CodeType, FunctionType
from typing import Any, NamedTuple

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.kernel.goal_tasks.table import FUNCTIONS, number
from mrsfi_runtime.kernel.state import is_kernel

ROLES = tuple(FUNCTIONS)
EFFECT = "apply"


class CompilationError(EvaluationError):
    """A region cannot be compiled; the message names file, line, region and reason."""


class Region(NamedTuple):
    """What a team wrote, and the place of its address among the calls of a state."""

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
    """Return which goals have a margin: those of which a team wrote neither check nor progress."""
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
    """Return whether a region only calls what its goal's task says, by whatever name."""
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
    """Return whether a function has such a text, but for its own text of what it does."""
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
