"""The example of nodes of a team's own, in Python: flown, searched, killed and resumed."""

import os
import signal
from pathlib import Path

import pytest

import mrsfi
from mrsfi_runtime.errors import RecordError
from tests.support.cli import mrsfi_json, mrsfi_process
from tests.support.interrupted import digest, evaluations
from tests.support.nodes import MISSION, PYTHON, SERVICE, processes_in, require_silence, yard
from tests.support.rosbridge import process
from tests.support.tree import UNDRAWN
from tests.tiers import night

FLY = ("simulate", MISSION, *PYTHON, *SERVICE)
SEARCH = ("evolve", MISSION, *PYTHON, *SERVICE)
PATH = os.pathsep.join([str(UNDRAWN), *filter(None, [os.environ.get("PYTHONPATH")])])
NODE = "patrol.py ws"
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
