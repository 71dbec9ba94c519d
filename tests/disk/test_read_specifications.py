"""A written specification is read by the libraries for models only if a file has changed."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from m2t.metamodels import metamodel_folder
from m2t.models.load import load_specification
from mrsfi import folders, loading
from mrsfi_runtime.errors import ModelError
from tests.support.cli import MISSION, edit, stop_specification, workspace
from tests.support.world import paper_code

CODE = paper_code()


@pytest.fixture
def written(tmp_path, monkeypatch):
    """A specification beside its mission, written a while ago, and an empty cache."""
    monkeypatch.setenv("MRSFI_CACHE", str(tmp_path / "cache"))
    shutil.copytree(metamodel_folder(), tmp_path / "own")
    monkeypatch.setenv("MRSFI_METAMODELS", str(tmp_path / "own"))
    models = workspace(tmp_path).joinpath("models", MISSION)
    path = stop_specification(models / "stop.xmi", [(100, 900)])
    return aged(path)


def aged(path):
    """Let the files of a folder be older than the last second."""
    for each in path.parent.iterdir():
        if each.is_file():
            os.utime(each, (1_000_000_000, 1_000_000_000))
    return path


@pytest.fixture
def loads(monkeypatch):
    """The files that were read by the libraries for models, which read them as ever."""
    found = list[Path]()

    def load(path):
        found.append(path)
        return load_specification(path)

    monkeypatch.setattr(loading, "load_models", load)
    return found


def read(path):
    found = loading.read_specification(path, CODE)
    return found.pool, found.specification, found.unknown, found.late


def of_the_mission(path, _):
    edit(path.with_name("mission.xmi"), 'speed="5.0"', 'speed="6.0"')


def of_the_specification(path, _):
    edit(path, 'finish="900"', 'finish="901"')


def of_a_metamodel(_, __):
    edit(Path(os.environ["MRSFI_METAMODELS"], "faults.ecore"), "?>", "?><!-- mine -->")


def of_mrsfi(_, monkeypatch):
    monkeypatch.setattr(folders, "_version", lambda: "another")


CHANGES = [of_the_mission, of_the_specification, of_a_metamodel, of_mrsfi]


@pytest.mark.parametrize("change", CHANGES)
def test_a_specification_is_loaded_again_after_a_change(change, written, loads, monkeypatch):
    first, again = read(written), read(written)

    assert (again, loads) == (first, [written])
    change(written, monkeypatch)
    changed = read(aged(written))
    assert (changed == first) == (change is not of_the_specification)
    assert (read(written), loads) == (changed, [written] * 2)


def test_a_damaged_entry_is_made_again(written, loads, tmp_path):
    first = read(written)
    (entry,) = tmp_path.glob("cache/*/code")
    entry.write_bytes(entry.read_bytes()[:-1])

    assert [read(written), read(written)] == [first, first]
    assert loads == [written] * 2


def test_a_file_that_changed_a_moment_ago_is_loaded_again(written, loads):
    written.touch()

    assert read(written) == read(written)
    assert loads == [written] * 2


def test_an_error_in_a_specification_is_reported_each_time(written, loads):
    edit(written, "mission.xmi#r1", "mission.xmi#r9")

    for _ in range(2):
        with pytest.raises(ModelError, match=r"stop\.xmi:5: .*r9"):
            read(written)
    assert loads == [written] * 2


def test_a_folder_that_others_may_write_to_is_not_read(written, loads, tmp_path):
    first = read(written)
    (tmp_path / "cache").chmod(0o777)

    assert read(written) == first
    assert loads == [written] * 2


def test_many_may_read_at_once(written, loads):
    with ThreadPoolExecutor(4) as threads:
        found = [*threads.map(read, [written] * 4)]

    assert found == [read(written)] * 4
    assert loads == [written]
