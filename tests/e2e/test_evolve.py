import shutil

from tests.support.cli import (
    MISSION,
    SMALL,
    contents,
    interrupted,
    mrsfi,
    mrsfi_json,
)
from tests.tiers import slow


def test_it_ends_with_the_ten_most_critical_the_front_and_the_folder(place):
    arguments = ("--case", "b", "--population", "12", "--generations", "0")

    done = mrsfi("evolve", MISSION, *arguments, "--ratio", "g3:g1=2:1", cwd=place)

    lines = done.stdout.splitlines()
    assert lines[0].startswith("The 10 most critical of ")
    assert sum("believed  " in line for line in lines) == 10
    assert any(line.startswith("Pareto front: ") for line in lines)
    assert any(line.startswith("nearest to g3:g1=2:1: ") for line in lines)
    assert lines[-3] == "campaign  runs/uuv_sampling-b-1: 12 evaluations"
    assert lines[-2].startswith("digest ")
    assert max(map(len, lines)) <= 100
    assert "generation 0/0" in done.stderr


def test_a_found_specification_validates_and_flies_again(flown):
    place = flown.parent.parent
    found = flown / "critical" / "01.xmi"

    mrsfi("validate", found, cwd=place)
    flight = mrsfi_json("simulate", MISSION, "--faults", found, cwd=place)
    replayed = mrsfi_json("replay", flown, "--best", cwd=place)

    assert flight["digest"] == replayed["digest"]


def test_a_search_that_makes_no_new_specification_says_how_many_evaluations_it_made(place):
    (place / "still.toml").write_text(
        "[search]\nevaluations = 9\npopulation = 3\nfaults = 2\ncrossover = 0\nmutation = 0\n",
        encoding="utf-8",
    )

    done = mrsfi("evolve", MISSION, "--case", "still.toml", "--no-explain", "--out", "s", cwd=place)

    assert "the search ended after 3 of 9 evaluations: it found no new spec" in done.stderr
    assert "campaign  s: 3 of 9 evaluations\n" in done.stdout
    assert "3 of 9 evaluations of 3 distinct spec" in (place / "s/report.md").read_text("utf-8")


def test_a_folder_in_use_ends_with_9_and_stays_as_it_is(flown):
    before = contents(flown)

    mrsfi("evolve", MISSION, *SMALL, "--out", flown, cwd=flown.parent.parent, expected=9)

    assert contents(flown) == before


@slow
def test_ctrl_c_while_figures_are_drawn_says_that_they_are_missing(flown, tmp_path):
    folder = shutil.copytree(flown, tmp_path / "run")

    done = interrupted("report", folder, cwd=tmp_path, sign="drawing figures")

    advice = f"the report is not complete; write it again with: mrsfi report {folder}\n"
    assert done.returncode == 130, done.stderr
    assert advice in done.stderr
    assert "digest" in done.stdout
    assert "Traceback" not in done.stderr
    mrsfi("report", folder, cwd=tmp_path)
    assert contents(folder / "figures").keys() == contents(flown / "figures").keys()
