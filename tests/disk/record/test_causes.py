"""What a campaign finds out about causes: kept whole, and refused where it makes no sense."""

import json
import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.causes import RecordedCause
from mrsfi_runtime.record.encoding import COUNTS
from tests.support.campaigns import evaluation, outcome
from tests.tiers import law

FAULTS = (TimedFault("f1", 1, 9), TimedFault("f2", 3, 7), TimedFault("f1", 20, 30))
FIRM = {"goal": "g1", "kind": "true", "median": 3.5, "least": 0, "most": 9, "n_violated": 12}
FOUND = RecordedCause(
    index=1,
    n_flown=57,
    places=(0, 2),
    leading=1,
    outcome=outcome((5, 0, 9), 2),
    sentences=("f1.1 did “this”", "f1.2 did that"),
    chains=({"belief": {"tick": 3, "changes": []}, "verdicts": {}}, {"belief": None}),
    firmness=(FIRM, FIRM | {"kind": "believed"}),
)
UNKNOWN = RecordedCause(0, 31, "it would take more flights than the search did")


@pytest.fixture
def explained(store):
    """A campaign of which two evaluations were looked at."""
    store.append([evaluation(k, (k, 0, 1), specification=FAULTS) for k in range(3)])
    for cause in (FOUND, UNKNOWN):
        store.append_cause(cause)
    return store


def damage(store, content, index=1):
    """Store another text about an evaluation."""
    with closing(sqlite3.connect(store.path)) as other, other:
        other.execute("UPDATE cause SET content = ? WHERE idx = ?", (content, index))


def test_causes_are_read_back_in_the_order_of_evaluations(explained):
    with CampaignStore.open(explained.path.parent) as again:
        assert again.causes() == (UNKNOWN, FOUND)


def test_causes_change_neither_evaluations_nor_digest(store):
    store.append([evaluation(0, (1, 2))])
    before = tuple(store.evaluations()), store.digest()

    store.append_cause(UNKNOWN)

    assert (tuple(store.evaluations()), store.digest()) == before


def test_an_evaluation_is_explained_once(explained):
    with pytest.raises(RecordError, match=r"cause\.idx"):
        explained.append_cause(replace(FOUND, n_flown=1))

    assert explained.causes() == (UNKNOWN, FOUND)


def test_a_record_of_before_there_were_causes_has_none_and_takes_some(store):
    store.append([evaluation(k, (1,), specification=FAULTS) for k in range(2)])
    with closing(sqlite3.connect(store.path)) as other:
        other.execute("DROP TABLE cause")

    assert store.causes() == ()
    store.append_cause(FOUND)
    assert store.causes() == (FOUND,)


@pytest.mark.parametrize(
    "changed",
    [
        {"n_flown": "57"},
        {"reason": None},
        {"places": [0, 3]},
        {"places": ["0", "2"]},
        {"places": "02"},
        {"places": 2},
        {"places": [0]},
        {"leading": 2},
        {"leading": -1},
        {"outcome": None},
        {"outcome": {"digest": "0"}},
        {"outcome": {"digest": ""} | {name: ["1"] for name in COUNTS}},
        {"sentences": ["one"]},
        {"sentences": [1, 2]},
        {"chains": None},
        {"firmness": [{}]},
        {"more": 1},
    ],
    ids=str,
)
def test_a_text_that_makes_no_sense_is_damage(explained, changed):
    damage(explained, json.dumps(json.loads(FOUND.text()) | changed))

    with pytest.raises(RecordError, match="the record is damaged"):
        explained.causes()


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", None, b"\xff", 7])
def test_no_text_is_damage(explained, text):
    damage(explained, text)

    with pytest.raises(RecordError, match="the record is damaged"):
        explained.causes()


def test_a_cause_of_no_evaluation_is_damage(explained):
    explained.append_cause(replace(UNKNOWN, index=3))

    with pytest.raises(RecordError, match="the record is damaged"):
        explained.causes()


@given(st.data())
@law(100)
def test_a_text_with_another_character_is_damage_or_still_a_cause(data):
    text = FOUND.text()
    place = data.draw(st.integers(0, len(text) - 1))
    drawn = data.draw(st.characters(codec="ascii"))
    row = (1, text[:place] + drawn + text[place + 1 :], json.dumps(FAULTS))

    try:
        found = RecordedCause.from_row(row)
    except (ValueError, TypeError):
        return

    assert len(found.places) == len(found.sentences) == len(found.chains) == 2
    assert found.leading in range(len(found.sentences))
    assert all(0 <= place < len(FAULTS) for place in found.places)
    assert RecordedCause.from_row((1, found.text(), json.dumps(FAULTS))) == found
