"""What goals do in a compiled flight: as their tasks say, or what a team wrote, by its address."""

from collections.abc import Sequence
from typing import Any

from mrsfi_runtime.engine.compiled.directories import ALLOWED, CALLS, N_ALLOWED, OWN, RECORDED
from mrsfi_runtime.engine.compiled.views import call, call_effect, word_of
from mrsfi_runtime.engine.recording import record_type
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.goal_tasks import reference
from mrsfi_runtime.kernel.state import MapState, MissionState

_N_CONSTANT = OWN.fields["memory"][1] // 8  # type: ignore[index]
_N_MISSION, _N_MAP = (record_type(kind).itemsize // 8 for kind in (MissionState, MapState))
_ODD = -7046029254386353131


@kernel
def progress(view: Any) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    calls = getattr(view, CALLS)
    for g in range(len(view.goals)):
        if calls[3 * g]:
            call(calls[3 * g], view)
        else:
            reference.progress(view, g, view.goals[g].task)


@kernel
def check(view: Any, violated: Any) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    calls = getattr(view, CALLS)
    for g in range(len(view.goals)):
        address = calls[3 * g + 1]
        if address:
            violated[g] = call(address, view)
        else:
            violated[g] = reference.violated(view, g, view.goals[g].task)


@kernel
def react(ci: Any) -> None:
    """Let every goal command its members."""
    calls = getattr(ci, CALLS)
    for g in range(len(ci.goals)):
        if calls[3 * g + 2]:
            call(calls[3 * g + 2], ci)
        else:
            reference.react(ci, g, ci.goals[g].task)


@kernel
def progress_by_task(view: Any, g: int, task: int) -> int:
    """Note what a goal has to remember, as a task says: what regions call by address."""
    reference.progress(view, g, task)
    return 0


@kernel
def check_by_task(view: Any, g: int, task: int) -> int:
    """Return whether a goal is violated, as a task says; by address, likewise."""
    return 1 if reference.violated(view, g, task) else 0


@kernel
def react_by_task(ci: Any, g: int, task: int) -> int:
    """Command the members of a goal, as a task says; by address, likewise."""
    reference.react(ci, g, task)
    return 0


BY_TASK = (progress_by_task, check_by_task, react_by_task)
"""They stand behind the calls of all goals and those of a team's effects."""


@kernel
def apply(ci: Any, inbox: Any, fault: Any) -> None:
    """Let a fault of a team's own type act; fail if it changes what its type does not allow.

    A sum is taken of the words before and after: that no single change escapes follows from the
    factor, which is odd.
    """
    calls = getattr(ci, CALLS)
    address = calls[3 * len(ci.goals)]
    if address == 0:
        return
    before = fixed(ci, inbox, fault)
    call_effect(address, ci, inbox, fault)
    if fixed(ci, inbox, fault) != before:
        raise ValueError


@kernel
def fixed(ci: Any, inbox: Any, fault: Any) -> Any:
    """Return a sum of all words that a fault must not change."""
    believed = getattr(ci, RECORDED)
    total = add(0, getattr(inbox, RECORDED), 0, len(believed))
    total = add_record(total, fault, _N_CONSTANT)
    for view in (ci, inbox):
        total = add_record(add_record(total, view.mission, _N_MISSION), view.map, _N_MAP)
    first = 0
    allowed = getattr(fault, ALLOWED)
    for k in range(N_ALLOWED):
        total = add(total, believed, first, allowed[k])
        first = allowed[k] + 1
    return total


@kernel
def add(total: int, words: Sequence[int], first: int, last: int) -> int:
    """Add some words to a sum."""
    for place in range(first, last):
        total = (total + words[place]) * _ODD
    return total


@kernel
def add_record(total: int, record: Any, n_words: int) -> int:
    """Add the first words of a record to a sum."""
    for place in range(n_words):
        total = (total + word_of(record, place)) * _ODD
    return total
