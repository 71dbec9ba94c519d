"""The compiled engine: many flights in one call of machine code.

``CompiledFlight`` is that code: the kernel, compiled once for an installation, and a mission's
regions. ``require_same`` compares its flights with those of the reference engine before any result
is used. Every process does so, on as many first ticks as the time allows, with every fault of the
pool active: code that behaves differently when compiled mostly differs at once. A compiled flight
that ends with an error is repeated on the reference engine, whose errors name the line.

Begin with ``CompiledEngine``, at the end.

References
----------
Source paper, section III-G and Figure 4, without the bus between the two sides.
"""

import ctypes
import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache, partial
from itertools import chain, pairwise
from time import perf_counter, process_time
from typing import Any

import numpy as np

from mrsfi_runtime.cosimulation.lockstep import allowed_columns
from mrsfi_runtime.engine.compiled.layout import (
    Batch,
    Frame,
    FreshState,
    laid_out,
    packed,
    read_recorded,
)
from mrsfi_runtime.engine.compiled.machine_code import (
    FLIGHT,
    Library,
    MachineCode,
    forget,
    kept_code,
    kernel_key,
    key_of,
    prebuilt_kernel,
    sources_key,
)
from mrsfi_runtime.engine.compiled.regions import ROLES, Reached, Region, own_regions
from mrsfi_runtime.engine.flights import Engine, ReferenceEngine, Request
from mrsfi_runtime.engine.recording import SIDES, VERDICTS, Recording, Records, moment_type
from mrsfi_runtime.errors import EvaluationError, MrsfiError, ReplayMismatch, WorkerLost
from mrsfi_runtime.fence import TimeLimitReached, fenced, in_thread, words
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.kernel.flight import Verdicts, initial_state
from mrsfi_runtime.kernel.injections import FaultShapes, OwnRow, plan_rows
from mrsfi_runtime.kernel.state import COLUMNS, State, state_bytes
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification, TimedFault
from mrsfi_runtime.model.mission import Evaluated, Mission, Outcome


class CompiledFlight:
    """Flies a mission compiled; ``is_new`` unless all code came from the cache."""

    def __init__(self, code: MissionCode) -> None:
        self._directory = code.directory
        self._regions = [(each, Reached([each.function])) for each in own_regions(code)]
        self.is_guarded = bool(self._regions)
        self._keys = [
            key_of(kernel_key(), each.role, reached.text) for each, reached in self._regions
        ]
        self._n_calls = len(ROLES) * len(code.mission.goals) + 1 + len(ROLES)
        self.key = key_of(sources_key(), *self._keys)
        self._compile()

    def _compile(self) -> None:
        compiled, self.is_new = kernel()
        guarded, *by_task, unguarded = compiled.addresses()
        self._fly: Any = FLIGHT(guarded if self.is_guarded else unguarded)
        self.calls = np.zeros(self._n_calls, np.int64)
        self.calls[-len(by_task) :] = by_task
        if not self.is_guarded:  # the kernel then reads no address
            self.calls = self.calls[:0]
        for (region, reached), key in zip(self._regions, self._keys, strict=True):
            found, is_new = kept_code(key, partial(self._compiled, region, reached))
            self.calls[region.place] = found.addresses()[0]
            self.is_new |= is_new

    def _compiled(self, region: Region, reached: Reached) -> MachineCode:
        from mrsfi_runtime.engine.compiled.compiler import compiled_region  # noqa: PLC0415 - slow

        return compiled_region(self._directory, region, reached)

    def forget(self) -> None:
        """Compile its regions anew, or the kernel if there are none and none was prebuilt."""
        for key in self._keys or ([] if prebuilt_kernel() else [kernel_key()]):
            forget(key)
        self._compile()

    def __call__(self, frame: Frame, first: int, last: int) -> None:
        """Fly the specifications ``first … last - 1`` of a frame."""

        def located(error: BaseException) -> EvaluationError:
            if not isinstance(error, TimeLimitReached):
                return EvaluationError(words(error))
            return WorkerLost(
                f"{self._directory}: the compiled mission does not get beyond "
                f"tick {frame.tick}: {error}; --engine reference names the line"
            )

        with fenced(located, lambda: (frame.at, frame.tick)):
            in_thread(partial(self._call, frame, first, last))

    def _call(self, frame: Frame, first: int, last: int) -> None:
        result, error = ctypes.c_int64(), ctypes.c_void_p()
        status = self._fly(result, error, frame.directory.ctypes.data, first, last)
        if status:
            raise EvaluationError(f"{self._directory}: a compiled flight ended with an error")


def kernel() -> tuple[MachineCode | Library, bool]:
    """Return the kernel, prebuilt, cached or compiled now, and whether it was compiled now."""
    prebuilt = prebuilt_kernel()
    return (prebuilt, False) if prebuilt else kept_code(kernel_key(), _compiled_kernel)


def _compiled_kernel() -> MachineCode:
    from mrsfi_runtime.engine.compiled.compiler import compiled_kernel  # noqa: PLC0415 - slow

    log = logging.getLogger(__name__)
    log.warning("compiling the kernel, once for this installation; it takes about 25 seconds")
    began = perf_counter()
    code = compiled_kernel()
    log.warning("compiled the kernel in %.1f s", perf_counter() - began)
    return code


SECONDS = 0.05
"""How long the reference engine flies for the comparison."""

_HINT = (
    "look for code that differs when compiled (`mrsfi validate` warns of it), or use "
    "--engine reference"
)
_UNREPEATED = (
    "expected equal flights: look for a region that keeps state from flight to flight, reads a "
    "clock or draws unseeded random numbers"
)

Record = Callable[[Specification, int], Recording | None]
"""Flies compiled, and returns the first ticks; ``None`` if that ended with an error."""


def trials(gate: Gate) -> list[Specification]:
    """Return specifications with all faults of a pool, as many in each as may act at once."""
    others, last = gate.conflicts(), gate.mission.duration - 1
    flown: list[Specification] = [()]
    for fault in gate.pool:
        windows = [(0, min(7, last)), (16, last)]
        timed = tuple(TimedFault(fault.id, a, b, fault.values) for a, b in windows if a <= b)
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
    """Refuse compiled flights that differ: an EvaluationError names the tick and the region.

    If flights of the reference engine differ themselves, that is a ReplayMismatch.
    """
    for specification in flown:
        ends = process_time() + seconds / len(flown)
        moments, failure = _first_moments(reference, specification, ends)
        recording = record(specification, len(moments))
        if recording is None:
            continue
        difference = _difference(reference.code.mission, recording, moments)
        if difference is not None:
            if reference.evaluate(specification) != reference.evaluate(specification):
                raise unrepeated(reference, specification)  # a comparison would mean nothing
            tick, what, a, b = difference
            acting = [one.fault for one in specification if one.start <= tick <= one.finish]
            where, under = reference.code.directory, ", ".join(acting) or "no fault"
            raise EvaluationError(
                f"{where}: {what} is {a} on the reference engine, but {b} when compiled, at tick "
                f"{tick} under {under}; {_HINT}"
            )
        if failure is not None:
            raise EvaluationError(f"{failure}; compiled, it raises no error: {_HINT}") from failure


def unrepeated(engine: Engine, specification: Specification) -> ReplayMismatch:
    """Return the error of a mission whose flights differ, with the first difference and a hint."""
    what = differing(engine.code, specification, engine.seed)
    return ReplayMismatch(f"the mission does not repeat itself: {what}")


def differing(code: MissionCode, specification: Specification, seed: int) -> str:
    """Fly a specification of the mission's pool twice, from fresh code; describe the difference."""
    engine = ReferenceEngine(load_code(code.directory, code.pool), seed)
    try:
        first, second = (engine.record(specification) for _ in range(2))
        pair = _difference(code.mission, second, _moments(first))
    except EvaluationError as error:
        return f"{error}; {_UNREPEATED}"
    place = "at tick {}, {} is {}, then {}".format(*pair) if pair else "two more flights agree"
    return f"{place}; {_UNREPEATED}"


class _EnoughError(MrsfiError):
    """Ends a flight when enough ticks are recorded."""


def _first_moments(
    reference: Engine, specification: Specification, ends: float
) -> tuple[list[list[Any]], EvaluationError | None]:
    """Return as many ticks as there is time for, two at least, and the flight's error if any."""
    moments: list[list[Any]] = []

    def observe(world: State, belief: State, verdicts: Verdicts) -> None:
        judged = [list(getattr(verdicts, name)) for name in VERDICTS]
        moments.append([*judged, state_bytes(world), state_bytes(belief)])
        if len(moments) > 1 and process_time() > ends:
            raise _EnoughError

    try:
        with suppress(_EnoughError):
            reference.evaluate(specification, observer=observe)
    except WorkerLost:  # the flight hung, which is no result
        raise
    except EvaluationError as error:
        return moments, error
    return moments, None


def _moments(recording: Recording) -> Iterator[list[Any]]:
    for moments in recording.moments():
        columns = [moments[name].tolist() for name in VERDICTS]
        sides = [[bytes(row) for row in packed(moments[side])] for side in SIDES]
        yield from map(list, zip(*columns, *sides, strict=True))


def _difference(
    mission: Mission, recording: Recording, expected: Iterable[list[Any]]
) -> tuple[int, str, Any, Any] | None:
    """Return the first difference: tick, description of field and region, and both values."""
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
        ] + ["the memory of goals"] * len(left)
    differing = (each for each in zip(places, left, right, strict=False) if each[1] != each[2])
    return (tick, *next(differing, ("the memory of goals", "something", "nothing")))


_TRUSTED: set[tuple[str, str]] = set()
"""The keys of compiled code, and missions, that this process has compared with the reference."""


class CompiledEngine(Engine):
    """Flies the mission many times in one call, on threads that run in parallel.

    A flight that ends with an error is repeated on the reference engine, which reports where.
    """

    def __init__(self, code: MissionCode, seed: int, n_threads: int = 1) -> None:
        super().__init__(code, seed)
        self._fresh = cache(self._fresh_state)
        self._moment_type = moment_type(initial_state(code.mission, seed))
        self._reference = ReferenceEngine(code, seed)
        self._gate = Gate(code.mission, code.pool)
        self._shapes = FaultShapes(code.mission, code.pool)
        self.n_workers = n_threads
        self._threads = ThreadPoolExecutor(n_threads)
        self._fly_many = CompiledFlight(code)
        self._mission = (self._fly_many.key, repr((code.mission, code.pool)))

    def _fresh_state(self, seed: int) -> FreshState:
        """Return a mission's state; only code of a team reads what was heard, or wakes the calm."""
        state = initial_state(self.code.mission, seed)
        if not self._fly_many.is_guarded:
            state.calm, state.quiet = [0] * len(state.members), [0] * len(state.goals)
            state.heard = []
        return laid_out(state)

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown()

    def require_same(self) -> None:
        """Compare with the reference engine once in a process; recompile cached code on failure."""
        if self._mission in _TRUSTED:
            return
        check = partial(
            require_same, self._reference, self._first_ticks, trials(self._gate), SECONDS
        )
        try:
            check()
        except WorkerLost:  # a flight that hangs is no difference
            raise
        except EvaluationError:
            if self._fly_many.is_new:
                raise
            self._fly_many.forget()
            check()
        _TRUSTED.add(self._mission)

    def _first_ticks(self, specification: Specification, n_ticks: int) -> Recording | None:
        return self._recorded(self._batch([specification], self.code.pool), self.seed, n_ticks)

    def _recorded(self, batch: Batch, seed: int, n_ticks: int) -> Recording | None:
        """Fly a batch of one, and return its first ticks; ``None`` if it ended with an error."""
        frame = Frame(self._fresh(seed), self._fly_many.calls, batch, (0, 1))
        recording = Recording(self._moment_type)
        begins = [*range(0, max(n_ticks, 1), recording.chunk)]
        for begin, end in pairwise([*begins, self.code.mission.duration]):
            n_kept = min(recording.chunk, n_ticks - begin)
            moments: Records = np.zeros(n_kept, self._moment_type)
            frame.keep(moments, begin, end)
            if self._fly(frame, 0, 1):
                return None
            recording.append(moments)
        recording.tallies = batch.tallies_of(0)
        return recording

    def _evaluate(self, request: Request) -> Outcome:
        specification, seed, pool, observer, tallies = request
        self.require_same()
        batch = self._batch([specification], pool)
        recording = self._recorded(batch, seed, self.code.mission.duration if observer else 0)
        if recording is None:
            watched: dict[str, Any] = {"observer": observer, "tallies": tallies}
            return self._reference.evaluate(specification, seed, pool=pool, **watched)
        tallies[:] = batch.tallies_of(0)
        if observer is not None:
            world = initial_state(self.code.mission, seed)
            belief = initial_state(self.code.mission, seed)
            for tick, moment in enumerate(chain.from_iterable(recording.moments())):
                world.mission.tick = belief.mission.tick = tick
                read_recorded(world, moment["world"])
                read_recorded(belief, moment["belief"])
                observer(world, belief, Verdicts(*(moment[name].tolist() for name in VERDICTS)))
        return batch.outcomes(self.measured)[0]

    def _record(self, specification: Specification, seed: int) -> Recording:
        self.require_same()
        batch = self._batch([specification], self.code.pool)
        recording = self._recorded(batch, seed, self.code.mission.duration)
        return self._reference.record(specification, seed) if recording is None else recording

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order."""
        self.require_same()
        seed, n_most = self.seed if seed is None else seed, 64  # specifications in a call
        for first in range(0, len(specifications), n_most):
            yield from self._evaluate_chunk(specifications[first : first + n_most], seed)

    def _evaluate_chunk(
        self, specifications: Sequence[Specification], seed: int
    ) -> list[Evaluated]:
        n = len(specifications)
        specifications = [self._gate.admitted(each) for each in specifications]
        batch = self._batch(specifications, self.code.pool)
        size = -(-n // self.n_workers)
        spans = [(first, min(first + size, n)) for first in range(0, n, size)]
        fresh = self._fresh(seed)  # once, and not on every thread

        def fly(span: tuple[int, int]) -> list[int]:
            return self._fly(Frame(fresh, self._fly_many.calls, batch, span), *span)

        again = {k for failed in self._threads.map(fly, spans) for k in failed}
        return [
            self._reference.attempt(specifications[k], seed) if k in again else outcome
            for k, outcome in enumerate(batch.outcomes(self.measured))
        ]

    def _batch(self, specifications: Sequence[Specification], pool: FaultPool) -> Batch:
        is_own = pool is self.code.pool
        shapes = self._shapes if is_own else FaultShapes(self.code.mission, pool)
        plans = [plan_rows(shapes, specification) for specification in specifications]
        kinds = {fault.kind.effect: fault.kind for fault in pool}
        layout = self._fresh(self.seed)

        def allowed(row: OwnRow) -> Sequence[int]:
            _, effect, _, target, *_ = row
            listed, columns = allowed_columns(kinds[effect])
            return layout.allowed_words(listed, target, columns)

        return Batch(plans, self._moment_type, allowed)

    def _fly(self, frame: Frame, first: int, last: int) -> list[int]:
        """Fly some specifications of a frame, and return those that ended with an error.

        If one of them wrote to a table, all are returned, because it may have affected later ones.
        """
        failed = []
        everyone = list(range(first, last))
        while first < last:
            try:
                self._fly_many(frame, first, last)
            except WorkerLost:
                raise
            except EvaluationError:  # the reference engine reports what and where
                failed.append(max(frame.at, first))
                first = failed[-1] + 1
            else:
                first = last
        return everyone if frame.has_written_to_tables else failed
