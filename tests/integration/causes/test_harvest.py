"""What a campaign finds out about weaknesses after its search, without the command."""

from dataclasses import replace
from functools import partial
from random import Random

import numpy as np
import pytest

from mrsfi_runtime.causes.cause_set import Column
from mrsfi_runtime.causes.harvest import N_SEEDS, harvest, known_by
from mrsfi_runtime.causes.mildest import least, mildest
from mrsfi_runtime.causes.weakness import MEASURES, Weakness, detected, faults_of
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.errors import EvaluationError, RecordError, WorkerLost
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault, fault_ticks
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation
from mrsfi_runtime.search.space import SearchSpace, varied_specification
from tests.support.rendezvous import PLANTED, harmless, write_rendezvous
from tests.support.search import outcome_of, paper_space


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    return ReferenceEngine(load_code(write_rendezvous(tmp_path_factory.mktemp("harvested"))), 1)


def flown_on(engine):
    """Return how an engine evaluates specifications, and how it records them."""
    return engine.evaluate_many, partial(map, engine.record)


@pytest.fixture(scope="module")
def space(engine):
    return SearchSpace.of(engine.code.mission, engine.code.pool)


@pytest.fixture(scope="module")
def evaluations(engine):
    """What a search found: what is planted, and enough that may be flown after it."""
    found = []
    for index, faults in enumerate([*PLANTED, *harmless(120)]):
        specification = tuple(TimedFault(*fault) for fault in faults)
        flown = engine.evaluate(specification)
        found.append(Evaluation(index, 0, flown, (float(sum(flown.believed)),), 1, specification))
    return tuple(found)


@pytest.fixture
def store(tmp_path, evaluations):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as opened:
        opened.append(evaluations)
        yield opened


def test_what_was_flown_is_enough_to_know_it_again(store, space, engine):
    assert known_by(space, store) is None

    n_flights, found = harvest(space, store, *flown_on(engine))

    again = known_by(space, store)
    assert again.n_flights == n_flights
    assert tuple(replace(each, detection=None, depth=None) for each in again.weaknesses) == found
    assert 0 < len(store.flights()) - n_flights <= n_shrinking(again)
    assert found
    assert all(again.outcomes[each.witness].true for each in found)


def harvested(space, store, *flying):
    """Return what is recorded after a harvest."""
    harvest(space, store, *flying)
    return known_by(space, store)


def test_progress_never_goes_back_and_its_bound_never_rises(store, space, engine):
    steps = []

    harvest(space, store, *flown_on(engine), lambda *step: steps.append(step[:3]))

    units = [*dict.fromkeys(unit for unit, _, _ in steps)]
    assert units == ["flights", "bisections"]
    assert [unit for unit, _, _ in steps] == sorted((step[0] for step in steps), reverse=True)
    for unit in units:
        done, most = zip(*(step[1:] for step in steps if step[0] == unit), strict=True)
        assert list(done) == sorted(done)
        assert len({*most}) == 1
        assert done[-1] <= most[0]


def n_shrinking(found):
    """Return the flights of a harvest that sought mildest forms."""
    return sum(each.n_flights for each in found.mildest)


def test_what_is_the_least_for_each_goal_is_shrunk(store, space, engine):
    found = harvested(space, store, *flown_on(engine))

    told = least(found.goal_weaknesses)
    assert [each.goal for each in told] == [each.weakness.column.goal for each in found.mildest]
    assert all(each.is_mildest for each in told)
    listed = [found.goal_weaknesses[each.number - 1] for each in told]
    assert not any(each.is_mildest for each in listed)
    assert [each.faults for each in told] == [each.faults for each in listed]
    n_ticks = [
        [fault_ticks(each.shown.witness, space.duration) for each in some]
        for some in (told, listed)
    ]
    assert sum(n_ticks[0]) < sum(n_ticks[1]) / 2
    for each in told:  # in the campaign's seed it breaks the goal, and no part of it does
        broken = found.yardstick.broken(found.outcomes[each.shown.witness])
        assert each.shown.column in broken
        assert each.shown.n_held == each.shown.n_seeds == 3


def test_what_is_shrunk_side_by_side_ends_as_what_is_shrunk_alone(store, space, engine):
    found, batches, seeds = harvested(space, store, *flown_on(engine)), [], (1, 2)

    def noted(specifications, seed):
        batches.append(len(specifications))
        return engine.evaluate_many(specifications, seed)

    together = mildest(
        space, found.known, found.weaknesses, noted, partial(map, engine.record), seeds
    )

    for each, weakness in zip(together, found.weaknesses, strict=True):
        (alone,) = mildest(space, found.known, [weakness], *flown_on(engine), seeds)
        assert each.weakness == alone.weakness
    assert sum(each.n_flights for each in together) == sum(batches) - len(seeds)  # without faults
    assert sum(batches) > 1.5 * len(batches)


def test_every_form_says_since_when_it_breaks_the_goal(store, space, engine):
    found = harvested(space, store, *flown_on(engine))

    verdicts = {"believed": "is_believed", "true": "is_true", "missed": "missed"}
    for each in [*found.weaknesses, *(each.weakness for each in found.mildest)]:
        judged = engine.record(each.witness)[verdicts[each.column.kind]] > 0
        place = space.gate.mission.goal_ids.index(each.column.goal)
        assert each.since == judged[:, place].tolist().index(True)


def test_what_a_record_says_of_a_goal_that_there_is_not_is_refused(store, space, engine, refused):
    harvest(space, store, *flown_on(engine))
    text = store.kept("weaknesses", str)
    store.keep("weaknesses", text.replace('"goal":"', '"goal":"no'))

    with refused(RecordError):
        known_by(space, store)


def test_a_goal_that_only_evaluations_break_is_explained_by_them(tmp_path):
    """Three faults that break a goal together only are hardly ever drawn together."""
    space, guilty = paper_space(), {"f6", "f8", "f10"}

    def flown(specification):
        return outcome_of(0, int(guilty <= faults_of(specification)), 0, 0, 0, 0)

    def recorded(_):
        true = {"robots": [dict.fromkeys(("x", "y", "z", "speed", "energy"), 0.0)] * 3}
        world = [true | {"sensors": [{"rate": 0.0, "energy": 0.0}] * 9}]
        return {"world": world, **dict.fromkeys(MEASURES, np.zeros((1, 6)))}

    rng = Random(1)
    drawn = [varied_specification(space, 12, rng, lambda _: True) for _ in range(900)]
    with CampaignStore.create(tmp_path, CampaignSettings(faults=3), Manifest()) as store:
        store.append(
            Evaluation(index, 0, flown(each), (0.0,), 1, each) for index, each in enumerate(drawn)
        )

        found = harvested(space, store, lambda some, _: map(flown, some), partial(map, recorded))

    assert {each.faults for each in found.weaknesses} == {tuple(sorted(guilty))}


def test_what_was_violated_came_near_even_where_nothing_tells_by_how_much(tmp_path, space):
    """As of SufficientEnergy, whose violations are forecasts: its margin is of the end."""
    held = replace(outcome_of(0, 0, 0), margins=((0.5, 7), (2.5, 7), (2.5, 7)))
    broken = replace(held, true=(0, 3, 0), margins=((3.0, 9), None, (1.0, 9)))
    flown = [Evaluation(k, 0, each, (0.0,), 1, ()) for k, each in enumerate((held, broken, held))]
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append(flown)

        found = harvested(space, store, lambda some, _: [held] * len(some), list)

    assert found.nearest == {"g1": ((0.5, 7), 0), "g2": (None, 1), "g3": ((1.0, 9), 1)}


@pytest.mark.parametrize(("semantics", "depth"), [(2, None), (3, (-4.5, 7))])
def test_only_records_of_semantics_3_say_how_far_a_goal_was_beyond_its_limit(
    tmp_path, space, semantics, depth
):
    """Earlier ones have the margin of the first violation."""
    flown = replace(outcome_of(0, 0, 0), true=(2, 0, 0), margins=((-4.5, 7), (2.5, 7), (2.5, 7)))
    manifest = replace(Manifest(), semantics=semantics)
    with CampaignStore.create(tmp_path, CampaignSettings(), manifest) as store:
        store.append([Evaluation(0, 0, flown, (0.0,), 1, ())])

        near = harvested(space, store, lambda some, _: [flown] * len(some), list).nearest
        told = Weakness(Column("g1", "true"), (), (), 1, 1)
        (found,) = detected(space.gate.mission, store, [told], ())

    assert near["g1"] == (depth, 0)
    assert found.depth == (depth and (4.5, 7))


def test_what_is_recorded_is_not_flown_again(store, space, engine):
    flown = []

    def cut(specifications, seed):
        if len(flown) > 40:
            raise WorkerLost
        flown.extend(specifications)
        return engine.evaluate_many(specifications, seed)

    with pytest.raises(WorkerLost):
        harvest(space, store, cut, partial(map, engine.record))
    n_kept = len(store.flights())
    flown.clear()

    def noted(specifications, seed):
        flown.extend(specifications)
        return engine.evaluate_many(specifications, seed)

    harvest(space, store, noted, partial(map, engine.record))

    assert n_kept > 40
    assert n_kept + len(flown) == len(store.flights())


@pytest.mark.parametrize(("n_evaluations", "n_seeds"), [(1, 1), (30, 1), (60, N_SEEDS)])
def test_there_are_no_more_flights_than_those_of_the_search(
    tmp_path, space, engine, evaluations, n_evaluations, n_seeds
):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append(evaluations[:n_evaluations])

        found = harvested(space, store, *flown_on(engine))

    assert found.n_flights <= n_evaluations
    assert {each.n_seeds for each in found.weaknesses} <= {*range(n_seeds, N_SEEDS + 1)}


def test_a_mission_that_fails_without_faults_has_no_yardstick(store, space, engine, refused):
    with refused(EvaluationError):
        harvest(
            space,
            store,
            lambda some, _: [FailedFlight("late")] * len(some),
            partial(map, engine.record),
        )
