"""Searches find the same, version after version: what one flies for a seed is pinned."""

from hashlib import sha256

import pytest

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.run import run_campaign
from tests.support.campaigns import content, store_of
from tests.support.search import evaluate_stand_in, paper_mission, pool_of

FLOWN = {
    "paper": "916f8f99d0d0b705",
    "eaSimple": "95e1c83e079871f7",
    "eaMuPlusLambda": "41d9c14b778c7a2b",
    "eaMuCommaLambda": "abe7bb8bd3e438fc",
    "eaGenerateUpdate": "3a4f8c50648c65b0",
    "nsga2": "f7f145aa9c1ae6bc",
    "guided": "12b1e6cf4ccb3ee1",
    "random": "79ebcdb0ddfcb364",
    "drift": "8a161f900c2b2468",
    "nsga2 by fault_ticks": "9e81f1da4f5f1c5d",
    "guided by faults": "c0d6f467065c33b4",
}


@pytest.mark.parametrize("search", FLOWN)
def test_what_a_search_flies_changes_with_intent_only(search):
    algorithm, _, minimise = search.partition(" by ")
    settings = CampaignSettings(
        algorithm=algorithm, minimise=minimise or None, generations=60, faults=12, seed=5
    )
    store = store_of(settings=settings)

    run_campaign(settings, paper_mission(), pool_of(), evaluate_stand_in, store)

    flown = [each.specification for each in content(store)[0]]
    text = repr(flown).replace(", trigger=''", "")
    assert sha256(text.encode()).hexdigest()[:16] == FLOWN[search]
