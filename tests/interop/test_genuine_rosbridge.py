"""Missions on the genuine rosbridge server of ROS 1, which keeps order within a topic only.

``MRSFI_GENUINE_ROSBRIDGE`` names a program that is given a port and a command, and runs the
command beside such a server on the loopback of its machine.
"""

import json
import os
import subprocess
from pathlib import Path
from time import monotonic
from typing import Any

import pytest

from tests.support.cli import MISSION, ROOT, command_line, mrsfi_json, workspace
from tests.support.missing import skip
from tests.support.page_simulator import page_simulator, write_page_simulator
from tests.support.rosbridge import process

PROGRAM = os.environ.get("MRSFI_GENUINE_ROSBRIDGE", "")
PORT = 9191
URL = f"ws://127.0.0.1:{PORT}"
CI = ("--engine", "rosbridge", "--side", "ci", "--url")

pytestmark = pytest.mark.skipif(not PROGRAM, reason="MRSFI_GENUINE_ROSBRIDGE is not set")


@pytest.fixture(scope="module")
def server() -> Path:
    """Return the program that runs a command beside the server; it must be able to."""
    program = ROOT / PROGRAM
    if not os.access(program, os.X_OK):
        skip(f"MRSFI_GENUINE_ROSBRIDGE: {program} is no program")
    tried = subprocess.run(
        [program, str(PORT), "true"], check=False, capture_output=True, encoding="utf-8"
    )
    if tried.returncode:
        skip(f"MRSFI_GENUINE_ROSBRIDGE: {program} failed: {tried.stderr[-300:]}")
    return program


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with models and code of the mission."""
    return workspace(tmp_path_factory.mktemp("genuine"))


def flown_beside(server: Path, *command: str, cwd: Path) -> Any:
    """Return what a flight beside the server printed as JSON."""
    done = subprocess.run(
        [server, str(PORT), *command],
        check=False,
        cwd=cwd,
        capture_output=True,
        encoding="utf-8",
        timeout=240,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("client", ["asyncio", "twisted"])
def test_a_mission_flies_as_in_process(server, place, client, note):
    bus = ("--engine", "rosbridge", "--url", URL, "--client", client)
    begin = monotonic()

    flight = flown_beside(server, *command_line("simulate", MISSION, *bus, "--json"), cwd=place)

    assert flight == mrsfi_json("simulate", MISSION, cwd=place)
    note(f"the genuine rosbridge server, {client}", seconds=round(monotonic() - begin))


def test_the_simulator_of_the_page_flies_as_on_a_server_that_keeps_order(server, place, note):
    with process("bridge", "--port", "0") as bridge:
        url = bridge.stdout.readline().strip()
        with page_simulator(place, url):
            expected = mrsfi_json("simulate", MISSION, *CI, url, cwd=place)
    program = write_page_simulator(place, URL)
    ci = command_line("simulate", MISSION, *CI, URL, "--json")
    both = 'simulator=$1; shift; "$1" "$simulator" & "$@"; code=$?; kill $!; exit $code'

    flights = [
        flown_beside(server, "sh", "-c", both, "sh", str(program), *ci, cwd=place) for _ in range(3)
    ]

    assert flights == [expected] * 3
    note("the page's simulator on the genuine server", flights=len(flights))
