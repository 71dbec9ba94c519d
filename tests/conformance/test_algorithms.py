"""Every algorithm on a mission that really flies: exact budget, legal, repeatable, resumable."""

from itertools import product
from pathlib import Path

import pytest

from mrsfi_runtime.causes.cover import ALGORITHMS
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import COSTS
from mrsfi_runtime.model.gate import Gate
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import run_campaign
from mrsfi_runtime.search.space import SearchSpace
from tests.support.cli import workspace
from tests.support.interrupted import MISSION, SEARCH, begin, digest, evaluations, killed_after
from tests.tiers import seeds

N_EVALUATIONS = 40


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with models and generated code of the small mission."""
    return workspace(tmp_path_factory.mktemp("place"), MISSION)


def begin_search(place: Path, name: str, algorithm: str, minimise: str | None) -> Path:
    settings = CampaignSettings(
        algorithm=algorithm,
        population=8,
        faults=6,
        evaluations=N_EVALUATIONS,
        minimise=minimise,
        seed=3,
    )
    return begin(place / f"{name}-{algorithm}-{minimise}", place / "models" / MISSION, settings)


def search(campaign: Path) -> int:
    """Search a campaign to its end, and return how many specifications were evaluated."""
    code = load_code(campaign / "generated")
    with CampaignStore.open(campaign) as store:
        n_before = store.n_evaluations
        settings = store.settings
        engine = ReferenceEngine(code, settings.mission_seed)
        run_campaign(
            settings,
            code.mission,
            code.pool,
            lambda specifications: map(engine.evaluate, specifications),
            store,
            algorithms=ALGORITHMS,
        )
        return store.n_evaluations - n_before


@pytest.fixture(
    scope="module",
    params=seeds([*((name, None) for name in ALGORITHMS), *product(MINIMISING, COSTS)], 0, 7),
    ids=lambda search: "-".join(filter(None, search)),
)
def whole(place: Path, request: pytest.FixtureRequest) -> Path:
    """Folder of a campaign of one algorithm that was never interrupted."""
    path = begin_search(place, "whole", *request.param)
    search(path)
    return path


def search_of(campaign: Path) -> tuple[str, str | None]:
    with CampaignStore.open(campaign) as store:
        return store.settings.algorithm, store.settings.minimise


def test_it_flies_as_many_specifications_as_it_may_within_restriction_and_bounds(whole):
    code = load_code(whole / "generated")
    space = SearchSpace.of(code.mission, code.pool)

    flown = [evaluation.specification for evaluation in evaluations(whole)]

    assert len(flown) == N_EVALUATIONS
    for specification in flown:
        Gate(code.mission, code.pool).admitted(specification)
        assert space.require(specification, "record") == specification
        assert len(specification) <= 6
    assert all(flown[1:])  # only who covers flies without faults, once, before all others


def test_killed_and_resumed_it_ends_as_one_that_never_was(place, whole):
    path = begin_search(place, "killed", *search_of(whole))

    is_killed = killed_after(0.0, SEARCH, path, 1, n_evaluated=20)
    n_kept = len(evaluations(path))
    n_after = search(path)

    assert is_killed
    assert n_kept + n_after == N_EVALUATIONS
    assert digest(path) == digest(whole)
