import json
from pathlib import Path

import pytest

from tests.support.cli import MISSION, edit, mrsfi, mrsfi_json, mrsfi_process

BODY = "return goal_tasks.avoid_collision.violated(ci, G1)"
OWN = "return ci.robots[R1].speed ** 2 > 9000.0"


def _edited(place: Path, body: str = OWN) -> tuple[Path, int]:
    code = place / "generated" / MISSION / "collective_intelligence.py"
    edit(code, BODY, body)
    return code, code.read_text(encoding="utf-8").splitlines().index(f"    {body}") + 1


def test_validate_warns_of_a_region_that_compiles_to_something_else(place):
    _, line = _edited(place)

    lines = mrsfi("validate", MISSION, cwd=place).stdout.splitlines()
    found = mrsfi_json("validate", MISSION, cwd=place)

    path = f"generated/{MISSION}/collective_intelligence.py"
    assert lines[-1].endswith("1 warning")
    assert (found["n_errors"], found["n_warnings"]) == (0, 1)
    (warning,) = found["diagnostics"]
    said = f"{path}:{line}: warning: {warning.pop('message')} [RegionCompilesAlike]"
    assert lines[0] == said
    assert warning == {
        "path": path,
        "line": line,
        "element": "region 'g1.check'",
        "constraint": "RegionCompilesAlike",
        "severity": "warning",
    }


def test_validate_warns_of_a_region_that_reads_what_cannot_be_listed(place, approved):
    (place / "team.py").write_text("def __getattr__(name):\n    return {'LIMIT': 9.0}[name]\n")
    code, _ = _edited(place, "return ci.robots[R1].speed > team.LIMIT")
    edit(
        code,
        "# protected region imports on begin\n",
        "# protected region imports on begin\nimport team\n",
    )

    warned, counted = mrsfi_process("validate", MISSION, cwd=place).stdout.splitlines()

    approved(warned)
    assert counted.endswith("1 warning")


def test_a_mission_that_was_not_generated_yet_has_no_regions_to_warn_of(place):
    text = mrsfi("validate", MISSION, "--generated", "nowhere", cwd=place).stdout

    assert "[Region" not in text


UNREACHED = "return ci.mission.tick < 0 and nowhere(ci)"
LATE = "return 1 // (ci.mission.tick - 7) == 0"
MISSPELT = "return ci.mission.tick < 0 and ci.robots[R1].heading > 0.0"


@pytest.mark.parametrize(
    ("body", "constraint"),
    [(UNREACHED, "RegionRuns"), (MISSPELT, "RegionRuns"), (LATE, "MissionFlies")],
)
def test_a_region_that_fails_is_an_error_of_every_command_before_anything_flies(
    place, body, constraint
):
    _, line = _edited(place, body)
    where = f"generated/{MISSION}/collective_intelligence.py:{line}: "

    lines = mrsfi("validate", MISSION, cwd=place, expected=6).stdout.splitlines()
    text = mrsfi("validate", MISSION, "--json", cwd=place, expected=6).stdout

    assert lines[0].startswith(f"{where}error: ")
    assert lines[-1] == f"{MISSION}: 1 error, 0 warnings"
    (found,) = json.loads(text)["diagnostics"]
    assert (found["line"], found["severity"], found["constraint"]) == (line, "error", constraint)
    for command in ("evolve", "compare", "simulate"):
        error = mrsfi(command, MISSION, cwd=place, expected=6).stderr
        assert error.startswith(f"mrsfi: {where}")
        assert len(error.splitlines()) == 1
    assert not (place / "runs").exists()


@pytest.mark.parametrize(("body", "found"), [(OWN, "CompilesAlike"), (UNREACHED, "Runs")])
def test_regions_are_read_although_an_error_of_the_models_decides(place, body, found):
    _edited(place, body)
    edit(place / "models" / MISSION / "mission.xmi", 'name="LEN" speed="5.0"', 'speed="fast"')

    text = mrsfi("validate", MISSION, cwd=place, expected=3).stdout

    assert f"[Region{found}]" in text


def test_a_file_that_cannot_be_imported_is_named_with_its_line(place, approved):
    code = place / "generated" / MISSION / "collective_intelligence.py"
    begin = "# protected region imports on begin\n"
    edit(code, begin, f"{begin}from nowhere import near\n")

    text = mrsfi("validate", MISSION, cwd=place, expected=6).stdout

    approved(text)
