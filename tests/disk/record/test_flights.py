"""What was flown after a search: kept whole, and refused where it makes no sense."""

import json
import sqlite3
from contextlib import closing
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record.database import COUNTS
from mrsfi_runtime.record.store import CampaignStore, RecordedFlight
from tests.support.campaigns import evaluation, outcome
from tests.tiers import law

FAULTS = (TimedFault("f1", 1, 9, (0.1, 2.0)), TimedFault("f2", 3, 7))
FLOWN = RecordedFlight(7, FAULTS, outcome((5, 0, 9), 2))
FAILED = RecordedFlight(8, (), FailedFlight("Traceback of “this”:\n"))


def damage(store, column, content):
    """Store something else about the first flight."""
    with closing(sqlite3.connect(store.path)) as other, other:
        other.execute(f"UPDATE flight SET {column} = ? WHERE idx = 1", (content,))


def test_flights_are_read_back_in_order(store):
    store.append_flights([FLOWN, FAILED])
    store.append_flights([FLOWN])

    with CampaignStore.open(store.path.parent) as again:
        assert again.flights() == (FLOWN, FAILED, FLOWN)


def test_flights_change_neither_evaluations_nor_digest(store):
    store.append([evaluation(0, (1, 2))])
    before = tuple(store.evaluations()), store.digest()

    store.append_flights([FLOWN])

    assert (tuple(store.evaluations()), store.digest()) == before


@pytest.mark.parametrize(
    ("column", "content"),
    [
        *(
            ("found", text)
            for text in ("", "{", "[]", "[{}]", "[1]", '["a","b"]', None, b"\xff", 7)
        ),
        ("found", json.dumps([asdict(FLOWN.found) | {"more": 1}])),
        ("found", json.dumps([{"digest": ""} | {name: ["1"] for name in COUNTS}])),
        ("specification", "[[1]]"),
        ("specification", None),
    ],
)
def test_what_makes_no_sense_is_damage(store, column, content):
    store.append_flights([FLOWN])
    damage(store, column, content)

    with pytest.raises(RecordError, match="the record is damaged"):
        store.flights()


@given(st.data())
@law(100)
def test_a_text_with_another_character_is_damage_or_still_a_flight(data):
    seed, specification, text = FLOWN.row()
    place = data.draw(st.integers(0, len(text) - 1))
    drawn = data.draw(st.characters(codec="ascii"))

    try:
        found = RecordedFlight.from_row(
            (seed, specification, text[:place] + drawn + text[place + 1 :])
        )
    except (ValueError, TypeError):
        return

    assert RecordedFlight.from_row(found.row()) == found
