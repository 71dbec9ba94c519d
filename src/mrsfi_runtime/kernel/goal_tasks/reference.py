"""What goals do for which a team wrote nothing: as a task says, by its number."""

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.goal_tasks.margins import NEVER, NO_MARGIN
from mrsfi_runtime.kernel.goal_tasks.table import TASKS

_MODULES = [sys.modules[task.__module__] for task in TASKS]
FUNCTIONS: Mapping[str, tuple[Callable[..., Any] | None, ...]] = {
    role: tuple(getattr(module, name, None) for module in _MODULES)
    for role, name in (("progress", "progress"), ("check", "violated"), ("react", "react"))
}
"""What generated code calls for each role of a goal, by the number of its task."""


def _by_task(
    role: str, functions: Sequence[Callable[..., Any] | None], otherwise: str, inputs: str = ""
) -> Callable[..., Any]:
    """Return a function of state, goal and number of a task, and more: that of the task.

    It is a chain of comparisons, as written by hand: neither compilers nor the common subset know
    a table of functions.
    """
    tasks = {f"task_{n}": each for n, each in enumerate(functions) if each is not None}
    cases = [
        f"    if task == {name[5:]}:\n        return {name}(view, g{inputs})\n" for name in tasks
    ]
    known: dict[str, Any] = {"__name__": __name__, "inf": NO_MARGIN, **tasks}
    exec(f"def {role}(view, g, task{inputs}):\n{''.join(cases)}    return {otherwise}", known)
    found: Callable[..., Any] = known[role]
    return kernel(found)


progress = _by_task("progress", FUNCTIONS["progress"], "None")
"""Note what a goal has to remember."""

violated = _by_task("check", FUNCTIONS["check"], "False")
"""Return whether a goal is violated in a state."""

react = _by_task("react", FUNCTIONS["react"], "None")
"""Command the members of a goal."""

margin = _by_task("margin", [module.margin for module in _MODULES], f"inf, {NEVER}", ", least")
"""Return how far a goal is from being violated, and after how many ticks it can be nearer."""
