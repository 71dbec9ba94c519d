"""The flights of a batch, one after the other, as the compiled engine runs them.

Functions here run compiled only; what they take are views of directories.
"""

from dataclasses import dataclass

from mrsfi_runtime.engine.compiled import dispatch
from mrsfi_runtime.engine.compiled.directories import RECORDED
from mrsfi_runtime.engine.compiled.views import seen_as
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.delivery import send
from mrsfi_runtime.kernel.effects.commands import issue
from mrsfi_runtime.kernel.flight import MissionFunctions, Verdicts, answer
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.motion import move
from mrsfi_runtime.kernel.state import State


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
    functions = MissionFunctions(dispatch.progress, dispatch.check, dispatch.react, dispatch.apply)
    world = _state(flights.states[0])
    belief = _state(flights.states[1])
    inbox = _state(flights.states[2])
    n_sensors = len(world.sensors)
    n_recorded = len(getattr(world, RECORDED))
    n_words = 2 * n_recorded + 7 * len(world.goals)
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
            if tick - begin < flights.n_moments:
                moment = (tick - begin) * n_words
                copy(flights.world, 0, flights.moments, moment, n_recorded)
                copy(flights.belief, 0, flights.moments, moment + n_recorded, n_recorded)
                copy(
                    flights.results,
                    row + 2 * n_recorded,
                    flights.moments,
                    moment + 2 * n_recorded,
                    n_words - 2 * n_recorded,
                )
        copy(flights.world, 0, flights.results, row, n_recorded)
        copy(flights.belief, 0, flights.results, row + n_recorded, n_recorded)
    return 0


@kernel
def copy(words: list[int], first: int, target: list[int], place: int, n: int) -> None:
    """Copy words to a place."""
    for k in range(n):
        target[place + k] = words[first + k]
