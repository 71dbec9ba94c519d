"""Which regions a team wrote, and what compiled code reaches."""

import importlib
import os
import sys

import numpy as np
import pytest
from numba.core.typing import templates

from mrsfi_runtime.api import kernel
from mrsfi_runtime.engine.compiled.compiler import register
from mrsfi_runtime.engine.compiled.regions import (
    CompilationError,
    Reached,
    measured_goals,
    own_regions,
)
from mrsfi_runtime.generated_code import load_code
from tests.support.cli import edit
from tests.support.edited import COLLECTIVE, edited
from tests.support.edits import EDITS, MODULES, REFUSED, write_team
from tests.support.tree import ROOT


@kernel
def near(ci):
    return 1


@kernel
def far(ci):
    return 2


chosen = near


@kernel
def measured(ci):
    return chosen(ci)


HELPERS = "# protected region helpers on begin\n"


WRAPPED = """@kernel
def wrapped(ci, g):
    return goal_tasks.avoid_collision.violated(ci, g)


"""


def named(code):
    return [(each.function.__name__, each.role, each.place) for each in own_regions(code)]


@pytest.mark.parametrize("mission", ["uuv_sampling", "tight_energy"])
def test_of_a_mission_as_it_was_generated_a_team_wrote_nothing(mission):
    assert named(load_code(ROOT / "generated" / mission)) == []


def test_a_region_of_a_team_is_found_with_its_place():
    code = load_code(ROOT / "generated" / "tight_margins")

    assert named(code) == [("react_energy", "react", 8)]


@pytest.mark.parametrize(
    "body",
    [
        "    return goal_tasks.avoid_collision.violated(ci, G2)\n",
        "    return goal_tasks.stay_within_mission_area.violated(ci, G1)\n",
        "    return not goal_tasks.avoid_collision.violated(ci, G1)\n",
        "    goal_tasks.avoid_collision.violated(ci, G1)\n    return False\n",
        "    return goal_tasks.avoid_collision.violated(ci, 0)\n",
    ],
)
def test_what_looks_like_a_default_and_is_none_is_found(tmp_path, body):
    code = load_code(edited(tmp_path, "g1.check", body))

    assert named(code) == [("check_g1", "check", 1)]


def test_a_name_that_means_something_else_makes_no_default(tmp_path):
    path = edited(tmp_path, "g1.check", "    return goal_tasks.avoid_collision.violated(ci, G1)\n")
    line = "from mrsfi_runtime.api import forecast as goal_tasks\n"
    edit(path / COLLECTIVE, HELPERS, HELPERS + line)

    assert ("check_g1", "check", 1) in named(load_code(path))


def test_a_default_that_was_exchanged_in_memory_is_none(monkeypatch):
    code = load_code(ROOT / "generated" / "uuv_sampling")
    names = code.functions.check.__globals__
    monkeypatch.setattr(
        names["goal_tasks"].gather_samples, "react", names["kernel"](lambda *_: None)
    )

    assert named(code) == [(f"react_g{n}", "react", 3 * n - 1) for n in (4, 5, 6)]


@pytest.mark.parametrize(
    ("region", "body", "unmeasured"),
    [
        ("g1.check", "    return goal_tasks.avoid_collision.violated(ci, G1)\n", []),
        ("g1.react", "    pass\n", []),
        ("g1.check", "    return False\n", [0]),
        (
            "g1.check",
            "    return ci.mission.tick > 9 and goal_tasks.avoid_collision.violated(ci, G1)\n",
            [0],
        ),
        ("g1.check", "    return goal_tasks.avoid_collision.violated(ci, G2)\n", [0]),
        ("g1.check", "    return wrapped(ci, G1)\n", [0]),
        ("g4.progress", "    pass\n", [3]),
        ("helpers", "G4 = G5\n", range(6)),
        ("helpers", "goal_tasks = goal_tasks.gather_samples\n", range(6)),
    ],
)
def test_a_goal_has_a_margin_if_its_check_and_progress_are_the_references(
    tmp_path, region, body, unmeasured
):
    path = edited(tmp_path, region, body)
    edit(path / COLLECTIVE, HELPERS, HELPERS + WRAPPED)

    measured = measured_goals(load_code(path))

    assert measured == tuple(g not in unmeasured for g in range(6))


def test_no_goal_has_a_margin_whose_function_cannot_be_told(tmp_path):
    path = edited(tmp_path, "g1.check", "    return False\n")
    edit(path / COLLECTIVE, "    violated[G1] = 1 if check_g1(view) else 0\n", "")

    assert measured_goals(load_code(path)) == (False,) * 6


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("    react_g1(ci)\n    react_g2(ci)\n", "    react_g2(ci)\n    react_g1(ci)\n"),
        ("    progress_g4(view)\n", ""),
        ("G1 = 0\n", "G1 = 3\n"),
        ("violated[G1] = 1 if", "violated[G1] = 0 if"),
        ("    react_g1(ci)\n", "    react_g1(ci)\n    react_g1(ci)\n"),
        ("    react_g6(ci)\n", ""),
        ("    react_g6(ci)\n", "    react_g7(ci)\n"),
        ("    violated[G6] = 1 if check_g6(view) else 0\n", ""),
    ],
)
def test_functions_that_do_not_call_the_goals_in_their_order_are_refused(
    tmp_path, text, other, refused
):
    path = edited(tmp_path, "g1.check", "    return False\n")
    edit(path / COLLECTIVE, text, other)

    with refused(CompilationError):
        own_regions(load_code(path))


def test_what_a_function_reads_must_not_change_once_it_was_compiled(monkeypatch, refused):
    register([near, far, measured])
    register([measured])
    monkeypatch.setitem(globals(), "chosen", far)

    with refused(CompilationError):
        register([measured])


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
