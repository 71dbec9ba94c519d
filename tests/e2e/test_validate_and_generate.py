import re

from m2t.models.load import _Loading
from tests.support.cli import MISSION, contents, edit, mrsfi, mrsfi_json, stop_specification
from tests.support.rendezvous import NAME


def test_validate_loads_once_and_says_how_much_there_is(place, tmp_path, monkeypatch):
    inspect, loaded = _Loading.inspect, []

    def counted(self, *paths):
        loaded.append(paths)
        return inspect(self, *paths)

    monkeypatch.setattr(_Loading, "inspect", counted)
    text = mrsfi("validate", place / "models" / MISSION, cwd=tmp_path).stdout
    assert len(loaded) == 1
    found = mrsfi_json("validate", MISSION, cwd=place)

    assert text.splitlines()[-1].startswith(
        f"ok: {MISSION}: 3 robots, 8 obstacles, 6 goals, 12 messages, 30 faults, "
    )
    assert found["mission"] == MISSION
    assert found["n_errors"] == 0
    assert len(found["diagnostics"]) == found["n_warnings"]


def test_a_broken_model_ends_with_3_and_its_line_and_nothing_is_written(place):
    mission = place / "models" / MISSION / "mission.xmi"
    edit(mission, 'name="LEN" speed="5.0"', 'name="LEN" speed="fast"')
    line = next(
        number
        for number, text in enumerate(mission.read_text(encoding="utf-8").splitlines(), 1)
        if 'speed="fast"' in text
    )

    before = contents(place)

    text = mrsfi("validate", MISSION, cwd=place, expected=3).stdout
    mrsfi("generate", MISSION, cwd=place, expected=3)

    assert f"mission.xmi:{line}: error: " in text
    assert "1 error" in text.splitlines()[-1]
    assert contents(place) == before


def test_a_figure_in_another_unit_is_a_warning_and_with_strict_an_error(place):
    mrsfi("validate", MISSION, "--strict", cwd=place)
    mission = place / "models" / MISSION / "mission.xmi"
    edit(mission, 'name="LEN" speed="5.0"', 'name="LEN" speed="40000.0"')

    warned = mrsfi("validate", MISSION, cwd=place).stdout
    refused = mrsfi("validate", MISSION, "--strict", cwd=place, expected=3).stdout

    assert "warning: robots 'r1' " in warned
    assert "error: robots 'r1' " in refused
    assert refused.splitlines()[-1] == f"{MISSION}: 1 error, 0 warnings"


def test_validate_checks_a_written_specification(place):
    models = place / "models" / MISSION
    sound = stop_specification(models / "sound.xmi", [(100, 200)])
    broken = stop_specification(models / "broken.xmi", [(100, 200)])
    edit(broken, "#r1", "#r77")

    assert mrsfi("validate", sound, cwd=place).stdout.startswith("ok: ")
    assert "r77" in mrsfi("validate", broken, cwd=place, expected=3).stdout


def test_generate_check_and_diff_show_what_a_changed_model_means_and_write_nothing(place):
    assert "fresh" in mrsfi("generate", MISSION, "--check", cwd=place).stdout
    edit(place / "models" / MISSION / "mission.xmi", 'name="LEN"', 'name="LENA"')
    before = contents(place)

    error = mrsfi("generate", MISSION, "--check", cwd=place, expected=4).stderr
    shown = mrsfi("generate", MISSION, "--diff", cwd=place).stdout

    assert "mission_loader.py" in error
    assert "mrsfi generate" in error
    changed = [line for line in shown.splitlines() if re.match(r"[+-](?![+-]{2} )", line)]
    assert changed
    assert all(("LENA" if line[0] == "+" else "LEN") in line for line in changed)
    assert len([line for line in changed if line[0] == "-"]) == len(changed) / 2
    assert contents(place) == before


def test_a_goal_that_is_violated_without_faults_is_worth_a_warning(place):
    mission = place / "models" / MISSION / "mission.xmi"
    edit(mission, 'targetSampleNumber="500"', 'targetSampleNumber="5000"')
    mrsfi("generate", MISSION, cwd=place)

    found = mrsfi_json("validate", MISSION, cwd=place)

    assert found["n_errors"] == 0
    assert [
        d["element"] for d in found["diagnostics"] if d["constraint"] == "FaultFreeMission"
    ] == ["goals 'g6'"]


def test_a_goal_that_starves_is_told_with_who_holds_its_robots(small):
    mission = small / "models" / NAME / "mission.xmi"
    holder = (
        '<goals ID="g0" name="Wait" members="a"><task xsi:type="mission:Stay">'
        '<area ID="start" radius="50.0"><center x="-200.0"/></area></task></goals>'
    )
    edit(mission, '<goals ID="g1"', holder + '<goals ID="g1"')
    mrsfi("generate", NAME, cwd=small)

    (small / "any.toml").write_text("[search]\n", encoding="utf-8")
    said = mrsfi("validate", NAME, cwd=small).stdout
    options = ("--case", "any.toml", "--evaluations", "40", "--engine", "reference")
    found = mrsfi("evolve", NAME, *options, "--workers", "1", cwd=small).stdout

    held = "as Wait (g0), which reacts first, keeps a in area start"
    told = "without faults, in belief at 50 ticks, in truth at 50, and fails"
    assert f"goals 'g1' is violated {told}, {held}; expected none" in said
    assert said.count(held) == 2
    assert f"g1 is violated without any fault {held}" in " ".join(found.split())
