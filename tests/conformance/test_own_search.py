"""The example of a search of one's own: it runs, and goes on after a cut."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import pytest

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import EvaluateMany, run_campaign
from tests.support.campaigns import content, store_of
from tests.support.search import evaluate_stand_in, paper_mission, pool_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_search"


@pytest.fixture(params=["own_parts", "own_algorithm"])
def settings(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> CampaignSettings:
    monkeypatch.syspath_prepend(EXAMPLE)
    return CampaignSettings.load(EXAMPLE / f"{request.param}.toml", evaluations=95)


def run(settings: CampaignSettings, store: CampaignStore, evaluate: EvaluateMany) -> None:
    run_campaign(
        settings,
        paper_mission(),
        pool_of(),
        evaluate,
        store,
        replicas=[evaluate_stand_in] * (settings.replications - 1),
    )


def test_it_goes_on_after_a_cut_as_if_there_had_been_none(settings):
    whole, cut = store_of(settings=settings), store_of(settings=settings)
    run(settings, whole, evaluate_stand_in)
    flown: list[Specification] = []

    def cut_short(specifications: Sequence[Specification]) -> list[Outcome]:
        if len(flown) >= 40:
            raise KeyboardInterrupt
        flown.extend(specifications)
        return evaluate_stand_in(specifications)

    with suppress(KeyboardInterrupt):
        run(settings, cut, cut_short)
    n_before = cut.n_evaluations
    run(settings, cut, evaluate_stand_in)

    assert 40 <= n_before < 95 == whole.n_evaluations
    first, *_, last = whole.generations()
    assert last.statistics["max"] >= first.statistics["max"]
    assert content(cut) == content(whole)
