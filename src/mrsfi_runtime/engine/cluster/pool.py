"""Evaluates many fault specifications on a cluster, in chunks.

Their size decides no result; a chunk whose worker was lost is evaluated again on another.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from typing import Any

from mrsfi_runtime.engine.cluster.connection import Cluster
from mrsfi_runtime.engine.cluster.worker import Chunk, Shipment
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated
from mrsfi_runtime.record.engine_settings import EngineSettings

CHUNK_SECONDS = 0.35
"""What a chunk should take: long beside dask's 2 ms for a task, short if its worker is lost."""

_FIRST_GUESS = 0.05
_N_AHEAD = 2  # chunks for each worker, so that the next is there when one is done


class ClusterPool(Evaluator):
    """The workers of a cluster, with an engine each; every one gets the generated code once.

    An engine that cannot be opened is told before any worker begins. Workers keep their engines for
    the next pool of the cluster.
    """

    def __init__(
        self, cluster: Cluster, code: MissionCode, seed: int, settings: EngineSettings
    ) -> None:
        open_engine(settings, code, seed).close()
        self._cluster = cluster
        self._seed = seed
        self._settings = settings
        self._pace = Pace()
        self._plugin = cluster.ship(Shipment.of(code.directory, code.pool))

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order, as they come."""
        seed = self._seed if seed is None else seed
        self.n_workers = n_workers = self._cluster.n_workers()
        first = 0
        waiting: deque[Any] = deque()
        try:
            while waiting or first < len(specifications):
                while first < len(specifications) and _n_open(waiting) < _N_AHEAD * n_workers:
                    size = self._pace.chunk_size(len(specifications), n_workers)
                    some = tuple(specifications[first : first + size])
                    chunk = Chunk(self._plugin, seed, self._settings, some)
                    waiting.append(self._cluster.begin(chunk))
                    first += size
                while waiting and waiting[0].done():
                    evaluated = self._cluster.result(waiting.popleft())
                    self._pace.learn(len(evaluated.results), evaluated.seconds)
                    yield from evaluated.results
                if waiting:
                    self._cluster.wait(waiting)
        finally:
            self._cluster.give_up(waiting)


def _n_open(futures: deque[Any]) -> int:
    return sum(not future.done() for future in futures)


class Pace:
    """Follows how long one evaluation takes on a worker; only the speed depends on it."""

    def __init__(self) -> None:
        self._seconds: float | None = None

    def learn(self, n_evaluations: int, seconds: float) -> None:
        """Take a chunk into account; the later it came, the more it counts."""
        found = seconds / n_evaluations
        self._seconds = found if self._seconds is None else (self._seconds + found) / 2

    def chunk_size(self, n_specifications: int, n_workers: int) -> int:
        """Return how many of some specifications to evaluate in one go, all workers alike."""
        seconds = _FIRST_GUESS if self._seconds is None else self._seconds
        most = max(1, int(CHUNK_SECONDS / max(seconds, 1e-6))) * n_workers
        n_rounds = max(1, -(-n_specifications // most))
        return max(1, -(-n_specifications // (n_rounds * n_workers)))
