"""A dask scheduler and its workers, as processes that are started from the command line."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep

from tests.support.missing import skip

_LOOPBACK = ("--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0")
_QUICKLY = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
"""One lost worker is enough for a chunk to be given up."""


class Process:
    """A process with its children, in a group of its own."""

    def __init__(self, folder: Path, *words: str, env: Mapping[str, str]) -> None:
        folder.mkdir(parents=True)
        self.log = folder / "log.txt"
        with self.log.open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "dask", *words, *_LOOPBACK],
                cwd=folder,
                env={**os.environ, **env},
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def send(self, sign: signal.Signals) -> None:
        """Send a signal to all of them."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, sign)

    def kill(self) -> None:
        """Kill all of them, and wait."""
        self.send(signal.SIGKILL)
        self._process.wait(timeout=20)


class Scheduler:
    """A scheduler with workers, each with an empty working directory."""

    def __init__(self, folder: Path, env: Mapping[str, str], protocol: str) -> None:
        self._folder = folder
        self.workers: list[Process] = []
        words = ("scheduler", "--port", "0", "--scheduler-file", str(folder / "address.json"))
        words = (*words, "--protocol", protocol)
        self.process = Process(folder / "scheduler", *words, env=env)
        self.address = self._found_address()

    def _found_address(self) -> str:
        file = self._folder / "address.json"
        limit = monotonic() + 60
        while monotonic() < limit:
            with suppress(FileNotFoundError, json.JSONDecodeError):
                return str(json.loads(file.read_text(encoding="utf-8"))["address"])
            sleep(0.05)
        raise AssertionError(self.process.log.read_text(encoding="utf-8"))

    def start_worker(self, env: Mapping[str, str] | None = None, n_threads: int = 1) -> Process:
        """Start a worker, which joins some time later."""
        folder = self._folder / f"worker-{len(self.workers)}"
        words = ("worker", self.address, "--nthreads", str(n_threads), "--no-nanny")
        words = (*words, "--local-directory", "own")
        self.workers.append(Process(folder, *words, env=env or {}))
        return self.workers[-1]

    def wait_for_workers(self) -> None:
        """Wait until all that were started have joined."""
        limit = monotonic() + 60
        for worker in self.workers:
            while "Registered to" not in worker.log.read_text(encoding="utf-8"):
                assert monotonic() < limit, worker.log.read_text(encoding="utf-8")
                sleep(0.05)

    def kill(self) -> None:
        """Kill everything."""
        for process in (*self.workers, self.process):
            process.kill()


def require_dask() -> None:
    """Skip the test where dask is not installed."""
    if find_spec("distributed") is None:
        skip("needs dask.distributed: pip install '.[dask]'")


def without_mrsfi(folder: Path) -> dict[str, str]:
    """Return an environment in which a process finds no mrsfi; it begins in the folder."""
    package = folder / "mrsfi_runtime"
    package.mkdir(parents=True)
    text = "raise ModuleNotFoundError(\"No module named 'mrsfi_runtime'\", name='mrsfi_runtime')\n"
    (package / "__init__.py").write_text(text, encoding="utf-8")
    return {"PYTHONPATH": str(folder)}


@contextmanager
def scheduler(
    folder: Path,
    n_workers: int,
    *,
    is_quick: bool = False,
    protocol: str = "tcp",
) -> Iterator[Scheduler]:
    """Run a scheduler, which has no mrsfi and needs none, and workers while the body runs.

    With ``is_quick``, a chunk that killed one worker is given to no other.
    """
    require_dask()
    env = without_mrsfi(folder / "none")
    env = {**env, **_QUICKLY} if is_quick else env
    found = Scheduler(folder, env, protocol)
    try:
        for _ in range(n_workers):
            found.start_worker()
        yield found
    finally:
        found.kill()
