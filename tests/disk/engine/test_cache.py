"""The cache of compiled missions: whose it is, what is read of it, and how much it keeps."""

import os
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp

import pytest

from mrsfi_runtime.engine.compiled import cache
from mrsfi_runtime.engine.compiled.cache import N_KEPT, cache_folder, is_sound, sealing
from mrsfi_runtime.engine.compiled.machine_code import FILE, MachineCode, forget, kept
from mrsfi_runtime.errors import EvaluationError


@pytest.fixture
def entry(tmp_path):
    """A sealed entry with something in it."""
    path = tmp_path / "mission"
    with sealing(path):
        write(path)
    return path


def write(entry):
    (entry / "__pycache__").mkdir(exist_ok=True)
    for name in ("flight.py", "__pycache__/flight.nbi", "__pycache__/flight.nbc"):
        (entry / name).write_bytes(b"machine code")


def files(entry):
    return sorted(path.name for path in entry.rglob("*") if path.is_file())


def test_what_was_sealed_is_found_again(entry):
    assert is_sound(entry)
    with sealing(entry):
        assert "flight.nbc" in files(entry)


@pytest.mark.parametrize("name", ["flight.py", "__pycache__/flight.nbi", "__pycache__/flight.nbc"])
@pytest.mark.parametrize("content", [b"", b"machine", b"machine code of others", None])
def test_of_what_was_cut_emptied_exchanged_or_lost_nothing_is_read(entry, name, content):
    if content is None:
        (entry / name).unlink()
    else:
        (entry / name).write_bytes(content)

    assert not is_sound(entry)
    with sealing(entry):
        assert files(entry) == ["lock", "seal"]
        write(entry)
    assert is_sound(entry)


@pytest.mark.parametrize("seal", [b"", b"\xff", b"0" * 64])
def test_an_entry_with_another_seal_or_a_file_more_is_emptied(entry, seal):
    (entry / "seal").write_bytes(seal)
    assert not is_sound(entry)
    with sealing(entry):
        pass
    (entry / "__pycache__" / "foreign.nbi").write_bytes(b"")
    assert not is_sound(entry)


def test_what_was_not_finished_is_not_sealed(entry):
    with suppress(EvaluationError), sealing(entry):
        (entry / "flight.py").write_bytes(b"half")
        raise EvaluationError
    assert not is_sound(entry)


def test_a_file_in_the_place_of_an_entry_is_removed(tmp_path):
    (tmp_path / "mission").write_bytes(b"")
    with sealing(tmp_path / "mission"):
        pass
    assert is_sound(tmp_path / "mission")


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
        ("given/file", 0o700, 0, "given/file: compiled code is not kept there: it is no folder"),
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
    monkeypatch.setattr(cache, "mkdtemp", lambda **_: made)

    found = cache_folder()

    assert found == Path(os.environ["MRSFI_CACHE"]) == Path(made)
    assert [why in record.message for record in caplog.records] == [True]


@pytest.mark.parametrize("content", [b"", b"[[], []]", b"machine code of others"])
def test_machine_code_that_was_cut_or_exchanged_is_compiled_anew(tmp_path, monkeypatch, content):
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path))
    code = MachineCode(("fly",), b"machine\ncode", ("floor",))
    assert kept("one", lambda: code) == (code, True)

    (tmp_path / "one" / FILE).write_bytes(content)

    assert kept("one", lambda: code) == (code, True)
    assert kept("one", lambda: pytest.fail("compiled twice")) == (code, False)
    forget("one")
    assert kept("one", lambda: code) == (code, True)


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
    code = MachineCode(("fly",), b"machine code", ("floor",))

    assert kept("last", lambda: code) == (code, True)
    assert kept("last", lambda: pytest.fail("compiled twice")) == (code, False)

    found = {path.name for path in tmp_path.iterdir()}
    assert found == {*[f"mission_{k}" for k in range(n_before)][-(N_KEPT - 1) :], "last"}
