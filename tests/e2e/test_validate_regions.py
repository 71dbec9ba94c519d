from pathlib import Path

from tests.support.cli import MISSION, edit, mrsfi, mrsfi_json

BODY = "return goal_tasks.avoid_collision.violated(ci, G1)"
OWN = "return ci.robots[R1].speed ** 2 > 9000.0"


def _edited(place: Path) -> tuple[Path, int]:
    code = place / "generated" / MISSION / "collective_intelligence.py"
    edit(code, BODY, OWN)
    return code, code.read_text(encoding="utf-8").splitlines().index(f"    {OWN}") + 1


def test_validate_warns_of_a_region_that_compiles_to_something_else(place: Path) -> None:
    _, line = _edited(place)

    lines = mrsfi("validate", MISSION, cwd=place).stdout.splitlines()

    assert lines[0] == (
        f"generated/{MISSION}/collective_intelligence.py:{line}: warning: region 'g1.check': found "
        "`ci.robots[R1].speed ** 2`, which may differ in the last bit when compiled; write x * x "
        "[RegionCompilesAlike]"
    )
    assert lines[-1].endswith("1 warning")


def test_warnings_of_regions_stand_beside_those_of_models_in_json(place: Path) -> None:
    _, line = _edited(place)

    found = mrsfi_json("validate", MISSION, cwd=place)

    assert (found["n_errors"], found["n_warnings"]) == (0, 1)
    (warning,) = found["diagnostics"]
    assert warning.pop("message").startswith("region 'g1.check': found ")
    assert warning == {
        "path": f"generated/{MISSION}/collective_intelligence.py",
        "line": line,
        "element": "region 'g1.check'",
        "constraint": "RegionCompilesAlike",
        "severity": "warning",
    }


def test_regions_are_read_although_the_model_is_broken(place: Path) -> None:
    _edited(place)
    edit(place / "models" / MISSION / "mission.xmi", 'name="LEN" speed="5.0"', 'speed="fast"')

    text = mrsfi("validate", MISSION, cwd=place, expected=3).stdout

    assert "[RegionCompilesAlike]" in text


def test_a_mission_that_was_not_generated_yet_has_no_regions_to_warn_of(place: Path) -> None:
    text = mrsfi("validate", MISSION, "--generated", "nowhere", cwd=place).stdout

    assert "[Region" not in text
