"""The flights of a batch, one after the other, as the compiled engine runs them.

Functions here run compiled only; what they take as arguments are arrays of records and rows of
them. The functions of a mission come from its stub (``driver``).
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.engine.compiled.layout import NEVER
from mrsfi_runtime.engine.recording import Records
from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.delivery import send
from mrsfi_runtime.kernel.effects.commands import issue
from mrsfi_runtime.kernel.flight import MissionFunctions, answer
from mrsfi_runtime.kernel.motion import move


class Arrays(NamedTuple):
    """What some flights read and write.

    ``fresh`` and ``words`` are what changes in the states, as words: before the first tick, and of
    ``states`` itself, which are truth, belief and inbox. ``weather`` has the valid samples of each
    sensor, a row a tick. ``injections, tallies, own, ends`` are those of a ``Batch``, ``plans`` is
    room for one plan; ``results`` has a record a specification: verdicts, and the words of the last
    truth and belief; ``moments`` one for each tick to be kept. ``at`` receives the number of the
    specification that flies.
    """

    fresh: npt.NDArray[np.int64]
    words: npt.NDArray[np.int64]
    states: Records
    weather: npt.NDArray[np.uint8]
    plans: Records
    injections: Records
    tallies: Records
    own: Records
    ends: npt.NDArray[np.int64]
    results: Records
    moments: Records
    at: npt.NDArray[np.int64]


@kernel
def fly_many(functions: MissionFunctions, arrays: Arrays, first: int, last: int) -> None:
    """Fly the specifications ``first … last - 1`` of a batch."""
    states = arrays.states
    world = states[0]
    belief = states[1]
    inbox = states[2]
    plan = arrays.plans[0]
    moments = arrays.moments
    for k in range(first, last):
        arrays.at[0] = k
        for side in range(len(arrays.words)):
            copy(arrays.fresh[side], arrays.words[side])
        lay_out(plan, arrays, k)
        result = arrays.results[k]
        issue(belief, world, plan, 0)
        for tick in range(world.mission.duration):
            move(world, arrays.weather[tick], tick)
            send(world, inbox)
            answer(functions, world, belief, inbox, world, plan, result, tick)
            if tick < len(moments):
                record(moments[tick], arrays.words)
                keep(moments[tick], result)
        record(result, arrays.words)
        first_tally = arrays.ends[k, 4]
        n_tallies = arrays.ends[k, 5] - first_tally
        copy(plan.tallies[:n_tallies], arrays.tallies[first_tally:])


@kernel
def lay_out(plan: Any, arrays: Arrays, k: int) -> None:
    """Bring the injections and tallies of a specification into the plan."""
    ends = arrays.ends
    copy_injections(plan.messages, arrays.injections, ends[k, 0], ends[k, 1])
    copy_injections(plan.reports, arrays.injections, ends[k, 1], ends[k, 2])
    copy_injections(plan.commands, arrays.injections, ends[k, 2], ends[k, 3])
    copy_injections(plan.own, arrays.own, ends[k, 6], ends[k, 7])
    copy(arrays.tallies[ends[k, 4] : ends[k, 5]], plan.tallies)


@kernel
def copy_injections(listed: Any, injections: Any, first: int, last: int) -> None:
    """Fill a list of the plan, with a sentinel behind the last injection."""
    copy(injections[first:last], listed)
    listed[last - first].start = NEVER


@kernel
def record(moment: Any, words: Any) -> None:
    """Write down what is recorded of truth and belief."""
    copy(words[0, : len(moment.world)], moment.world)
    copy(words[1, : len(moment.belief)], moment.belief)


@kernel
def keep(moment: Any, verdicts: Any) -> None:
    """Write down what was judged until now."""
    copy(verdicts.is_true, moment.is_true)
    copy(verdicts.is_believed, moment.is_believed)
    copy(verdicts.believed, moment.believed)
    copy(verdicts.true, moment.true)
    copy(verdicts.phantom, moment.phantom)
    copy(verdicts.masked, moment.masked)
    copy(verdicts.missed, moment.missed)


@kernel
def copy(entries: Any, target: Any) -> None:
    """Copy entries to where a list begins, one by one: slices take twice as long to compile."""
    for k in range(len(entries)):
        target[k] = entries[k]
