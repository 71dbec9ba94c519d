"""Simulations and nodes that take their time to begin anew, as Gazebo and MOOS do."""

import shlex
import sys
from contextlib import contextmanager

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import SERVICE, EngineSettings
from tests.support.page_simulator import page_simulator
from tests.support.tree import ROOT
from tests.support.world import code_of
from tests.tiers import night, slow

CODE = code_of("uuv_sampling", 60)
PATIENT, HASTY = 20.0, 0.5
AFTER = "\ndef reset(request, response):\n"
SLOW = f"""{AFTER}    import time
    open("resets", "a").write("x")
    time.sleep(2.5)
"""
"""The simulator of docs/bus.md with a reset that is noted, and takes longer than two seconds."""


@contextmanager
def simulated(folder, ros, reset=SLOW):
    """Yield a server with the simulator, which works in a folder."""
    with (
        EmbeddedBridge(ServerSettings(types=TypeTable(ros=ros))) as server,
        page_simulator(folder, server.url, AFTER, reset),
    ):
        yield server.url


def flown(url, ros=1, timeout=PATIENT, **node):
    """Return what came of a flight on the simulator at a server, with a node if one is named."""
    settings = EngineSettings("rosbridge", url, ros=ros, timeout=timeout, **({"side": "ci"} | node))
    with open_engine(settings, CODE, 1) as engine:
        return engine.evaluate(())


def n_resets(folder):
    """Return how often the simulator was asked to reset."""
    return len((folder / "resets").read_text(encoding="ascii"))


@pytest.fixture(autouse=True)
def in_folder(tmp_path, monkeypatch):
    """Have the simulator note its resets where each test looks for them."""
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("ros", [1, pytest.param(2, marks=slow)])
def test_a_slow_reset_is_waited_for_and_its_flight_is_that_of_a_quick_one(ros, tmp_path):
    with simulated(tmp_path, ros, AFTER) as url:
        quick = flown(url, ros)

    with simulated(tmp_path, ros) as url:
        assert flown(url, ros) == quick

    assert n_resets(tmp_path) <= ros  # in ROS 2 one may have come before its setup


def test_a_reset_may_take_longer_than_the_timeout_of_a_tick(tmp_path):
    with simulated(tmp_path, 1) as url:
        assert flown(url, timeout=HASTY) == flown(url)

    assert n_resets(tmp_path) == 2


NODE = """
import time
from tests.support.standin_node import StandIn, main

reset = StandIn.on_reset

def on_reset(self, request):
    open("resets_of_node", "a").write("x")
    time.sleep(2.5)
    return reset(self, request)

StandIn.on_reset = on_reset
main()
"""
"""The node of the tests with a reset that is noted, and takes longer than two seconds."""


@night
def test_so_is_that_of_a_node_and_of_the_simulation_behind_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    words = shlex.join([sys.executable, "-c", NODE, str(CODE.directory.resolve())])
    with simulated(tmp_path, 1) as url:
        expected = flown(url).believed
        node = {
            "side": "injector",
            "node": f"{words} {{url}} 1 {{seed}} /node",
            "node_pace": "answer",
            "node_reset": SERVICE,
            "node_prefix": "/node",
        }

        assert flown(url, **node).believed == expected

    assert n_resets(tmp_path) == 2
    assert (tmp_path / "resets_of_node").read_text(encoding="ascii") == "x"
