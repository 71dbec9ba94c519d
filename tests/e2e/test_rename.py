"""``mrsfi rename``: other IDs everywhere at once, or nothing."""

import shutil

import pytest

from tests.support.cli import MISSION, contents, edit, mrsfi, mrsfi_json, workspace
from tests.support.edited import write_body
from tests.support.tree import ROOT

MODELS = f"models/{MISSION}"
COLLECTIVE = f"generated/{MISSION}/collective_intelligence.py"
HELPER = """def far(ci: State, robot: int) -> bool:
    # r1 and R1 stand in a comment
    return bool(ci.robots[robot].x > 1.0e6)
"""
BODY = """    r1 = R1
    if far(ci, r1) or far(ci, robot=R2):
        return check_g2(ci)
    return goal_tasks.avoid_collision.violated(ci, G1)
"""
RENAMED = """    r1 = LEADER
    if far(ci, r1) or far(ci, robot=R2):
        return check_inside(ci)
    return goal_tasks.avoid_collision.violated(ci, G1)
"""


@pytest.fixture
def place(tmp_path):
    workspace(tmp_path)
    write_body(tmp_path / COLLECTIVE, "helpers", HELPER)
    write_body(tmp_path / COLLECTIVE, "g1.check", BODY)
    return tmp_path


def _text(path):
    return path.read_text(encoding="utf-8")


def _refused(place, *names, expected=2):
    before = contents(place)

    done = mrsfi("rename", MISSION, *names, cwd=place, expected=expected)

    assert contents(place) == before
    return done.stderr


def test_regions_follow_with_their_markers_and_names_but_not_with_text(place):
    digest = mrsfi_json("simulate", MISSION, cwd=place)["digest"]

    mrsfi("rename", MISSION, "r1=leader", "g2=inside", cwd=place)

    code = _text(place / COLLECTIVE)
    assert RENAMED in code
    assert HELPER in code
    assert "# protected region inside.react on begin\n" in code
    assert "g2" not in code
    mrsfi("generate", MISSION, "--check", cwd=place)
    assert mrsfi_json("simulate", MISSION, cwd=place)["digest"] == digest


def test_specifications_campaign_files_and_limits_follow(place):
    case = place / MODELS / "case_b.toml"
    about = _text(case).partition("goals")[0]
    limits = place / MODELS / "regressions" / "case_a_1.toml"

    done = mrsfi("rename", MISSION, "g3=power", "f12=slow", "m8=report", "g2=in.side", cwd=place)

    assert _text(case).startswith(about)
    assert '"power"' in _text(case)
    kept = _text(limits.with_suffix(".xmi"))
    assert '<faults ID="slow.1" name="f12"' in kept
    assert '"../mission.xmi#report"' in kept
    assert "\npower = 771\n" in _text(limits)
    assert '\n"in.side" = 698\n' in _text(limits)
    mrsfi("check", MISSION, cwd=place)
    assert f"written    {MODELS}/regressions/case_a_1.xmi\n" in done.stdout
    assert f"{MODELS}/build.py:" in done.stderr


def test_two_ids_change_places(place):
    mrsfi("rename", MISSION, "g1=g2", "g2=g1", cwd=place)

    told = mrsfi("diff", str(ROOT / MODELS), MODELS, cwd=place).stdout
    assert "goal g1: " in told
    mrsfi("validate", MISSION, cwd=place)
    mrsfi("check", MISSION, cwd=place)
    assert "    return goal_tasks.avoid_collision.violated(ci, G2)\n" in _text(place / COLLECTIVE)


def test_models_without_code_are_renamed_alone(place):
    shutil.rmtree(place / "generated")

    mrsfi("rename", MISSION, "r1=leader", cwd=place)

    assert '<robots ID="leader" name="LEN"' in _text(place / MODELS / "mission.xmi")
    assert not (place / "generated").exists()


def test_what_is_not_as_eclipse_writes_it_is_told(place):
    mission = place / MODELS / "mission.xmi"
    edit(mission, "<missionArea", "<!-- ours -->\n  <missionArea")
    mrsfi("generate", MISSION, cwd=place)

    shown = mrsfi("rename", MISSION, "r1=leader", "--diff", cwd=place).stdout

    assert f"{MODELS}/mission.xmi: is not as Eclipse writes it; layout and comments" in shown


@pytest.mark.parametrize(
    "name", ["r11=x", "r1=r2", "r1=R2", "r1=1st", "r1=class", "f1=f2", "r1", "r1="]
)
def test_ids_that_cannot_be_are_refused(name, place, approved):
    approved(_refused(place, name))


def test_a_requirement_keeps_its_id_apart_from_others_but_not_its_name_in_python(tmp_path):
    shutil.copytree(ROOT / "models" / "undersea", tmp_path / "models" / "undersea")

    taken = mrsfi("rename", "undersea", "r2=R2", "--diff", cwd=tmp_path, expected=2).stderr
    free = mrsfi("rename", "undersea", "R2=SURVEY", "--diff", cwd=tmp_path).stdout

    assert "R2 and r2 would both be named R2" in taken
    assert '+  <requirements ID="SURVEY"' in free
    assert ' requirements="SURVEY" ' in free


def test_a_name_that_a_region_uses_is_refused_with_its_line(place, approved):
    line = write_body(place / COLLECTIVE, "g1.check", BODY.replace("r1", "LEADER"))

    told = _refused(place, "r1=leader")

    assert f"{COLLECTIVE}:{line}: " in told
    approved(told)


def test_stale_code_and_regions_that_are_not_python_are_refused(place, approved):
    write_body(place / COLLECTIVE, "g1.check", "    return (\n")
    approved(_refused(place, "r1=leader", expected=4))

    edit(place / MODELS / "mission.xmi", 'name="LEN"', 'name="LENA"')
    _refused(place, "r1=leader", expected=4)


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("case_b.toml", "goals = [", "goals = [["),
        ("case_b.toml", "[search]\n", ""),
        ("regressions/case_a_1.toml", "g3 = ", "  g3 = "),
    ],
)
def test_a_file_that_cannot_be_edited_is_named_and_nothing_is_written(
    name, old, new, place, approved
):
    edit(place / MODELS / name, old, new)
    if not new:
        edit(place / MODELS / name, "goals = ", "search.goals = ")

    approved(_refused(place, "g3=power", "g1=first"))
