"""The reference engine and its workers, and the cache, libraries and check of compiled code."""

import json
import os
import resource
import tempfile
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import mkdtemp

import pytest

from mrsfi_runtime.engine.compiled import machine_code
from mrsfi_runtime.engine.compiled.engine import require_same, trials
from mrsfi_runtime.engine.compiled.machine_code import (
    FILE,
    N_KEPT,
    Library,
    MachineCode,
    cache_folder,
    forget,
    kept,
    kept_code,
    key_of,
    sealed,
    sources_key,
)
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import quickest
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.errors import EvaluationError, UsageError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import FaultPool, Gate, TimedFault
from mrsfi_runtime.record.engine_settings import (
    AUTO,
    COMPILED,
    REFERENCE,
    EngineSettings,
    Workers,
    require_address,
)
from tests.support.cluster import require_dask
from tests.support.edited import edited
from tests.support.world import ROOT, paper_code

GENERATED = ROOT / "generated" / "uuv_sampling"
MADE = b"machine\ncode"
NAMES = ["fly", "check"]
SEED = 3
TENTH = "define double @f(double %x) {\n%y = fmul double %x, 0x3FB999999999999A\nret double %y\n}"


def test_an_error_in_a_region_names_its_line_mission_tick_and_cause(tmp_path):
    body = "    return 1 // (500 - ci.mission.tick) > 9\n"
    folder = edited(tmp_path, "g2.check", body)
    path = folder / "collective_intelligence.py"
    line = path.read_text(encoding="utf-8").splitlines().index(body.rstrip()) + 1

    with pytest.raises(EvaluationError) as failed:
        ReferenceEngine(load_code(folder), 1).evaluate(())

    expected = f"{path}:{line}: the mission stopped at tick 500: ZeroDivisionError: "
    assert str(failed.value).startswith(expected)


def test_a_region_that_does_not_compile_is_named_with_its_file(tmp_path, refused):
    folder = edited(tmp_path, "g2.check", "    return (\n")

    with refused(EvaluationError):
        load_code(folder)


def test_two_folders_of_one_mission_do_not_share_code(tmp_path):
    folder = edited(tmp_path, "g2.check", "    return True\n")

    first, second = load_code(GENERATED), load_code(folder)

    assert ReferenceEngine(first, 1).evaluate(()).believed[1] == 0
    assert ReferenceEngine(second, 1).evaluate(()).believed[1] == 1000


def test_a_mission_of_one_tick_flies():
    code = paper_code()
    short = replace(code, mission=replace(code.mission, duration=1))

    outcome = ReferenceEngine(short, 1).evaluate((TimedFault("f26", 0, 0),))

    assert outcome.applied == (1,)


@pytest.mark.parametrize("text", ["local", "tcp://127.0.0.1:8786", "tls://[::1]:8786"])
def test_addresses_of_schedulers_are_taken(text):
    require_dask()

    require_address(text)


@pytest.mark.parametrize(
    "text",
    ["", "remote", "127.0.0.1:8786", "tcp://host", "tcp://:8786", "ws://host:1", "tcp://h:x"],
)
def test_what_is_no_address_is_refused_with_what_was_expected(text, refused):
    require_dask()

    with refused(UsageError):
        require_address(text)


def test_an_address_with_tls_is_refused_while_no_certificates_are_configured(refused):
    require_dask()
    from mrsfi_runtime.engine.cluster import ClusterPool

    code = load_code(ROOT / "generated" / "tight_margins")

    with refused(UsageError):
        ClusterPool("tls://127.0.0.1:8786", 1, code, 1, EngineSettings())


@pytest.fixture
def entry(tmp_path, monkeypatch):
    """An entry with something in it."""
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    assert kept("mission", lambda: MADE) == (MADE, True)
    return tmp_path / "mission"


def found_again(entry):
    return kept(entry.name, lambda: pytest.fail("made twice")) == (MADE, False)


def test_what_was_sealed_is_found_again_until_it_is_forgotten(entry):
    assert found_again(entry)
    forget(entry.name)
    assert kept(entry.name, lambda: MADE) == (MADE, True)


@pytest.mark.parametrize(
    "content",
    [
        lambda whole: b"",
        lambda whole: whole[:-1],
        lambda whole: whole[1:],
        lambda whole: whole.replace(b"machine", b"foreign"),
        lambda whole: b"0" * 64 + b"\n" + MADE,
        lambda whole: b"\xff\n" + MADE,
        None,
    ],
    ids=["emptied", "cut", "begun later", "exchanged", "another seal", "no seal", "lost"],
)
def test_of_what_was_cut_emptied_exchanged_or_lost_nothing_is_read(entry, content):
    if content is None:
        (entry / FILE).unlink()
    else:
        (entry / FILE).write_bytes(content((entry / FILE).read_bytes()))

    assert kept(entry.name, lambda: MADE) == (MADE, True)
    assert found_again(entry)


def test_of_two_entries_that_were_exchanged_neither_is_read(entry):
    other = entry.with_name("other")
    kept("other", lambda: b"of another")
    mine, theirs = (each / FILE for each in (entry, other))
    moved = mine.read_bytes()
    mine.write_bytes(theirs.read_bytes())
    theirs.write_bytes(moved)

    assert kept(entry.name, lambda: MADE) == (MADE, True)
    assert kept("other", lambda: b"of another") == (b"of another", True)


def test_what_was_not_finished_is_not_kept(entry):
    def fail():
        raise EvaluationError

    forget(entry.name)
    with suppress(EvaluationError):
        kept(entry.name, fail)

    assert kept(entry.name, lambda: MADE) == (MADE, True)


def test_where_no_folder_has_room_the_error_says_how_to_name_one(entry, monkeypatch, refused):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    monkeypatch.setattr(tempfile, "tempdir", str(entry.parent))
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(MADE), before[1]))
    try:
        with refused(UsageError):
            kept("other", lambda: MADE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_file_in_the_place_of_an_entry_is_removed(entry):
    entry.with_name("other").write_bytes(b"")

    assert kept("other", lambda: MADE) == (MADE, True)
    assert kept("other", lambda: pytest.fail("made twice")) == (MADE, False)


def test_a_folder_of_ones_own_is_made_for_nobody_else(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "new"))

    assert cache_folder() == tmp_path / "new"
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    ("folder", "mode", "owner", "why"),
    [
        ("given", 0o777, 0, "others may write to it (mode 777, expected 700)"),
        ("given", 0o720, 0, "others may write to it (mode 720, expected 700)"),
        ("given", 0o700, 1, "it belongs to user"),
        ("given/file", 0o700, 0, "given/file: compiled code is not cached there: it is no folder"),
        ("given/file/inner", 0o700, 0, "Not a directory"),
    ],
)
def test_a_folder_that_is_not_to_be_trusted_is_told_once_and_replaced(
    tmp_path, monkeypatch, caplog, folder, mode, owner, why
):
    given = tmp_path / "given"
    given.mkdir()
    (given / "file").touch()
    given.chmod(mode)
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / folder))
    user = given.stat().st_uid + owner
    monkeypatch.setattr(os, "getuid", lambda: user)
    made = mkdtemp(dir=tmp_path)
    monkeypatch.setattr("tempfile.mkdtemp", lambda **_: made)

    found = cache_folder()

    assert found == Path(os.environ["MRSFI_CACHE"]) == Path(made)
    assert [why in record.message for record in caplog.records] == [True]


def test_machine_code_is_found_as_it_was_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    code = MachineCode(("fly",), b"machine\ncode", ("floor",), is_near=True)

    assert kept_code("one", lambda: code) == (code, True)
    assert kept_code("one", lambda: pytest.fail("compiled twice")) == (code, False)


@pytest.mark.parametrize("n_before", [0, 1, N_KEPT // 2 + 3, N_KEPT - 1, N_KEPT, N_KEPT + 5])
def test_a_new_mission_takes_the_place_of_the_oldest_only_where_the_cache_is_full(
    tmp_path, monkeypatch, n_before
):
    for k in range(n_before):
        path = tmp_path / f"mission_{k}" / FILE
        path.parent.mkdir()
        path.touch()
        os.utime(path, (k + 1, k + 1))

    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))

    assert kept("last", lambda: MADE) == (MADE, True)
    assert kept("last", lambda: pytest.fail("made twice")) == (MADE, False)

    found = {path.name for path in tmp_path.iterdir()}
    assert found == {*[f"mission_{k}" for k in range(n_before)][-(N_KEPT - 1) :], "last"}


@pytest.mark.skipif(machine_code.platform.machine() != "x86_64", reason="it is of x86-64")
def test_code_has_no_addresses_of_64_bits_of_its_constants():
    llvm = pytest.importorskip("llvmlite.binding")
    machine = machine_code.this_machine(is_near=True)

    code = machine.emit_assembly(llvm.parse_assembly(TENTH))

    assert "mulsd" in code
    assert "movabs" not in code


def found_in(folder, monkeypatch, names, seal):
    (folder / "kernel.so").write_bytes(b"library")
    (folder / "kernel.json").write_text(json.dumps({"seal": seal, "names": names}))
    monkeypatch.setattr(machine_code, "FOLDER", folder)
    monkeypatch.setattr(machine_code, "_FEATURES", frozenset())
    return machine_code.prebuilt_kernel.__wrapped__()


@pytest.mark.skipif(machine_code.platform.machine() != "x86_64", reason="it is of x86-64")
def test_what_was_sealed_is_taken(tmp_path, monkeypatch):
    seal = sealed(key_of(sources_key(), *NAMES), b"library").decode()

    found = found_in(tmp_path, monkeypatch, NAMES, seal)

    assert found == Library(tmp_path / "kernel.so", tuple(NAMES))


@pytest.mark.parametrize(
    ("sources", "names", "library"),
    [
        ("others", NAMES, b"library"),
        (sources_key(), NAMES[::-1], b"library"),
        (sources_key(), NAMES, b"exchanged"),
    ],
)
def test_what_was_sealed_as_another_is_not(tmp_path, monkeypatch, sources, names, library):
    seal = sealed(key_of(sources, *names), library).decode()

    assert found_in(tmp_path, monkeypatch, NAMES, seal) is None


@pytest.mark.parametrize("duration", [1, 3, 1000])
def test_every_fault_of_the_pool_acts_at_once_or_in_turns_until_the_end(duration):
    code = paper_code()
    mission = replace(code.mission, duration=duration)
    gate = Gate(mission, code.pool)

    flown = trials(gate)

    for each in flown:
        assert gate.admitted(each) == each
        assert {timed.fault for timed in each if timed.start == 0} == {one.fault for one in each}
        assert max(timed.finish for timed in each) == duration - 1
    assert {timed.fault for each in flown for timed in each} == set(code.pool.by_id)
    assert len(flown) < 9


def test_without_faults_the_mission_flies_alone():
    code = paper_code()
    assert trials(Gate(code.mission, FaultPool("none", ()))) == [()]


@pytest.fixture
def reference():
    return ReferenceEngine(paper_code(40), SEED)


def recorded(reference, change=lambda _recording: None):
    """Return what records flights on the reference engine, but for a change."""

    def record(specification, n_ticks):
        (moments,) = reference.record(specification).moments()
        recording = Recording(moments.dtype)
        recording.append(moments[:n_ticks])
        change(recording)
        return recording

    return record


def one(reference):
    return trials(Gate(reference.code.mission, reference.code.pool))


def test_equal_flights_pass_over_as_many_ticks_as_there_is_time_for(reference):
    lengths = []
    record = recorded(reference, lambda recording: lengths.append(len(recording)))

    require_same(reference, record, one(reference), 10.0)
    require_same(reference, record, one(reference), 0.0)

    n = len(one(reference))
    assert lengths == [40] * n + [2] * n


def spoilt(*path, tick=9):
    def change(recording):
        where = recording[tick]
        for name in path[:-1]:
            where = where[name]
        where[path[-1]] += 1

    return change


@pytest.mark.parametrize(
    "change",
    [
        spoilt("is_true", 1),
        spoilt("believed", 0),
        spoilt("belief", "commands", "speed", 2),
        spoilt("world", "robots", "x", 1),
        spoilt("belief", "goals", "memory", (0, 3)),
    ],
)
def test_the_first_difference_is_named_with_tick_and_region(reference, change, refused):
    with refused(EvaluationError):
        require_same(reference, recorded(reference, change), one(reference), 10.0)


def test_flights_that_fail_compiled_are_not_compared_for_they_are_repeated(reference):
    require_same(reference, lambda *_: None, one(reference), 0.0)


def test_what_fails_on_the_reference_engine_alone_is_told_with_its_line(refused):
    code = paper_code(40)
    sound = ReferenceEngine(code, SEED)

    def check(ci, violated):
        code.functions.check(ci, violated)
        if ci.mission.tick == 12:
            raise ZeroDivisionError

    functions = code.functions._replace(check=check)
    failing = ReferenceEngine(replace(code, functions=functions), SEED)

    with refused(EvaluationError):
        require_same(failing, recorded(sound), one(sound), 10.0)


def test_two_flights_of_the_papers_mission_do_not_wait_for_compiled_code():
    code, auto, many = paper_code(), EngineSettings(AUTO), Workers(4)

    assert quickest(auto, many, code, SEED, pytest.fail, 2) == (
        EngineSettings(REFERENCE),
        Workers(1),
    )
    for settings in (EngineSettings(COMPILED), EngineSettings(REFERENCE)):
        assert quickest(settings, many, code, SEED, pytest.fail, 2) == (settings, many)
