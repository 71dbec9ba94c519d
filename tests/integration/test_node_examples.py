"""The examples of nodes of a team's own, in Python: flown, searched, killed and resumed.

That of ROS 2 runs on a stand-in for rclpy.
"""

import json
import os
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import mrsfi
from mrsfi_runtime.cosimulation.node_mapping import NodeMapping
from mrsfi_runtime.errors import RecordError
from tests.support.cli import mrsfi_json, mrsfi_process
from tests.support.interrupted import digest, evaluations
from tests.support.nodes import MISSION, PYTHON, SERVICE, processes_in, require_silence, yard
from tests.support.rosbridge import process
from tests.support.tree import ROOT, UNDRAWN
from tests.tiers import night, slow

FLY = ("simulate", MISSION, *PYTHON, *SERVICE)
SEARCH = ("evolve", MISSION, *PYTHON, *SERVICE)
PATH = os.pathsep.join([str(UNDRAWN), *filter(None, [os.environ.get("PYTHONPATH")])])
NODE = "patrol.py ws"
LAUNCH = "ros2 launch ros2/patrol.launch.py"
FEW = ("--evaluations", "40", "--population", "10", "--no-explain")


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A copy of the example."""
    return yard(tmp_path / "nodes")


def test_without_faults_nothing_breaks_and_a_node_that_is_started_anew_flies_the_same(place):
    flights = [mrsfi_json(*FLY, cwd=place), mrsfi_json("simulate", MISSION, *PYTHON, cwd=place)]

    assert flights[0] == flights[1]
    assert all(goal["true"] == goal["believed"] == 0 for goal in flights[0]["goals"])
    assert processes_in(place) == {}


def test_kept_weaknesses_start_a_node_once_for_each_worker(place):
    kept = place / "models" / MISSION / "regressions"
    kept.mkdir()
    pool = (kept.parent / "faults.xmi").read_text(encoding="ascii")
    head, *faults = pool.replace('"mission.xmi#', '"../mission.xmi#').split("  <faults ")
    for number, fault in enumerate(faults[:4], 1):
        timed = fault.replace(" name=", ' start="5" finish="9" name=', 1).partition("</faults>\n")
        written = f"{head}  <faults {timed[0]}{timed[1]}</faults:FaultSpecification>\n"
        (kept / f"w{number}.xmi").write_text(written, encoding="ascii")
        limits = 'found = ""\nside = "injector"\nviolations = "true"\nmission_seeds = [1]\n'
        (kept / f"w{number}.toml").write_text(f"{limits}goals = 1\n\n[max]\ncollide = 0\n", "ascii")
    noted = f'echo >> starts; exec {sys.executable} python/patrol.py "{{url}}"'

    words = ("check", MISSION, "--side", "injector", "--node", f"sh -c '{noted}'", *SERVICE)
    done = mrsfi_process(*words, "--workers", "2", "--json", cwd=place)

    require_silence(place)
    assert [each["state"] for each in json.loads(done.stdout)[MISSION]] == ["holds"] * 4
    assert (place / "starts").read_text(encoding="ascii") == "\n" * 2


def test_a_campaign_of_a_node_is_flown_again_by_that_node_alone(place, tmp_path, monkeypatch):
    few = ("--evaluations", "4", "--population", "4", "--no-explain")
    mrsfi_process(*SEARCH, *few, "--workers", "1", "--out", "runs/it", cwd=place)

    monkeypatch.chdir(place)
    (best,) = mrsfi.Campaign("runs/it").top(1)
    flight = mrsfi.Campaign("runs/it").fly(best.index)
    monkeypatch.chdir(tmp_path)  # where no table [node] says what it hears

    assert flight.outcome == best.outcome
    with pytest.raises(RecordError, match="this campaign was flown with another node; its "):
        mrsfi.Campaign(place / "runs/it").fly(best.index)
    require_silence(place)


@pytest.fixture
def ros2(place, tmp_path, monkeypatch):
    """The options that launch the node of ROS 2, by a stand-in for ``ros2 launch``."""
    folder = tmp_path / "bin"
    folder.mkdir()
    words = f"{sys.executable} -m tests.support.standin_rclpy ros2/patrol.py"
    (folder / "ros2").write_text(f"#!/bin/sh\nexec {words}\n", "utf-8")
    (folder / "ros2").chmod(0o755)
    ours = Path(sys.executable).parent
    monkeypatch.setenv("PATH", os.pathsep.join(map(str, (folder, ours, os.environ["PATH"]))))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    return ("--engine", "ros2", "--node", LAUNCH, *SERVICE)


def test_the_node_of_ros_2_flies_as_that_on_roslibpy_which_hears_of_charges_in_single_precision(
    place, ros2
):
    patrol = place / "python" / "patrol.py"
    text = patrol.read_text("utf-8")
    single = text.replace('message["percentage"]', 'float(numpy.float32(message["percentage"]))')
    patrol.write_text(single.replace("import roslibpy", "import numpy\nimport roslibpy"), "utf-8")

    found = mrsfi_json("simulate", MISSION, *ros2, cwd=place)

    assert single != text
    assert found["digest"] == mrsfi_json(*FLY, cwd=place)["digest"]
    require_silence(place)


def test_docs_ros2_md_shows_what_is_flown_and_a_part_of_the_example_s_mapping(place):
    page = (ROOT / "docs" / "ros2.md").read_text("utf-8")
    (table,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    shown, whole = (
        NodeMapping.of(tomllib.loads(text)["node"])
        for text in (table, (place / "mrsfi.toml").read_text("utf-8"))
    )

    commands = re.findall(r"^\$ mrsfi \w+ (.*)$", page, re.MULTILINE)

    assert len(commands) == 2
    assert all(f'{MISSION} --engine ros2 --node "{LAUNCH}"' in each for each in commands)
    assert {each.topic for each in shown.tells} < {each.topic for each in whole.tells}
    assert shown.obeys == whole.obeys


@slow
def test_a_kept_weakness_is_a_test_of_the_launch_file(place, ros2):
    mrsfi_process("generate", f"models/{MISSION}", cwd=place)
    search = ("--evaluations", "100", "--population", "10", "--out", "runs/it")
    mrsfi_process("evolve", MISSION, *search, cwd=place)  # by the CI that is generated
    mrsfi_process("keep", "runs/it", "--weakness", "1", "--name", "it", cwd=place)
    words = (sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "ros2/test_patrol.py")

    failed = subprocess.run(words, cwd=place, check=False, capture_output=True, text=True)
    mrsfi_process("keep", MISSION, "--update", *ros2, cwd=place)
    passed = subprocess.run(words, cwd=place, check=False, capture_output=True, text=True)

    assert failed.returncode == 1
    assert "exceeds its limit" in failed.stdout
    assert passed.returncode == 0, passed.stdout


@night
def test_a_campaign_whose_node_is_killed_ends_as_if_it_had_not_been(place):
    mrsfi_process(*SEARCH, *FEW, "--workers", "1", "--out", "runs/whole", cwd=place)
    words = (*SEARCH, *FEW, "--workers", "2", "--out", "runs/killed")

    with process(*words, cwd=place, PYTHONPATH=PATH) as command:
        for line in command.stderr:
            if line.startswith("generation 0"):
                break
        os.kill(min(k for k, line in processes_in(place).items() if NODE in line), signal.SIGKILL)
        _, errors = command.communicate(timeout=120)

    assert (command.returncode, "Traceback" in errors) == (0, False)
    assert evaluations(place / "runs/killed") == evaluations(place / "runs/whole")
    assert digest(place / "runs/killed") == digest(place / "runs/whole")
    require_silence(place)
