"""The side of a worker, which may be on another machine: what travels there, and what it keeps.

It unpacks a mission once, in an empty folder, builds an engine once, and keeps both.
"""

import pickle
import platform
import shutil
import sys
from dataclasses import dataclass
from functools import cache, partial
from hashlib import sha256
from importlib import metadata
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any, Self, cast

from distributed import WorkerPlugin, get_worker

import mrsfi_runtime
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import MrsfiError, TransportError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.imported_copies import copied_files
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight
from mrsfi_runtime.record.engine_settings import EngineSettings

_ELSEWHERE = frozenset({"analysis", "causes", "cli", "search", "study"})
"""Rooms of mrsfi whose source no evaluation depends on."""


@dataclass(frozen=True, slots=True)
class Shipment:
    """The generated code of a mission, and what a worker needs to fly it with the same bits.

    Its name follows from the content. ``given`` and ``absolute`` are the folder it comes from, as
    the user names it and from the root; ``environment`` is what the worker has to have.
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

    def told_as_at_home(self, text: str, folder: Path) -> str:
        """Return a message or traceback with the places of the code where it comes from."""
        framed = text.replace(f'File "{folder}', f'File "{self.absolute}')
        return framed.replace(str(folder), self.given)

    def differences(self) -> str:
        """Return what of this process is not as it has to be, for a message; empty if nothing."""
        found = environment()
        return ", ".join(
            f"{name} {found[name]} where this command has {expected}"
            for name, expected in self.environment.items()
            if found[name] != expected
        )


@cache
def environment() -> dict[str, str]:
    """Return what decides the bits of a result, and whether two processes understand each other."""
    return {
        "mrsfi": f"{_version('mrsfi')} (source {_source_hash()})",
        "Python": f"{sys.version_info.major}.{sys.version_info.minor}",
        "numba": _version("numba"),
        "distributed": _version("distributed"),
        "processor": platform.machine(),
    }


def _source_hash() -> str:
    """Return a hash of all source of mrsfi on which evaluations depend."""
    package = Path(str(mrsfi_runtime.__file__)).parent
    digest = sha256()
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] not in _ELSEWHERE:
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:8]


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "not installed"


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
        told = partial(self._shipment.told_as_at_home, folder=self._folder)
        with self._lock:
            try:
                engine = self._engine(seed, settings)
                start = perf_counter()
                results = tuple(engine.evaluate_many(specifications, seed))
                seconds = perf_counter() - start
            except MrsfiError as error:
                raise type(error)(told(str(error))) from error
        results = tuple(
            FailedFlight(told(each.traceback)) if isinstance(each, FailedFlight) else each
            for each in results
        )
        return EvaluatedChunk(results, seconds)

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
                self._engines[settings] = open_engine(settings, code, seed, self._n_threads)
            except MrsfiError as error:
                raise type(error)(
                    f"on the worker at {self._address}: {error}; what regions import has to be "
                    "installed on every worker"
                ) from error
        return self._engines[settings]
