"""The connection to a dask cluster: tasks go out, results or clear errors come back."""

import logging
import pickle
import warnings
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from multiprocessing.resource_tracker import ensure_running
from time import monotonic
from typing import Any
from uuid import uuid4

from distributed import Client, KilledWorker, LocalCluster, Security, wait

from mrsfi_runtime.engine.cluster.worker import Chunk, EvaluatedChunk, MissionPlugin, Shipment
from mrsfi_runtime.engine.pools import starting_workers
from mrsfi_runtime.errors import MrsfiError, TransportError, UsageError, WorkerLost
from mrsfi_runtime.record.engine_settings import LOCAL

CONNECT_SECONDS = 5.0
"""How long a scheduler may take to answer."""

WORKER_SECONDS = 30.0
"""How long there may be no worker."""

_LOOK_SECONDS = 1.0  # between two looks at whether anybody still works
_INSTALL = "expected the same mrsfi[dask,fast] on every worker as here"
_LOGGERS = ("distributed", "distributed.client", "tornado", "tornado.application")
_LOOPBACK = "127.0.0.1"
_SILENT = logging.CRITICAL + 1


class Cluster(AbstractContextManager["Cluster"]):
    """A scheduler with workers that come and go, or ``LOCAL`` with so many processes."""

    def __init__(self, address: str, n_workers: int = 1, patience: float = WORKER_SECONDS) -> None:
        self.address = address
        self._patience = patience
        self._has_workers_until = monotonic()
        self._plugins: dict[str, str] = {}
        with ExitStack() as stack:
            for log in map(logging.getLogger, _LOGGERS):  # what matters becomes an error
                stack.callback(log.setLevel, log.level)
                log.setLevel(_SILENT)
            target = _local(n_workers, stack) if address == LOCAL else address
            self._client = self._connected(target)
            stack.callback(self._client.close, timeout=CONNECT_SECONDS)
            stack.callback(self._take_back)
            self._wait_for_workers()
            self._stack = stack.pop_all()

    def __exit__(self, *_: object) -> None:
        """Leave the cluster as it was; a local one ends."""
        self._stack.close()

    def n_workers(self) -> int:
        """Return how many workers there are now, but not 0: who waits will see about that."""
        return max(self._count_workers(), 1)

    def ship(self, shipment: Shipment) -> str:
        """Give every worker, also those to come, a mission's code once; name it for chunks."""
        if shipment.name not in self._plugins:
            name = f"{shipment.name}-{self._client.id}"  # another command's end must not take it
            try:
                self._client.register_plugin(MissionPlugin(name, shipment), name)
            except MrsfiError:
                raise
            except Exception as error:  # dask tells in a bare one what a worker cannot load
                raise TransportError(
                    f"a worker of {self.address} cannot take the mission's code: {error}; "
                    f"{_INSTALL}"
                ) from error
            self._plugins[shipment.name] = name
        return self._plugins[shipment.name]

    def begin(self, chunk: Chunk) -> Any:
        """Have a chunk evaluated on any worker; return dask's future for it."""
        key = f"evaluate-{uuid4()}"
        with self._told():
            return self._client.submit(pickle.loads, pickle.dumps(chunk), key=key)

    def result(self, future: Any) -> EvaluatedChunk:
        """Return what came of a chunk, or raise why nothing did."""
        with self._told():
            found: EvaluatedChunk = future.result()
        return found

    def wait(self, futures: Iterable[Any]) -> None:
        """Wait until another chunk is done, or for a moment; without workers not for long."""
        open_ones = [future for future in futures if not future.done()]
        with suppress(TimeoutError, CancelledError), self._client.as_current():
            if open_ones:
                wait(open_ones, timeout=_LOOK_SECONDS, return_when="FIRST_COMPLETED")
            return
        if self._count_workers():
            self._has_workers_until = monotonic()
        elif monotonic() > self._has_workers_until + self._patience:
            raise TransportError(
                f"no worker has been left on {self.address} for {self._patience:g} s; "
                f"{self._advice()}"
            )

    def give_up(self, futures: Sequence[Any]) -> None:
        """Drop chunks that nobody waits for any more."""
        if futures and self._client.status == "running":
            with suppress(OSError, CancelledError):
                self._client.cancel(futures)

    @contextmanager
    def _told(self) -> Iterator[None]:
        try:
            yield
        except KilledWorker as error:
            raise WorkerLost(
                f"{error.allowed_failures + 1} workers of {self.address} died, one after the "
                f"other, while they had the same chunk, the last at {error.last_worker.address}; "
                "resume the campaign without --dask and with --workers 1 to see why"
            ) from error
        except ImportError as error:
            raise TransportError(
                f"a worker of {self.address} cannot evaluate: {error}; {_INSTALL}"
            ) from error
        except (OSError, CancelledError) as error:
            raise TransportError(
                f"{self.address}: the connection to the scheduler is lost "
                f"({type(error).__name__}); see whether it still runs, and resume"
            ) from error

    def _connected(self, target: Any) -> Any:
        _require_certificates(self.address)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of versions that differ: we refuse them
                return Client(target, timeout=CONNECT_SECONDS, set_as_default=False)
        except OSError as error:
            raise TransportError(
                f"--dask {self.address}: no scheduler answers: {error}; start one with "
                "`dask scheduler`, or correct the address"
            ) from error

    def _wait_for_workers(self) -> None:
        try:
            self._client.wait_for_workers(1, timeout=self._patience)
        except TimeoutError as error:
            raise TransportError(
                f"--dask {self.address}: found no worker within {self._patience:g} s; "
                f"{self._advice()}"
            ) from error
        self._has_workers_until = monotonic()

    def _advice(self) -> str:
        if self.address == LOCAL:
            return "expected processes of this machine; use --workers without --dask"
        return f"start some with `dask worker {self.address} --nworkers auto --nthreads 1`"

    def _count_workers(self) -> int:
        with self._told():
            return len(self._client.nthreads())

    def _take_back(self) -> None:
        for name in self._plugins.values():
            if self._client.status == "running":
                with suppress(OSError, CancelledError):
                    self._client.unregister_worker_plugin(name)


def _require_certificates(address: str) -> None:
    """Refuse an address with TLS while dask's configuration has nothing to connect with."""
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
            cluster = LocalCluster(
                n_workers=n_workers,
                threads_per_worker=1,
                host=_LOOPBACK,
                dashboard_address=f"{_LOOPBACK}:0",
                silence_logs=_SILENT,
                memory_limit=0,
            )
            return stack.enter_context(cluster)
    except RuntimeError as error:
        raise TransportError(f"--dask {LOCAL}: {error}; use --workers without --dask") from error
