"""External simulations that mrsfi starts: well, wrong, slow, late, and chancy ones."""

import json
import os
import signal
import sys
from pathlib import Path
from shlex import quote
from shutil import copytree

import pytest

from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import mrsfi, mrsfi_json, mrsfi_process
from tests.support.interrupted import n_rows
from tests.support.nodes import require_silence
from tests.support.planted_world import CHANCY, LATE, SAME, TICK
from tests.support.processes import children, wait_for
from tests.support.rendezvous import DURATION, NAME, PLANTED, harmless, write_planted
from tests.support.rosbridge import process
from tests.support.tree import ROOT
from tests.tiers import slow

SCRIPT = ROOT / "tests" / "support" / "planted_world.py"


def world(what=SAME, *more):
    """Return the options that start a world."""
    return ("--world", f"{quote(sys.executable)} {SCRIPT} {quote(what)} {{url}}", *more)


def pids(folder):
    """Return the process of each flight so far."""
    path = folder / "flights"
    return path.read_text(encoding="ascii").split() if path.exists() else []


def campaign(place, out, *options):
    """Evolve what is planted in a folder, and return digest, flights after it, and what it said."""
    evolve = write_planted(place, [*PLANTED, *harmless(8)])[:-2]
    done = mrsfi_process(*evolve, *options, "--out", out, cwd=place, timeout=300)
    require_silence(place)
    with CampaignStore.open(place / out) as store:
        return store.digest(), store.flights(), done


@slow
@pytest.mark.parametrize("n_workers", ["1", "2"])
def test_a_world_that_repeats_itself_gives_the_campaign_of_our_own_world(small, n_workers):
    digest, flights, _ = campaign(small, "ours", "--engine", "reference", "--workers", "1")
    found, there, done = campaign(small, "theirs", *world(), "--workers", n_workers)

    assert found == digest
    assert [(each.specification, each.found) for each in there] == [
        (each.specification, each.found) for each in flights
    ]
    assert len(flights) > 0
    assert "flights with an external simulation repeat themselves: one specification, flown 3" in (
        done.stderr
    )


@slow
def test_a_world_is_started_once_or_for_each_flight(small):
    options = ("--workers", "1", "--no-explain")
    digest, *_ = campaign(small, "by_service", *world(), *options)
    by_service = pids(small)
    (small / "flights").unlink()
    found, *_ = campaign(small, "anew", *world(), "--world-reset", "restart", *options)
    anew = pids(small)

    assert found == digest
    assert len(by_service) == len(anew)
    assert len({*anew}) == len(anew)
    assert len({*by_service}) < 4  # a search, and engines that look whether it repeats itself


@slow
def test_a_world_that_dies_in_mid_flight_is_started_anew(small):
    digest, *_ = campaign(small, "ours", "--engine", "reference", "--workers", "1", "--no-explain")
    found, *_ = campaign(small, "theirs", *world("dies once"), "--workers", "1", "--no-explain")

    assert (small / "died").exists()
    assert found == digest


@pytest.mark.parametrize(
    ("what", "said"),
    [
        ("dies", f"tick {TICK}: the simulation ended: exit code 3: "),
        ("hangs", ": the simulation was silent for 4 s; check that it still runs"),
        ("lies", f"tick {TICK}: 9 of 10 messages from the simulation arrived; it count"),
        (f"{LATE}2", "tick 12: commands came too late in 7 ticks; expected at most 6 of 120; let"),
    ],
)
def test_a_world_that_fails_twice_is_an_error_of_the_flight(small, what, said):
    words = (*write_planted(small, PLANTED)[:-2], *world(what, "--timeout", "4"))

    failed = mrsfi_process(*words, cwd=small, expected=6)

    require_silence(small)
    assert said in failed.stderr.splitlines()[-1]
    assert failed.stdout == ""
    assert len(pids(small)) == 2


def test_a_command_that_does_not_start_is_named(small):
    failed = mrsfi("simulate", NAME, "--world", "no_such_world {url}", cwd=small, expected=8)

    assert failed.stderr.splitlines()[-1].endswith(
        "the simulation did not start: no_such_world: No such file or directory; check --world"
    )


def test_a_world_may_be_slow_to_reset(small):
    ours = mrsfi_json("simulate", NAME, cwd=small)
    theirs = mrsfi_json("simulate", NAME, *world("is slow", "--timeout", "2"), cwd=small)

    assert theirs["digest"] == ours["digest"]


def test_late_ticks_are_counted(small):
    found = mrsfi_json("simulate", NAME, *world(f"{LATE}3", "--late", "40%"), cwd=small)
    printed = mrsfi("simulate", NAME, *world(f"{LATE}3", "--late", "40%"), cwd=small).stdout

    assert found["late"] == DURATION // 3
    assert f"Commands came too late in {DURATION // 3} of {DURATION} ticks\n" in printed


@slow
def test_flights_that_differ_are_flown_three_times_and_counted(small):
    _, flights, done = campaign(small, "theirs", *world(CHANCY), "--workers", "1")

    found = json.loads((small / "theirs" / "summary.json").read_text(encoding="utf-8"))
    with CampaignStore.open(small / "theirs") as store:
        kept = {each.index: each.outcome for each in store.evaluations()}
        flown = [each.repetition for each in kept.values()]
        assert store.manifest.engine.repeats == 3
    assert flights == ()
    assert {each.n_flights for each in flown} == {3}
    assert {k for each in flown for k in each.broken} >= {0, 3}
    assert "because they do not repeat themselves" in found["unrepeated"]
    for each in found["top"]:
        assert each["repetition"] == json.loads(
            json.dumps(kept[each["evaluation"]].repetition._asdict())
        )
    assert "broken in" in done.stdout
    assert "| 50 / 50 / 70 / 3 of 3 |" in (small / "theirs" / "report.md").read_text("utf-8")
    assert '"broken in"' in (small / "theirs" / "report.html").read_text("utf-8")


ENDS = {
    "mrsfi": lambda running: [running.pid],
    "a worker": lambda running: children(running.pid, b"spawn_main"),
}
"""What is killed: one of these processes, as soon as there is one."""


@slow
@pytest.mark.parametrize("what", ENDS)
def test_a_campaign_whose_parts_are_killed_leaves_nothing_and_ends_the_same(small, what):
    digest, flights, _ = campaign(small, "ours", "--engine", "reference", "--workers", "1")
    words = (*write_planted(small, [*PLANTED, *harmless(8)])[:-2], *world(), "--out", "out")

    for n_flights in range(4, 44, 4):
        n_before = len(pids(small))
        with process(*words, "--workers", "2", cwd=small) as running:
            wait_for(
                lambda n=n_before + n_flights: (
                    (len(pids(small)) >= n and ENDS[what](running)) or running.poll() is not None
                ),
                60,
            )
            if running.poll() is None:
                os.kill(min(ENDS[what](running)), signal.SIGKILL)
            else:
                assert running.returncode == 0, running.communicate()
            running.wait(60)
        require_silence(small)
        if (small / "out" / "campaign.sqlite").exists():
            words = ("evolve", "--resume", "out")
    mrsfi_process(*words, "--workers", "2", cwd=small)

    with CampaignStore.open(small / "out") as store:
        assert store.digest() == digest
        assert len(store.flights()) == len(flights)


@slow
def test_a_campaign_whose_world_is_killed_again_and_again_ends_the_same(small):
    digest, *_ = campaign(small, "ours", "--engine", "reference", "--workers", "1", "--no-explain")
    words = (*write_planted(small, [*PLANTED, *harmless(8)])[:-2], *world(), "--out", "out")

    with process(*words, "--workers", "2", "--no-explain", cwd=small) as running:
        for n in range(1, 11):  # each with a process that flies, or has flown
            wait_for(lambda n=n: n_rows(small / "out", "evaluation") >= n)
            os.kill(int(pids(small)[-1]), signal.SIGKILL)
        output, _ = running.communicate(timeout=120)

    require_silence(small)
    assert running.returncode == 0
    assert f"digest    {digest}" in output


def test_kept_weaknesses_fly_in_one_world_for_each_worker(found, tmp_path):
    place = Path(copytree(found, tmp_path / "place"))
    for number in "123":
        mrsfi("keep", "runs/it", "--weakness", number, cwd=place)

    ours = mrsfi_json("check", NAME, cwd=place)
    theirs = mrsfi_process("check", NAME, *world(), "--workers", "2", "--json", cwd=place)

    require_silence(place)
    assert json.loads(theirs.stdout) == ours
    assert len(pids(place)) == 3
    assert len({*pids(place)}) == 2
