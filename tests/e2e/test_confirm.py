"""Weaknesses of a campaign are flown in another world, over a real socket, and counted."""

import csv
import shutil
import sys
from time import monotonic

import pytest

from mrsfi_runtime.model.mission import wilson
from mrsfi_runtime.record.store import CampaignStore
from tests.support import planted_world
from tests.support.cli import mrsfi, mrsfi_json, press
from tests.support.nodes import require_silence
from tests.support.planted_world import CHANCY, NEARER, NEVER, SAME, SLOW, THERE, external_world
from tests.support.processes import wait_for
from tests.support.rosbridge import process
from tests.tiers import slow

RUN, GOALS = "runs/it", ("g1", "g2", "g3")


@pytest.fixture
def project(found, tmp_path):
    """Copy of the project of the small mission, with its campaign."""
    return shutil.copytree(found, tmp_path / "project")


def flights(project):
    """Return the flights that are recorded of other worlds."""
    with CampaignStore.open(project / RUN) as store:
        return store.flights_elsewhere()


def n_broken(project, row):
    """Return how many recorded flights of a variant broke the goal as printed, and of how many."""
    wanted = [(each["fault"], each["start"], each["finish"]) for each in row["variant"]]
    counts = [
        getattr(each.flown.found, row["measure"])[GOALS.index(row["goal"])]
        for each in flights(project)
        if [timed[:3] for timed in each.flown.specification] == wanted
    ]
    return sum(count > 0 for count in counts), len(counts)


def flown_times(project):
    """Return how often each specification was flown."""
    flown = [each.flown.specification for each in flights(project)]
    return {each: flown.count(each) for each in flown}


def test_in_the_same_world_every_weakness_breaks_the_same_goal_at_the_same_tick(project, url):
    before = mrsfi_json("weaknesses", RUN, cwd=project)

    with external_world(url, project, SAME):
        told = mrsfi_json("confirm", RUN, "--url", url, cwd=project)

    found = told["weaknesses"]
    assert {one["number"] for one in found} == {one["number"] for one in before}
    assert {one["there"]["verdict"] for one in found} == {"same goal"}
    assert [one["there"]["measure"] for one in found] == [one["measure"] for one in found]
    assert {one["there"]["delay"] for one in found} == {0}
    assert {one["there"]["kind"] for one in found} == {"listed", "mildest"}
    assert told["share"] == {"same": 6, "of": 6, "interval": [*wilson(6, 6)]}
    assert told["repeats_itself"]
    assert told["flights"] == len(flights(project)) == 8
    assert sorted(flown_times(project).values()) == [1, 1, 1, 1, 1, 3]
    after = mrsfi_json("weaknesses", RUN, cwd=project)
    assert [{**one, "elsewhere": []} for one in after] == before
    assert {one["elsewhere"][0]["world"] for one in after} == {url}


@slow
def test_worlds_that_are_started_here_fly_at_once_and_confirm_the_same(project, url):
    with external_world(url, project, SAME):
        at_url = mrsfi_json("confirm", RUN, "--url", url, cwd=project)

    command = f"{sys.executable} {planted_world.__file__} '{SAME}' {{url}}"
    told = mrsfi_json("confirm", RUN, "--world", command, "--workers", "2", cwd=project)

    require_silence(project)
    assert told["world"] == command
    found, expected = (
        [{**one, "there": {**one["there"], "world": ""}} for one in each["weaknesses"]]
        for each in (told, at_url)
    )
    assert found == expected
    assert told["share"] == at_url["share"]


def test_the_record_says_it_wherever_weaknesses_are_printed(project, url):
    with external_world(url, project, NEVER):
        told = mrsfi("confirm", RUN, "--url", url, cwd=project).stdout

    said = "2 of 2 weaknesses break the same goal (95 %: 34 % to 100 %)"
    assert "breaks without faults" in told
    assert told.splitlines()[-2] == f"In {url}, {said}"
    printed = mrsfi("weaknesses", RUN, "--fmea", "fmea.csv", cwd=project).stdout
    assert f"In the world {url}, {said}" in " ".join(printed.split())
    text = (project / "fmea.csv").read_text(encoding="utf-8")
    rows = [*csv.DictReader(text.splitlines())]
    sentences = [each["evidence"].partition("In the world ")[2] for each in rows]
    anyway, same = f"{url}: breaks without faults", f"{url}: same goal fails"
    assert sorted(sentences) == [*[anyway] * 4, *[same] * 2]
    mrsfi("report", RUN, cwd=project)
    for name in ("report.md", "report.html"):
        assert said in (project / RUN / name).read_text(encoding="utf-8")
    assert anyway in (project / RUN / "report.html").read_text(encoding="utf-8")


def test_the_share_is_that_of_the_listed_variants_that_broke_their_goal_by_the_record(project, url):
    with external_world(url, project, THERE):
        told = mrsfi_json("confirm", RUN, "--url", url, cwd=project)
    printed = mrsfi("weaknesses", RUN, cwd=project).stdout

    kept, lost = [], []
    judged = [
        one for one in mrsfi_json("weaknesses", RUN, cwd=project) if one["measure"] == "missed"
    ]
    for one in judged:  # by the gravest measure
        k, n = n_broken(project, {**one, "variant": one["witness"]})
        assert n in {1, 3}
        assert k in {0, n}
        (kept if k else lost).append(one["number"])
    assert (len(kept), len(lost)) == (4, 2)
    same, interval = {"same": 4, "of": 6}, wilson(4, 6)
    assert told["share"] == same | {"interval": [*interval]}
    verdicts = {one["number"]: one["there"]["verdict"] for one in told["weaknesses"]}
    assert [number for number in verdicts if verdicts[number] != "same goal"] == lost
    low, high = (f"{100 * each:.0f} %" for each in interval)
    share = f"4 of 6 weaknesses break the same goal (95 %: {low} to {high})"
    said = f"In the world {url}, {share}; not: {', '.join(map(str, lost))}"
    assert said in " ".join(printed.split())


def test_a_variant_is_shrunk_anew_where_the_mildest_does_not_break_the_goal(project, url):
    with external_world(url, project, NEARER):
        told = mrsfi_json("confirm", RUN, "--url", url, "--goal", "g2", cwd=project)

    (found,) = (one["there"] for one in told["weaknesses"])
    assert (found["verdict"], found["kind"]) == ("same goal", "shrunk")
    (timed,) = found["variant"]
    assert 0 < timed["start"] < 35  # when robot b would arrive
    assert 60 < timed["finish"] < 119  # it needs the rest of the time until the deadline, 70
    assert n_broken(project, {**found, "goal": "g2"}) == (1, 1)


def test_a_world_that_does_not_repeat_itself_flies_each_variant_three_times(project, url):
    options = ("confirm", RUN, "--url", url, "--weakness", "3", "--weakness", "5")

    with external_world(url, project, CHANCY):
        told = mrsfi_json(*options, cwd=project)
        printed = mrsfi(*options, cwd=project).stdout

    assert told["repeats_itself"] is False
    assert {*flown_times(project).values()} == {3}
    for one in told["weaknesses"]:
        k, n = n_broken(project, {**one["there"], "goal": one["goal"]})
        assert (one["there"]["n_broken"], one["there"]["n_flown"]) == (k, n)
        assert n == 3
    assert "3 of 3 flights (95 %: 44 % to 100 %)" in " ".join(printed.split())


def test_a_budget_ends_it_and_the_same_command_continues(project, url):
    with external_world(url, project, SAME):
        options = ("confirm", RUN, "--url", url)
        first = mrsfi_json(*options, "--budget", "4", cwd=project)
        none = mrsfi_json(*options, "--budget", "1", "--goal", "g1", cwd=project)
        rest = mrsfi_json(*options, cwd=project)
        again = mrsfi_json(*options, cwd=project)

    assert (first["flights"], none["flights"], rest["flights"]) == (4, 5, 8)
    assert {one["there"]["verdict"] for one in first["weaknesses"]} == {
        "same goal",
        "not flown yet",
    }
    assert again == rest


def test_another_world_at_the_same_place_is_refused_until_it_is_flown_anew(project, url):
    options = ("confirm", RUN, "--url", url)
    with external_world(url, project, SAME):
        mrsfi(*options, "--budget", "4", cwd=project)

    with external_world(url, project, NEARER):
        refused = mrsfi(*options, cwd=project, expected=7).stderr
        told = mrsfi_json(*options, "--anew", "--budget", "4", cwd=project)

    assert f"runs/it: the flight without faults in {url} differs from its record" in refused
    assert told["flights"] == len(flights(project)) == 4


@slow
def test_killed_at_any_moment_it_loses_the_flight_under_way_alone(project, url):
    words = ("confirm", RUN, "--url", url)
    with external_world(url, project, SLOW):
        for n in (1, 3, 6):
            with process(*words, cwd=project) as running:
                wait_for(lambda n=n: len(flights(project)) >= n)
                running.kill()
            assert n <= len(flights(project)) <= n + 1
        told = mrsfi_json(*words, cwd=project)

    assert told["flights"] == len(flights(project)) == 8
    assert told["share"]["same"] == 6


@slow
def test_a_world_that_is_slower_than_the_timeout_ends_it_and_keeps_what_was_flown(project, url):
    options = ("confirm", RUN, "--url", url)
    hanging = "chain([0.0] * 3, (sleep(60) for _ in count()))"
    with external_world(url, project, hanging):
        ended = mrsfi(*options, "--timeout", "2", cwd=project, expected=8).stderr

    assert "flights that ended are kept in runs/it; the same command continues" in ended
    assert len(flights(project)) >= 2


@slow
def test_an_archive_of_a_confirmed_campaign_is_as_repeatable_as_before(project, url):
    with external_world(url, project, SAME):
        mrsfi("confirm", RUN, "--url", url, "--budget", "4", cwd=project)

    mrsfi("report", RUN, cwd=project)
    mrsfi("pack", RUN, "--out", "it.zip", cwd=project)
    told = mrsfi("check", "it.zip", cwd=project).stdout

    assert told.startswith("same: 130 of 130 evaluations")


@slow
def test_ctrl_c_in_a_flight_ends_it_at_once(project, url):
    words = ("confirm", RUN, "--url", url)
    hanging = "chain([0.0] * 3, (sleep(60) for _ in count()))"
    with external_world(url, project, hanging), process(*words, cwd=project) as running:
        wait_for(lambda: len(flights(project)) >= 2)
        began = monotonic()
        press(running.pid)
        output = running.communicate(timeout=20)

    assert monotonic() - began < 5.0  # not the ten of the timeout
    assert running.returncode == 130
    assert "flights that ended are kept in runs/it; the same command continues" in output[1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "--side ci needs --url"),
        (("--url", "ws://localhost:1", "--goal", "g9"), "--goal: found 'g9'; expected one of g1"),
        (
            ("--url", "ws://localhost:1", "--weakness", "9"),
            "found no weakness 9; expected one of 1",
        ),
        (("--url", "ws://localhost:1", "--budget", "0"), "found '0'; expected a number of flights"),
        (("--url", "ws://localhost:1", "--engine", "compiled"), "--url needs --engine rosbridge"),
    ],
)
def test_what_makes_no_sense_is_refused(found, options, said):
    assert said in mrsfi("confirm", RUN, *options, cwd=found, expected=2).stderr


def test_flights_of_another_world_are_in_no_count_of_the_campaigns_own(project, url):
    before = mrsfi_json("weaknesses", RUN, "--seeds", "2", cwd=project)
    with external_world(url, project, NEARER):
        mrsfi("confirm", RUN, "--url", url, cwd=project)
        there = ("--engine", "rosbridge", "--side", "ci", "--url", url)
        refused = mrsfi("weaknesses", RUN, "--seeds", "2", *there, cwd=project, expected=2).stderr
    after = mrsfi_json("weaknesses", RUN, "--seeds", "2", cwd=project)

    assert "which counts differently" in refused
    assert "mrsfi confirm" in refused
    assert [{**one, "elsewhere": []} for one in after] == before
