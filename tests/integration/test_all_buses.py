"""Every client, server and ROS: the same flights, while messages of a tick overtake each other."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from itertools import product
from time import sleep

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.engine.rosbridge import SimulationProcess
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.transport.topics import CLIENTS, ROS_VERSIONS
from tests.support.rosbridge import Relay, code_of, digests_apart, reference_digests
from tests.tiers import night, slow

MISSION, DURATION = "uuv_sampling", 200
CODE = code_of(MISSION, DURATION)
SEEDS = range(20)
SCATTER = 0.01
AT_A_TIME = 3
WAYS = ("in the simulation", "simulation first", "ci first")
"""Where the server is; if it is in a process of its own, who joins it first."""

COMBINATIONS = [*product(WAYS, ROS_VERSIONS, CLIENTS)]


def flown(way, ros, client, seeds):
    """Return the digests of flights in one way, the ci's messages scattered by up to 10 ms."""
    settings = EngineSettings("rosbridge", ros=ros, client=client, timeout=20.0)
    with ExitStack() as opened, ThreadPoolExecutor(1) as beside:
        if way == "in the simulation":
            url = opened.enter_context(closing(SimulationProcess(CODE, settings))).url
        else:
            server = EmbeddedBridge(ServerSettings(types=TypeTable(ros=ros)))
            url = opened.enter_context(server).url
        relay = opened.enter_context(Relay(url, scatter=SCATTER))

        def simulation():
            joined = SimulationProcess(
                CODE, EngineSettings("rosbridge", url, ros=ros, client=client)
            )
            opened.enter_context(closing(joined))

        def fly():
            return digests_apart(client, MISSION, DURATION, seeds, relay.url, ros)

        if way == "simulation first":
            simulation()
        flying = beside.submit(fly)
        if way == "ci first":
            sleep(1.5)
            simulation()
        return flying.result()


@pytest.mark.parametrize(
    "seeds", [pytest.param(SEEDS[:1], marks=slow), pytest.param(SEEDS[1:], marks=night)], ids=str
)
def test_every_bus_flies_as_the_reference_does(seeds):
    with ThreadPoolExecutor(AT_A_TIME) as pool:  # a flight waits most of its time
        found = [*pool.map(lambda way: flown(*way, seeds), COMBINATIONS)]

    expected = reference_digests(CODE, seeds)
    assert dict(zip(COMBINATIONS, found, strict=True)) == dict.fromkeys(COMBINATIONS, expected)
