"""What was found is kept beside the models, and a build server is told when it comes back."""

import json
import os
import re
import shutil
from xml.etree import ElementTree as ET

import pytest

from tests.support.cli import edit, mrsfi, mrsfi_json
from tests.support.edited import COLLECTIVE, indented, write_body
from tests.support.rendezvous import NAME
from tests.support.tree import ROOT

REFERENCE = ("--engine", "reference")
WORSE = "return ci.mission.tick > 20"
WORSE_IN_SEEDS_2_AND_3 = "return ci.mission.tick > 20 and ci.robots[1].y > 1.0"


@pytest.fixture
def place(found, tmp_path):
    """Copy of it, in which nothing is kept."""
    return shutil.copytree(found, tmp_path, dirs_exist_ok=True)


@pytest.fixture
def kept(place):
    """That folder, in which weakness 2 is kept: robot a is stopped, and comes too late."""
    mrsfi("keep", "runs/it", "--weakness", "2", cwd=place)
    return place


def regressions(place):
    return place / "models" / NAME / "regressions"


def limits(place, name="it-weakness-2"):
    return regressions(place) / f"{name}.toml"


def worsen(place, body=WORSE):
    """Let the check of goal g1 find it violated earlier; return what mends it."""
    path = place / "generated" / NAME / COLLECTIVE
    before = path.read_bytes()
    write_body(path, "g1.check", indented(body))
    return lambda: path.write_bytes(before)


def test_nothing_kept_is_no_pass(place, approved):
    for words in (("check",), ("check", NAME)):
        done = mrsfi(*words, cwd=place, expected=2)
        approved(done.stderr)


def test_what_this_project_keeps_holds():
    done = mrsfi("check", cwd=ROOT)

    assert "uuv_sampling: 1 of 1 kept weaknesses is within its limit" in done.stdout


def test_what_is_kept_is_the_witness_with_what_was_recorded_of_its_goal(kept, found):
    summary = json.loads((found / "runs" / "it" / "summary.json").read_text(encoding="utf-8"))
    *_, gravest = (each for each in summary["weaknesses"]["found"] if each["number"] == 2)

    (checked,) = mrsfi_json("check", NAME, *REFERENCE, cwd=kept)[NAME]
    flown = mrsfi_json(
        "simulate", NAME, "--faults", regressions(kept) / "it-weakness-2.xmi", cwd=kept
    )

    assert checked["state"] == "holds"
    assert checked["max"] == checked["now"] == {"g1": flown["goals"][0]["missed"]}
    assert checked["max"]["g1"] > 0
    assert (gravest["measure"], gravest["faults"]) == ("missed", ["stop_a"])
    assert checked["found"].startswith("runs/it, weakness 2 (stop_a): g1 fails if a is stopped for")
    assert [(f["id"], f["start"], f["finish"]) for f in flown["faults"]] == [
        ("stop_a.1", each["start"], each["finish"]) for each in gravest["witness"]
    ]


@pytest.mark.parametrize("engine", ["auto", "reference", "rosbridge"])
def test_a_changed_region_that_brings_it_back_fails_and_mended_it_passes(kept, engine):
    words = ("check", "--engine", engine, "--junit", "found.xml")
    most = mrsfi_json("check", *REFERENCE, cwd=kept)[NAME][0]["max"]["g1"]

    mend = worsen(kept)
    failed = mrsfi(*words, cwd=kept, expected=10)
    junit = ET.parse(kept / "found.xml").getroot()
    mend()
    passed = mrsfi(*words, cwd=kept)

    assert f"it-weakness-2: g1 (missed) exceeds its limit (99, allowed {most})" in failed.stderr
    assert "it-weakness-2 exceeds its limit. From runs/it, weakness 2 (stop_a): g" in failed.stdout
    (suite,) = junit.iter("testsuite")
    assert suite.attrib | {"time": ""} == {
        "name": NAME,
        "tests": "1",
        "failures": "1",
        "errors": "0",
        "time": "",
    }
    (failure,) = junit.iter("failure")
    assert (
        failure.attrib["message"]
        == f"it-weakness-2: g1 (missed) exceeds its limit (99, allowed {most})"
    )
    assert f"{NAME}: 1 of 1 kept weaknesses is within its limit" in passed.stdout
    assert not [*ET.parse(kept / "found.xml").getroot().iter("failure")]


def test_a_limit_of_ones_own_says_which_faults_exceed_it(place):
    mrsfi("keep", "runs/it", "--weakness", "3", "--max", "g2=0", "--name", "late", cwd=place)

    done = mrsfi("check", *REFERENCE, cwd=place, expected=10)

    assert "[max]\ng2 = 0\n" in limits(place, "late").read_text(encoding="utf-8")
    assert "late exceeds its limit" in done.stdout
    assert "  stop_b.1 (StopRobot)" in done.stdout
    assert "  stop_a.1 (StopRobot)" not in done.stdout  # has nothing to do with g2


def test_new_limits_of_one_or_all_are_taken_over_with_a_difference(kept):
    mrsfi("keep", "runs/it", "--weakness", "3", "--max", "g2=0", "--name", "late", cwd=kept)
    before = limits(kept).read_bytes()
    worsen(kept)
    update = ("keep", NAME, "--update", *REFERENCE)

    one = mrsfi(*update, "--name", "late", cwd=kept)
    unknown = mrsfi(*update, "--name", "no", cwd=kept, expected=2)
    others = limits(kept).read_bytes()
    new = mrsfi(*update, cwd=kept)
    again = mrsfi(*update, cwd=kept)

    (most,) = re.findall("g1 = ([0-9]+)", before.decode())
    assert one.stdout.startswith("late\n  g2: 0 → ")
    assert others == before
    assert "found --name no; expected one that is kept: it-weakness-2, late" in unknown.stderr
    assert new.stdout == f"it-weakness-2\n  g1: {most} → 99\n"
    assert again.stdout == "no difference\n"
    mrsfi("check", *REFERENCE, cwd=kept)


def test_what_came_back_is_told_though_it_cannot_be_explained(kept):
    edit(limits(kept), "g1 = ", "g1 = 0 # ")
    body = (
        "if ci.mission.tick == 60 and ci.robots[0].x > -9.0:\n"
        "    raise ValueError('as without faults')\n"
        "return ci.mission.tick > 20"
    )
    write_body(kept / "generated" / NAME / COLLECTIVE, "g1.check", indented(body))

    done = mrsfi("check", *REFERENCE, cwd=kept, expected=10)

    assert "it-weakness-2   missed       g1           0    99   exceeds its limit" in done.stdout
    assert "  The cause is not known: " in done.stdout
    assert "as without faults" in done.stdout


def test_only_in_seeds_for_which_limits_are_kept_does_it_come_back(kept, approved):
    mrsfi("keep", "runs/it", "--weakness", "1", "--name", "wide", "--seeds", "3", cwd=kept)
    worsen(kept, WORSE_IN_SEEDS_2_AND_3)

    failed = mrsfi("check", *REFERENCE, cwd=kept, expected=10)
    limits(kept, "wide").unlink()
    regressions(kept).joinpath("wide.xmi").unlink()
    holds = mrsfi("check", "--seeds", "1", *REFERENCE, cwd=kept)
    unknown = mrsfi("check", "--seeds", "3", *REFERENCE, "--junit", "j.xml", cwd=kept, expected=2)
    new = mrsfi("keep", NAME, "--update", "--seeds", "3", *REFERENCE, cwd=kept)
    (checked,) = mrsfi_json("check", *REFERENCE, cwd=kept)[NAME]

    approved(failed.stdout)
    approved(failed.stderr)
    approved(holds.stdout)
    approved(unknown.stdout)
    approved(unknown.stderr)
    assert [*ET.parse(kept / "j.xml").getroot().iter("error")]
    assert "  mission seeds: 1 → 3\n  g1: " in new.stdout
    assert checked["mission_seeds"] == checked["kept_seeds"] == [1, 2, 3]
    assert checked["max"] == checked["now"]


def to_window(path, start, finish):
    text = path.read_text(encoding="ascii")
    text, n = re.subn(r'start="\d+" finish="\d+"', f'start="{start}" finish="{finish}"', text)
    assert n == 1
    path.write_text(text, encoding="ascii")


def as_pipe(path):
    path.unlink()
    os.mkfifo(path)


def edited(kind, found, replaced):
    return lambda kept: edit(kept[kind], found, replaced)


@pytest.mark.parametrize(
    ("damage", "code"),
    [
        (edited(".xmi", "mission.xmi#a", "mission.xmi#gone"), 3),
        (lambda kept: to_window(kept[".xmi"], 100, 120), 5),
        (lambda kept: to_window(kept[".xmi"], 900, 999), 5),
        (lambda kept: as_pipe(kept[".xmi"]), 5),
        (lambda kept: as_pipe(kept[".toml"]), 5),
        (lambda kept: kept[".xmi"].unlink(), 2),
        (lambda kept: kept[".toml"].unlink(), 2),
        (edited(".toml", "[max]", "[most]"), 2),
        (edited(".toml", "g1 = ", "g7 = 0 # "), 2),
        (edited(".toml", "[max]", "[max"), 2),
        (edited(".toml", "g1 = ", "g1 = " + "9" * 5_000), 2),
    ],
)
def test_what_cannot_be_judged_is_no_pass_and_the_others_are_flown(kept, damage, code, approved):
    mrsfi("keep", "runs/it", "--weakness", "1", cwd=kept)
    damage({kind: regressions(kept) / f"it-weakness-2{kind}" for kind in (".xmi", ".toml")})

    done = mrsfi("check", *REFERENCE, "--junit", "found.xml", cwd=kept, expected=code)

    approved(done.stderr)
    assert f"{NAME}: 1 of 2 kept weaknesses is within its limit" in done.stdout
    (error,) = ET.parse(kept / "found.xml").getroot().iter("error")
    assert error.attrib["message"].removeprefix("it-weakness-2: ") in done.stderr


@pytest.mark.parametrize("n_workers", ["1", "2"])
def test_an_error_in_a_region_under_one_weakness_hides_no_other(kept, n_workers):
    mrsfi("keep", "runs/it", "--weakness", "3", cwd=kept)
    worsen(
        kept,
        "if ci.mission.tick == 60 and ci.robots[0].x < -9.0:\n"
        "    raise ValueError('too late')\n"
        "return False",
    )

    words = ("check", *REFERENCE, "--workers", n_workers, "--github")
    done = mrsfi(*words, cwd=kept, expected=6)

    assert f"{NAME}: 1 of 2 kept weaknesses is within its limit" in done.stdout
    assert "it-weakness-2 cannot be judged: " in done.stdout
    assert "ValueError: too late" in done.stderr
    assert f"::error file=generated/{NAME}/{COLLECTIVE},line=" in done.stdout


@pytest.mark.parametrize("most", ["120", "9" * 30])
def test_a_limit_that_nothing_exceeds_is_a_warning_when_it_is_kept_and_when_it_is_flown(
    most, place
):
    words = ("--weakness", "2", "--name", "idle", "--max", f"g1={most}")

    kept = mrsfi("keep", "runs/it", *words, cwd=place)
    checked = mrsfi("check", *REFERENCE, cwd=place)

    warning = (
        f"models/{NAME}/regressions/idle.toml: max: a mission of 120 ticks cannot exceed the limit "
        f"g1 = {most}; expected fewer ticks"
    )
    assert warning in kept.stderr.splitlines()
    assert warning in checked.stderr.splitlines()
    assert f"{NAME}: 1 of 1 kept weaknesses is within its limit" in checked.stdout


def test_a_limit_that_can_be_exceeded_goes_without_a_warning(kept):
    edit(limits(kept), "g1 = ", "g1 = 119 # ")

    assert "exceeded" not in mrsfi("check", *REFERENCE, cwd=kept).stderr


def test_weaknesses_are_looked_for_at_any_depth_and_without_a_mission(kept):
    mission = kept / "models" / NAME
    shutil.copytree(mission, kept / "models" / "a" / "b")
    mrsfi("generate", "models/a/b", cwd=kept)
    shutil.copytree(mission, kept / "models" / "stale")
    mrsfi("generate", "stale", cwd=kept)
    (kept / "generated" / "stale" / "topics.py").unlink()
    (mission / "mission.xmi").unlink()

    done = mrsfi("check", *REFERENCE, cwd=kept, expected=3)

    assert "a/b: 1 of 1 kept weaknesses is within its limit" in done.stdout
    assert f"{NAME}: 0 of 1 kept weaknesses are within their limits\n" in done.stdout
    assert f"models/{NAME}/mission.xmi:1: mission.xmi cannot be read: No such file" in done.stderr
    assert "it-weakness-2 cannot be judged: generated/stale: stale" in done.stdout

    worsen_nested = kept / "models" / "a" / "generated" / "b" / COLLECTIVE
    write_body(worsen_nested, "g1.check", indented(WORSE))

    assert "; 2 cannot be judged" in mrsfi("check", *REFERENCE, cwd=kept, expected=10).stderr


def test_names_and_texts_of_any_characters_leave_a_file_that_build_servers_can_read(kept):
    for kind in (".xmi", ".toml"):
        (regressions(kept) / f"it-weakness-2{kind}").rename(
            regressions(kept) / f"a\x01\udcff{kind}"
        )
    edit(limits(kept, "a\x01\udcff"), 'found = "', 'found = "\\u0002')
    worsen(kept)

    mrsfi("check", *REFERENCE, "--junit", "found.xml", "--json", cwd=kept, expected=10)

    (case,) = ET.parse(kept / "found.xml").getroot().iter("testcase")
    assert case.attrib["name"] == r"a\x01\udcff"
    assert r"Found in \x02runs/it" in case.findtext("failure")


def test_a_fault_that_left_the_pool_is_named_and_flown(kept):
    pool = kept / "models" / NAME / "faults.xmi"
    edit(pool, 'ID="stop_a"', 'ID="halt_a"')
    mrsfi("generate", NAME, cwd=kept)

    done = mrsfi("check", *REFERENCE, cwd=kept)

    assert "not in the pool: stop_a.1 (flown as kept)" in done.stdout


@pytest.mark.parametrize(
    "words",
    [
        ("--weakness", "7"),
        ("--weakness", "2"),
        ("--weakness", "1", "--max", "g9=0"),
        ("--weakness", "1", "--max", "g1"),
        ("--weakness", "1", "--max", f"g1={'9' * 5_000}"),
        (),
        ("--weakness", "1", "--name", "../out"),
        ("--weakness", "1", "--name", ""),
        ("--weakness", "1", "--update"),
    ],
)
def test_what_cannot_be_kept_is_refused_and_nothing_is_written(kept, words, approved):
    before = sorted(regressions(kept).iterdir())

    done = mrsfi("keep", "runs/it", *words, cwd=kept, expected=2)

    approved(done.stderr)
    assert sorted(regressions(kept).iterdir()) == before


def test_what_came_back_is_told_to_github_at_the_line_of_its_goal(kept):
    mission = kept / "models" / NAME / "mission.xmi"
    line = 1 + next(
        k for k, text in enumerate(mission.read_text().split("\n")) if 'ID="g1"' in text
    )
    worsen(kept)

    done = mrsfi("check", *REFERENCE, "--github", cwd=kept, expected=10)

    (told,) = [text for text in done.stdout.split("\n") if text.startswith("::")]
    place, _, message = told.removeprefix("::error file=").partition("::")
    assert place == f"models/{NAME}/mission.xmi,line={line}"
    assert message.startswith("it-weakness-2: g1 (missed) exceeds its limit ")


def test_a_region_that_fails_is_told_to_github_at_its_line(kept):
    path = kept / "generated" / NAME / COLLECTIVE
    write_body(path, "g1.check", indented("return 1 // 0 > ci.mission.tick"))
    (line,) = [k for k, text in enumerate(path.read_text().split("\n"), 1) if "1 // 0" in text]

    done = mrsfi("check", *REFERENCE, "--github", cwd=kept, expected=6)

    (told,) = [text for text in done.stdout.split("\n") if text.startswith("::")]
    assert told.startswith(f"::error file=generated/{NAME}/{COLLECTIVE},line={line}::")


def test_why_limits_are_accepted_is_kept_and_printed(kept, approved):
    because = ("--because", 'the "mast" is lowered')
    new = mrsfi("keep", NAME, "--update", *REFERENCE, *because, cwd=kept)
    done = mrsfi("check", *REFERENCE, cwd=kept)

    approved(new.stdout)
    approved(done.stdout)
    (found,) = mrsfi_json("check", *REFERENCE, cwd=kept)[NAME]
    assert found["accepted"] == 'the "mast" is lowered'
    edit(limits(kept), "accepted = ", "accepted = 1 # ")
    approved(mrsfi("check", cwd=kept, expected=2).stdout)
