"""Flies on plain Python while a process of its own compiles, and compiled from then on.

Both engines find the same, bit for bit, so no result depends on when the one takes over.
"""

import pickle
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from mrsfi_runtime.engine.flights import Engine, Evaluated
from mrsfi_runtime.engine.pools import WorkerPool, apart, start_worker
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.settings import COMPILED, ON_REFERENCE, EngineSettings
from mrsfi_runtime.errors import MrsfiError
from mrsfi_runtime.hosting.lockstep import Observer
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.outcome import Outcome

if TYPE_CHECKING:
    from mrsfi_runtime.engine.recording import Recording

N_TRIED = 2
"""Specifications that new code flies where it is built, and is held to the reference engine by."""

HEAD_START = 4.0
"""Seconds for which all workers fly what is evaluated first, before one of them compiles.

Who edited a region waits for the first generation.
"""

_COMPILED = EngineSettings(COMPILED)


class HandoverEngine(Engine):
    """Flies on the reference engine, and on the compiled one as soon as that is built.

    Building begins after a head start with what is evaluated first, because a compiled plan has a
    size. Until it ends there are ``n_workers`` processes, of which one compiles; then threads.
    ``tell`` is told when the compiled engine takes over, or why it does not.
    """

    def __init__(
        self, code: MissionCode, seed: int, n_workers: int, tell: Callable[[str], None]
    ) -> None:
        super().__init__(code, seed)
        self.engine = self
        self._n_workers = n_workers
        self._tell = tell
        self._before = WorkerPool(code, seed, n_workers)
        self._reference = ReferenceEngine(code, seed)
        self._build: Build | None = None
        self._is_decided = False
        self._compiled: Engine | None = None

    def close(self) -> None:
        """End the workers, and a compilation that nobody waits for any more."""
        for each in (self._build, self._before, self._compiled):
            if each is not None:
                each.close()

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order, as they come."""
        seed = self.seed if seed is None else seed
        ends = monotonic() + HEAD_START
        first = 0
        while first < len(specifications):
            if self._build is not None or monotonic() > ends:
                compiled = self._taken_over(specifications)
                if compiled is not None:
                    yield from compiled.evaluate_many(specifications[first:], seed)
                    return
            is_building = self._build is not None and not self._is_decided
            n = max(1, self._n_workers - is_building)
            yield from self._before.evaluate_many(specifications[first : first + n], seed)
            first += n
        self._begun(specifications)

    def _evaluate(
        self,
        specification: Specification,
        seed: int,
        pool: FaultPool,
        observer: Observer | None,
        tallies: list[FaultTally],
    ) -> Outcome:
        tried = specification if pool is self.code.pool else ()
        engine = self._taken_over([tried]) or self._reference
        return engine.evaluate(specification, seed, pool=pool, observer=observer, tallies=tallies)

    def _record(self, specification: Specification, seed: int) -> "Recording":
        engine = self._taken_over([specification]) or self._reference
        return engine.record(specification, seed)

    def _taken_over(self, specifications: Sequence[Specification]) -> Engine | None:
        """Return the compiled engine if it is built; what is to be flown begins to build it."""
        build = self._begun(specifications)
        if self._is_decided or (told := build.told()) is None:
            return self._compiled
        self._is_decided = True
        if told:
            self._tell(f"not compiled: {told}; {ON_REFERENCE}")
        else:
            self._compiled = _COMPILED.open(self.code, self.seed, self._n_workers)
            self._tell(f"compiled in {build.seconds:.1f} s; the compiled engine goes on")
        return self._compiled

    def _begun(self, specifications: Sequence[Specification]) -> "Build":
        if self._build is None:
            self._build = Build(self.code, self.seed, specifications[:N_TRIED])
        return self._build


class Build:
    """A process that compiles a mission into the cache, and flies specifications there."""

    def __init__(
        self, code: MissionCode, seed: int, specifications: Sequence[Specification]
    ) -> None:
        context = get_context("spawn")
        self._answer, answer = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_build,
            args=(answer, code.directory, pickle.dumps(code.pool), seed, tuple(specifications)),
            daemon=True,
        )
        self._began = monotonic()
        with apart():
            self._process.start()
        answer.close()

    @property
    def seconds(self) -> float:
        """Seconds since it began."""
        return monotonic() - self._began

    def told(self) -> str | None:
        """Return why it failed, an empty text if it did not, ``None`` while it goes on."""
        if not self._answer.poll():
            return None
        try:
            return str(self._answer.recv())
        except EOFError:
            return "the process that compiles died"

    def close(self) -> None:
        """End it; what it has not compiled by now is not kept."""
        self._process.kill()
        self._process.join()
        self._answer.close()


def _build(
    answer: Connection,
    directory: Path,
    pool: bytes,
    seed: int,
    specifications: Sequence[Specification],
) -> None:
    start_worker()
    try:
        with _COMPILED.open(load_code(directory, pickle.loads(pool)), seed) as engine:
            for _ in engine.evaluate_many(specifications):
                pass
    except MrsfiError as error:
        answer.send(str(error))
    else:
        answer.send("")
