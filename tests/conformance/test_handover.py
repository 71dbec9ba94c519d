"""A mission is flown on plain Python until it is compiled: nobody waits, and nothing changes."""

import json
import os
import signal
from itertools import count
from zlib import crc32

import pytest

from mrsfi_runtime.engine.handover import Build, HandoverEngine
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.mission import load_code
from tests.support.cli import SMALL, disturbed, edit, interrupted, mrsfi_process
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.models.shapes import small_mission
from tests.support.processes import children, is_running
from tests.support.rendezvous import NAME, write_rendezvous
from tests.support.world import code_of, specifications
from tests.tiers import slow

SEED = 3
GOES_ON = "the compiled engine goes on"
WAITS = "reference engine until the compiled one is built"


@pytest.fixture
def unique(request, tmp_path, monkeypatch):
    """A number that no other test writes into a region, of which nothing is compiled yet."""
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    return crc32(request.node.nodeid.encode()) / 2**40


def edited(folder, body):
    """Return code of a small mission with one goal, the check of which has another body."""
    directory = small_mission(folder).directory
    write_body(directory / COLLECTIVE, "g0.check", indented(body))
    return load_code(directory)


@pytest.fixture
def code(tmp_path, unique):
    """Code of a small mission that nobody else flies."""
    return edited(tmp_path, f"return ci.robots[0].x > {unique}")


def flown_until_told(engine, told, drawn):
    """Return what an engine found of specifications, flown until it tells what became of it."""
    found = []
    while not told:
        found.append(list(engine.evaluate_many(drawn)))
    return found


def auto(code):
    """Return the engine that auto becomes for who does not wait."""
    return EngineSettings("auto").tried(code, SEED, print, waits=False).name


def test_the_compiled_engine_goes_on_once_it_is_built_and_finds_the_same(code):
    drawn = specifications(code, 3)
    told = []
    assert auto(code) == "auto"

    with HandoverEngine(code, SEED, 2, told.append) as engine:
        found = flown_until_told(engine, told, drawn)
        found.append(list(engine.evaluate_many(drawn)))
        recorded = engine.record(drawn[0])
        outcome = engine.evaluate(drawn[1])

    reference = ReferenceEngine(code, SEED)
    expected = list(reference.evaluate_many(drawn))
    assert len(found) > 2
    assert all(each == expected for each in found)
    assert outcome == expected[1]
    assert (recorded == reference.record(drawn[0])).all()
    assert len(told) == 1
    assert told[0].startswith("compiled in ")
    assert told[0].endswith(GOES_ON)
    assert auto(code) == "compiled"


@slow
@pytest.mark.parametrize("n_workers", [1, 3])
def test_it_may_be_built_after_any_flight(monkeypatch, n_workers):
    code = code_of("tight_margins")
    drawn = specifications(code, 4)
    expected, others = (
        list(ReferenceEngine(code, seed).evaluate_many(drawn)) for seed in (SEED, SEED + 1)
    )
    told = Build.told

    for n_before in (0, 1, 5):
        polled = count()

        def later(build, polled=polled, n_before=n_before):
            if next(polled) < n_before:
                return None
            build._answer.poll(None)
            return told(build)

        monkeypatch.setattr(Build, "told", later)
        with HandoverEngine(code, SEED, n_workers, print) as engine:
            assert list(engine.evaluate_many(drawn)) == expected
            assert list(engine.evaluate_many(drawn, SEED + 1)) == others


@slow
@pytest.mark.turn(1)
@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("return any(robot.x > {} for robot in ci.robots)", "cannot be compiled: "),
        ("return (ci.mission.tick + 2) * 9000000000000000000 > {}", "but differs"),
    ],
    ids=["does not compile", "compiles to something else"],
)
def test_the_reference_engine_stays_where_compiled_code_cannot_be_had(
    tmp_path, unique, body, reason
):
    code = edited(tmp_path, body.format(unique))
    drawn = specifications(code, 3)
    told = []

    with HandoverEngine(code, SEED, 2, told.append) as engine:
        found = flown_until_told(engine, told, drawn)
        found.append(list(engine.evaluate_many(drawn)))

    expected = list(ReferenceEngine(code, SEED).evaluate_many(drawn))
    assert all(each == expected for each in found)
    (text,) = told
    assert text.startswith("not compiled: ")
    assert reason in text
    assert text.endswith("the reference engine evaluates, about 100 times slower")


def test_who_kills_the_compiler_loses_nothing(code):
    drawn = specifications(code, 3)
    told = []

    with HandoverEngine(code, SEED, 2, told.append) as engine:
        first = list(engine.evaluate_many(drawn))
        os.kill(engine._build._process.pid, signal.SIGKILL)
        found = [first, *flown_until_told(engine, told, drawn)]

    expected = list(ReferenceEngine(code, SEED).evaluate_many(drawn))
    assert all(each == expected for each in found)
    assert "the process that compiles died" in told[0]


def test_a_compilation_that_nobody_waits_for_any_more_is_ended(code):
    with HandoverEngine(code, SEED, 2, print) as engine:
        list(engine.evaluate_many(specifications(code, 1)))
        process = engine._build._process
        assert process.is_alive()

    assert process.exitcode is not None


@pytest.fixture
def place(tmp_path, unique):
    """Folder with a mission that nobody has compiled."""
    write_rendezvous(tmp_path)
    file = tmp_path / "generated" / NAME / COLLECTIVE
    (tmp_path / "models" / NAME / "case_a.toml").write_text("[search]\nfaults = 3\n")
    begin = "# protected region imports on begin\n"
    edit(file, begin, f"{begin}UNIQUE = {unique}\n")
    return tmp_path


@slow
def test_a_campaign_says_which_engine_flies_and_records_the_same_whichever_it_is(place):
    words = ("evolve", NAME, *SMALL, "--no-explain")

    new = mrsfi_process(*words, "--out", "runs/new", cwd=place)
    known = mrsfi_process(*words, "--engine", "reference", "--out", "runs/known", cwd=place)

    assert WAITS in new.stderr
    summaries = [
        json.loads((place / "runs" / name / "summary.json").read_text(encoding="utf-8"))
        for name in ("new", "known")
    ]
    assert summaries[0]["digest"] == summaries[1]["digest"]
    assert new.stdout.replace("runs/new", "runs/known") == known.stdout


@slow
def test_a_campaign_that_is_interrupted_while_it_compiles_leaves_no_process(place):
    known = []

    def kill(pid):
        known.extend(children(pid))
        os.kill(pid, signal.SIGKILL)

    words = ("evolve", NAME, "--no-explain", "--workers", "2", "--out")
    disturbed(*words, "runs/killed", cwd=place, sign="generation  0", disturb=kill)
    done = interrupted(*words, "runs/stopped", cwd=place, sign="generation  0")

    assert known
    assert "go on with: mrsfi evolve --resume runs/stopped" in done.stderr
    for pid in known:
        assert not is_running(pid)
