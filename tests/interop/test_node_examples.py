"""The example of a node in JavaScript, on roslib: flown and searched as it comes."""

import subprocess
from pathlib import Path

import pytest

from tests.support.cli import mrsfi_json, require_program
from tests.support.missing import skip
from tests.support.nodes import JAVASCRIPT, MISSION, yard


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the example, with what its node needs."""
    require_program("node")
    folder = yard(tmp_path_factory.mktemp("javascript") / "nodes")
    command = [require_program("npm"), "ci", "--prefix", "javascript", "--no-audit", "--no-fund"]
    done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode:
        skip(f"cannot install roslib: {done.stderr.strip()[-300:]}")
    return folder


def test_it_flies_without_faults_and_repeats_itself(place):
    flights = [mrsfi_json("simulate", MISSION, *JAVASCRIPT, cwd=place) for _ in range(2)]

    assert flights[0] == flights[1]
    assert all(goal["true"] == goal["believed"] == 0 for goal in flights[0]["goals"])
