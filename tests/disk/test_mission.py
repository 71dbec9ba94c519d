"""The door to generated code."""

import os
import sys
from pathlib import Path

import pytest

from mrsfi_runtime.mission import load_module


def test_an_edit_of_the_same_size_in_the_same_second_is_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "team.py"
    found = []

    for text in ("SPEED = 4\n", "SPEED = 6\n"):
        path.write_text(text, encoding="utf-8")
        os.utime(path, (1_000_000_000, 1_000_000_000))
        found.append(load_module("edited_in_a_hurry", path).SPEED)
    del sys.modules["edited_in_a_hurry"]

    assert found == [4, 6]


def test_code_loaded_by_a_relative_path_knows_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("team.py").write_text("def speed():\n    return 4\n", encoding="utf-8")

    module = load_module("known_by_its_file", Path("team.py"))
    del sys.modules["known_by_its_file"]

    assert module.speed.__code__.co_filename == str(tmp_path / "team.py")
