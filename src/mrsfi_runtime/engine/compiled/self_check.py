"""Holds compiled flights to those of the reference engine, before anything relies on them.

Every process does so, on as many first ticks as the time allows, with every fault of the pool at
work: what compiles to something else mostly does so at once.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from time import process_time
from typing import Any

import numpy as np

from mrsfi_runtime.engine.compiled.layout import packed
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import SIDES, VERDICTS, Recording
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, MrsfiError, ReplayMismatch, WorkerLost
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import COLUMNS, State, state_bytes
from mrsfi_runtime.model.faults import Gate, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission

SECONDS = 0.05
"""How long the reference engine flies for it."""

_WINDOWS = ((0, 7), (16, None))
"""First and last ticks at which a fault acts; ``None`` is the mission's last."""

_HINT = (
    "look for what compiles but differs (`mrsfi validate` warns of it), or use --engine reference"
)

_UNREPEATED = (
    "expected the same: look for a region that keeps state from flight to flight, reads a clock or "
    "draws unseeded random numbers"
)

Record = Callable[[Specification, int], Recording | None]
"""Flies compiled, and returns the first ticks; ``None`` if that failed and is not relied on."""


def trials(gate: Gate) -> list[Specification]:
    """Return specifications with all faults of a pool, as many in each as may act at once."""
    others, last = gate.conflicts(), gate.mission.duration - 1
    flown: list[Specification] = [()]
    for fault in gate.pool:
        windows = [(a, last if b is None else min(b, last)) for a, b in _WINDOWS if a <= last]
        timed = tuple(TimedFault(fault.id, *window, fault.values) for window in windows)
        for k, before in enumerate(flown):
            if others[fault.id].isdisjoint(each.fault for each in before):
                flown[k] += timed
                break
        else:
            flown.append(timed)
    return flown


def require_same(
    reference: Engine, record: Record, flown: Sequence[Specification], seconds: float
) -> None:
    """Refuse compiled flights that differ: an EvaluationError says where, and in which region.

    What the reference engine itself does not repeat is a ReplayMismatch.
    """
    for specification in flown:
        seen, failure = _seen(reference, specification, process_time() + seconds / len(flown))
        recording = record(specification, len(seen))
        if recording is None:
            continue
        found = _difference(reference.code.mission, recording, seen)
        if found is not None:
            if reference.evaluate(specification) != reference.evaluate(specification):
                raise unrepeated(reference, specification)  # nothing could be held to it
            tick, what, a, b = found
            acting = [one.fault for one in specification if one.start <= tick <= one.finish]
            where, under = reference.code.directory, ", ".join(acting) or "no fault"
            raise EvaluationError(
                f"{where}: compiled, {what} is {b}; the reference engine has {a} at tick {tick} "
                f"under {under}; {_HINT}"
            )
        if failure is not None:
            raise EvaluationError(f"{failure}; compiled, it does not fail: {_HINT}") from failure


def unrepeated(engine: Engine, specification: Specification) -> ReplayMismatch:
    """Return the error of a mission whose flights differ; it says what does first, and why."""
    what = differing(engine.code, specification, engine.seed)
    return ReplayMismatch(f"the mission does not repeat itself: {what}")


def differing(code: MissionCode, specification: Specification, seed: int) -> str:
    """Fly twice what does not repeat itself, from fresh code; return what differs first, and why.

    The specification is of the mission's own pool.
    """
    engine = ReferenceEngine(load_code(code.directory, code.pool), seed)
    try:
        first, second = (engine.record(specification) for _ in range(2))
        found = _difference(code.mission, second, _moments(first))
    except EvaluationError as error:
        return f"{error}; {_UNREPEATED}"
    place = "at tick {}, {} is {} and then {}".format(*found) if found else "two more flights agree"
    return f"{place}; {_UNREPEATED}"


class _EnoughError(MrsfiError):
    """Ends a flight of which enough was seen."""


def _seen(
    reference: Engine, specification: Specification, ends: float
) -> tuple[list[list[Any]], EvaluationError | None]:
    """Return as many ticks as there is time for, two at least, and how the flight failed if so."""
    seen: list[list[Any]] = []

    def observe(world: State, belief: State, verdicts: Verdicts) -> None:
        judged = [list(getattr(verdicts, name)) for name in VERDICTS]
        seen.append([*judged, state_bytes(world), state_bytes(belief)])
        if len(seen) > 1 and process_time() > ends:
            raise _EnoughError

    try:
        reference.evaluate(specification, observer=observe)
    except _EnoughError:
        return seen, None
    except WorkerLost:  # it got no further, which is no result
        raise
    except EvaluationError as error:
        return seen, error
    return seen, None


def _moments(recording: Recording) -> Iterator[list[Any]]:
    for moments in recording.moments():
        columns = [moments[name].tolist() for name in VERDICTS]
        sides = [[bytes(row) for row in packed(moments[side])] for side in SIDES]
        yield from map(list, zip(*columns, *sides, strict=True))


def _difference(
    mission: Mission, recording: Recording, expected: Iterable[list[Any]]
) -> tuple[int, str, Any, Any] | None:
    """Return what differs first: the tick, in words the field and its region, and both values."""
    pairs = enumerate(zip(expected, _moments(recording), strict=True))
    tick, moments = next(((tick, both) for tick, both in pairs if both[0] != both[1]), (0, ()))
    if not moments:
        return None
    moment = recording.moment(0)
    name, left, right = next(
        pair for pair in zip((*VERDICTS, *SIDES), *moments, strict=True) if pair[1] != pair[2]
    )
    places = [f"{name} of goal '{goal.id}' (region '{goal.id}.check')" for goal in mission.goals]
    if name in SIDES:
        left, right = np.frombuffer(left), np.frombuffer(right)
        places = [
            f"{column} of {name}.{listed}[{index}] (a reaction or an effect)"
            for listed, columns in COLUMNS.items()
            for index in range(len(moment[name][listed]))
            for column in columns
        ] + ["what goals remember"] * len(left)
    differing = (each for each in zip(places, left, right, strict=False) if each[1] != each[2])
    return (tick, *next(differing, ("what goals remember", "something", "nothing")))
