"""Holds compiled flights to those of the reference engine, before anything relies on them.

Every process does so, on as many first ticks as the time allows, with every fault of the pool at
work: what compiles to something else mostly does so at once.
"""

from collections.abc import Callable, Iterator, Sequence
from time import thread_time
from typing import Any

import numpy as np

from mrsfi_runtime.engine.compiled.layout import packed
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import SIDES, VERDICTS, Recording
from mrsfi_runtime.errors import EvaluationError, MrsfiError
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.packing import COLUMNS, state_bytes
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import conflicts

SECONDS, SECONDS_OF_NEW = 0.05, 1.0
"""How long the reference engine flies in every process, and in the one that compiled."""

_WINDOWS = (2, 16, 128)
"""Ticks for which faults act that take turns, one round after the other."""

Fits = Callable[[Specification], bool]
"""Whether compiled plans have room for a specification."""


def trials(mission: Mission, pool: FaultPool, fits: Fits) -> Iterator[Specification]:
    """Yield specifications in which all faults of a pool act, conflicting ones in turns."""
    groups = _groups(mission, pool, fits)
    if not groups:
        yield ()
    while groups:
        flown, n_acting = _laid_out(groups, mission.duration, fits)
        yield flown
        groups = groups[n_acting:]


def _groups(mission: Mission, pool: FaultPool, fits: Fits) -> list[list[Fault]]:
    """Return the faults of a pool in groups that may act at once."""
    others = conflicts(mission, pool)
    groups: list[list[Fault]] = []
    for fault in pool:
        for group in groups:
            is_alone = others[fault.id].isdisjoint(each.id for each in group)
            if is_alone and fits(_at(0, 0, [*group, fault])):
                group.append(fault)
                break
        else:
            groups.append([fault])
    return groups


def _laid_out(
    groups: Sequence[Sequence[Fault]], duration: int, fits: Fits
) -> tuple[Specification, int]:
    """Return as much of some groups as there is room for, and how many of them act."""
    flown: Specification = ()
    start = n_acting = 0
    for n_ticks in _WINDOWS:
        for group in groups[: n_acting or len(groups)]:
            more = flown + _at(start, min(start + n_ticks, duration) - 1, group)
            if start >= duration or not fits(more):
                return flown, max(1, n_acting)
            flown = more
            start += n_ticks + 1
            n_acting += n_ticks == _WINDOWS[0]
    return flown, n_acting


def _at(start: int, finish: int, faults: Sequence[Fault]) -> Specification:
    return tuple(TimedFault(fault.id, start, finish, fault.values) for fault in faults)


Record = Callable[[Specification, int], Recording | None]
"""Flies compiled, and returns the first ticks; ``None`` if that failed and is not relied on."""


def require_same(
    reference: Engine, record: Record, flown: Sequence[Specification], seconds: float
) -> None:
    """Refuse compiled flights that differ from those of the reference engine.

    Raises
    ------
    EvaluationError
        Naming the regions among which to look, and what differs first.
    """
    for specification in flown:
        seen, failure = _seen(reference, specification, thread_time() + seconds / len(flown))
        recording = record(specification, len(seen))
        if recording is None:
            continue
        for tick, (expected, found) in enumerate(zip(seen, _moments(recording), strict=True)):
            if expected != found:
                what = _difference(reference.code.mission, recording, expected, found)
                where = reference.code.directory
                raise EvaluationError(f"{where}: {what} at tick {tick} of {specification}; {_HINT}")
        if failure is not None:
            raise EvaluationError(f"{failure}; compiled, it does not fail: {_HINT}") from failure


_HINT = (
    "look for what compiles but differs (`mrsfi validate` warns of it), or use --engine reference"
)


class _EnoughError(MrsfiError):
    """Ends a flight of which enough was seen."""


def _seen(
    reference: Engine, specification: Specification, ends: float
) -> tuple[list[list[Any]], EvaluationError | None]:
    """Return as many ticks as there is time for, but those at least at which each fault begins."""
    seen: list[list[Any]] = []
    n_acting = len({timed.fault for timed in specification})
    least = max((timed.start for timed in specification[:n_acting]), default=0)

    def observe(world: State, belief: State, verdicts: Verdicts) -> None:
        judged = [list(getattr(verdicts, name)) for name in VERDICTS]
        seen.append([*judged, state_bytes(world), state_bytes(belief)])
        if thread_time() > ends and len(seen) > least + 1:
            raise _EnoughError

    try:
        reference.evaluate(specification, observer=observe)
    except _EnoughError:
        pass
    except EvaluationError as error:
        return seen, error
    return seen, None


def _moments(recording: Recording) -> Iterator[list[Any]]:
    """Yield every tick as ``_seen`` has it."""
    columns = [recording[name].tolist() for name in VERDICTS]
    sides = [[bytes(row) for row in packed(recording[side])] for side in SIDES]
    return map(list, zip(*columns, *sides, strict=True))


def _difference(
    mission: Mission, recording: Recording, expected: Sequence[Any], found: Sequence[Any]
) -> str:
    """Return in words what differs first of a tick, and in which region to look."""
    pairs = zip((*VERDICTS, *SIDES), expected, found, strict=True)
    name, left, right = next(pair for pair in pairs if pair[1] != pair[2])
    places = [(f"'{goal.id}.check'", f"of goal '{goal.id}'") for goal in mission.goals]
    if name in SIDES:
        left, right = np.frombuffer(left), np.frombuffer(right)
        places = [
            ("of a reaction or an effect", f"{listed}[{index}].{column}")
            for listed, columns in COLUMNS.items()
            for index in range(len(recording[name][0][listed]))
            for column in columns
        ]
    both = zip(places, left, right, strict=False)
    (region, place), a, b = next((each for each in both if each[1] != each[2]), (places[-1], 0, 1))
    return f"region {region}: compiled, {name} {place} is {b}; the reference engine has {a}"
