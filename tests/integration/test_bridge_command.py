"""``mrsfi bridge`` as a process."""

import json
import os
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from websockets.sync.client import connect

from tests.support.cli import command_line, mrsfi

PATIENCE_S = 30.0


@contextmanager
def running(*arguments: str, cwd: Path) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        command_line("bridge", "--port", "0", *arguments),
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def url_of(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


@pytest.mark.parametrize(("sign", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_it_prints_its_url_serves_and_ends_when_told(tmp_path, sign, code):
    with running(cwd=tmp_path) as process, connect(url_of(process)) as connection:
        connection.send("{")
        connection.send(json.dumps({"op": "call_service", "service": "/rosapi/get_time"}))
        answer = json.loads(connection.recv(PATIENCE_S))
        process.send_signal(sign)
        rest, log = process.communicate(timeout=PATIENCE_S)

    assert answer["result"] is True
    assert process.returncode == code
    assert rest == ""
    assert "ended: 1 clients, 1 operations received, 0 messages sent, 1 dropped" in log
    assert "Traceback" not in log


def test_definitions_of_the_user_are_known(tmp_path):
    folder = tmp_path / "defs" / "my" / "msg"
    folder.mkdir(parents=True)
    (folder / "Depth.msg").write_text("float64 metres\n", encoding="utf-8")

    with running("--types", "defs", cwd=tmp_path) as process, connect(url_of(process)) as peer:
        peer.send(json.dumps({"op": "advertise", "topic": "/d", "type": "my/Depth"}))
        peer.send(json.dumps({"op": "subscribe", "topic": "/d"}))
        peer.send(json.dumps({"op": "publish", "topic": "/d", "msg": {}}))

        assert json.loads(peer.recv(PATIENCE_S))["msg"] == {"metres": 0.0}


def test_a_wrong_definition_ends_it_before_it_listens(tmp_path):
    folder = tmp_path / "defs" / "my" / "msg"
    folder.mkdir(parents=True)
    (folder / "Depth.msg").write_text("float64\n", encoding="utf-8")

    done = mrsfi("bridge", "--types", "defs", cwd=tmp_path, expected=2)

    assert "Depth.msg:1: 'float64', expected 'type name'" in done.stderr
    assert done.stdout == ""


def test_a_port_in_use_ends_it_with_8(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]

        done = mrsfi("bridge", "--port", str(port), cwd=tmp_path, expected=8)

    assert f"127.0.0.1:{port}: cannot listen" in done.stderr


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
def test_wrong_usage_ends_it_with_2(tmp_path, arguments):
    done = mrsfi("bridge", *arguments, cwd=tmp_path, expected=2)

    assert done.stdout == ""


def test_a_public_server_takes_its_token_from_the_environment(tmp_path):
    token = "0123456789abcdef"
    environment = {**os.environ, "MRSFI_BRIDGE_TOKEN": token}
    command = command_line("bridge", "--host", "0.0.0.0", "--public", "--port", "0")
    with subprocess.Popen(
        command,
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
    ) as process:
        try:
            url = url_of(process)
            port = url.rpartition(":")[2]
            with connect(f"ws://127.0.0.1:{port}/?token={token}") as peer:
                peer.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes"}))
                assert json.loads(peer.recv(PATIENCE_S))["result"] is True
        finally:
            process.kill()

    assert url.startswith("ws://0.0.0.0:")
    assert token not in url
