"""The page says what was recorded, and nothing of a model becomes markup or script."""

import json
import re
import zlib
from base64 import b64decode, b64encode
from hashlib import sha256
from html.parser import HTMLParser

import numpy as np
import pytest

from mrsfi_runtime.analysis.page import PageEntry, document, flight_page, meanings
from mrsfi_runtime.analysis.story import (
    MOST_VALUES,
    Flown,
    flight_content,
    mission_content,
    runs,
    stride,
)
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import numbered
from mrsfi_runtime.record.observers import named_faults
from tests.support.world import code_of, paper_code, specifications

SEED = 3
HOSTILE = [
    "</script><script>alert(1)</script>",
    "<!-- <script>",
    "<img src=x onerror=alert(1)>",
    "'\"`${alert(1)}\\u003c",
    "\u202egnp.exe\u2066",
    "\u2028\u2029\x00\ufeff",
    "x" * 10_000,
]


class Elements(HTMLParser):
    """Names of the elements of a page, and the text of those that hold scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.texts = {}
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.cdata_elem:
            tag, attributes = self.found[-1]
            place = tag, attributes.get("type")
            self.texts[place] = self.texts.get(place, "") + data


def unpacked(text, n, step):
    """Return numbers as the page's script reads them."""
    planes = np.frombuffer(zlib.decompress(b64decode(text)), np.uint8).reshape(4, -1)
    differences = np.ascontiguousarray(planes.T).view("<i4").reshape(-1, n)
    return np.cumsum(differences, axis=0) * step


@pytest.fixture(scope="module")
def flown():
    """A flight of the paper's mission, its code and its faults."""
    code = paper_code(300)
    (specification,) = specifications(code, 1)
    names = numbered(timed.fault for timed in specification)
    faults = named_faults(code.mission, code.pool, specification, names)
    engine = ReferenceEngine(code, SEED)
    return code, faults, engine.record(specification), engine.evaluate(specification)


@pytest.mark.parametrize("kept", [1, 7])
def test_what_the_page_holds_of_a_flight_is_the_flight_to_what_it_says(flown, kept):
    code, faults, recording, _ = flown

    content = flight_content(code.mission, Flown("", faults, recording, {}), kept)

    (flight,) = content["flights"]
    n_ticks, n = code.mission.duration, len(code.mission.robots)
    ticks = [*range(0, n_ticks, kept)]
    ticks += [n_ticks - 1] if ticks[-1] != n_ticks - 1 else []
    for name in ("x", "y", "speed", "energy"):
        step = flight["steps"][name]
        true = unpacked(flight["packed"][name], n, step)
        believed = true + unpacked(flight["packed"][f"believed_{name}"], n, step)
        for side, found in (("world", true), ("belief", believed)):
            assert found.shape == (len(ticks), n)
            assert np.abs(found - recording[side]["robots"][name][ticks]).max() <= step / 2 * 1.001
    for k, judged in enumerate(flight["goals"]):
        for kind in ("believed", "true"):
            n_violated = sum(last - first + 1 for first, last in judged[kind])
            assert n_violated == recording[kind][-1, k]
    for name in ("x", "y"):
        assert f"positions to within {flight['steps'][name] / 2:g}" in content["said"]


def test_events_say_when_faults_and_violations_begin_and_end(flown):
    code, faults, recording, _ = flown

    events = flight_content(code.mission, Flown("", faults, recording, {}), 1)["events"]

    assert events == sorted(events, key=lambda event: event[0])
    for fault in (each for each in faults if each.window is not None):
        words = f"{fault.name} ({fault.fault.type} on {fault.target})"
        assert {(fault.window[0], f"{words} starts"), (fault.window[1], f"{words} ends")} <= {
            *events
        }
    for k, goal in enumerate(code.mission.goals):
        for first, last in runs(recording["is_true"][:, k]):
            assert (first, f"{goal.id} truly violated") in events
            is_over = (last + 1, f"{goal.id} no longer truly violated") in events
            assert is_over is (last + 1 < code.mission.duration)


@pytest.mark.parametrize(
    ("flags", "expected"),
    [([], []), ([0, 0], []), ([1], [(0, 0)]), ([1, 1, 0, 1], [(0, 1), (3, 3)])],
)
def test_windows_are_where_flags_are_set(flags, expected):
    assert runs(np.array(flags)) == expected


def test_a_page_of_many_ticks_leaves_ticks_out():
    mission = code_of("tight_margins").mission
    n_values = mission.duration * len(mission.robots) * 8

    assert stride(mission, 1) == 1
    assert stride(mission, MOST_VALUES // n_values) == 1
    assert stride(mission, 3 * MOST_VALUES // n_values) in {3, 4}


def test_a_page_has_one_script_and_one_style_of_its_own_and_asks_for_nothing(flown):
    code, faults, recording, outcome = flown
    told = PageEntry("one", faults, ["did it"] * len(faults), outcome, ["mrsfi"], "<xmi/>")

    page = Elements(document(flight_page(code.mission, told, recording, [("seed", SEED)])))

    (policy,) = (
        each["content"] for _, each in page.found if "Policy" in each.get("http-equiv", "")
    )
    texts = (page.texts[kind, None] for kind in ("script", "style"))
    hashes = [b64encode(sha256(text.encode()).digest()).decode() for text in texts]
    assert policy == (
        f"default-src 'none'; script-src 'sha256-{hashes[0]}'; style-src 'sha256-{hashes[1]}'; "
        "base-uri 'none'; form-action 'none'"
    )
    assert not [each for each in page.found if {"src", "href", "style"} & {*each[1]}]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_no_text_ends_the_element_that_holds_it(text):
    content = {
        "title": text,
        "mission": mission_content(paper_code(3).mission),
        "record": [[text] * 2],
    }

    page = Elements(document(content))

    kinds = [tag for tag, _ in page.found]
    assert kinds == [
        "html",
        "head",
        *["meta"] * 4,
        "title",
        "style",
        "body",
        "noscript",
        *["script"] * 2,
    ]
    data = page.texts["script", "application/json"]
    assert json.loads(data) == content | {"terms": meanings()}
    assert not re.search("[<>&\u2028\u2029]", data)
