"""What a campaign finds out about causes by itself, without the command."""

from random import Random

import pytest

from mrsfi_runtime.analysis.columns import top
from mrsfi_runtime.causes.recorded import record_causes
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.errors import WorkerLost
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.campaign import CampaignStore, Evaluation
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.campaigns import evaluation, store_of
from tests.support.rendezvous import PLANTED, harmless, write_rendezvous
from tests.tiers import slow


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    return ReferenceEngine(load_code(write_rendezvous(tmp_path_factory.mktemp("recorded"))), 1)


@pytest.fixture(scope="module")
def evaluations(engine):
    """What a search found: what is planted, and enough that may be flown after it."""
    found = []
    for index, faults in enumerate([*PLANTED, *harmless(120)]):
        specification = tuple(TimedFault(*fault) for fault in faults)
        flown = engine.evaluate(specification)
        found.append(Evaluation(index, 0, specification, flown, (float(sum(flown.believed)),), 1))
    return tuple(found)


@pytest.fixture
def store(tmp_path, evaluations):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as opened:
        opened.append(evaluations)
        yield opened


def find_out(store, engine, best, evaluate_many=None, on_found=lambda _: None):
    measure = Measure.of(store.settings, engine.code.mission)
    record_causes(store, measure, best, evaluate_many or engine.evaluate_many, engine, on_found)


def best_of(store, engine):
    return top(store, Measure.of(store.settings, engine.code.mission), 10)


@slow
def test_the_order_in_which_evaluations_are_explained_changes_nothing(
    tmp_path, evaluations, engine
):
    with store_of(evaluations) as store:
        best = best_of(store, engine)
    shuffled = Random(1).sample(best, len(best))
    found = []
    for number, order in enumerate((best, best[::-1], shuffled)):
        with CampaignStore.create(tmp_path / str(number), CampaignSettings(), Manifest()) as store:
            store.append(evaluations)
            find_out(store, engine, order)
            found.append(store.causes())

    assert found[0] == found[1] == found[2]
    assert [cause.places for cause in found[0]] == [(1,), (0, 2), (0, 1), (0, 2), *[()] * 6]


def test_what_is_known_is_not_flown_again_and_counts_as_flown(store, engine):
    best = best_of(store, engine)
    told, flown = [], []

    def evaluate_many(specifications, seed):
        flown.extend(specifications)
        return engine.evaluate_many(specifications, seed)

    find_out(store, engine, best[:2])
    n_known = sum(cause.n_flown for cause in store.causes())
    find_out(store, engine, best, evaluate_many, told.append)

    assert [cause.index for cause in told] == [each.index for each in best[2:]]
    n_recorded = sum(cause.places != () and len(cause.places) + 1 for cause in told)
    assert len(flown) + n_recorded == sum(cause.n_flown for cause in told)
    assert n_known + len(flown) + n_recorded <= store.n_evaluations


def test_the_first_that_takes_too_much_is_the_last(tmp_path, evaluations, engine):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append(evaluations[:50])
        find_out(store, engine, best_of(store, engine))
        first, second = sorted(store.causes(), key=lambda cause: bool(cause.reason))

        assert first.places
        assert second.reason == "it would take more flights than the search did"
        assert first.n_flown + second.n_flown <= 50


def test_a_lost_worker_ends_it_and_is_no_reason(store, engine):
    def evaluate_many(specifications, seed):
        if len(store.causes()) == 1 and specifications != [()]:
            raise WorkerLost
        return engine.evaluate_many(specifications, seed)

    best = best_of(store, engine)
    with pytest.raises(WorkerLost):
        find_out(store, engine, best, evaluate_many)

    (only,) = store.causes()
    assert (only.index, only.reason) == (best[0].index, "")


def test_what_is_violated_without_faults_is_not_due_to_any(tmp_path, engine):
    """The flights are those of another specification: all of them are late."""
    late = engine.evaluate(tuple(TimedFault(*fault) for fault in PLANTED[2]))
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append(evaluation(k, late.believed) for k in range(40))
        find_out(store, engine, [next(store.evaluations())], lambda many, _: [late for _ in many])
        (found,) = store.causes()

    assert found.reason == "without any of its faults, the violations are there as well"
    assert not found.places
