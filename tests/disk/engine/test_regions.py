"""Which regions a team wrote: whatever is not what the task of its goal says, as it is loaded."""

import pytest

from mrsfi_runtime.api import kernel
from mrsfi_runtime.engine.compiled.compiler import register
from mrsfi_runtime.engine.compiled.regions import CompilationError, measured_goals, own_regions
from mrsfi_runtime.generated_code import load_code
from tests.support.cli import edit
from tests.support.edited import COLLECTIVE, edited
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
