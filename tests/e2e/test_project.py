"""A team's project: folders of its own, found from anywhere inside, with its own metamodels."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import fields
from functools import partial
from pathlib import Path

import pytest

from m2t.models.load import load_mission_folder, load_specification, write_specification
from mrsfi.engines import Project, project
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.project_file import project_metamodels
from tests.support.cli import MISSION, edit, mrsfi, mrsfi_json
from tests.support.own_metamodels import add_feature, attribute, copy_metamodels
from tests.support.tree import ROOT
from tests.support.world import paper_code
from tests.tiers import slow

SETTINGS = """[project]
models = "src/missions"
generated = "src/middleware"
runs = "build/runs"
"""
SMALL = ("--evaluations", "3", "--no-explain", "--workers", "1", "--engine", "reference")


@pytest.fixture
def team(place):
    """Root of a project whose folders have other names than ours."""
    (place / "src").mkdir()
    (place / "models").rename(place / "src" / "missions")
    (place / "generated").rename(place / "src" / "middleware")
    (place / "mrsfi.toml").write_text(SETTINGS, encoding="utf-8")
    return place


@slow
def test_folders_of_the_settings_are_those_of_every_command_from_anywhere_inside(team):
    deep = team / "docs" / "deep"
    deep.mkdir(parents=True)

    for here in (team, team / "src", deep):
        assert "3 robots" in mrsfi("validate", MISSION, cwd=here).stdout
        assert "fresh: " in mrsfi("generate", MISSION, "--check", cwd=here).stdout
        assert "exceeds its limit" not in mrsfi("check", "--engine", "reference", cwd=here).stdout
        mrsfi("evolve", MISSION, *SMALL, cwd=here)
        mrsfi("report", cwd=here)

    runs = sorted(path.name for path in (team / "build" / "runs").iterdir())
    assert runs == [f"{MISSION}-a-{number}" for number in (1, 2, 3)]
    assert not (deep / "runs").exists()


def test_who_names_a_path_names_it_from_where_they_are(team):
    (team / "docs").mkdir()
    place = team / "docs"

    mrsfi("evolve", "../src/missions/uuv_sampling", *SMALL, "--out", "here", cwd=place)

    assert (place / "here" / "campaign.sqlite").is_file()


def test_what_settings_leave_out_is_what_the_page_says(place, monkeypatch):
    monkeypatch.chdir(place)
    copy_metamodels(place / "metamodels")
    page = (ROOT / "docs" / "projects.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (place / "mrsfi.toml").write_text("[project]\n", encoding="utf-8")
    left_out = project(), project_metamodels()
    (place / "mrsfi.toml").write_text(shown, encoding="utf-8")

    assert (project(), project_metamodels()) == left_out
    known = {field.name for field in fields(Project)} - {"node", "fmea"}
    assert set(tomllib.loads(shown)["project"]) == {*known, "metamodels"}


@pytest.mark.parametrize(
    "text",
    [
        "[project]\nmodel = 'x'\n",
        "[project]\nmodels = 3\n",
        "[project]\nros = 3\n",
        "[project]\nros = true\n",
        "[other]\n",
        "[project\n",
        "[fmea]\nseverity = 3\n",
        "[fmea]\ndetection = 3\n",
        "[fmea]\ndetection = {never = 11}\n",
        "[fmea]\noccurrence = {11 = 0.1}\n",
        "[fmea]\noccurrence = {1 = true}\n",
        "[fmea]\noccurrence = {1 = nan}\n",
        "[fmea]\noccurrence = {1 = 0.2, 10 = 0.1}\n",
        "[project]\nmetamodels = 'none'\n",
    ],
)
def test_settings_that_mean_nothing_are_refused_with_their_file(team, text, approved):
    (team / "mrsfi.toml").write_text(text, encoding="utf-8")

    done = mrsfi("validate", MISSION, cwd=team, expected=2)

    assert str(team / "mrsfi.toml") in done.stderr
    approved(done.stderr)


def test_a_mission_that_there_is_not_is_sought_where_the_settings_say(team, approved):
    done = mrsfi("validate", "nowhere", cwd=team, expected=2)

    approved(done.stderr)


def _own_metamodels(place):
    copy_metamodels(place / "metamodels")
    add_feature(place / "metamodels" / "mission.ecore", "Robot", attribute("payload", "EDouble"))
    edit(place / "models" / MISSION / "mission.xmi", 'name="LEN"', 'name="LEN" payload="3.5"')


def test_metamodels_of_ones_own_are_used_and_named(place):
    _own_metamodels(place)

    done = mrsfi("validate", MISSION, cwd=place)
    generated = mrsfi("generate", MISSION, cwd=place)

    told = f"metamodels {place / 'metamodels'} (the project's, not mrsfi's)\n"
    assert done.stderr.startswith(told)
    assert generated.stderr == told
    code = place / "generated" / MISSION / "collective_intelligence.py"
    assert "R1_PAYLOAD = 3.5" in code.read_text(encoding="utf-8")
    assert "MRSFI_METAMODELS" not in os.environ


def test_metamodels_that_are_ours_go_without_saying(place):
    copy_metamodels(place / "metamodels")

    assert mrsfi("validate", MISSION, cwd=place).stderr == ""


@slow
def test_a_campaign_is_read_with_the_metamodels_it_was_made_with(place):
    _own_metamodels(place)
    mrsfi("generate", MISSION, cwd=place)

    mrsfi("evolve", MISSION, *SMALL, "--out", "it", cwd=place)

    assert mrsfi_json("report", "it", cwd=place)["n_evaluations"] == 3


def test_a_script_that_loads_models_reads_them_too_from_anywhere_inside(place, monkeypatch):
    _own_metamodels(place)
    (place / "metamodels").rename(place / "src")
    (place / "mrsfi.toml").write_text('[project]\nmetamodels = "src"\n', encoding="utf-8")
    monkeypatch.chdir(place / "models")

    models = load_mission_folder(Path(MISSION))

    assert models.mission.robots[0].payload == 3.5
    assert "MRSFI_METAMODELS" not in os.environ
    timed = TimedFault("f9", 0, 9, (200.0, -450.0, 1.0))
    write_specification(models, paper_code().pool, (timed,), Path("one.xmi"), identifier="one")
    assert load_specification(Path("one.xmi")).mission.robots[0].payload == 3.5


def test_the_script_of_the_page_edits_models_of_the_projects_metamodels(place):
    _own_metamodels(place)
    shutil.rmtree(place / "generated")
    environment = {**os.environ, "PYTHONPATH": f"{place}{os.pathsep}{ROOT}"}
    page = (ROOT / "docs" / "editing-models.md").read_text(encoding="utf-8")
    script = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0]
    run = partial(subprocess.run, cwd=place, check=True)
    chosen = {**environment, "MRSFI_METAMODELS": "metamodels"}
    run([sys.executable, "-m", "m2t.classes", "generated/metamodel"], env=chosen)

    run([sys.executable, "-c", script], env=environment)

    text = (place / "models" / MISSION / "mission.xmi").read_text(encoding="utf-8")
    assert 'payload="3.5"' in text
    assert 'name="JEN" speed="6.0"' in text
