"""Monitors of campaigns of a node and of an external world, recounted from recorded messages."""

import json
import os
import re
import shutil
import sys
import tomllib
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from shlex import quote

import pytest

from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.database import canonical
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.independent.monitors import first_alarms, measures, thresholds
from tests.support.cli import mrsfi, mrsfi_json, mrsfi_process
from tests.support.nodes import require_silence
from tests.support.noting_node import NOTES
from tests.support.planted_world import SAME
from tests.support.rendezvous import DURATION, NAME
from tests.support.tree import ROOT
from tests.tiers import slow

RUN = "runs/it"
FEW = ("--fit-seeds", "2", "--json")


@pytest.fixture
def elsewhere(found, tmp_path, monkeypatch):
    """A copy of the campaign's project, in which programs of the tests are found."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", ""))))
    return Path(shutil.copytree(found, tmp_path / "elsewhere"))


def recorded_as(place, **engine):
    """Have the record of the campaign name external parts, which fly it alike; return them."""
    settings = EngineSettings("rosbridge", **engine)
    with CampaignStore.open(place / RUN) as store:
        store.keep("manifest", canonical(replace(store.manifest, engine=settings).as_json()))
    return settings


def by_element(found):
    """Return values by monitor and element."""
    return {(name, element): value for name, row in found.items() for element, value in row.items()}


CHANGED = "chain(repeat(0.0, 4), repeat(700.0))"
"""Begins as recorded, but after four flights so far away that it never gets there."""


def world(kind):
    """Return what starts a world of the tests."""
    script = ROOT / "tests" / "support" / "planted_world.py"
    return f"{quote(sys.executable)} {script} {quote(kind)} {{url}}"


NODE = f"{sys.executable} -m tests.support.noting_node generated/{NAME} {{url}} 1 {{seed}}"
WITHOUT_ENERGY = """
[[node.tells]]
topic = "/{robot}/position"
type = "geometry_msgs/Point"
fields = { x = "x", y = "y", z = "z" }
[[node.tells]]
topic = "/{robot}/speed"
type = "std_msgs/Float64"
fields = { data = "speed" }
[[node.obeys]]
topic = "/{robot}/command/heading"
type = "geometry_msgs/Vector3"
fields = { x = "heading_x", y = "heading_y" }
[[node.obeys]]
topic = "/{robot}/command/speed"
type = "std_msgs/Float64"
fields = { data = "speed" }
"""


class Noted:
    """The flights that a node noted, each as a recorded belief."""

    def __init__(self, ticks):
        self._ticks = ticks

    def __getitem__(self, name):
        assert name == "belief"
        return self._ticks

    def __len__(self):
        return len(self._ticks)


@slow
def test_a_node_is_judged_by_what_it_received_and_commanded(elsewhere):
    """The node noted both; it receives no energy, so that it stays as in the model."""
    (elsewhere / "mrsfi.toml").write_text(WITHOUT_ENERGY, encoding="ascii")
    mapping = json.dumps(tomllib.loads(WITHOUT_ENERGY)["node"], sort_keys=True)
    node = {"side": "injector", "node": NODE, "node_reset": "service", "node_mapping": mapping}
    recorded_as(elsewhere, **node)

    done = mrsfi_process("monitors", RUN, *FEW, cwd=elsewhere)

    require_silence(elsewhere)
    told, lines = json.loads(done.stdout), (elsewhere / NOTES).read_text("ascii").splitlines()
    ticks, mission = [*map(json.loads, lines)], load_code(elsewhere / "generated" / NAME).mission
    _, *flights = (Noted(ticks[k : k + DURATION]) for k in range(0, len(ticks), DURATION))
    alarms = {json.dumps(case["variant"]): by_element(case["alarms"]) for case in told["cases"]}
    limits = thresholds([measures(mission, flights[k], seed=1 + k) for k in range(2)])
    flown = flights[2 : 2 + len(alarms)]
    again = [first_alarms(measures(mission, flight, seed=1), limits) for flight in flown]
    assert f"monitors   {len(flights)} flights, 22 without faults\n" in done.stderr
    assert by_element(told["thresholds"]) == pytest.approx(limits)
    assert [*alarms.values()] == again
    assert any(again)


@slow
def test_an_external_world_is_judged_by_its_flights(elsewhere):
    """It flies as mrsfi's own."""
    ours = mrsfi_json("monitors", RUN, "--engine", "reference", *FEW[:2], cwd=elsewhere)
    settings = recorded_as(elsewhere, side="ci", world=world(SAME), is_bundled=True)

    done = mrsfi_process("monitors", RUN, *FEW, cwd=elsewhere)

    require_silence(elsewhere)
    told, code = json.loads(done.stdout), load_code(elsewhere / "generated" / NAME)
    with chdir(elsewhere), open_engine(settings, code, 1) as engine:
        fit = [measures(code.mission, engine.record((), seed), seed) for seed in (1, 2)]
        case = next(each for each in told["cases"] if each["alarms"])
        flight = engine.record(tuple(TimedFault(**each) for each in case["variant"]))
    again = first_alarms(measures(code.mission, flight, seed=1), thresholds(fit))
    assert by_element(case["alarms"]) == again
    assert told == ours


def test_a_world_whose_flights_differ_from_the_record_is_refused(elsewhere):
    """Those of the most critical evaluation and of three mission seeds without faults do not."""
    recorded_as(elsewhere, side="ci", world=world(CHANGED), is_bundled=True)

    done = mrsfi_process("monitors", RUN, "--fit-seeds", "3", cwd=elsewhere, expected=7)

    assert re.search(r"runs/it: a flight under lie_a differs from its record: ", done.stderr)


def test_monitors_are_not_written_for_a_node(elsewhere):
    recorded_as(elsewhere, side="injector", node=NODE)

    refused = mrsfi("monitors", RUN, "--write", cwd=elsewhere, expected=2)

    assert refused.stderr == (
        "mrsfi: runs/it: was flown with a node, and --write adds monitors to generated reactions; "
        "expected no --write: --json has thresholds and formulas for your node\n"
    )
