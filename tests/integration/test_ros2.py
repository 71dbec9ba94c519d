"""Native ROS 2: a node in a process of its own on DDS, without a server and without ROS."""

import os
import shlex
import signal
import sys
from contextlib import closing

import pytest

from mrsfi_bridge.settings import TypeTable
from mrsfi_runtime.cosimulation.bus_lockstep import SimulationHost
from mrsfi_runtime.cosimulation.bus_topics import Patience
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import (
    EvaluationError,
    ProtocolError,
    TransportError,
    TransportTimeout,
)
from mrsfi_runtime.record.engine_settings import RESTART, SERVICE, EngineSettings
from mrsfi_runtime.transport.ros2 import Ros2Transport, domain_of
from mrsfi_runtime.transport.topics import PrefixedTransport
from tests.integration.test_injector import REACHED, flown, in_process
from tests.support.world import specification
from tests.tiers import slow

SPECIFICATIONS = [specification(REACHED, seed) for seed in range(100, 120)]


def node(what=""):
    """Return the command of the node of the tests; ``what`` is something that it does wrong."""
    words = [sys.executable, "-m", "tests.support.ros2_node", str(REACHED.directory)]
    return f"{shlex.join(words)} {{domain}} {{seed}} {shlex.quote(what) if what else ''}"


def engine(pace="barrier", reset=SERVICE, what="", **options):
    settings = {"side": "injector", "timeout": 10.0, "node_pace": pace, "node_reset": reset}
    given = EngineSettings("ros2", node=node(what), **{**settings, **options})
    return open_engine(given, REACHED, 1)


@pytest.mark.parametrize(
    ("pace", "reset"),
    [("barrier", SERVICE), ("answer", RESTART), pytest.param("barrier", RESTART, marks=slow)],
)
def test_a_node_that_reacts_as_generated_flies_as_generated(pace, reset):
    with engine(pace, reset) as opened:
        found = [opened.evaluate(each) for each in SPECIFICATIONS[:2]]

    assert found == in_process(SPECIFICATIONS[:2])


@slow
def test_twenty_specifications_fly_as_generated_and_as_over_rosbridge():
    expected = in_process(SPECIFICATIONS)
    for pace in ("barrier", "answer"):
        with engine(pace) as opened:
            assert [opened.evaluate(each) for each in SPECIFICATIONS] == expected
    assert flown("our world inside", 2, SPECIFICATIONS, "barrier") == expected


def test_at_a_rate_the_node_has_its_time():
    with engine("500") as opened:
        found = opened.evaluate(())

    assert found.missed == in_process([()])[0].missed


@slow
def test_an_external_simulation_of_the_same_domain_flies_as_ours():
    with engine(domain=101, world_prefix="/world") as opened:
        domain = domain_of(101, opened._opened)
        with closing(Ros2Transport(domain, TypeTable(ros=2), {})) as there:
            transport = PrefixedTransport(there, "/world")
            SimulationHost(transport, REACHED.simulation, REACHED.mission, Patience())
            found = [opened.evaluate(each) for each in SPECIFICATIONS[:2]]

    assert found == in_process(SPECIFICATIONS[:2])


@slow
def test_a_node_that_is_killed_is_started_anew():
    with engine() as opened:
        first = opened.evaluate(SPECIFICATIONS[0])
        os.kill(opened._process.pid, signal.SIGKILL)
        again = opened.evaluate(SPECIFICATIONS[0])

    assert [first, again] == in_process([SPECIFICATIONS[0]] * 2)


BEFORE = "run 1, before tick 0: the node "


@pytest.mark.parametrize(
    ("what", "kind", "said"),
    [
        (
            "has another type",
            ProtocolError,
            (
                f"{BEFORE}subscribes to /r1/speed with type std_msgs/msg/Float32; expected "
                "std_msgs/msg/Float64, as in [node]"
            ),
        ),
        (
            "wants more",
            ProtocolError,
            (
                f"{BEFORE}subscribes to /r1/speed with durability transient_local, which does "
                "not meet volatile; expected qos = { durability = 'transient_local' } for this "
                "topic in [node]"
            ),
        ),
        (
            "has no parameters",
            ProtocolError,
            (
                f"{BEFORE}has no parameter service; expected one of rclpy or rclcpp, whose "
                "services were not switched off, or --node-pace answer or a rate"
            ),
        ),
        (
            "is silent",
            TransportTimeout,
            (
                f"{BEFORE}was silent for 2 s before tick 0; expected answers to calls of its "
                "parameter service; check that it still runs, or increase --timeout"
            ),
        ),
        (
            "commands late",
            ProtocolError,
            ": a command came after the node had answered tick ",
        ),
    ],
)
def test_a_node_that_cannot_be_flown_is_told_with_exit_code_8(what, kind, said):
    with engine(what=what, timeout=2.0) as opened, pytest.raises(kind) as told:
        opened.evaluate(())

    assert said in str(told.value)
    assert told.value.exit_code == 8


@pytest.mark.parametrize(
    ("does", "said"),
    [
        ("input()", "run 1, before tick 0: the node ended: exit code 1"),
        pytest.param(
            '__import__("time").sleep(60)',
            "names or the domain may differ: compare `ros2 node",
            marks=slow,
        ),
    ],
)
def test_a_node_that_does_not_come_is_told(does, said):
    settings = {"side": "injector", "timeout": 1.0, "node_reset": RESTART}
    absent = EngineSettings("ros2", node=f"{sys.executable} -c '{does}' {{domain}}", **settings)
    with open_engine(absent, REACHED, 1) as opened, pytest.raises(TransportError) as told:
        opened.evaluate(())

    assert said in str(told.value)


@slow
def test_a_node_that_dies_twice_is_an_error_of_the_flight():
    with engine(what="dies", reset=RESTART) as opened, pytest.raises(EvaluationError) as told:
        opened.evaluate(())

    assert "the node ended: exit code 3" in str(told.value)
