"""Whatever is ended while a campaign runs, and again after it went on: it ends as a whole one."""

import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from signal import SIGKILL, SIGTERM
from tempfile import TemporaryDirectory
from typing import NamedTuple

import pytest

from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import mrsfi, press
from tests.support.cluster import scheduler
from tests.support.interrupted import is_equal, n_rows, rows
from tests.support.processes import children, descendants, require_end, wait_for
from tests.support.rendezvous import searched, write_planted
from tests.support.rosbridge import process
from tests.tiers import slow

MOMENTS = (("evaluation", 20), ("flight", 3))
"""Rows that a command adds while it searches, and while it flies what that left unexplained."""

ONE, TWO = ("--workers", "1"), ("--workers", "2")
BUS = ("--engine", "rosbridge", *ONE)

Beside = tuple[tuple[str, ...], Callable[[], object] | None]
"""What a command is told of a process beside it, and what ends that process."""


@contextmanager
def server() -> Iterator[Beside]:
    with process("bridge", "--port", "0") as running:
        assert running.stdout is not None
        yield ("--url", running.stdout.readline().strip()), running.kill


@contextmanager
def cluster() -> Iterator[Beside]:
    with TemporaryDirectory() as folder, scheduler(Path(folder) / "dask", 1) as running:
        yield ("--dask", running.address), running.process.kill


class Case(NamedTuple):
    """A command with some options, what ends it, and what it says then."""

    options: tuple[str, ...]
    end: Callable[[int], object]
    code: int = -SIGKILL
    said: str = ""
    beside: Callable[[], AbstractContextManager[Beside]] = lambda: nullcontext(((), None))
    moments: tuple[tuple[str, int], ...] = MOMENTS


def kill(pid: int) -> None:
    os.kill(pid, SIGKILL)


def kill_child(word: bytes) -> Callable[[int], None]:
    return lambda pid: kill(min(children(pid, word)))


CASES = {
    "mrsfi": Case(ONE, kill),
    "mrsfi with workers": Case(TWO, kill),
    "mrsfi with a simulation": Case(BUS, kill, moments=MOMENTS[:1]),
    "Ctrl-C": Case(TWO, press, 130),
    "Ctrl-C with a cluster": Case(("--dask", "local", *TWO), press, 130),
    "SIGTERM": Case(TWO, lambda pid: os.kill(pid, SIGTERM), 130),
    "a worker": Case(TWO, kill_child(b"spawn_main"), 6, "a worker process died; resume the"),
    "the simulation": Case(BUS, kill_child(b"engine.rosbridge"), 8, "SIGKILL", moments=MOMENTS[:1]),
    "the server": Case(BUS, kill, 8, "was lost", server, MOMENTS[:1]),
    "the scheduler": Case((), kill, 8, "the connection to the scheduler is lost", cluster),
}


@pytest.mark.parametrize(
    "what", [what if what == "mrsfi" else pytest.param(what, marks=slow) for what in CASES]
)
def test_what_is_ended_goes_on_to_the_same(what, ended, small):
    run, done = ended
    out = small / "runs" / "it"
    words, kept = (*searched(small), "--out", "runs/it"), recorded(out)

    for table, n in CASES[what].moments:
        before, n_before = kept, n_rows(out, "evaluation")
        most = n_rows(out, table) + n
        told = cut(CASES[what], words, small, lambda t=table, n=most: n_rows(out, t) >= n)
        kept, words = recorded(out), ("evolve", "--resume", "runs/it")

        assert before < kept < recorded(run)
        assert f"{n_before} evaluations and 0 failures are recorded" in told or not n_before
    resumed, again = (mrsfi(*words, "--engine", "reference", *ONE, cwd=small) for _ in range(2))

    assert "generation 0/" not in resumed.stderr
    assert "was finished already" in again.stderr
    assert resumed.stdout == again.stdout == done.stdout
    assert recorded(out) == recorded(run)
    assert is_equal(out, run)


@slow
def test_a_killed_search_goes_on_from_its_kept_state_to_the_same(small):
    words = write_planted(small, (), algorithm="guided", faults=4, evaluations=1200)
    words, whole, out = (*words, *ONE, "--no-explain"), small / "runs" / "whole", small / "it"
    mrsfi(*words, "--out", whole, cwd=small)

    cut(Case((), kill), (*words, "--out", out), small, lambda: state(out))
    n_before = n_rows(out, "evaluation")
    mrsfi("evolve", "--resume", out, *ONE, cwd=small)

    assert 1000 < n_before < 1200
    for table in ("evaluation", "generation"):
        assert rows(out, table) == rows(whole, table)
    assert state(out) == state(whole)


def state(run: Path) -> str | None:
    """Return the last state that the search of a campaign kept."""
    if not n_rows(run, "evaluation"):
        return None
    with CampaignStore.open(run) as store:
        return store.kept("state", str)


def recorded(run: Path) -> set[tuple[object, ...]]:
    """Return evaluations and flights of a campaign, without what was half written at a kill."""
    is_begun = (run / "campaign.sqlite").is_file()
    return {*rows(run, "evaluation"), *rows(run, "flight")} if is_begun else set()


def cut(case: Case, words: tuple[str, ...], place: Path, is_time: Callable[[], bool]) -> str:
    """Run a command until it is time to end something; return what the command says of it."""
    with (
        case.beside() as (options, end),
        process(*words, *case.options, *options, cwd=place) as command,
    ):
        wait_for(is_time)
        started = descendants(command.pid)
        end() if end else case.end(command.pid)
        _, told = command.communicate(timeout=60)
        require_end(started)
    assert command.returncode == case.code, told
    assert case.said in told
    assert ("continue with: mrsfi evolve --resume runs/it" in told) == (case.code > 0)
    assert "Traceback" not in told
    return told
