"""The flights of a batch, one after the other, as the compiled engine runs them.

What goals do in them is what their tasks say, or what a team wrote, by its address. Functions here
run compiled only; what they take are views of directories.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mrsfi_runtime.engine.compiled.layout import ALLOWED, CALLS, N_ALLOWED, OWN, RECORDED
from mrsfi_runtime.engine.compiled.views import call, call_effect, seen_as, word_of
from mrsfi_runtime.engine.recording import VERDICTS, record_type
from mrsfi_runtime.kernel.commands import move
from mrsfi_runtime.kernel.effects import issue, send
from mrsfi_runtime.kernel.flight import MissionFunctions, Verdicts, answer
from mrsfi_runtime.kernel.goal_tasks import table
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import MapState, MissionState, State, kernel

_N_CONSTANT = OWN.fields["memory"][1] // 8  # type: ignore[index]
_N_MISSION, _N_MAP = (record_type(kind).itemsize // 8 for kind in (MissionState, MapState))
_N_VERDICTS = len(VERDICTS)
_ODD = -7046029254386353131


@kernel
def progress(view: Any) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    calls = getattr(view, CALLS)
    for g in range(len(view.goals)):
        if calls[3 * g]:
            call(calls[3 * g], view)
        else:
            table.progress(view, g, view.goals[g].task)


@kernel
def check(view: Any, violated: Any) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    calls = getattr(view, CALLS)
    for g in range(len(view.goals)):
        address = calls[3 * g + 1]
        if address:
            violated[g] = call(address, view)
        else:
            violated[g] = table.violated(view, g, view.goals[g].task)


@kernel
def react(ci: Any) -> None:
    """Let every goal command its members."""
    calls = getattr(ci, CALLS)
    for g in range(len(ci.goals)):
        if calls[3 * g + 2]:
            call(calls[3 * g + 2], ci)
        else:
            table.react(ci, g, ci.goals[g].task)


@kernel
def progress_by_task(view: Any, g: int, task: int) -> int:
    """Note what a goal has to remember, as a task says: what regions call by address."""
    table.progress(view, g, task)
    return 0


@kernel
def check_by_task(view: Any, g: int, task: int) -> int:
    """Return whether a goal is violated, as a task says; by address, likewise."""
    return 1 if table.violated(view, g, task) else 0


@kernel
def react_by_task(ci: Any, g: int, task: int) -> int:
    """Command the members of a goal, as a task says; by address, likewise."""
    table.react(ci, g, task)
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


@dataclass(slots=True)
class Flights:
    """What some flights read and write.

    ``states`` are the directories of truth, belief and inbox, ``plans`` and ``verdicts`` has one a
    specification. ``fresh`` is what changes in a state, before the first tick, ``world, belief,
    inbox`` the same of the states themselves. ``samples`` has the valid ones of each sensor,
    tick after tick. ``results`` has a row a specification: the words of the last truth and belief,
    then the verdicts; ``moments`` one for each tick to be kept, of ``n_moments``. ``at`` receives
    the number of the specification that flies, and says from which tick on and before which.
    """

    n_moments: int
    at: list[int]
    states: list[int]
    fresh: list[int]
    world: list[int]
    belief: list[int]
    inbox: list[int]
    samples: bytes
    plans: list[int]
    verdicts: list[int]
    results: list[int]
    moments: list[int]


_state, _plan, _verdicts = seen_as(State), seen_as(Plan), seen_as(Verdicts)


@kernel
def fly_many(flights: Flights, first: int, last: int) -> int:
    """Fly the specifications ``first … last - 1`` of a batch, each from the first tick or on."""
    functions = MissionFunctions(progress, check, react, apply)
    world = _state(flights.states[0])
    belief = _state(flights.states[1])
    inbox = _state(flights.states[2])
    n_sensors = len(world.sensors)
    n_recorded = len(getattr(world, RECORDED))
    n_words = 2 * n_recorded + _N_VERDICTS * len(world.goals)
    begin, end = flights.at[1], flights.at[2]
    for k in range(first, last):
        flights.at[0] = k
        plan = _plan(flights.plans[k])
        verdicts = _verdicts(flights.verdicts[k])
        row = k * n_words
        if begin == 0:
            n_fresh = len(flights.fresh)
            copy(flights.fresh, 0, flights.world, 0, n_fresh)
            copy(flights.fresh, 0, flights.belief, 0, n_fresh)
            copy(flights.fresh, 0, flights.inbox, 0, n_fresh)
            issue(belief, world, plan, 0)
        for tick in range(begin, end):
            valid = flights.samples[tick * n_sensors : (tick + 1) * n_sensors]
            move(world, valid, tick)
            send(world, inbox)
            answer(functions, world, belief, inbox, world, plan, verdicts, tick)
            moment = tick - begin
            if moment < flights.n_moments or tick + 1 == end:
                copy(flights.world, 0, flights.results, row, n_recorded)
                copy(flights.belief, 0, flights.results, row + n_recorded, n_recorded)
            if moment < flights.n_moments:
                copy(flights.results, row, flights.moments, moment * n_words, n_words)
    return 0


@kernel
def copy(words: list[int], first: int, target: list[int], place: int, n: int) -> None:
    """Copy words to a place."""
    for k in range(n):
        target[place + k] = words[first + k]
