"""Nodes that flood, lie, hang or die: each its sentence and exit code, and nothing left running."""

import re
import shlex
import shutil
import signal
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from mrsfi.engines import chosen
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import TransportTimeout
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record import engine_settings
from mrsfi_runtime.record.engine_settings import RESTART, SERVICE
from tests.integration.network import bridge
from tests.support.cli import mrsfi_process
from tests.support.nodes import MISSION, processes_in, require_silence, yard
from tests.support.rosbridge import process
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


def test_a_new_node_is_reset_when_it_has_subscribed(place):
    words = ("simulate", MISSION, "--side", "injector", "--node", command_of("listens late"))

    mrsfi_process(*words, "--node-reset", SERVICE, cwd=place)

    assert processes_in(place) == {}


@slow
def test_a_node_that_does_not_want_to_end_is_ended(place):
    words = ("simulate", MISSION, "--side", "injector", "--node", command_of("clings to life"))

    mrsfi_process(*words, cwd=place)

    assert processes_in(place) == {}


ANSWER = """
answer = { topic = "/husky1/cmd_vel", type = "geometry_msgs/Twist" }
types = ["interfaces"]
"""
"""More of the table of a node whose commands are its answers."""


@contextmanager
def with_a_world(place, folder, kind="nav_msgs/Odometry"):
    """Yield options to fly with a node and a world on one server, the server and the world.

    ``kind`` is the type of the odometry.
    """
    shutil.copytree(place, folder, dirs_exist_ok=True)
    table = (folder / "mrsfi.toml").read_text(encoding="utf-8") + ANSWER
    if kind not in table:
        table = re.sub(r'"nav_msgs/Odometry"\nfields = .*', f'"{kind}"\nfields.x = "x"', table)
    (folder / "mrsfi.toml").write_text(table, encoding="utf-8")
    types = folder / "interfaces" / "yard_msgs" / "msg"
    types.mkdir(parents=True)
    (types / "Odometry.msg").write_text("float64 x\n", encoding="utf-8")
    with bridge() as server:
        meet = ("--url", server.url, "--world-prefix", "/world", "--timeout", "1")
        side = ("--engine", "rosbridge", "--side", "simulation")
        with process("simulate", MISSION, *side, *meet, cwd=folder) as world:
            assert "serves at" in world.stderr.readline()
            yield meet, server, world


def flown_with(what, folder, code, *options):
    """Return what is said of a flight with a bad node, which ends with an exit code."""
    words = ("simulate", MISSION, "--side", "injector", "--node", command_of(what))
    return mrsfi_process(*words, *options, cwd=folder, expected=code).stderr


@slow
def test_after_a_silent_node_the_simulation_at_its_server_serves_the_next(place, tmp_path):
    with with_a_world(place, tmp_path) as (meet, _, world):
        told = flown_with("hangs", tmp_path, 6, *meet)
        flown_with("does nothing wrong", tmp_path, 0, *meet)
        world.send_signal(signal.SIGINT)
        _, said = world.communicate(timeout=20)

    require_silence(tmp_path)
    assert "the node was silent for 1 s; expected a message on /husky1/cmd_vel" in told
    assert said == "mrsfi: interrupted\n"  # each flight told it to stop


@slow
def test_silence_because_a_server_refuses_a_type_points_to_its_log(place, tmp_path):
    with with_a_world(place, tmp_path, "yard_msgs/Odometry") as (meet, server, _):
        told = flown_with("does nothing wrong", tmp_path, 6, *meet)
        server.log.seek(0)
        log = server.log.read()

    silent = ", ".join(f"/husky{number}/cmd_vel" for number in (1, 2, 3))
    hint = "the server may have refused the type of a topic or service: see its log"
    assert "tick 0: the node was silent for 1 s; " in told
    assert f"nothing arrived on {silent}, {hint}" in told
    assert "unknown message type 'yard_msgs/Odometry'" in log
