"""``mrsfi bridge`` against clients that others wrote: roslibpy's own test suites, and roslib."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tarfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from mrsfi_runtime.transport.topics import CLIENTS
from tests.support.cli import command_line, require_program
from tests.support.missing import skip

_CLIENTS = Path(__file__).parent / "clients"
_USUAL_PORT = 9090
_TIMEOUT_S = 300


class Suite(NamedTuple):
    """What roslibpy tests against a server of one version of ROS.

    ``ends`` are the goals that it sets our action server, by order, and how each must end.
    """

    arguments: tuple[str, ...]
    n_passed: int
    ends: dict[int, int]


_SUITES = {
    1: Suite(
        (
            *("tests/ros1", "tests/test_transport.py"),
            *("--deselect", "tests/ros1/test_tf.py"),
        ),
        28,
        {},
    ),
    2: Suite(("tests/ros2",), 25, {4: 4, 10: 5}),
}


@pytest.fixture(scope="module", params=(1, 2), ids=("ros1", "ros2"))
def ros(request: pytest.FixtureRequest) -> int:
    """Return a version of ROS."""
    version: int = request.param
    return version


def only(version: int) -> pytest.MarkDecorator:
    """Have a test take one version of ROS only."""
    return pytest.mark.parametrize(
        "ros", [version], ids=[f"ros{version}"], indirect=True, scope="module"
    )


@contextmanager
def bridge(folder: Path, port: int, ros: int) -> Iterator[str]:
    """Run ``mrsfi bridge`` and yield its URL; its log must have no traceback."""
    log = folder / "bridge.log"
    with (
        log.open("w", encoding="utf-8") as file,
        subprocess.Popen(
            command_line("bridge", "--port", port, "--ros", ros),
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=file,
            encoding="utf-8",
        ) as process,
    ):
        try:
            assert process.stdout is not None
            yield process.stdout.readline().strip()
        finally:
            process.terminate()
            code = process.wait(timeout=30)
    text = log.read_text(encoding="utf-8")
    assert code == 0, text
    assert "Traceback" not in text


@contextmanager
def fibonacci(url: str) -> Iterator[list[dict[str, int]]]:
    """Run our action server; once it has ended, the list has what it did with each of its goals."""
    with subprocess.Popen(
        [sys.executable, _CLIENTS / "fibonacci.py", url],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        goals: list[dict[str, int]] = []
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "advertised\n"
            yield goals
        finally:
            process.terminate()
            output, errors = process.communicate(timeout=30)
    assert (process.returncode, errors) == (-signal.SIGTERM, "")
    goals += map(json.loads, output.splitlines())


@cache
def free_port() -> int:
    """Return the port that the suite expects, or another if it is taken."""
    for port in (_USUAL_PORT, 0):
        try:
            with socket.create_server(("127.0.0.1", port)) as server:
                return server.getsockname()[1]
        except OSError:
            continue
    raise AssertionError("no free port")


@pytest.fixture(scope="module")
def suite(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return roslibpy's source distribution, with the port replaced only if it is taken."""
    folder = tmp_path_factory.mktemp("roslibpy")
    wanted = f"roslibpy=={version('roslibpy')}"
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    command += ["--no-binary", ":all:", "--dest", str(folder), wanted]
    done = subprocess.run(
        command, capture_output=True, encoding="utf-8", timeout=_TIMEOUT_S, check=False
    )
    if done.returncode:
        skip(f"cannot download {wanted}: {done.stderr.strip()[-300:]}")
    (archive,) = folder.glob("*.tar.gz")
    with tarfile.open(archive) as content:
        content.extractall(folder, filter="data")
    tests = next(folder.glob("roslibpy-*/tests"))
    if free_port() != _USUAL_PORT:
        for path in tests.rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            path.write_text(text.replace(str(_USUAL_PORT), str(free_port())), encoding="utf-8")
    return tests


@pytest.mark.parametrize("transport", CLIENTS)
def test_roslibpys_own_suite_passes(suite, tmp_path, note, transport, ros):
    arguments, n_expected, ends = _SUITES[ros]
    report = tmp_path / "report.xml"
    command = [sys.executable, "-m", "pytest", "-qs", "-p", "no:cacheprovider", "-p", "no:xdist"]
    command += [*arguments, f"--junitxml={report}", "-p", "exit_plugin"]
    variables = {"ROSLIBPY_TRANSPORT": transport, "PYTHONPATH": str(_CLIENTS)}
    if transport == "wire":
        command += ["-p", "wire_plugin"]
        variables["ROSLIBPY_TRANSPORT"] = "asyncio"
    with (
        bridge(tmp_path, free_port(), ros) as url,
        fibonacci(url) if ends else nullcontext([]) as goals,
    ):
        done = subprocess.run(
            command,
            cwd=suite.parent,
            env={**os.environ, **variables},
            capture_output=True,
            encoding="utf-8",
            timeout=_TIMEOUT_S,
            check=False,
        )

    assert done.returncode == 0, done.stdout + done.stderr
    totals = next(ET.parse(report).iter("testsuite")).attrib
    n_skipped = int(totals["skipped"])
    n_passed = int(totals["tests"]) - n_skipped
    assert n_passed >= n_expected
    assert {goal["order"]: goal["status"] for goal in goals} == ends
    assert done.stdout.count("Feedback: ") == sum(goal["n_feedback"] for goal in goals)
    note(f"roslibpy's own suite, ROS {ros}, {transport}", passed=n_passed, skipped=n_skipped)


@pytest.fixture(scope="module")
def node_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with roslib, the JavaScript client, and our program."""
    require_program("node")
    npm = require_program("npm")
    folder = tmp_path_factory.mktemp("roslib")
    for path in _CLIENTS.glob("*.*"):
        shutil.copy(path, folder)
    command = [npm, "ci", "--no-audit", "--no-fund", "--ignore-scripts"]
    installed = subprocess.run(
        command, cwd=folder, capture_output=True, encoding="utf-8", timeout=_TIMEOUT_S, check=False
    )
    if installed.returncode:
        skip(f"cannot install roslib: {installed.stderr.strip()[-300:]}")
    return folder


@pytest.fixture(scope="module")
def roslib(node_folder: Path, ros: int, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return what roslib reports of its steps against a bridge."""
    with bridge(tmp_path_factory.mktemp("bridge"), 0, ros) as url:
        done = subprocess.run(
            [require_program("node"), "roslib_client.mjs", url, str(ros)],
            cwd=node_folder,
            capture_output=True,
            encoding="utf-8",
            timeout=_TIMEOUT_S,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def test_roslib_finishes_every_step(roslib, note, ros):
    broken = {name: step for name, step in roslib.items() if "broken" in str(step)}

    assert broken == {}
    note(f"roslib on Node, ROS {ros}", steps=len(roslib))


def test_roslib_receives_what_it_publishes_in_order_until_it_unsubscribes(roslib):
    assert roslib["topics"] == {"numbers": list(range(200)), "late": 0}


def test_roslib_receives_latched_and_compressed_messages(roslib, ros):
    assert roslib["latched"] == {"x": 1.5, "y": 0, "z": 0}
    assert roslib["png"] == 1000
    assert roslib["cbor"] == {
        "name": ["a"],
        "kind": "Float64Array",
        "position": [1, 2.5],
        "stamp": {"secs": 7, "nsecs": 8} if ros == 1 else {"sec": 7, "nanosec": 8},
    }


def test_headers_are_numbered_in_ros_1_and_a_message_with_a_number_is_dropped_by_ros_2(roslib, ros):
    stamp = {"secs": 7, "nsecs": 8}
    numbered = [
        [1, {"seq": 1, "stamp": stamp, "frame_id": ""}],
        [2, {"seq": 2, "stamp": stamp, "frame_id": "map"}],
    ]
    plain = [[2, {"stamp": {"sec": 7, "nanosec": 8}, "frame_id": "map"}]]

    assert roslib["headers"] == (numbered if ros == 1 else plain)


def test_roslib_calls_and_provides_services(roslib):
    services = roslib["services"]

    assert services["sum"] == {"values": {"sum": 42}}
    assert services["later"] == {"values": {"sum": 7}}
    assert services["unknown"] == services["gone"] == {"error": "Service /js/add does not exist"}
    assert services["failed"] == {"error": "the provider reported a failure"}
    assert services["rejected"] == {"error": "Error: on purpose"}
    assert "has no field 'c'" in services["wrong"]["error"]


def test_roslib_keeps_parameters_which_are_trees_in_ros_1_and_of_a_node_in_ros_2(roslib, ros):
    ros_1 = {
        "missing": None,
        "kept": {"speed": 2.5, "names": ["a", "b"]},
        "names": ["/js/limits/speed", "/js/limits/names"],
        "deleted": None,
    }
    ros_2 = {"missing": "", "kept": [2.5, 3], "names": ["/js:limits"], "deleted": ""}

    assert roslib["parameters"] == (ros_1 if ros == 1 else ros_2)


def test_roslib_sees_topics_services_and_nodes(roslib):
    seen = roslib["introspection"]

    assert {"/rosout", "/js/pose"} <= set(seen["topics"])
    assert {"/rosapi/topics", "/rosapi/get_param"} <= set(seen["services"])
    assert seen["of_type"] == ["/js/pose"]
    assert (seen["request"], seen["response"]) == (["a", "b"], ["sum"])
    assert "/rosbridge_websocket" in seen["nodes"]
    assert seen["publishers"] == ["/rosbridge_websocket"]
    assert seen["decoded"]["orientation"]["w"] == "float64"
    assert seen["raw"] == len(seen["topics"])


def test_roslib_reads_names_of_types_in_two_parts_in_ros_1_and_in_three_in_ros_2(roslib, ros):
    seen = roslib["introspection"]

    assert (seen["type"], seen["of_short_type"], seen["service_type"]) == {
        1: ("geometry_msgs/Pose", ["/js/pose"], "rosapi/Topics"),
        2: ("geometry_msgs/msg/Pose", [], "rosapi_msgs/srv/Topics"),
    }[ros]


@only(1)
def test_an_action_of_roslib_gives_its_result(roslib):
    assert roslib["action"] == {"result": 42}


@only(2)
def test_actions_of_roslib_give_feedback_and_a_result(roslib):
    actions = roslib["actions"]

    assert actions["counted"] == [
        {"result": {"sequence": [3, 3]}, "feedback": [[3]]},
        {"result": {"sequence": [4, 4]}, "feedback": [[4]]},
    ]
    assert (actions["servers"], actions["servers_left"]) == (["/js/count"], [])


@only(2)
def test_a_provider_of_roslib_ends_a_goal_that_is_cancelled(roslib):
    actions = roslib["actions"]

    assert actions["given_up"] == {
        "error": 'GoalError: Action was canceled: {"sequence":[5]}',
        "feedback": [[5]],
    }
    assert actions["all_given_up"] == [
        {**actions["given_up"], "feedback": [[8]]},
        {**actions["given_up"], "feedback": [[9]]},
    ]
    assert actions["n_cancelled"] == 3


@only(2)
def test_roslib_is_told_of_every_goal_that_fails(roslib):
    no_field = "action /js/count: example_interfaces/Fibonacci{} has no field '{}', only {}"
    expected = {
        "unknown": ("Action /js/count does not exist", []),
        "failed": ('{"sequence":[]}', [[-1]]),
        "vague": ('{"sequence":[2]}', [[-2]]),
        "wrong": (f"request of {no_field.format('Goal', 'orders', 'order')}", []),
        "misfit": (f"result of {no_field.format('Result', 'numbers', 'sequence')}", [[0]]),
        "unadvertised": ("Action /js/count: its provider gave it up", [[6]]),
        "gone": ("Action /js/count does not exist", []),
        "left": ("Action /js/count: its provider left", [[7]]),
    }

    assert {name: roslib["actions"][name] for name in expected} == {
        name: {"error": f"GoalError: Action was aborted: {told}", "feedback": feedback}
        for name, (told, feedback) in expected.items()
    }
