"""The door to generated code."""

import os
import shutil
import sys
from pathlib import Path

import pytest

from mrsfi_runtime.errors import EvaluationError, GenerationError
from mrsfi_runtime.generated_code import load_code, load_module
from tests.support.tree import ROOT


def test_an_edit_of_the_same_size_in_the_same_second_is_seen(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "team.py"
    found = []

    for text in ("SPEED = 4\n", "SPEED = 6\n"):
        path.write_text(text, encoding="utf-8")
        os.utime(path, (1_000_000_000, 1_000_000_000))
        found.append(load_module("edited_in_a_hurry", path).SPEED)
    del sys.modules["edited_in_a_hurry"]

    assert found == [4, 6]


def test_code_loaded_by_a_relative_path_knows_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("team.py").write_text("def speed():\n    return 4\n", encoding="utf-8")

    module = load_module("known_by_its_file", Path("team.py"))
    del sys.modules["known_by_its_file"]

    assert module.speed.__code__.co_filename == str(tmp_path / "team.py")


def test_code_of_another_version_is_told_apart_from_a_mistake(tmp_path, refused):
    path = tmp_path / "old.py"
    path.write_text("from mrsfi_runtime.api import reactions\n", encoding="utf-8")

    with refused(EvaluationError):
        load_module("of_another_version", path)


@pytest.mark.parametrize(
    "text",
    ['{"schema": 1}', '{"semantics": 99}', "[]", None],
)
def test_code_that_was_not_generated_for_todays_rules_is_not_loaded(tmp_path, text, refused):
    folder = shutil.copytree(ROOT / "generated" / "tight_margins", tmp_path / "code")
    (folder / "manifest.json").unlink()
    if text is not None:
        (folder / "manifest.json").write_text(text, encoding="utf-8")

    with refused(GenerationError):
        load_code(folder)
