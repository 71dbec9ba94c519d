import subprocess
from pathlib import Path

from tests.support.cli import MISSION, command_line, contents, edit, mrsfi

RIGHT = 'LOWER_BOUND="11.0" UPPER_BOUND="30.0"'
WRONG = 'LOWER_BOUND="30.0" UPPER_BOUND="11.0"'


def _answered(answer: str, *arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command_line(*arguments),
        check=False,
        cwd=cwd,
        input=answer,
        capture_output=True,
        encoding="utf-8",
        timeout=120,
    )


def test_fix_shows_the_diff_and_writes_what_was_right_before(place):
    faults = place / "models" / MISSION / "faults.xmi"
    before = faults.read_bytes()
    edit(faults, RIGHT, WRONG)

    text = mrsfi("validate", MISSION, "--fix", "--yes", cwd=place).stdout

    assert faults.read_bytes() == before
    assert f"-    <randomSensorEnergyPerSample {WRONG}>" in text.splitlines()
    assert f"+    <randomSensorEnergyPerSample {RIGHT}>" in text.splitlines()
    assert "fix: Exchange the lowest and the highest random value [RandomBoundsOrdered]" in text
    assert text.splitlines()[-1].startswith(f"ok: {MISSION}")


def test_fix_writes_when_the_user_agrees_and_only_then(place):
    faults = place / "models" / MISSION / "faults.xmi"
    sound = faults.read_bytes()
    edit(faults, RIGHT, WRONG)
    before = contents(place / "models")

    refused = _answered("n\n", "validate", MISSION, "--fix", cwd=place)
    silent = _answered("", "validate", MISSION, "--fix", cwd=place)
    kept = contents(place / "models")
    agreed = _answered("y\n", "validate", MISSION, "--fix", cwd=place)

    assert refused.returncode == 3
    assert "nothing written" in refused.stdout
    assert silent.returncode != 0
    assert kept == before
    assert agreed.returncode == 0
    assert faults.read_bytes() == sound


def test_fix_of_a_flawless_mission_says_so(place, approved):
    before = contents(place / "models")

    text = mrsfi("validate", MISSION, "--fix", cwd=place).stdout

    approved(text.splitlines()[0])
    assert contents(place / "models") == before


def test_fix_leaves_errors_of_structure_to_the_user(place, approved):
    edit(place / "models" / MISSION / "mission.xmi", 'name="LEN" speed="5.0"', 'speed="fast"')
    before = contents(place / "models")

    text = mrsfi("validate", MISSION, "--fix", "--yes", cwd=place, expected=3).stdout

    approved(text)
    assert contents(place / "models") == before


def test_fix_tells_when_a_file_loses_its_layout(place):
    faults = place / "models" / MISSION / "faults.xmi"
    edit(faults, RIGHT, WRONG)
    edit(faults, "<startRobot>", "<!-- why --><startRobot>")

    text = mrsfi("validate", MISSION, "--fix", "--yes", cwd=place).stdout

    assert "is not as Eclipse writes it; layout and comments will be lost" in text


def test_fix_options_that_make_no_sense_together_are_refused(place):
    assert "--json" in mrsfi("validate", MISSION, "--fix", "--json", cwd=place, expected=2).stderr
    assert "--fix" in mrsfi("validate", MISSION, "--yes", cwd=place, expected=2).stderr
