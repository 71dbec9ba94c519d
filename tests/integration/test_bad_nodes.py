"""Nodes that flood, lie, hang or die: each its sentence and exit code, and nothing left running."""

import shlex
import sys
from pathlib import Path

import pytest

from mrsfi.engines import chosen
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import TransportTimeout
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record import engine_settings
from mrsfi_runtime.record.engine_settings import RESTART, SERVICE
from tests.support.cli import mrsfi_process
from tests.support.nodes import MISSION, processes_in, require_silence, yard
from tests.support.tree import ROOT
from tests.tiers import seeds, slow

SCRIPT = ROOT / "tests" / "support" / "bad_node.py"
FREE = ("--node-pace", "1000")

OF_THE_NODE = {
    "dies": "the node ended: exit code 1: lost its way",
    "is killed": "the node ended: signal SIGKILL",
    "leaves a child": "the node ended: exit code 3",
    "hangs": "the node was silent for 1 s; expected answers to pings; check that it",
    "leaves": "the node was silent for 1 s; expected answers to pings",
    "floods": "/husky1/cmd_vel: the node sent more than 1000 commands in a tick",
    "says a text": "the server refused a message of the node: field 'linear.x': found 'fast'",
    "says another type": "a message of the node: geometry_msgs/Twist has no field 'data'",
    "says no JSON": "the server refused a message of the node: bad JSON at character 1 of 6: ",
}
"""What is said of a node that goes wrong in mid-flight, and again when it flies once more."""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A copy of the example of nodes."""
    return yard(tmp_path_factory.mktemp("nodes"))


def told_of(command, place, code, *options):
    """Return the one line that is said of a node with which a flight ends with an exit code."""
    words = ("simulate", MISSION, "--side", "injector", "--node", command, "--timeout", "1")
    failed = mrsfi_process(*words, *options, cwd=place, expected=code)
    require_silence(place)
    assert failed.stdout == ""
    return failed.stderr.splitlines()[-1]


def command_of(what):
    """Return what starts a bad node."""
    return f"{sys.executable} {SCRIPT} {shlex.quote(what)} {{url}}"


@pytest.mark.parametrize("what", seeds(OF_THE_NODE, 0, 5))
def test_what_goes_wrong_in_mid_flight_belongs_to_the_specification(what, place):
    assert OF_THE_NODE[what] in told_of(command_of(what), place, 6)


@slow
def test_so_does_leaving_where_nobody_waits(place):
    told = told_of(command_of("leaves"), place, 6, *FREE)

    assert "the node no longer subscribes to /husky1/odom; expected it to stay connected" in told


@slow
def test_what_never_runs_is_no_result(place):
    absent = told_of("no-such-node {url}", place, 8)
    ended = told_of(command_of("ends"), place, 8)

    assert (
        "tick 0: the node did not start: no-such-node: No such file or directory; check --node"
        in absent
    )
    assert "before tick 0: the node ended: exit code 1: has no map" in ended


@slow
@pytest.mark.parametrize(
    ("what", "reset", "said"),
    [
        (
            "is deaf",
            RESTART,
            "the node subscribed to no topic within 2 s; no subscriber to /husky1/b",
        ),
        ("dies", SERVICE, "the node did not reset within 2 s: /patrol/reset: "),
    ],
)
def test_what_never_gets_ready_is_no_result(what, reset, said, place, monkeypatch):
    monkeypatch.chdir(place)
    code = load_code(Path("generated") / MISSION)
    monkeypatch.setattr(engine_settings, "_HANDSHAKE", 2.0)
    given = {"side": "injector", "node": command_of(what), "node_reset": reset, "timeout": 1.0}
    settings = chosen(given)

    with open_engine(settings, code, 1) as engine, pytest.raises(TransportTimeout) as failed:
        engine.evaluate(())

    require_silence(place)
    assert said in str(failed.value)


@slow
def test_a_node_that_does_not_want_to_end_is_ended(place):
    words = ("simulate", MISSION, "--side", "injector", "--node", command_of("clings to life"))

    mrsfi_process(*words, cwd=place)

    assert processes_in(place) == {}
