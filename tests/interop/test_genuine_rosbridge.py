"""Our server's answers, held against those that a genuine rosbridge server of ROS 1 gave.

``MRSFI_GENUINE_ANSWERS`` names the file in which they were recorded; the program that asked stands
beside it as ``probe.py``.
"""

import ast
import json
import os
import re
import sys
from pathlib import Path
from time import sleep
from typing import Any

import pytest
from websockets.sync.client import ClientConnection, connect

from mrsfi_bridge.embedded import EmbeddedBridge
from tests.support.bridge import png_text
from tests.support.missing import skip
from tests.support.tree import ROOT

RECORDED = os.environ.get("MRSFI_GENUINE_ANSWERS", "")
N_RECORDED = 230
"""Letters of an answer that are recorded at most."""

N_SAME = 57
OWN_TOPICS = ("/rosout_agg", "/rosout", "/client_count", "/connected_clients")
VOLATILE = (
    r'(?<="secs":)\d{10},"nsecs":\d+|(?<=service_request:)[^"]*(","[a-z]*$)?|(?<=dsecs).*(?=ebytes)'
)
"""Times, and numbers of calls."""

KNOWN = {
    "set_level info then bad op": "who asks for a level is told of all that is as bad",
    "fragment_size 20": "a whole number of fragments, of an id that is text, as the protocol says",
    "latched late sub": "a latched message is told once",
    "get_param": "a parameter is kept as the text that it was set to",
    "get_param args list": "the same",
    "bad args": "our words",
    "node_details": "the server itself is node /rosapi",
    "nodes": "the same; there is no other",
    "services": "those of other nodes are not there",
    "provider died mid call": "the caller is told, at once",
    "ros2 style type name": "names of ROS 2 are understood",
}
"""Probes that are answered otherwise on purpose, and why."""

Answers = dict[str, list[list[str]]]
"""What came back, told in one way: by probe, as often as that was made."""


class Asked:
    """What the program does its work with, in place of its own waiting by the clock."""

    def __init__(self, url: str) -> None:
        self.said: list[str] = []
        self._url = url

    def say(self, *words: Any, **_: Any) -> None:
        """Take what it prints."""
        self.said.append(" ".join(map(str, words)))

    def case(self, name: str, *messages: Any, t: float = 0.0, pre: tuple[Any, ...] = ()) -> None:
        """Send messages, and print what comes back; ``t`` is given where it takes time."""
        with connect(self._url, max_size=None, compression=None) as client:
            _send(client, *pre)
            self.drain(client)
            for message in messages:
                _send(client, message)
                sleep(t / 75)
            sleep(t / 3)
            self.say(f"{name} -> {self.drain(client) or 'nothing'}")

    def drain(self, client: ClientConnection, t: float = 0.0) -> list[str]:
        """Return what comes before the answer to a last call, but wait for something first."""
        told = [client.recv(timeout=t)] if t else []
        _send(client, {"op": "call_service", "service": "/rosapi/get_time", "id": "the end"})
        while "the end" not in str(found := client.recv(timeout=10.0)):
            told.append(found)
        return [
            one if isinstance(one, str) else f"BIN:{len(one)}:{_shown(one[:60])}" for one in told
        ]


def _shown(content: bytes) -> str:
    """Return bytes in single quotes, whichever quotes are among them."""
    return "b'" + repr(b'"' + content).removeprefix("b'\"")


def _send(client: ClientConnection, *messages: Any) -> None:
    for message in messages:
        client.send(message if isinstance(message, str | bytes) else json.dumps(message))


def ours(probe: Path) -> Answers:
    """Return what our server answers to the program that probed the genuine one."""
    tree = ast.parse(probe.read_text(encoding="utf-8"))
    tree.body = [part for part in tree.body if getattr(part, "name", "") not in {"case", "drain"}]
    with EmbeddedBridge() as server, pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [probe.name, server.url])
        asked = Asked(server.url)
        names = {"case": asked.case, "drain": asked.drain, "print": asked.say}
        exec(compile(tree, probe, "exec"), names)
    return told_in_one_way(asked.said)


def told_in_one_way(lines: list[str]) -> Answers:
    """Return the answers that lines tell, without what differs from run to run."""
    answers: Answers = {}
    for line in lines:
        name, arrow, answer = line.partition(" -> ")
        if not arrow:
            name, brace, rest = line.partition("{")
            answer = brace + rest
        found = ast.literal_eval(answer) if answer.startswith("[") else [answer]
        lasting = _lasting(name.strip(), [_as_recorded(each) for each in found])
        answers.setdefault(name.strip(), []).append(lasting)
    return answers


def _as_recorded(answer: str) -> str:
    """Return an answer as the genuine server orders its fields, cut as the record is."""
    try:
        fields = json.loads(answer)
    except ValueError:
        return answer  # cut there, or no text
    if fields["op"] == "png":
        fields["data"] = json.loads(png_text(fields["data"]))
    last = [name for name in ("values", "result", "id") if fields["op"] == "service_response"]
    in_order = {name: fields.pop(name) for name in last if name in fields}
    told = json.dumps({**fields, **in_order}, separators=(",", ":")).replace("/", "\\/")
    return told[:N_RECORDED]


def _lasting(name: str, answers: list[str]) -> list[str]:
    """Return what the clock, and what was asked before, do not decide."""
    if "throttle 200" in name:
        return [answers[0], answers[-1] if name.endswith("q2") else ""]
    if name == "topics no id":
        return [topic for topic in OWN_TOPICS if topic.replace("/", "\\/") in answers[0]]
    return [re.sub(VOLATILE, "…", answer) for answer in answers]


@pytest.fixture(scope="module")
def answers() -> tuple[Answers, Answers]:
    """Return our answers and those recorded."""
    if not RECORDED:
        skip("MRSFI_GENUINE_ANSWERS is not set")
    record = ROOT / RECORDED
    lines = record.read_text(encoding="utf-8").splitlines()
    recorded = told_in_one_way([line for line in lines if not line.startswith("  ")])
    return ours(record.with_name("probe.py")), recorded


def test_our_server_answers_as_the_genuine_one(answers):
    told, recorded = answers
    same = sorted(recorded.keys() - KNOWN.keys())

    assert {name: told[name] for name in same} == {name: recorded[name] for name in same}
    assert len(same) == N_SAME
    assert told.keys() == recorded.keys()


def test_what_it_answers_otherwise_is_known(answers):
    told, recorded = answers

    assert [name for name in KNOWN if told[name] == recorded[name]] == []
