"""Evaluation on a dask cluster, in chunks of fault specifications.

A worker may be on another machine. A ``Shipment`` carries the mission's code to it, once;
``MissionPlugin`` unpacks it in an empty folder, builds an engine, and keeps both. A worker whose
environment could give other results refuses. ``ClusterPool`` is the evaluator: it connects, sends
chunks, and receives results or clear errors.

Results do not depend on the size of chunks. A chunk of a lost worker goes to another worker.
"""

import logging
import pickle
import platform
import shutil
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from hashlib import sha256
from multiprocessing.resource_tracker import ensure_running
from pathlib import Path
from threading import Lock
from time import monotonic, perf_counter
from typing import Any, Self, TypeAlias, cast
from uuid import uuid4

from distributed import Client, KilledWorker, LocalCluster, Security, WorkerPlugin, get_worker, wait

import mrsfi_runtime
from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.engine.pools import starting_workers
from mrsfi_runtime.errors import MrsfiError, TransportError, UsageError, WorkerLost, counted
from mrsfi_runtime.fence import copied_files
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight
from mrsfi_runtime.project_file import installed_version
from mrsfi_runtime.record.engine_settings import LOCAL, EngineSettings


@dataclass(frozen=True, slots=True)
class Shipment:
    """The generated code of a mission, and all that a worker needs to get identical results.

    Its name is a hash of the content. ``given`` and ``absolute`` are the paths of its folder, as
    the user names it and from the root; ``environment`` is required of the worker.
    """

    name: str
    files: dict[str, bytes]
    pool: FaultPool | None
    given: str
    absolute: str
    environment: dict[str, str]

    @classmethod
    def of(cls, directory: Path, pool: FaultPool | None = None) -> Self:
        """Return the shipment of a folder of generated code, and of the faults to fly."""
        paths = [path for path in sorted(directory.iterdir()) if path.is_file()]
        paths += copied_files(directory)
        files = {path.relative_to(directory).as_posix(): path.read_bytes() for path in paths}
        digest = sha256(pickle.dumps(pool))
        for name, content in files.items():
            digest.update(f"{name} {len(content)}\n".encode() + content)
        return cls(
            name=f"mrsfi-{digest.hexdigest()[:16]}",
            files=files,
            pool=pool,
            given=str(directory),
            absolute=str(directory.absolute()),
            environment=environment(),
        )

    def unpack(self, folder: Path) -> None:
        """Write the files into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in self.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)

    def with_original_paths(self, text: str, folder: Path) -> str:
        """Return a message or traceback with the paths of the folder that the code comes from."""
        framed = text.replace(f'File "{folder}', f'File "{self.absolute}')
        return framed.replace(str(folder), self.given)

    def differences(self) -> str:
        """Return how this process differs from the required environment; empty if it does not."""
        found = environment()
        return ", ".join(
            f"{name} {found[name]} where this command has {expected}"
            for name, expected in self.environment.items()
            if found[name] != expected
        )


@cache
def environment() -> dict[str, str]:
    """Return the versions on which results and the communication of processes depend."""
    return {
        "mrsfi": f"{installed_version('mrsfi')} (source {_source_hash()})",
        "Python": f"{sys.version_info.major}.{sys.version_info.minor}",
        "numba": installed_version("numba"),
        "distributed": installed_version("distributed"),
        "processor": platform.machine(),
    }


def _source_hash() -> str:
    """Return a hash of all source of mrsfi on which evaluations depend."""
    package = Path(str(mrsfi_runtime.__file__)).parent
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        room = path.relative_to(package).parts[0]
        if room not in ("analysis", "causes", "cli", "search", "study"):
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:8]


EvaluatedChunk: TypeAlias = tuple[list[Evaluated], float]
"""The results of a chunk, in its order, and the seconds that the evaluations took."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """Specifications for any worker, which evaluates them by unpickling the chunk.

    So a task is ``pickle.loads`` and bytes, and a scheduler without mrsfi can pass it on.
    ``plugin`` names the ``MissionPlugin`` that has the mission.
    """

    plugin: str
    seed: int
    specifications: tuple[Specification, ...]

    def __reduce__(self) -> tuple[object, ...]:
        return _evaluate, (self.plugin, self.seed, self.specifications)


def _evaluate(plugin: str, *chunk: Any) -> EvaluatedChunk:
    return cast("MissionPlugin", get_worker().plugins[plugin]).evaluate(*chunk)


class MissionPlugin(WorkerPlugin):
    """Keeps the code of a mission on a worker, and its engine.

    A worker evaluates one chunk at a time. Compiled code spreads it over the worker's threads.
    Plain Python would gain nothing from threads, and regions need not be thread-safe.
    """

    def __init__(self, name: str, shipment: Shipment, settings: EngineSettings) -> None:
        self.name = name
        self._shipment = shipment
        self._settings = settings

    def setup(self, worker: Any) -> None:
        """Unpack the code into the folder of a worker; refuse a differing environment."""
        self._address = str(worker.address)
        self._folder = Path(worker.local_directory) / self.name
        self._n_threads = int(worker.state.nthreads)
        self._engine: Engine | None = None
        self._lock = Lock()
        self._require_same_environment()
        try:
            self._shipment.unpack(self._folder)
        except OSError as error:
            raise TransportError(
                f"the worker at {self._address} cannot store the mission's code: {error}"
            ) from error

    def teardown(self, worker: Any) -> None:  # noqa: ARG002 - dask's signature
        """Close the engine, and remove the folder."""
        if self._engine is not None:
            self._engine.close()
        shutil.rmtree(self._folder, ignore_errors=True)

    def evaluate(self, seed: int, specifications: tuple[Specification, ...]) -> EvaluatedChunk:
        """Evaluate a chunk; errors and failures have the original paths of the code."""
        self._require_same_environment()  # it may have joined late
        original = partial(self._shipment.with_original_paths, folder=self._folder)
        with self._lock:
            try:
                self._engine = engine = self._engine or self._opened(seed)
                start = perf_counter()
                results = [*engine.evaluate_many(specifications, seed)]
                seconds = perf_counter() - start
            except MrsfiError as error:
                raise type(error)(original(str(error))) from error
        for place, each in enumerate(results):
            if isinstance(each, FailedFlight):
                results[place] = FailedFlight(original(each.traceback))
        return results, seconds

    def _require_same_environment(self) -> None:
        differences = self._shipment.differences()
        if differences:
            raise TransportError(
                f"the worker at {self._address} would not give the same results: it has "
                f"{differences}; install the same versions there, or stop that worker"
            )

    def _opened(self, seed: int) -> Engine:
        try:
            code = load_code(self._folder, self._shipment.pool)
            return open_engine(self._settings, code, seed, self._n_threads)
        except MrsfiError as error:
            raise type(error)(
                f"on the worker at {self._address}: {error}; the packages that regions import "
                "have to be installed on every worker"
            ) from error


CONNECT_SECONDS = 5.0
"""How long a scheduler may take to answer."""

WORKER_SECONDS = 30.0
"""How long there may be no worker."""

_INSTALL = "expected the same mrsfi[dask,fast] on every worker as here"
_SILENT = logging.CRITICAL + 1


CHUNK_SECONDS = 0.35
"""Duration of a chunk: long beside dask's 2 ms for a task, short enough to repeat elsewhere."""


class ClusterPool(Evaluator):
    """The workers of a scheduler, which come and go, or ``LOCAL`` with so many processes.

    Every worker has an engine, and gets the generated code once. ``on_reached`` receives the number
    of workers before that. An engine that cannot be opened is reported before any worker begins.
    """

    def __init__(
        self,
        address: str,
        n_workers: int,
        code: MissionCode,
        seed: int,
        settings: EngineSettings,
        on_reached: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._address = address
        self._seed = seed
        self._pace = Pace()
        with ExitStack() as stack:
            for name in ("distributed", "distributed.client", "tornado", "tornado.application"):
                log = logging.getLogger(name)  # relevant messages become errors
                stack.callback(log.setLevel, log.level)
                log.setLevel(_SILENT)
            target = _local(n_workers, stack) if address == LOCAL else address
            self._client = self._connected(target)
            stack.callback(self._client.close, timeout=CONNECT_SECONDS)
            self._wait_for_workers()
            self.n_workers = max(self._count_workers(), 1)
            on_reached(f"{counted(self.n_workers, 'workers')} of {address}")
            open_engine(settings, code, seed).close()
            self._plugin = self._shipped(Shipment.of(code.directory, code.pool), settings)
            stack.callback(self._take_back)
            self._stack = stack.pop_all()

    def close(self) -> None:
        """Leave the cluster as it was; a local one ends."""
        self._stack.close()

    def evaluate_many(
        self, specifications: Sequence[Specification], seed: int | None = None
    ) -> Iterator[Evaluated]:
        """Evaluate specifications, and yield the results in the same order, as they come."""
        seed = self._seed if seed is None else seed
        self.n_workers = n_workers = max(self._count_workers(), 1)  # `_wait` reports none
        first = 0
        waiting: deque[Any] = deque()
        try:
            while waiting or first < len(specifications):
                # Two for each worker, so that the next is there when one is done
                n_wanted = 2 * n_workers - sum(not future.done() for future in waiting)
                while first < len(specifications) and n_wanted > 0:
                    size = self._pace.chunk_size(len(specifications), n_workers)
                    chunked = tuple(specifications[first : first + size])
                    waiting.append(self._begin(Chunk(self._plugin, seed, chunked)))
                    first += size
                    n_wanted -= 1
                while waiting and waiting[0].done():
                    with self._translated():
                        results, seconds = waiting.popleft().result()
                    self._pace.learn(len(results), seconds)
                    yield from results
                if waiting:
                    self._wait(waiting)
        finally:
            if waiting and self._client.status == "running":  # chunks that are no longer needed
                with suppress(OSError, CancelledError):
                    self._client.cancel(waiting)

    def _shipped(self, shipment: Shipment, settings: EngineSettings) -> str:
        """Send a mission's code once to each present and later worker; return the plugin's name."""
        name = f"{shipment.name}-{self._client.id}"  # another command's end must not remove it
        try:
            self._client.register_plugin(MissionPlugin(name, shipment, settings), name)
        except MrsfiError:
            raise
        except Exception as error:  # dask's type if a worker cannot load it
            raise TransportError(
                f"a worker of {self._address} cannot take the mission's code: {error}; {_INSTALL}"
            ) from error
        return name

    def _take_back(self) -> None:
        if self._client.status == "running":
            with suppress(OSError, CancelledError):
                self._client.unregister_worker_plugin(self._plugin)

    def _begin(self, chunk: Chunk) -> Any:
        """Have a chunk evaluated on any worker; return dask's future for it."""
        key = f"evaluate-{uuid4()}"
        with self._translated():
            return self._client.submit(pickle.loads, pickle.dumps(chunk), key=key)

    def _wait(self, futures: Iterable[Any]) -> None:
        """Wait for another chunk, at most a second; raise if workers are missing for too long."""
        open_ones = [future for future in futures if not future.done()]
        with suppress(TimeoutError, CancelledError), self._client.as_current():
            if open_ones:
                wait(open_ones, timeout=1.0, return_when="FIRST_COMPLETED")
            return
        if self._count_workers():
            self._has_workers_until = monotonic()
        elif monotonic() > self._has_workers_until + WORKER_SECONDS:
            raise TransportError(
                f"{self._address} has had no worker for {WORKER_SECONDS:g} s; {self._advice()}"
            )

    @contextmanager
    def _translated(self) -> Iterator[None]:
        try:
            yield
        except KilledWorker as error:
            raise WorkerLost(
                f"{error.allowed_failures + 1} workers of {self._address} died in turn while they "
                f"evaluated the same chunk, the last at {error.last_worker.address}; "
                "resume the campaign without --dask and with --workers 1 to see why"
            ) from error
        except ImportError as error:
            raise TransportError(
                f"a worker of {self._address} cannot evaluate: {error}; {_INSTALL}"
            ) from error
        except (OSError, CancelledError) as error:
            raise TransportError(
                f"{self._address}: the connection to the scheduler is lost "
                f"({type(error).__name__}); check that it still runs, and resume"
            ) from error

    def _connected(self, target: Any) -> Any:
        _require_certificates(self._address)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of versions that differ: we refuse them
                return Client(target, timeout=CONNECT_SECONDS, set_as_default=False)
        except OSError as error:
            raise TransportError(
                f"--dask {self._address}: no scheduler answers: {error}; start one with "
                "`dask scheduler`, or correct the address"
            ) from error

    def _wait_for_workers(self) -> None:
        try:
            self._client.wait_for_workers(1, timeout=WORKER_SECONDS)
        except TimeoutError as error:
            raise TransportError(
                f"--dask {self._address}: found no worker within {WORKER_SECONDS:g} s; "
                f"{self._advice()}"
            ) from error
        self._has_workers_until = monotonic()

    def _advice(self) -> str:
        if self._address == LOCAL:
            return "expected worker processes on this machine; use --workers without --dask"
        return f"start some with `dask worker {self._address} --nworkers auto --nthreads 1`"

    def _count_workers(self) -> int:
        with self._translated():
            return len(self._client.nthreads())


def _require_certificates(address: str) -> None:
    """Refuse an address with TLS while dask's configuration has no certificates."""
    if not address.startswith("tls:"):
        return
    try:
        found = Security().get_connection_args("client").get("ssl_context")
        reason = "has none"
    except OSError as error:
        found, reason = None, f"has some that cannot be used: {error}"
    if found is None:
        raise UsageError(
            f"--dask {address}: expected certificates in dask's configuration "
            f"(distributed.comm.tls), which {reason}"
        )


def _local(n_workers: int, stack: ExitStack) -> Any:
    """Run a cluster of processes of one thread each, that only this machine can reach."""
    ensure_running()  # or the first worker's start would begin with it, which lets Ctrl-C through
    try:
        with starting_workers():
            here = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
            limits = {"threads_per_worker": 1, "memory_limit": 0, "silence_logs": _SILENT}
            return stack.enter_context(LocalCluster(n_workers=n_workers, **here, **limits))
    except RuntimeError as error:
        raise TransportError(f"--dask {LOCAL}: {error}; use --workers without --dask") from error


class Pace:
    """Estimates how long an evaluation takes on a worker; it only affects the speed."""

    def __init__(self) -> None:
        self._seconds: float | None = None

    def learn(self, n_evaluations: int, seconds: float) -> None:
        """Take a chunk into account; later chunks have more weight."""
        latest = seconds / n_evaluations
        self._seconds = latest if self._seconds is None else (self._seconds + latest) / 2

    def chunk_size(self, n_specifications: int, n_workers: int) -> int:
        """Return the size of the next chunks, equal for all workers."""
        seconds = 0.05 if self._seconds is None else self._seconds
        most = max(1, int(CHUNK_SECONDS / max(seconds, 1e-6))) * n_workers
        n_rounds = max(1, -(-n_specifications // most))
        return max(1, -(-n_specifications // (n_rounds * n_workers)))
