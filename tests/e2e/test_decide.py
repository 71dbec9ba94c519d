"""What a team decided on weaknesses is kept beside the models, printed, and checked."""

import json
import os
import re
import shutil
import subprocess
import sys
from datetime import date
from functools import partial
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.support.cli import edit, mrsfi, mrsfi_json
from tests.support.rendezvous import NAME
from tests.support.tree import ROOT
from tests.tiers import slow

ACCEPT = ("accept", "--because", "a tether holds it", "--by", "A. Rivera")
REFERENCE = ("--engine", "reference")
FOLDER = f"models/{NAME}/decisions"


@pytest.fixture
def place(found, tmp_path):
    """Folder of a small mission and its campaign runs/it, without decisions."""
    return shutil.copytree(found, tmp_path, dirs_exist_ok=True)


def decide(place, number, *words, expected=0):
    return mrsfi("decide", "runs/it", str(number), *words, cwd=place, expected=expected)


def undated(text):
    return text.replace(str(date.today()), "TODAY")


def test_a_decision_is_a_file_that_names_goal_measure_and_faults(place, approved):
    done = decide(place, 2, *ACCEPT, "--until", "2999-03-01")

    approved(undated(done.stderr))
    path = place / FOLDER / "g1-missed-stop_a.toml"
    approved(undated(path.read_text(encoding="utf-8")))


def test_deciding_again_replaces_the_file(place, approved):
    decide(place, 2, *ACCEPT)

    done = decide(place, 2, "duplicate", "--of", "1", "--because", "same", "--by", "Li")

    approved(undated(done.stderr))
    (path,) = (place / FOLDER).iterdir()
    approved(undated(path.read_text(encoding="utf-8")))


HOSTILE = '=1+1 </script><b>|\n\\input{x} \x07\x1b[31m "ä"'
SHOWN = '=1+1 </script><b>| \\input{x} \\x07\\x1b[31m "ä"'


def test_hostile_text_is_one_line_of_text_wherever_a_decision_is_printed(place):
    decide(place, 2, "mitigate", "--because", HOSTILE, "--by", HOSTILE)

    mrsfi("report", "runs/it", cwd=place)
    page = (place / "runs/it/report.html").read_text()
    texts = (
        " ".join(mrsfi("weaknesses", "runs/it", cwd=place).stdout.split()),
        mrsfi("check", "--github", "--junit", "found.xml", *REFERENCE, cwd=place).stdout,
        ET.parse(place / "found.xml").findtext(".//system-out"),
        (place / "runs/it/report.md").read_text().replace("&lt;", "<").replace(r"\|", "|"),
        json.loads(re.search('id="data">(.*?)</script>', page)[1])["first"]["ways"][1]["status"],
    )

    words = f"to be mitigated, decided by {SHOWN} on {date.today()}: {SHOWN}"
    assert [words in text for text in texts] == [True] * 5
    rows = mrsfi_json("weaknesses", "runs/it", cwd=place)
    assert {each["decision"] for each in rows} == {"", words}


def test_without_its_mission_a_campaign_has_no_decisions_and_takes_none(place):
    decide(place, 2, *ACCEPT)
    shutil.rmtree(place / "models")

    told = mrsfi("weaknesses", "runs/it", cwd=place).stdout
    refused = decide(place, 2, *ACCEPT, expected=2)

    assert "accepted by" not in told
    assert f"found no mission '{NAME}'" in refused.stderr


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("--of", "2"),
        ("--of", "7"),
        ("--because", " "),
        ("--by", "\udcff"),
        ("--until", "2020-01-01"),
        ("--until", "soon"),
    ],
)
def test_what_is_no_decision_is_refused_and_nothing_is_written(place, words, approved):
    kind = "accept" if {"--until", "--because", "--by"} & {*words} else "duplicate"

    done = decide(place, 2, kind, "--because", "x", "--by", "Li", *words, expected=2)

    approved(undated(done.stderr))
    assert not (place / FOLDER).exists()


DAMAGES = {
    "key": ("kind", "kinds"),
    "kind": ("accept", "ignore"),
    "measure": ("missed", "masked"),
    "faults": ('["stop_a"]', "[]"),
    "day": ("date = ", "date = 1 # "),
    "toml": ("kind = ", "kind "),
    "fault gone": ("stop_a", "stop_z"),
    "goal gone": ('"g1"', '"g9"'),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_decision_that_does_not_fit_is_an_error_of_check(place, damage, approved):
    decide(place, 2, *ACCEPT)
    edit(place / FOLDER / "g1-missed-stop_a.toml", *DAMAGES[damage])

    done = mrsfi("check", *REFERENCE, "--github", cwd=place, expected=2)
    approved(undated(done.stdout))


def test_a_graver_weakness_needs_a_new_decision(place):
    decide(place, 2, *ACCEPT)
    edit(place / FOLDER / "g1-missed-stop_a.toml", '"missed"', '"true"')

    assert "accepted by" not in mrsfi("weaknesses", "runs/it", cwd=place).stdout


def test_rename_rewrites_decisions_and_their_names(place, approved):
    decide(place, 2, *ACCEPT)
    decide(place, 1, "duplicate", "--of", "2", "--because", "same", "--by", "Li")

    difference = mrsfi("rename", NAME, "g1=late", "stop_a=halt", "--diff", cwd=place)
    mrsfi("rename", NAME, "g1=late", "stop_a=halt", cwd=place)

    names = sorted(path.name for path in (place / FOLDER).iterdir())
    assert names == ["late-missed-halt.toml", "late-missed-lie_a.toml"]
    approved(undated(difference.stdout.partition("--- models/rendezvous/decisions")[2]))
    mrsfi("check", NAME, *REFERENCE, cwd=place)
    mrsfi("rename", NAME, "halt=lie_a", "lie_a=halt", cwd=place)
    assert '["lie_a"]' in (place / FOLDER / "late-missed-lie_a.toml").read_text()


def test_an_expired_decision_is_a_warning_and_in_a_strict_check_an_error(place, approved):
    decide(place, 2, *ACCEPT, "--until", str(date.today()))
    path = place / FOLDER / "g1-missed-stop_a.toml"
    edit(path, str(date.today()), "2020-02-29")

    warned = mrsfi("check", "--github", "--junit", "found.xml", cwd=place)
    junit = ET.parse(place / "found.xml")
    failed = mrsfi("check", "--github", "--junit", "found.xml", "--strict", cwd=place, expected=11)

    for done in (warned, failed):
        approved(done.stdout)
        approved(done.stderr)
    assert junit.findtext(".//system-out").startswith("Decision on g1 by stop_a: expired, ")
    assert junit.find(".//error") is None
    assert ET.parse(place / "found.xml").find(".//error") is not None


def test_a_kept_weakness_that_exceeds_its_limit_names_requirement_and_decision(place):
    mission = place / "models" / NAME / "mission.xmi"
    edit(mission, '<goals ID="g1"', '<goals ID="g1" requirements="R1"')
    edit(mission, "</mission:Mission>", '<requirements ID="R1" text="be there"/></mission:Mission>')
    mrsfi("generate", NAME, cwd=place)
    mrsfi("keep", "runs/it", "--weakness", "2", "--max", "g1=0", cwd=place)
    decide(place, 2, *ACCEPT)

    words = ("check", "--github", "--junit", "found.xml", *REFERENCE)
    done = mrsfi(*words, cwd=place, expected=10)

    about = "g1: requirement R1 (be there). Decision on g1 by stop_a: accepted by A. Rivera on "
    (told,) = (text for text in done.stdout.splitlines() if text.startswith("::error"))
    assert about in told
    assert about in ET.parse(place / "found.xml").findtext(".//system-out")


def test_a_night_ends_with_an_error_until_every_weakness_is_kept_or_decided(place, approved):
    (place / "models" / NAME / "case_a.toml").write_text("[search]\n")
    run = ("--nightly", "--evaluations", "30", "--workers", "1", "--out", "runs/night")

    first = mrsfi("evolve", NAME, *run, cwd=place, expected=11)
    found = {each["number"] for each in mrsfi_json("weaknesses", "runs/night", cwd=place)}
    mrsfi("keep", "runs/night", "--weakness", "1", cwd=place)
    for number in found - {1}:
        mrsfi("decide", "runs/night", str(number), *ACCEPT, "--until", "2999-01-01", cwd=place)
    again = ("evolve", "--resume", "runs/night", "--nightly")
    mrsfi(*again, cwd=place)
    edit(place / FOLDER / "g1-missed-stop_a.toml", str(date.today()), "2020-01-01")
    edit(place / FOLDER / "g1-missed-stop_a.toml", "2999-01-01", "2020-01-01")
    expired = mrsfi(*again, cwd=place, expected=11)

    approved("\n".join(first.stderr.splitlines()[-len(found) - 3 :]))
    assert expired.stderr.count("\nundecided  ") == 1


def commands_of(template):
    """Return the commands that a template on the page runs, for the small mission."""
    page = (ROOT / "docs" / "nightly.md").read_text(encoding="utf-8")
    (text,) = (
        part for part in re.findall("```yaml\n(.*?)```", page, re.DOTALL) if template in part
    )
    found = re.findall("^ +- (?:run: )?(mrsfi .*)", text, re.MULTILINE)
    return [each.replace(" demo ", f" {NAME} ").replace(" 2000 ", " 30 ") for each in found]


@slow
@pytest.mark.parametrize("template", ["jobs:", "script:"])
def test_the_templates_of_the_page_fail_until_all_is_decided(place, template):
    (place / "models" / NAME / "case_a.toml").write_text("[search]\n")
    numbers = {"GITHUB_RUN_NUMBER": "2", "CI_PIPELINE_IID": "2"}
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"

    def codes():
        shutil.rmtree(place / "runs" / "night", ignore_errors=True)
        run = partial(
            subprocess.run, shell=True, cwd=place, env=os.environ | numbers | {"PATH": path}
        )
        return {
            words.split()[1]: run(words, check=False).returncode for words in commands_of(template)
        }

    assert codes() == {"evolve": 11, "check": 2}
    for number in {each["number"] for each in mrsfi_json("weaknesses", "runs/night", cwd=place)}:
        mrsfi("decide", "runs/night", str(number), *ACCEPT, cwd=place)
    assert codes() == {"evolve": 0, "check": 0}


def test_a_night_needs_cover_and_weaknesses(place):
    for words in (("--algorithm", "random"), ("--no-explain",)):
        done = mrsfi("evolve", NAME, "--nightly", *words, cwd=place, expected=2)
        assert "--nightly needs --algorithm cover and --explain" in done.stderr
