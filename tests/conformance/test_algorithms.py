"""Every algorithm on a mission that really flies: exact budget, legal specifications."""

from itertools import product

import pytest

from mrsfi.evolving import ALGORITHMS
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import COSTS, Gate
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.search.run import run_campaign
from mrsfi_runtime.search.space import SearchSpace
from tests.support.campaigns import store_of
from tests.support.tree import ROOT
from tests.tiers import slow

N_EVALUATIONS = 40


@slow
@pytest.mark.parametrize(
    ("algorithm", "minimise"), [*((name, None) for name in ALGORITHMS), *product(MINIMISING, COSTS)]
)
def test_it_flies_as_many_specifications_as_it_may_within_restriction_and_bounds(
    algorithm, minimise
):
    code = load_code(ROOT / "generated" / "tight_margins")
    settings = CampaignSettings(
        algorithm=algorithm,
        population=8,
        faults=6,
        evaluations=N_EVALUATIONS,
        minimise=minimise,
        seed=3,
    )
    engine, store = ReferenceEngine(code, settings.mission_seed), store_of(settings=settings)
    space = SearchSpace.of(code.mission, code.pool)

    evaluate = engine.evaluate_many
    run_campaign(settings, code.mission, code.pool, evaluate, store, algorithms=ALGORITHMS)

    flown = [evaluation.specification for evaluation in store.evaluations()]
    assert len(flown) == N_EVALUATIONS
    for specification in flown:
        Gate(code.mission, code.pool).admitted(specification)
        assert space.require(specification, "record") == specification
        assert len(specification) <= 6
    assert all(flown[1:])  # only who covers flies without faults, once, before all others
