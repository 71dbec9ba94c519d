"""What compiled code reaches, by value: whatever an edit changes, it changes the text of it."""

import importlib
import os
import sys

import numpy as np
import pytest
from numba.core.typing import templates

from mrsfi_runtime.engine.compiled.regions import CompilationError, Reached
from tests.support.edits import EDITS, MODULES, REFUSED, write_team


@pytest.fixture
def team(tmp_path, monkeypatch):
    """A folder of a team's modules, that are imported from source."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield tmp_path
    for name in [name for name in sys.modules if name.startswith(("edit_", "reach_"))]:
        del sys.modules[name]


@pytest.fixture
def without_extensions(monkeypatch):
    """Numba without what a test registers with it, afterwards."""
    for name in ("functions", "attributes"):
        listed = getattr(templates.builtin_registry, name)
        monkeypatch.setattr(templates.builtin_registry, name, listed.copy())


def loaded(name="edit_team"):
    """Return a module as it stands now."""
    return importlib.import_module(name)


@pytest.mark.parametrize("kind", EDITS)
def test_an_edit_is_seen_and_what_was_not_edited_is_the_same(team, kind):
    texts, values = [], []
    for is_edited in (False, True, False):
        write_team(team, kind, is_edited=is_edited)
        verdict = loaded().verdict
        values.append(verdict(2.7))
        texts.append(Reached([verdict]).text)

    assert values[0] == values[2] != values[1]
    assert texts[0] == texts[2] != texts[1]


@pytest.mark.parametrize("kind", REFUSED)
def test_what_no_text_tells_is_refused_with_its_name(team, without_extensions, kind, refused):
    write_team(team, kind, is_edited=False)

    with refused(CompilationError):
        Reached([loaded().verdict])


def test_what_counts_is_what_was_loaded_and_not_the_file(team):
    write_team(team, "alias of a constant", is_edited=False)
    path = team / "edit_other.py"
    sys.dont_write_bytecode = False
    os.utime(path, (1, 1))
    before = Reached([loaded().verdict]).text

    path.write_text("LOW, HIGH = 4.0, 2.0\n", encoding="utf-8")
    os.utime(path, (1, 1))
    for name in MODULES:
        del sys.modules[name]

    assert (
        loaded("edit_other").LOW == 1.0
    )  # Python takes its bytecode: size and second are the same
    assert Reached([loaded().verdict]).text == before


def test_functions_are_reached_through_modules_that_reach_each_other(team):
    (team / "reach_a.py").write_text(
        "from mrsfi_runtime.api import kernel\nimport reach_b\n"
        "@kernel\ndef a(n):\n    return reach_b.b(n)\ndef plain():\n    return 0\n"
    )
    (team / "reach_b.py").write_text(
        "from mrsfi_runtime.api import kernel\nimport reach_a\n"
        "@kernel\ndef b(n):\n    return reach_a.a(n - 1) if n else reach_a.plain\n"
    )

    found = Reached([loaded("reach_a").a]).functions

    assert [function.__name__ for function in found] == ["a", "b"]


def test_an_array_that_changes_in_memory_is_another(team):
    write_team(team, "a tuple of long arrays", is_edited=False)
    verdict = loaded().verdict
    before = Reached([verdict]).text

    sys.modules["edit_other"].TABLE[2501] = np.nextafter(250.1, 0)

    assert Reached([verdict]).text != before


def test_a_field_may_have_the_name_of_an_object_of_the_module(team):
    (team / "reach_c.py").write_text(
        "from mrsfi_runtime.api import kernel\nspeed = object()\n"
        "@kernel\ndef c(robot):\n    return robot.speed\n"
    )

    assert Reached([loaded("reach_c").c]).functions
