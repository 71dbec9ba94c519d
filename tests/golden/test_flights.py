"""Committed traces of fixed seeds: every bit of belief and truth at every tick."""

import json

from tests.golden.flights import RECORD, flights


def test_missions_fly_as_they_were_recorded():
    assert flights() == json.loads(RECORD.read_text(encoding="utf-8"))
