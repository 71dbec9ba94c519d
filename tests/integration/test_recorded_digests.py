"""Digests since the world last changed: README's campaigns, and each fault alone."""

import json
from dataclasses import replace

import pytest

from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.engine.compiled.layout import Frame, read_recorded
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import run_campaign
from tests.golden.flights import EFFECTS, effects
from tests.golden.frozen import outcome_digest
from tests.support.tree import ROOT
from tests.tiers import slow

MISSION = "uuv_sampling"
DIGESTS = {
    "a": "3966486edcec5897ad332c0b5fca95d4e61af8579535aa52390d33f35b515eaa",
    "b": "82da852f34bb334fba0a46bf13123c15a38e62254298fa598e88f58edab88c3e",
}


@slow
def test_every_fault_does_alone_what_was_recorded():
    assert dict(effects()) == json.loads(EFFECTS.read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", DIGESTS)
def test_a_campaign_finds_what_it_found_at_first(tmp_path, case):
    settings = CampaignSettings.load(ROOT / "models" / MISSION / f"case_{case}.toml")
    code = load_code(ROOT / "generated" / MISSION)
    world, belief = (initial_state(code.mission, settings.mission_seed) for _ in range(2))

    def evaluate_many(specifications):
        batch = engine._batch(specifications, code.pool)
        span = 0, len(specifications)
        frame = Frame(engine._fresh(settings.mission_seed), engine._fly_many.calls, batch, span)
        assert engine._fly(frame, *span) == []
        for k, outcome in enumerate(batch.outcomes(engine.measured)):
            read_recorded(world, batch.results["world"][k])
            read_recorded(belief, batch.results["belief"][k])
            yield replace(outcome, digest=outcome_digest(outcome, world, belief))

    with (
        CompiledEngine(code, settings.mission_seed) as engine,
        CampaignStore.create(tmp_path / "run", settings, Manifest()) as store,
    ):
        run_campaign(settings, code.mission, code.pool, evaluate_many, store)

        assert store.digest() == DIGESTS[case]
