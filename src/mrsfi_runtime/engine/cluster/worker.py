"""The side of a worker: it unpacks a mission once, builds an engine once, and keeps both."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any, cast

from distributed import WorkerPlugin, get_worker

from mrsfi_runtime.engine.cluster.shipment import Shipment
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.errors import MrsfiError, TransportError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Evaluated, FailedFlight


@dataclass(frozen=True, slots=True)
class EvaluatedChunk:
    """What came of a chunk, in its order, and how long the evaluations took."""

    results: tuple[Evaluated, ...]
    seconds: float


@dataclass(frozen=True, slots=True)
class Chunk:
    """Specifications for any worker, on which unpickling this evaluates them in one go.

    So a task is ``pickle.loads`` and bytes, and a scheduler without mrsfi can pass it on. It
    names the ``MissionPlugin`` that has the mission.
    """

    plugin: str
    seed: int
    settings: EngineSettings
    specifications: tuple[Specification, ...]

    def __reduce__(self) -> tuple[object, ...]:
        return _evaluate, (self.plugin, self.seed, self.settings, self.specifications)


def _evaluate(plugin: str, *chunk: Any) -> EvaluatedChunk:
    """Evaluate a chunk on the worker that calls this."""
    return cast("MissionPlugin", get_worker().plugins[plugin]).evaluate(*chunk)


class MissionPlugin(WorkerPlugin):
    """Keeps the code of a mission on a worker, and its engines, one for each of their settings.

    A worker evaluates one chunk at a time. Compiled code shares it among the worker's threads;
    plain Python would gain nothing from them, and a region need not know of threads.
    """

    def __init__(self, name: str, shipment: Shipment) -> None:
        self.name = name
        self._shipment = shipment

    def setup(self, worker: Any) -> None:
        """Unpack the code into the folder of a worker that finds the same results."""
        self._address = str(worker.address)
        self._folder = Path(worker.local_directory) / self.name
        self._n_threads = int(worker.state.nthreads)
        self._engines: dict[EngineSettings, Engine] = {}
        self._lock = Lock()
        self._require_same_environment()
        try:
            self._shipment.unpack(self._folder)
        except OSError as error:
            raise TransportError(
                f"the worker at {self._address} cannot keep the mission's code: {error}"
            ) from error

    def teardown(self, worker: Any) -> None:  # noqa: ARG002 - dask's signature
        """Give up engines and folder."""
        for engine in self._engines.values():
            engine.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def evaluate(
        self, seed: int, settings: EngineSettings, specifications: tuple[Specification, ...]
    ) -> EvaluatedChunk:
        """Evaluate a chunk; errors and failures tell of the places of the code at home."""
        self._require_same_environment()  # it may have joined late
        with self._lock:
            try:
                engine = self._engine(seed, settings)
                start = perf_counter()
                results = tuple(engine.evaluate_many(specifications, seed))
                seconds = perf_counter() - start
            except MrsfiError as error:
                raise type(error)(self._told(str(error))) from error
        return EvaluatedChunk(tuple(map(self._as_at_home, results)), seconds)

    def _require_same_environment(self) -> None:
        differences = self._shipment.differences()
        if differences:
            raise TransportError(
                f"the worker at {self._address} would not give the same results: it has "
                f"{differences}; install the same there, or stop that worker"
            )

    def _engine(self, seed: int, settings: EngineSettings) -> Engine:
        if settings not in self._engines:
            try:
                code = load_code(self._folder, self._shipment.pool)
                self._engines[settings] = settings.open(code, seed, self._n_threads)
            except MrsfiError as error:
                raise type(error)(
                    f"on the worker at {self._address}: {error}; what regions import has to be "
                    "installed on every worker"
                ) from error
        return self._engines[settings]

    def _as_at_home(self, result: Evaluated) -> Evaluated:
        if isinstance(result, FailedFlight):
            return FailedFlight(self._told(result.traceback))
        return result

    def _told(self, text: str) -> str:
        return self._shipment.told_as_at_home(text, self._folder)
