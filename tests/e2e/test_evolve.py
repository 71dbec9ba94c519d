import shutil

from tests.support.cli import (
    MISSION,
    SMALL,
    contents,
    interrupted,
    mrsfi,
    mrsfi_json,
    workspace,
)
from tests.support.rendezvous import NAME
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

    assert "the search ended after 3 of 9 evaluations: it made no new spec" in done.stderr
    assert "campaign  s: 3 of 9 evaluations\n" in done.stdout
    assert "3 of 9 evaluations of 3 distinct spec" in (place / "s/report.md").read_text("utf-8")


@slow
def test_a_campaign_can_count_how_long_goals_were_missed(tmp_path):
    quick = workspace(tmp_path, "tight_margins")
    (quick / "mine.toml").write_text(
        '[search]\nviolations = "missed"\nfitness = "focused"\ngoals = ["within", "depths"]\n'
        "population = 6\ngenerations = 1\nfaults = 6\n",
        encoding="utf-8",
    )

    found = mrsfi_json("evolve", "tight_margins", "--case", "mine.toml", "--out", "out", cwd=quick)

    best = found["best"]
    assert found["measure"] == {"violations": "missed", "mission_seeds": 1}
    assert best["fitness"] == sum(best["missed"][goal] for goal in ("within", "depths")) > 0
    assert best["measured"] == best["missed"]
    for goal, ticks in best["missed"].items():
        assert best["missed_since"][goal] == (200 - ticks if ticks else None)
    assert best["evaluation"] in [point["evaluation"] for point in found["front"]["points"]]


def test_a_folder_in_use_ends_with_9_and_stays_as_it_is(flown):
    before = contents(flown)

    mrsfi("evolve", MISSION, *SMALL, "--out", flown, cwd=flown.parent.parent, expected=9)

    assert contents(flown) == before


@slow
def test_ctrl_c_while_figures_are_drawn_says_that_they_are_missing(flown, tmp_path):
    folder = shutil.copytree(flown, tmp_path / "run")

    done = interrupted("report", folder, cwd=tmp_path, sign="drawing figures")

    advice = f"figures are missing from the report; write it anew with: mrsfi report {folder}\n"
    assert done.returncode == 130, done.stderr
    assert advice in done.stderr
    assert "digest" in done.stdout
    assert "Traceback" not in done.stderr
    mrsfi("report", folder, cwd=tmp_path)
    assert contents(folder / "figures").keys() == contents(flown / "figures").keys()


ONE_GOAL = ("--minimise", "faults", "--violations", "true", "--goals", "depths", "--faults", "4")


@slow
def test_the_smallest_set_that_makes_a_goal_truly_fail_is_one_command(tmp_path):
    quick = workspace(tmp_path, "tight_margins")
    search = ("--algorithm", "guided", *ONE_GOAL, *SMALL, "--out", "out")

    printed = mrsfi("evolve", "tight_margins", *search, cwd=quick).stdout
    found = mrsfi_json("report", "out", cwd=quick)

    assert "trade-offs between depths, faults (true violations)" in printed
    assert "Most harm with how few faults (true violations, depths)" in printed
    assert found["harm"][0]["cost"] == found["front"]["points"][0]["faults"]
    assert (quick / "out" / "figures" / "figure_harm.png").is_file()
    assert "finished already" in mrsfi("evolve", "--resume", "out", *ONE_GOAL, cwd=quick).stderr
    other = ("--resume", "out", "--goals", "energy")
    error = mrsfi("evolve", *other, cwd=quick, expected=2).stderr
    assert "--goals: found ['energy']" in error


def test_a_fitness_too_large_for_a_float_is_told_of_its_function(small, monkeypatch):
    (small / "huge.py").write_text("def huge(findings):\n    return 10**400\n", encoding="utf-8")
    case = '[search]\npopulation = 4\ngenerations = 1\nfaults = 2\nfitness = "huge:huge"\n'
    (small / "case.toml").write_text(case, encoding="utf-8")
    monkeypatch.syspath_prepend(small)

    words = ("evolve", NAME, "--case", "case.toml", "--engine", "reference", "--no-explain")
    done = mrsfi(*words, cwd=small, expected=6)

    last = done.stderr.splitlines()[-1]
    assert last.startswith("mrsfi: the fitness of (TimedFault(")
    assert last.endswith(" is inf as a float; expected a finite number, -1e+100 to 1e+100")
