"""A server that keeps order within a topic only, as the genuine one does: nothing goes unseen."""

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.page_simulator import page_simulator
from tests.support.rosbridge import FLIGHT_SEED, Relay, code_of, digests
from tests.tiers import slow

CODE = code_of("uuv_sampling", 60)
SCATTER = 0.02
SEEDS = range(2)


def flown(url: str) -> list[list[str]]:
    """Return the digests of flights on whatever simulation a server has."""
    settings = EngineSettings(url=url, side="ci", timeout=3.0)
    with RosbridgeEngine(CODE, FLIGHT_SEED, settings) as engine:
        return digests(engine, SEEDS)


@slow
def test_the_simulator_of_the_page_flies_as_on_a_server_that_keeps_order(tmp_path):
    with EmbeddedBridge() as server, page_simulator(tmp_path, server.url):
        in_order = flown(server.url)

    with (
        EmbeddedBridge() as server,
        Relay(server.url, scatter=SCATTER) as relay,
        page_simulator(tmp_path, relay.url),
    ):
        assert flown(server.url) == in_order


def test_a_simulator_that_flies_with_what_it_happens_to_have_is_refused(tmp_path):
    found = 'state["obeyed"] < state["sent"]'
    problem = (
        r"run 1, tick \d+: the simulation flew with \d+ commands; \d+ were sent since the "
        r"reset: .*docs/bus\.md"
    )
    with (
        EmbeddedBridge() as server,
        Relay(server.url, scatter=SCATTER) as relay,
        page_simulator(tmp_path, relay.url, found, f"tick == 0 and {found}"),
        pytest.raises(ProtocolError, match=problem) as refused,
    ):
        flown(server.url)

    assert refused.value.exit_code == 8
