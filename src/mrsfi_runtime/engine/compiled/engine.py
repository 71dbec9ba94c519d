"""Evaluates fault specifications with the kernel and the regions compiled, many in one call.

References
----------
Source paper, section III-G and Figure 4, without the bus between the two sides.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from itertools import chain, pairwise

import numpy as np

from mrsfi_runtime.cosimulation.lockstep import Observer, allowed_columns
from mrsfi_runtime.engine.compiled.batch import Batch, Frame
from mrsfi_runtime.engine.compiled.compiled_flight import CompiledFlight
from mrsfi_runtime.engine.compiled.layout import laid_out, read_recorded
from mrsfi_runtime.engine.compiled.self_check import SECONDS, require_same, trials
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import VERDICTS, Recording, Records, moment_type
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, WorkerLost
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.kernel.flight import Verdicts, initial_state
from mrsfi_runtime.kernel.injections import FaultShapes, FaultTally, OwnRow, plan_rows
from mrsfi_runtime.model.faults import FaultPool, Gate, Specification
from mrsfi_runtime.model.mission import Evaluated, Outcome

CHUNK = 64
"""Specifications that are laid out and flown in one call, at most."""

_TRUSTED: set[tuple[str, str]] = set()
"""What this process has held to the reference engine: compiled code by its key, and missions."""


class CompiledEngine(Engine):
    """Flies the mission many times in one call, on threads that truly run side by side.

    A flight that fails is repeated on the reference engine, which can tell where and why.
    """

    def __init__(self, code: MissionCode, seed: int, n_threads: int = 1) -> None:
        super().__init__(code, seed)
        self._fresh = cache(lambda seed: laid_out(initial_state(code.mission, seed)))
        self._moment_type = moment_type(initial_state(code.mission, seed))
        self._reference = ReferenceEngine(code, seed)
        self._gate = Gate(code.mission, code.pool)
        self._shapes = FaultShapes(code.mission, code.pool)
        self._n_threads = n_threads
        self._threads = ThreadPoolExecutor(n_threads)
        self._fly_many = CompiledFlight(code)
        self._mission = (self._fly_many.key, repr((code.mission, code.pool)))

    def close(self) -> None:
        """End the threads."""
        self._threads.shutdown()

    def require_same(self) -> None:
        """Hold compiled code to the reference engine once in a process; differing, compile anew."""
        if self._mission in _TRUSTED:
            return
        check = partial(
            require_same, self._reference, self._first_ticks, trials(self._gate), SECONDS
        )
        try:
            check()
        except WorkerLost:  # code that gets no further is no difference
            raise
        except EvaluationError:
            if self._fly_many.is_new:
                raise
            self._fly_many.forget()
            check()
        _TRUSTED.add(self._mission)

    def _first_ticks(
        self, specification: Specification, n_ticks: int, seed: int | None = None
    ) -> Recording | None:
        """Return the first ticks of a flight; ``None`` if the reference engine is to repeat it."""
        batch = self._batch([specification], self.code.pool)
        return self._recorded(batch, self.seed if seed is None else seed, n_ticks)

    def _recorded(self, batch: Batch, seed: int, n_ticks: int) -> Recording | None:
        """Fly a batch of one, and return its first ticks; ``None`` if that failed."""
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

    def _evaluate(
        self,
        specification: Specification,
        seed: int,
        pool: FaultPool,
        observer: Observer | None,
        tallies: list[FaultTally],
    ) -> Outcome:
        self.require_same()
        batch = self._batch([specification], pool)
        recording = self._recorded(batch, seed, self.code.mission.duration if observer else 0)
        if recording is None:
            return self._reference.evaluate(
                specification, seed, pool=pool, observer=observer, tallies=tallies
            )
        tallies[:] = batch.tallies_of(0)
        if observer is not None:
            self._tell(observer, seed, recording)
        return batch.outcome(0, self.measured)

    def _record(self, specification: Specification, seed: int) -> Recording:
        self.require_same()
        recording = self._first_ticks(specification, self.code.mission.duration, seed)
        return self._reference.record(specification, seed) if recording is None else recording

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order."""
        self.require_same()
        seed = self.seed if seed is None else seed
        for first in range(0, len(specifications), CHUNK):
            yield from self._evaluate_chunk(specifications[first : first + CHUNK], seed)

    def _evaluate_chunk(
        self, specifications: Sequence[Specification], seed: int
    ) -> list[Evaluated]:
        n = len(specifications)
        specifications = [self._gate.admitted(each) for each in specifications]
        batch = self._batch(specifications, self.code.pool)
        size = -(-n // self._n_threads)
        spans = [(first, min(first + size, n)) for first in range(0, n, size)]
        self._fresh(seed)  # once, and not on every thread
        failed = self._threads.map(partial(self._fly_some, batch, seed), spans)
        again = {k for some in failed for k in some}
        return [
            self._reference.attempt(each, seed) if k in again else batch.outcome(k, self.measured)
            for k, each in enumerate(specifications)
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

    def _fly_some(self, batch: Batch, seed: int, span: tuple[int, int]) -> list[int]:
        return self._fly(Frame(self._fresh(seed), self._fly_many.calls, batch, span), *span)

    def _fly(self, frame: Frame, first: int, last: int) -> list[int]:
        """Fly some specifications of a frame, and return which of them failed.

        All have failed if one of them wrote to a table, as it may have misled those after it.
        """
        failed = []
        everyone = list(range(first, last))
        while first < last:
            try:
                self._fly_many(frame, first, last)
            except WorkerLost:
                raise
            except EvaluationError:  # the reference engine tells what and where
                failed.append(max(frame.at, first))
                first = failed[-1] + 1
            else:
                first = last
        return everyone if frame.has_written_to_tables else failed

    def _tell(self, observer: Observer, seed: int, recording: Recording) -> None:
        world = initial_state(self.code.mission, seed)
        belief = initial_state(self.code.mission, seed)
        for tick, moment in enumerate(chain.from_iterable(recording.moments())):
            world.mission.tick = belief.mission.tick = tick
            read_recorded(world, moment["world"])
            read_recorded(belief, moment["belief"])
            observer(world, belief, Verdicts(*(moment[name].tolist() for name in VERDICTS)))
