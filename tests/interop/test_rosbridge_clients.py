"""``mrsfi bridge`` against clients that others wrote: roslibpy's own test suite, and roslib."""

import json
import os
import shutil
import socket
import subprocess
import sys
import tarfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from mrsfi_runtime.transport.server_address import CLIENTS
from tests.support.cli import command_line, require_program
from tests.support.missing import skip

_CLIENTS = Path(__file__).parent / "clients"
_USUAL_PORT = 9090
_TIMEOUT_S = 300


@contextmanager
def bridge(folder: Path, port: int) -> Iterator[str]:
    """Run ``mrsfi bridge`` and yield its URL; its log must have no traceback."""
    log = folder / "bridge.log"
    with (
        log.open("w", encoding="utf-8") as file,
        subprocess.Popen(
            command_line("bridge", "--port", port),
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
def test_roslibpys_own_suite_passes(suite, tmp_path, note, transport):
    report = tmp_path / "report.xml"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist"]
    command += ["tests/ros1", "tests/test_ws_headers.py", "tests/test_transport.py"]
    command += ["--deselect", "tests/ros1/test_tf.py", f"--junitxml={report}"]
    variables = {"ROSLIBPY_TRANSPORT": transport}
    if transport == "wire":
        command += ["-p", "wire_plugin"]
        variables = {"ROSLIBPY_TRANSPORT": "asyncio", "PYTHONPATH": str(_CLIENTS)}
    with bridge(tmp_path, free_port()):
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
    assert n_passed >= 29
    note(f"roslibpy's own suite, {transport}", passed=n_passed, skipped=n_skipped)


@pytest.fixture(scope="module")
def roslib(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return what roslib, the JavaScript client, reports of its steps against a bridge."""
    node, npm = require_program("node"), require_program("npm")
    folder = tmp_path_factory.mktemp("roslib")
    for path in _CLIENTS.glob("*.*"):
        shutil.copy(path, folder)
    command = [npm, "ci", "--no-audit", "--no-fund", "--ignore-scripts"]
    installed = subprocess.run(
        command, cwd=folder, capture_output=True, encoding="utf-8", timeout=_TIMEOUT_S, check=False
    )
    if installed.returncode:
        skip(f"cannot install roslib: {installed.stderr.strip()[-300:]}")
    with bridge(folder, 0) as url:
        done = subprocess.run(
            [node, "roslib_client.mjs", url],
            cwd=folder,
            capture_output=True,
            encoding="utf-8",
            timeout=_TIMEOUT_S,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def test_roslib_finishes_every_step(roslib, note):
    broken = {name: step for name, step in roslib.items() if "broken" in str(step)}

    assert broken == {}
    note("roslib on Node", steps=len(roslib))


def test_roslib_receives_what_it_publishes_in_order_until_it_unsubscribes(roslib):
    assert roslib["topics"] == {"numbers": list(range(200)), "late": 0}


def test_roslib_receives_latched_and_compressed_messages(roslib):
    assert roslib["latched"] == {"x": 1.5, "y": 0, "z": 0}
    assert roslib["png"] == 1000
    assert roslib["cbor"] == {
        "name": ["a"],
        "kind": "Float64Array",
        "position": [1, 2.5],
        "stamp": {"secs": 7, "nsecs": 8},
    }


def test_roslib_calls_and_provides_services(roslib):
    services = roslib["services"]

    assert services["sum"] == {"values": {"sum": 42}}
    assert services["later"] == {"values": {"sum": 7}}
    assert services["unknown"] == services["gone"] == {"error": "Service /js/add does not exist"}
    assert services["failed"] == {"error": "the provider reported a failure"}
    assert services["rejected"] == {"error": "Error: on purpose"}
    assert "has no field 'c'" in services["wrong"]["error"]


def test_roslib_keeps_parameters(roslib):
    assert roslib["parameters"] == {
        "missing": None,
        "kept": {"speed": 2.5, "names": ["a", "b"]},
        "names": ["/js/limits/speed", "/js/limits/names"],
        "deleted": None,
    }


def test_roslib_sees_topics_services_types_and_nodes(roslib):
    seen = roslib["introspection"]

    assert {"/rosout", "/js/pose"} <= set(seen["topics"])
    assert {"/rosapi/topics", "/rosapi/get_param"} <= set(seen["services"])
    assert (seen["type"], seen["of_type"]) == ("geometry_msgs/Pose", ["/js/pose"])
    assert seen["service_type"] == "rosapi/Topics"
    assert (seen["request"], seen["response"]) == (["a", "b"], ["sum"])
    assert "/rosbridge_websocket" in seen["nodes"]
    assert seen["publishers"] == ["/rosbridge_websocket"]
    assert seen["decoded"]["orientation"]["w"] == "float64"
    assert seen["raw"] == len(seen["topics"])


def test_an_action_of_roslib_gives_its_result(roslib):
    assert roslib["action"] == {"result": 42}
