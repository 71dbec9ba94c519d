"""Simulation and CI on a rosbridge server: same results, and no message lost unseen."""

import json
import os
import signal
import threading
import time
from contextlib import closing
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine, SimulationProcess
from mrsfi_runtime.errors import TransportClosed, TransportError, TransportTimeout
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.processes import is_running
from tests.support.rosbridge import (
    FLIGHT_SEED,
    Relay,
    code_of,
    digests,
    reference_digests,
)
from tests.tiers import slow

SHORT = code_of("tight_margins", 60)


@pytest.fixture
def server():
    with EmbeddedBridge() as bridge:
        yield bridge


@pytest.fixture
def simulation(server):
    """A simulation that waits for somebody to fly it."""
    with closing(simulation_on(server.url)) as running:
        yield running


def simulation_on(url):
    return SimulationProcess(SHORT, EngineSettings(url=url, client="asyncio", timeout=3.0))


def engine(code, **options):
    return RosbridgeEngine(code, FLIGHT_SEED, EngineSettings(timeout=3.0, **options))


def test_the_ci_may_start_before_the_simulation(server):
    flown = []

    def fly():
        with engine(SHORT, url=server.url, side="ci") as opened:
            flown.extend(digests(opened, range(2)))

    thread = threading.Thread(target=fly)
    thread.start()
    time.sleep(1.0)
    simulation = simulation_on(server.url)
    thread.join(60)
    simulation.close()

    assert flown == reference_digests(SHORT, range(2))


def test_on_ros_2_types_and_times_are_named_as_there():
    said = []

    def heard(frame):
        said.append(json.loads(frame))
        return [frame]

    with (
        EmbeddedBridge(ServerSettings(types=TypeTable(ros=2))) as server,
        Relay(server.url, to_server=heard) as relay,
        engine(SHORT, url=relay.url, ros=2) as opened,
    ):
        opened.evaluate(())

    types = {each["type"] for each in said if "type" in each}
    clocks = [
        each["msg"]["clock"] for each in said if each.get("topic") == "/clock" and "msg" in each
    ]
    assert {"geometry_msgs/msg/Point", "std_srvs/srv/Trigger"} < types
    assert {len(name.split("/")) for name in types} == {3}
    assert clocks[:2] == [{"sec": 0, "nanosec": 0}, {"sec": 1, "nanosec": 0}]


def test_strangers_cannot_join_an_embedded_server():
    simulation = simulation_on(None)
    url, _, token = simulation.url.partition("/?token=")
    try:
        with pytest.raises(TransportError, match=f"^{url} requires a token, and received none"):
            engine(SHORT, url=url, side="ci")
        with engine(SHORT, url=simulation.url, side="ci") as opened:
            assert digests(opened, [1]) == reference_digests(SHORT, [1])
    finally:
        simulation.close()
    assert len(token) > 30


def test_a_simulation_that_knows_no_bundles_is_told(server, simulation):

    def deaf(frame):
        return [] if "/mission/go/bundle" in frame else [frame]

    with (
        Relay(server.url, to_server=deaf) as relay,
        engine(SHORT, url=relay.url, side="ci", is_bundled=True) as opened,
        pytest.raises(
            TransportTimeout, match=r"tick 0: .*--bundle expects it to know /mission/go/bundle"
        ),
    ):
        opened.evaluate(())


@pytest.mark.parametrize(
    ("sign", "has_server", "problem"),
    [
        (signal.SIGKILL, False, "SIGKILL"),
        (signal.SIGKILL, True, "SIGKILL"),
        pytest.param(signal.SIGSTOP, False, "the simulation was silent for 3", marks=slow),
    ],
)
def test_a_simulation_that_is_lost_is_told_at_once_with_its_tick(server, sign, has_server, problem):
    def observe(world, belief, verdicts):
        if world.mission.tick == 20:
            os.kill(opened.simulation.pid, sign)

    started = time.monotonic()
    with engine(SHORT, url=server.url if has_server else None) as opened:
        with pytest.raises(TransportError, match=rf"run 1, tick 2\d: .*{problem}") as told:
            opened.evaluate((), observer=observe)
        told_within = time.monotonic() - started
        if not has_server:  # else the engine waits for another simulation
            with pytest.raises(TransportError, match="run 2, before tick 0"):
                opened.evaluate(())

    assert type(told.value) is (TransportClosed if problem == "SIGKILL" else TransportTimeout)
    assert not is_running(opened.simulation.pid)
    assert told_within < 20


def test_an_observer_that_raises_ends_its_run_only():
    def observe(world, belief, verdicts):
        if world.mission.tick == 20:
            raise TransportError("nothing to write on")

    with engine(SHORT) as opened:
        with pytest.raises(TransportError, match="run 1, tick 20: nothing to write on"):
            opened.evaluate((), observer=observe)
        outcome = opened.evaluate(())

    assert outcome == ReferenceEngine(SHORT, FLIGHT_SEED).evaluate(())


def test_a_server_that_speaks_something_else_is_told():
    with ThreadingHTTPServer(("127.0.0.1", 0), BaseHTTPRequestHandler) as other:
        thread = threading.Thread(target=other.serve_forever)
        thread.start()
        try:
            with pytest.raises(TransportError, match="expected a rosbridge server"):
                engine(SHORT, url=f"ws://127.0.0.1:{other.server_address[1]}")
        finally:
            other.shutdown()
            thread.join()
