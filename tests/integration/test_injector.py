"""The generated reactions as somebody else's node, behind sockets: the same flights."""

import shlex
import sys
from contextlib import ExitStack, closing
from dataclasses import replace
from itertools import product

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.node_speech import Speech, out_of_reach
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.engine.rosbridge import SimulationProcess
from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import BUILT_IN, RESTART, SERVICE, EngineSettings
from mrsfi_runtime.transport.topics import ROS_VERSIONS
from tests.support.triggers import with_triggers
from tests.support.world import paper_code, specification

CODE = paper_code()
REACHED = replace(
    CODE,
    pool=CODE.pool.without(
        out_of_reach(CODE.mission, CODE.pool, Speech.of("", CODE.mission)),
    ),
)
EMBEDDED, ON_ONE_SERVER = "our world inside", "all on one server"
NODE_ON_A_SERVER = "our world inside, the node on a server"
WAYS = [*product((EMBEDDED, ON_ONE_SERVER, NODE_ON_A_SERVER), ROS_VERSIONS)]


def flown(way, ros, specifications, pace="answer", reset=SERVICE, code=REACHED):
    """Return the outcomes of flights with the node of the tests, in one way."""
    words = [sys.executable, "-m", "tests.support.standin_node", str(code.directory)]
    url, prefix, world_prefix = None, "", ""
    with ExitStack() as opened:
        if way != EMBEDDED:
            server = EmbeddedBridge(ServerSettings(types=TypeTable(ros=ros)))
            url = opened.enter_context(server).url
        if way == ON_ONE_SERVER:
            prefix, world_prefix = "/node", "/world"
            world = EngineSettings("rosbridge", url, ros=ros, world_prefix=world_prefix)
            opened.enter_context(closing(SimulationProcess(code, world)))
        command = f"{shlex.join(words)} {{url}} {ros} {{seed}} {prefix}"
        settings = EngineSettings(
            "rosbridge",
            url,
            ros=ros,
            side="injector",
            world=BUILT_IN if way == NODE_ON_A_SERVER else None,
            timeout=20.0,
            node=command,
            node_pace=pace,
            node_reset=reset,
            node_prefix=prefix,
            world_prefix=world_prefix,
        )
        engine = opened.enter_context(open_engine(settings, code, 1))
        return [engine.evaluate(each) for each in specifications]


def in_process(specifications):
    """Return the outcomes of the reference."""
    with ReferenceEngine(REACHED, 1) as engine:
        return [engine.evaluate(each) for each in specifications]


@pytest.mark.parametrize(("way", "ros"), WAYS)
def test_a_node_that_reacts_as_generated_flies_as_generated(way, ros):
    specifications = [specification(REACHED, seed) for seed in (100, 101)]

    assert flown(way, ros, specifications) == in_process(specifications)


def test_faults_that_wait_fly_as_generated_too():
    code = with_triggers(REACHED)
    specifications = [specification(code, seed) for seed in (100, 101, 102)]

    with ReferenceEngine(code, 1) as engine:
        expected = [engine.evaluate(each) for each in specifications]
    assert flown(EMBEDDED, 2, specifications, code=code) == expected


@pytest.mark.parametrize(("pace", "reset"), [("barrier", SERVICE), ("answer", RESTART)])
def test_pings_and_a_new_start_do_as_well(pace, reset):
    specifications = [specification(REACHED, seed) for seed in (102, 103)]

    assert flown(EMBEDDED, 1, specifications, pace, reset) == in_process(specifications)


def test_at_a_rate_the_node_has_its_time():
    (found,) = flown(EMBEDDED, 1, [()], pace="1000")

    assert found.missed == in_process([()])[0].missed


def test_what_does_not_reach_the_node_is_refused_before_the_flight():
    with pytest.raises(
        SpecificationError, match="fault 'f9' cannot be injected: it affects o5 obstacle, and no"
    ):
        flown(EMBEDDED, 1, [(TimedFault("f9", 1, 2, (0.0, 0.0, 0.0)),)], code=CODE)
