"""What the command line does, a script does; and finds the same."""

import inspect
import json
import shutil
import subprocess
import sys
from contextlib import chdir
from dataclasses import fields

import numpy as np
import pytest

import mrsfi
from mrsfi_runtime.errors import RecordError, SpecificationError, UsageError
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.cli import MISSION, mrsfi_json, stop_specification
from tests.support.rendezvous import NAME
from tests.support.tree import ROOT
from tests.tiers import slow

REFERENCE = "reference"


@pytest.fixture
def uuv(place):
    """The paper's mission in a folder of its own."""
    return mrsfi.load(place / "models" / MISSION)


def test_every_public_name_is_there_and_no_other(refused):
    assert all(getattr(mrsfi, name) is not None for name in mrsfi.__all__)
    with refused(AttributeError):
        mrsfi.laod  # noqa: B018 - the look-up is the test


def test_a_file_flies_as_by_command_and_every_tick_is_told(uuv, place):
    file = stop_specification(place / "models" / MISSION / "stop.xmi", [(100, 900)])
    told = mrsfi_json("simulate", MISSION, "--faults", file, cwd=place)

    flight = uuv.fly(file)

    n_ticks, n_robots, n_goals = flight.mission.duration, 3, 6
    assert (told["mission"], told["digest"]) == (MISSION, flight.outcome.digest)
    assert flight.robots == tuple(robot.id for robot in uuv.model.robots)
    for positions in (flight.true_positions, flight.believed_positions):
        assert positions.shape == (n_ticks, n_robots, 3)
    for values in (
        flight.true_speeds,
        flight.believed_speeds,
        flight.true_energies,
        flight.believed_energies,
    ):
        assert values.shape == (n_ticks, n_robots)
    assert flight.truly_violated.shape == flight.believed_violated.shape == (n_ticks, n_goals)
    for violated, kind in ((flight.truly_violated, "true"), (flight.believed_violated, "believed")):
        counts = dict(zip(flight.goals, violated.sum(axis=0).tolist(), strict=True))
        assert flight.violations(kind) == counts
        assert [goal[kind] for goal in told["goals"]] == [*counts.values()]


def test_a_timed_fault_has_the_values_of_the_pool_unless_others_are_given(uuv, refused):
    usual = uuv.timed("f9", 100, 400)

    assert usual.values == uuv.pool["f9"].values
    assert uuv.timed("f9", 100, 400, NEW_X=7.0).values == (7.0, *usual.values[1:])
    with refused(SpecificationError):
        uuv.timed("f9", 100, 400, VAL=1)
    with refused(SpecificationError):
        uuv.timed("f99", 1, 2)
    with refused(SpecificationError):
        uuv.fly([usual._replace(start=400, finish=100)])


def test_many_are_counted_as_one_by_one(uuv):
    specifications = [(), (uuv.timed("f9", 100, 400),)]

    many = [*uuv.evaluate(specifications, engine=REFERENCE, workers=1)]

    assert many == [uuv.fly(each).outcome for each in specifications]


def test_a_kind_of_violations_that_there_is_not_is_refused(uuv, refused):
    with refused(ValueError):
        uuv.fly().violations("real")


@pytest.mark.parametrize(
    "call",
    [
        lambda u: u.fly(engine="refrence"),
        lambda u: u.evaluate([()], engine=None),
        lambda u: u.check(engine="compield"),
        lambda u: u.fly(seed=-1),
        lambda u: u.fly(seed=1.5),
        lambda u: u.evaluate([()], seed=2**70),
        lambda u: u.evaluate([()], workers=0),
        lambda u: u.evolve(workers="2"),
        lambda u: u.evolve(out=3),
        lambda u: u.evolve(generation=5),
        lambda u: u.evolve(algorithm="gided"),
        lambda u: u.evolve(goals=["g33"]),
        lambda u: u.compare([], 2, 10),
        lambda u: u.compare("random", 2, 10),
        lambda u: u.compare(["random"] * 2, 2, 10),
        lambda u: u.compare(["random"], 0, 10),
        lambda u: u.check(n_seeds=1.5),
        lambda u: mrsfi.load(u.folders.models, 3),
    ],
)
def test_arguments_that_make_no_sense_are_refused_before_anything_flies(uuv, call, refused):
    with refused(UsageError):
        call(uuv)


def test_numbers_of_numpy_and_folders_as_text_are_taken(uuv, place):
    few = {"population": np.int64(2), "generations": 0, "faults": 2, "explain": False}

    campaign = uuv.evolve(out=str(place / "few"), engine=REFERENCE, workers=np.int32(1), **few)

    assert campaign.folder.parent == place
    assert uuv.fly(seed=np.int64(3)).seed == 3


def test_stale_code_is_refused_until_it_is_generated_anew(uuv, refused):
    model = uuv.folders.models / "mission.xmi"
    model.write_text(
        model.read_text(encoding="utf-8").replace('speed="5.0"', 'speed="4.5"'), "utf-8"
    )

    with refused(mrsfi.MrsfiError):
        uuv.fly()

    assert uuv.generate() == ("mission_loader.py",)
    assert uuv.generate() == ()
    assert uuv.model.robots[0].speed == 4.5
    assert uuv.validate() == ()


def test_code_that_was_fresh_is_compared_again_when_the_project_s_metamodels_change(
    place, monkeypatch
):
    shutil.copytree(ROOT / "metamodels", place / "metamodels")
    monkeypatch.delenv("MRSFI_METAMODELS", raising=False)
    script = f"import mrsfi; mrsfi.load('models/{MISSION}').fly()"

    def flown():
        words = (sys.executable, "-c", script)
        return subprocess.run(words, cwd=place, check=False, capture_output=True, text=True)

    first, again = flown(), flown()
    (place / "metamodels" / "mission.ecore").write_text("no XML", encoding="utf-8")

    assert (first.returncode, again.returncode) == (0, 0), first.stderr
    assert "mission.ecore" in flown().stderr


@slow
def test_a_search_by_script_finds_what_the_command_finds(uuv, flown, place):
    settings = {"population": 4, "generations": 2}
    generations = []

    campaign = uuv.evolve(
        "b", engine=REFERENCE, workers=1, out=place / "it", progress=generations.append, **settings
    )

    by_command = mrsfi.Campaign(flown)
    assert campaign.digest == by_command.digest
    assert [state.generation for state in generations] == [0, 1, 2]
    assert np.array_equal(campaign.fitness, by_command.fitness)
    assert campaign.weaknesses == by_command.weaknesses


def test_a_search_without_a_campaign_file_has_the_papers_settings(uuv, place, refused):
    campaign = uuv.evolve(
        evaluations=3, explain=False, engine=REFERENCE, workers=1, out=place / "it"
    )

    assert (campaign.settings.algorithm, campaign.settings.faults) == ("paper", 20)
    assert len(campaign) == 3
    with refused(RecordError):
        campaign.weaknesses  # noqa: B018 - that it is refused


@slow
def test_a_campaign_tells_its_evaluations_in_arrays_and_its_weaknesses(found):
    folder = found / "runs" / "it"
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))

    campaign = mrsfi.Campaign(folder)

    assert campaign.digest == summary["digest"]
    assert campaign.violations.shape == (len(campaign), len(campaign.goals))
    assert campaign.fitness.shape == (summary["n_evaluations"],)
    (best, *_) = campaign.top()
    assert best.fitness[0] == campaign.fitness.max()
    counted = dict(zip(campaign.goals, campaign.violations[best.index], strict=True))
    again = campaign.fly(best.index)
    assert again.outcome == best.outcome
    kind = campaign.settings.violations
    assert counted == {goal: again.violations(kind)[goal] for goal in campaign.goals}
    told = [each["witness"] for each in summary["weaknesses"]["found"]]
    assert told
    assert [each.as_json()["witness"] for each in campaign.weaknesses] == told


def test_an_evaluation_is_explained_as_it_is_recorded(found):
    campaign = mrsfi.Campaign(found / "runs" / "it")

    explanation = campaign.explain(0)

    assert explanation.cause.places == (0,)
    assert len(explanation.alone) == len(campaign.evaluation(0).specification)


def test_a_weakness_is_kept_and_checked(found, tmp_path, refused):
    place = shutil.copytree(found, tmp_path, dirs_exist_ok=True)
    mission = mrsfi.load(place / "models" / NAME)
    with refused(UsageError):
        mission.check()

    with chdir(place):
        kept = mrsfi.Campaign("runs/it").keep(3, name="first")

    (checked,) = mission.check(REFERENCE)
    assert kept.name == checked.regression.name == "first"
    assert checked.counts == kept.limits
    assert checked.exceeded == ()


SUITE = """
from mrsfi.regressions import regression_test

test_what_was_found = regression_test("models/uuv_sampling", engine="reference")
"""


def _pytest(place):
    (place / "test_found.py").write_text(SUITE, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_found.py"]
    return subprocess.run(command, cwd=place, capture_output=True, text=True, check=False)


@slow
def test_kept_weaknesses_are_tests_of_pytest(place):
    assert "1 passed" in _pytest(place).stdout

    limits = place / "models" / MISSION / "regressions" / "case_a_1.toml"
    text = limits.read_text(encoding="utf-8")
    assert "g2 = 698" in text
    limits.write_text(text.replace("g2 = 698", "g2 = 697"), encoding="utf-8")
    done = _pytest(place)
    assert done.returncode == 1
    assert "case_a_1: g2 (believed) exceeds its limit (698, allowed 697)" in done.stdout
    assert "FixedRobotCoordinates" in done.stdout

    shutil.rmtree(limits.parent)
    done = _pytest(place)
    assert done.returncode == 2
    assert "no weakness is kept; expected at least one" in done.stdout


def test_a_signature_completes_every_setting_of_a_campaign_file():
    named = [*inspect.signature(mrsfi.Mission.evolve).parameters]

    settings = {each.name for each in fields(CampaignSettings)} - {"source", "options"}
    assert settings <= {*named}
    assert named[:3] == ["self", "case", "out"]


def test_a_notebook_shows_a_mission_and_a_flight_with_their_names(uuv):
    flight = uuv.fly([uuv.timed("f26", 100, 400)])

    assert "KAL (r3)" in uuv._repr_html_()
    assert "under 1 fault" in flight._repr_html_()
    assert all(goal in flight._repr_html_() for goal in flight.goals)


def test_a_flight_is_drawn_on_axes_of_its_kind_and_another_kind_is_refused(uuv, refused):
    flight = uuv.fly()

    assert flight.plot().get_xlabel() == "x (distance units)"
    assert flight.plot("timeline").get_xlabel() == "tick"
    with refused(UsageError):
        flight.plot("maps")
