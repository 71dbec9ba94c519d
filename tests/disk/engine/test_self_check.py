"""What is remembered of compiled code is remembered of the very same code, and of no other."""

import os
import sys
from dataclasses import replace
from shutil import copytree

import pytest

from mrsfi_runtime.engine.compiled.self_check import FLIES, SAME, SelfCheck
from mrsfi_runtime.mission import load_code
from tests.support.cli import edit
from tests.support.modules import old_modules  # noqa: F401 - a fixture
from tests.support.world import paper_code

SEED = 3


@pytest.fixture
def folder(tmp_path):
    """A cache folder with machine code in it."""
    path = tmp_path / "cache"
    (path / "__pycache__").mkdir(parents=True)
    for k in (1, 2):
        write_before(path / "__pycache__" / f"flight.{k}.nbc", "machine code")
    return path


@pytest.fixture
def code(tmp_path, monkeypatch, old_modules):  # noqa: F811 - a fixture
    """Code of a mission in a folder of its own, whose interface imports a module of the team."""
    monkeypatch.syspath_prepend(str(tmp_path / "team"))
    (tmp_path / "team").mkdir()
    write_before(tmp_path / "team" / "checked_outer.py", "from checked_inner import LIMIT\n")
    write_before(tmp_path / "team" / "checked_inner.py", "LIMIT = 3\n")
    directory = copytree(paper_code().directory, tmp_path / "generated")
    edit(directory / "sim_interface.py", "from .topics", "import checked_outer\nfrom .topics")
    yield load_code(directory)
    forget()


def write_before(path, text):
    """Write a file as if before this process began."""
    path.write_text(text, encoding="utf-8")
    os.utime(path, (1.0, 1.0))


def forget():
    """Let the next import find the team's modules as they stand now."""
    for name in ("checked_outer", "checked_inner"):
        sys.modules.pop(name, None)


def test_what_is_remembered_is_known_in_every_folder_of_the_same_code(folder, code, tmp_path):
    assert not SelfCheck(folder, code, SEED).is_known(SAME)

    SelfCheck(folder, code, SEED).remember(SAME)

    copy = SelfCheck(folder, load_code(copytree(code.directory, tmp_path / "copy")), SEED)
    assert copy.is_known(SAME)
    assert not copy.is_known(FLIES)


@pytest.mark.parametrize(
    "changed",
    [
        "cache/__pycache__/flight.1.nbc",
        "cache/__pycache__/flight.2.nbc",
        "generated/simulation.py",
        "team/checked_outer.py",
        "team/checked_inner.py",
    ],
)
def test_nothing_is_known_of_other_machine_code_generated_code_or_modules(
    folder, code, tmp_path, changed
):
    SelfCheck(folder, code, SEED).remember(SAME)

    path = tmp_path / changed
    text = path.read_text(encoding="utf-8")
    write_before(path, f"{text}# edited\n")

    forget()
    assert not SelfCheck(folder, load_code(code.directory), SEED).is_known(SAME)
    write_before(path, text)
    assert SelfCheck(folder, load_code(code.directory), SEED).is_known(SAME)


def test_nothing_is_known_of_another_mission_pool_or_seed_or_of_other_libraries(
    folder, code, tmp_path
):
    SelfCheck(folder, code, SEED).remember(SAME)

    mission = replace(code.mission, duration=code.mission.duration - 1)
    assert not SelfCheck(folder, replace(code, mission=mission), SEED).is_known(SAME)
    pool = replace(code.pool, id="other")
    assert not SelfCheck(folder, replace(code, pool=pool), SEED).is_known(SAME)
    assert not SelfCheck(folder, code, SEED + 1).is_known(SAME)
    (tmp_path / "team" / "library-2.0.dist-info").mkdir()
    assert not SelfCheck(folder, code, SEED).is_known(SAME)


@pytest.mark.parametrize("changed", ["generated/simulation.py", "team/checked_inner.py"])
def test_nothing_is_remembered_of_code_that_was_edited_while_it_flew(
    folder, code, tmp_path, changed
):
    check = SelfCheck(folder, code, SEED)

    with (tmp_path / changed).open("a", encoding="utf-8") as file:
        file.write("# edited\n")
    check.remember(SAME)

    assert not list(folder.glob(f"{SAME}_*"))


def test_nothing_is_known_of_modules_that_were_edited_since_the_process_began(
    folder, code, tmp_path
):
    SelfCheck(folder, code, SEED).remember(SAME)

    os.utime(tmp_path / "team" / "checked_inner.py")

    assert not SelfCheck(folder, code, SEED).is_known(SAME)


def test_nothing_is_remembered_of_code_that_loads_modules_while_it_flies(folder, code, tmp_path):
    check = SelfCheck(folder, code, SEED)

    write_before(tmp_path / "team" / "checked_late.py", "")
    __import__("checked_late")
    check.remember(SAME)

    assert not list(folder.glob(f"{SAME}_*"))
    del sys.modules["checked_late"]


def test_nothing_is_remembered_of_machine_code_that_is_elsewhere(tmp_path, code):
    SelfCheck(tmp_path, code, SEED).remember(SAME)

    assert not SelfCheck(tmp_path, code, SEED).is_known(SAME)
