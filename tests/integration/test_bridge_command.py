"""``mrsfi bridge`` and ``python -m mrsfi_bridge`` as processes."""

import json
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from websockets.sync.client import connect

from tests.support.cli import command_line
from tests.support.rosbridge import process

PATIENCE_S = 30.0
TOGETHER = (*command_line("bridge"), "--port", "0")
_ALONE = """
import runpy, sys
sys.modules["mrsfi_runtime"] = sys.modules["m2t"] = None  # importing them is an error
runpy.run_module("mrsfi_bridge", run_name="__main__", alter_sys=True)
"""
ALONE = (sys.executable, "-c", _ALONE, "--port", "0")
BOTH = pytest.mark.parametrize("command", [TOGETHER, ALONE], ids=["mrsfi", "alone"])


def url_of(server: subprocess.Popen[str]) -> str:
    assert server.stdout is not None
    return server.stdout.readline().strip()


@BOTH
@pytest.mark.parametrize(("sign", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_it_prints_its_url_serves_and_ends_when_told(tmp_path, command, sign, code):
    with process(cwd=tmp_path, program=command) as server, connect(url_of(server)) as connection:
        connection.send("{")
        connection.send(json.dumps({"op": "call_service", "service": "/rosapi/get_time"}))
        answer = json.loads(connection.recv(PATIENCE_S))
        server.send_signal(sign)
        rest, log = server.communicate(timeout=PATIENCE_S)

    assert answer["result"] is True
    assert server.returncode == code
    assert rest == ""
    assert "ended: 1 clients, 1 operations received, 0 messages sent, 1 dropped" in log
    assert "Traceback" not in log


@pytest.mark.parametrize(
    ("command", "words", "setting", "seconds"),
    [
        (TOGETHER, (), "", "secs"),
        (TOGETHER, (), "ros = 2", "sec"),
        (TOGETHER, ("--ros", "1"), "ros = 2", "secs"),
        (ALONE, ("--ros", "2"), "", "sec"),
    ],
)
def test_it_is_of_the_ros_of_its_command_line_or_project(
    tmp_path, command, words, setting, seconds
):
    (tmp_path / "mrsfi.toml").write_text(f"[project]\n{setting}\n", encoding="utf-8")

    with (
        process(*words, cwd=tmp_path, program=command) as server,
        connect(url_of(server)) as connection,
    ):
        connection.send(json.dumps({"op": "call_service", "service": "/rosapi/get_time"}))
        answer = json.loads(connection.recv(PATIENCE_S))

    assert seconds in answer["values"]["time"]


def test_definitions_of_the_user_are_known(tmp_path):
    folder = tmp_path / "defs" / "my" / "msg"
    folder.mkdir(parents=True)
    (folder / "Depth.msg").write_text("float64 metres\n", encoding="utf-8")

    words = ("--types", "defs")
    with process(*words, cwd=tmp_path, program=TOGETHER) as server, connect(url_of(server)) as peer:
        peer.send(json.dumps({"op": "advertise", "topic": "/d", "type": "my/Depth"}))
        peer.send(json.dumps({"op": "subscribe", "topic": "/d"}))
        peer.send(json.dumps({"op": "publish", "topic": "/d", "msg": {}}))

        assert json.loads(peer.recv(PATIENCE_S))["msg"] == {"metres": 0.0}


@BOTH
def test_a_port_in_use_ends_it_with_8(tmp_path, command):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]

        done = run(*command, "--port", str(port), cwd=tmp_path)

    assert done.returncode == 8
    assert f"127.0.0.1:{port}: cannot listen" in done.stderr
    assert "Traceback" not in done.stderr


@BOTH
@pytest.mark.parametrize(
    "arguments",
    [
        ("--host", "0.0.0.0"),
        ("--host", "0.0.0.0", "--public"),
        ("--token", "short"),
        ("--max-clients", "0"),
        ("--types", "nowhere"),
    ],
)
def test_wrong_usage_ends_it_with_2(tmp_path, command, arguments):
    done = run(*command, *arguments, cwd=tmp_path)

    assert done.returncode == 2
    assert done.stdout == ""
    assert "Traceback" not in done.stderr


def run(*command: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, cwd=cwd, capture_output=True, encoding="utf-8", timeout=PATIENCE_S, check=False
    )


def test_both_ways_to_run_it_have_the_same_help(tmp_path):
    together, alone = (run(*command, "--help", cwd=tmp_path) for command in (TOGETHER, ALONE))

    assert together.returncode == alone.returncode == 0
    assert "\n    mrsfi bridge --port 0 " in together.stdout
    assert alone.stdout == together.stdout.replace("mrsfi bridge", "python -m mrsfi_bridge")


def test_a_public_server_takes_its_token_from_the_environment(tmp_path):
    token = "0123456789abcdef"
    options = (*TOGETHER, "--host", "0.0.0.0", "--public")

    with process(cwd=tmp_path, program=options, MRSFI_BRIDGE_TOKEN=token) as server:
        url = url_of(server)
        port = url.rpartition(":")[2]
        with connect(f"ws://127.0.0.1:{port}/?token={token}") as peer:
            peer.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes"}))
            assert json.loads(peer.recv(PATIENCE_S))["result"] is True

    assert url.startswith("ws://0.0.0.0:")
    assert token not in url
