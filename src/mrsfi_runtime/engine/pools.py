"""Evaluates many fault specifications on the processes of one machine.

Evaluation keeps no state, so any number of workers and any order give the same results.
"""

import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent import futures  # which imports processes when they are used
from contextlib import contextmanager
from functools import lru_cache, partial
from multiprocessing import get_context, parent_process
from pathlib import Path
from threading import Thread
from types import ModuleType
from typing import TYPE_CHECKING, TypeVar

from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import WorkerLost
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated
from mrsfi_runtime.record.engine_settings import EngineSettings

if TYPE_CHECKING:
    from mrsfi_runtime.engine.recording import Recording

Result = TypeVar("Result")


class WorkerPool(Evaluator):
    """Worker processes that each load the generated code once."""

    def __init__(
        self, code: MissionCode, seed: int, n_workers: int, settings: EngineSettings
    ) -> None:
        self._seed = seed
        self._open_engine = partial(
            _worker_engine, code.directory, pickle.dumps(code.pool), seed, settings
        )
        self.n_workers = n_workers
        spawning = get_context("spawn")
        self._executor = futures.ProcessPoolExecutor(n_workers, spawning, start_worker)

    def close(self) -> None:
        """Stop the workers; evaluations that they have not begun are dropped."""
        self._executor.shutdown(wait=True, cancel_futures=True)

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications from now on; the results come in the same order."""
        seed = self._seed if seed is None else seed
        evaluate = partial(_evaluate, self._open_engine, seed)
        size = max(1, -(-len(specifications) // (4 * self.n_workers)))
        with _worker_lost(), starting_workers():
            return _results(self._executor.map(evaluate, specifications, chunksize=size))

    def record_many(
        self, _: Engine, specifications: Iterable[Specification]
    ) -> Iterator["Recording"]:
        """Record flights of the default mission seed on the workers; they come in order."""
        with _worker_lost(), starting_workers():
            return _results(self._executor.map(partial(_record, self._open_engine), specifications))


def _results(results: Iterator[Result]) -> Iterator[Result]:
    with _worker_lost():
        yield from results


@contextmanager
def _worker_lost() -> Iterator[None]:
    try:
        yield
    except futures.BrokenExecutor as error:
        raise WorkerLost(
            "a worker process died; resume the campaign, or use --workers 1 to see why"
        ) from error


@contextmanager
def starting_workers() -> Iterator[None]:
    """Start workers apart from the terminal and the script of this process.

    They inherit that Ctrl-C is blocked, so it never interrupts their start. Unlike other spawned
    workers they do not run the script again, so a script need not guard its lines.
    """
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


def start_worker() -> None:
    """Set up a worker process: it ignores Ctrl-C, and ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides how a run ends
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this worker when its parent ends, even if killed: the pool alone would wait forever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@lru_cache(maxsize=1)
def _worker_engine(directory: Path, pool: bytes, seed: int, settings: EngineSettings) -> Engine:
    return open_engine(settings, load_code(directory, pickle.loads(pool)), seed)


def _evaluate(
    open_engine: Callable[[], Engine], seed: int, specification: Specification
) -> Evaluated:
    return open_engine().attempt(specification, seed)


def _record(open_engine: Callable[[], Engine], specification: Specification) -> "Recording":
    return open_engine().record(specification)
