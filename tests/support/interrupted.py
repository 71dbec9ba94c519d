"""Campaigns that are begun, ended in the middle, and looked at."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep

from mrsfi.evolving import made
from mrsfi.folders import find_mission
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation
from tests.support.processes import is_running

MISSION = "tight_margins"
"""The mission of 200 ticks: an evaluation takes some ten milliseconds."""

_SCRIPT = """
import sys
from contextlib import nullcontext
from hashlib import sha256
from pathlib import Path
from mrsfi_runtime.causes.cover import ALGORITHMS
from mrsfi_runtime.engine.pools import WorkerPool
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder, only_writer
from mrsfi_runtime.search.run import run_campaign

evaluated = 0

def counted(specifications):
    global evaluated
    for result in evaluate_many(specifications):
        evaluated += 1
        {report}
        yield result

def hashed(specifications):
    for specification in specifications:
        digest = sha256(repr(specification).encode()).digest()
        counts = tuple(digest[:len(code.mission.goals)])
        none = (0,) * len(specification)
        yield Outcome(counts, counts, counts, counts, counts, counts, none, none, digest.hex())

folder = CampaignFolder(Path(sys.argv[1]))
with only_writer(folder), CampaignStore.open(folder.path) as store:
    code = load_code(folder.generated)
    settings = store.settings
    with {pool} as pool:
        evaluate_many = {evaluate_many}
        print("ready", flush=True)
        run_campaign(settings, code.mission, code.pool, counted, store, algorithms=ALGORITHMS{more})
print(evaluated)
"""

SEARCH = _SCRIPT.format(
    report="print(evaluated, flush=True)",
    pool="WorkerPool(code, settings.mission_seed, int(sys.argv[2]))",
    evaluate_many="pool.evaluate_many",
    more="",
)
"""Searches a campaign folder to its end, without a report, and prints how many it evaluated."""

WRITE = _SCRIPT.format(
    report="", pool="nullcontext()", evaluate_many="hashed", more=", clock=lambda: 0.0"
)
"""The same with evaluations that take no time and are written one by one: nearly all is writing."""


def begin(path: Path, models: Path, settings: CampaignSettings) -> Path:
    """Make the folder of a campaign on a mission that is to be searched."""
    with made(path, find_mission(str(models)), settings, "a", EngineSettings()):
        return path


def evaluations(campaign: Path) -> tuple[Evaluation, ...]:
    """Return what a campaign has recorded; whoever opens it first undoes a half-done write."""
    with CampaignStore.open(campaign) as store:
        return tuple(store.evaluations())


def digest(campaign: Path) -> str:
    """Return the digest of a campaign."""
    with CampaignStore.open(campaign) as store:
        return store.digest()


@contextmanager
def running(script: str, *arguments: str | Path) -> Iterator[subprocess.Popen[str]]:
    """Run a script that says when it is ready, until the body kills it."""
    with subprocess.Popen(
        [sys.executable, "-c", script, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n", process.communicate()[1]
        try:
            yield process
        finally:
            process.kill()
            process.communicate()


def killed_after(seconds: float, script: str, *arguments: str | Path, n_evaluated: int = 0) -> bool:
    """Kill a script so long after it evaluated so many; return whether it was not at its end."""
    with running(script, *arguments) as process:
        assert process.stdout is not None
        for _ in range(n_evaluated):
            process.stdout.readline()
        sleep(seconds)
        process.kill()
        return process.wait() == -signal.SIGKILL


def finished(script: str, *arguments: str | Path) -> int:
    """Run a script to its end and return how many specifications it evaluated."""
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)],
        check=False,
        capture_output=True,
        encoding="utf-8",
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return int(done.stdout.split()[-1])


def are_gone(processes: list[int], *, within: float) -> bool:
    """Wait until processes have ended, at most so many seconds."""
    limit = monotonic() + within
    while monotonic() < limit:
        if not any(map(is_running, processes)):
            return True
        sleep(0.05)
    return False
