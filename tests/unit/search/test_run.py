"""Searches as a whole: budget, record, failures, and what one flies for a seed."""

import random
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import chain, count, product, repeat
from random import Random
from types import SimpleNamespace
from typing import Any

import pytest

from mrsfi.evolving import ALGORITHMS
from mrsfi_runtime.errors import EvaluationError, RecordError, UsageError
from mrsfi_runtime.model.faults import COSTS, FaultPool, Specification, fault_ticks
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Generation
from mrsfi_runtime.search.run import CampaignProgress, EvaluateMany, run_campaign
from tests.support.campaigns import content, store_of
from tests.support.search import (
    evaluate_stand_in,
    outcome_of,
    paper_mission,
    pool_of,
    stand_in_outcome,
)
from tests.support.triggers import drawn_triggers
from tests.tiers import slow

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


@dataclass(frozen=True)
class Failed:
    traceback: str


class Watched(CampaignStore):
    """A store that notes which generations a search compares with it."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.compared: list[int] = []

    def generation(self, index: int) -> Generation | None:
        self.compared.append(index)
        return super().generation(index)


@dataclass
class Run:
    settings: CampaignSettings
    evaluate_many: EvaluateMany = evaluate_stand_in
    pool: FaultPool = field(default_factory=pool_of)
    replicas: Sequence[EvaluateMany] = ()
    state_every: int = 1000

    def __post_init__(self) -> None:
        self.store = store_of(settings=self.settings, kind=Watched)
        self.progress: list[CampaignProgress] = []

    def start(self) -> None:
        run_campaign(
            self.settings,
            paper_mission(),
            self.pool,
            self.evaluate_many,
            self.store,
            self.progress.append,
            replicas=self.replicas,
            algorithms=ALGORITHMS,
            state_every=self.state_every,
        )


@pytest.mark.parametrize("algorithm", ["paper", "nsga2", "guided"])
def test_a_run_of_the_papers_size_is_recorded_whole(algorithm):
    run = Run(CampaignSettings(algorithm=algorithm))

    run.start()

    evaluations, _, generations = content(run.store)
    assert [generation.index for generation in generations] == list(range(51))
    assert sum(g.statistics["n_evaluations"] for g in generations) == len(evaluations)
    for evaluation in evaluations:
        outcome = stand_in_outcome(evaluation.specification)
        n_distinct = sum(1 for violations in outcome.believed if violations)
        assert evaluation.outcome == outcome
        assert evaluation.fitness == (0.3 * sum(outcome.believed) + 0.7 * n_distinct,)
        assert evaluation.fault_ticks == fault_ticks(evaluation.specification, 1000)
    for generation in generations:
        fitness = [evaluations[index].fitness[0] for index in generation.population]
        assert len(fitness) == 20
        assert generation.statistics["max"] == max(fitness)
        assert generation.statistics["min"] == min(fitness)


def test_progress_follows_the_record():
    run = Run(CampaignSettings(generations=5))

    run.start()

    n_evaluations, best, expected = 0, 0.0, []
    for generation in run.store.generations():
        n_evaluations += int(generation.statistics["n_evaluations"])
        best = max(best, generation.statistics["max"])
        mean = generation.statistics["mean"]
        expected.append(CampaignProgress(generation.index, best, mean, n_evaluations, 0))
    assert run.progress == expected


def failing_if_odd(specifications: Sequence[Specification]) -> list[Outcome | Failed]:
    return [
        Failed("Traceback: odd start") if specification[0].start % 2 else outcome_of(*[7] * 6)
        for specification in specifications
    ]


def test_a_failed_evaluation_is_recorded_and_the_run_goes_on():
    run = Run(CampaignSettings(generations=3, max_failures=1000), failing_if_odd)

    run.start()

    evaluations, failures, generations = content(run.store)
    assert len(generations) == 4
    assert failures
    assert run.progress[-1].n_failures == len(failures)
    assert all(failure.traceback == "Traceback: odd start" for failure in failures)
    n_asked = sum(g.statistics["n_evaluations"] for g in generations)
    assert n_asked == len(evaluations) + len(failures)
    first = generations[0]
    assert first.statistics["min"] == 0.0
    assert first.population == tuple(
        range(20 - sum(failure.generation == 0 for failure in failures))
    )
    for generation in generations[1:]:
        assert all(0 <= index < len(evaluations) for index in generation.population)


def test_too_many_failures_end_the_run_with_the_last_reason_and_again_without_evaluating(refused):
    run = Run(
        CampaignSettings(max_failures=3),
        lambda specifications: (
            [Failed("Traceback:\n  somewhere\nErr: always")] * len(specifications)
        ),
    )

    for _ in range(2):
        with refused(EvaluationError):
            run.start()
        run.evaluate_many = Cut(0)

    assert (run.store.n_failures, run.store.n_generations) == (20, 0)


def test_large_populations_are_recorded_in_chunks():
    sizes = []

    def counted(specifications: Sequence[Specification]) -> list[Outcome]:
        sizes.append(len(specifications))
        return evaluate_stand_in(specifications)

    Run(CampaignSettings(population=230, generations=0), counted).start()

    assert sizes == [100, 100, 30]


def test_a_fitness_that_is_not_finite_late_in_a_run_ends_it_too(monkeypatch, refused):
    fitness = chain(map(float, range(15)), repeat(float("nan")))
    broken = SimpleNamespace(fitness=lambda _: next(fitness))
    monkeypatch.setitem(sys.modules, "broken_late", broken)
    run = Run(CampaignSettings(fitness="broken_late:fitness"))

    with refused(EvaluationError):
        run.start()

    assert [each.fitness[0] for each in run.store.evaluations()] == list(range(15))


def test_a_result_too_few_is_noticed():
    run = Run(CampaignSettings(), lambda specifications: evaluate_stand_in(specifications[1:]))

    with pytest.raises(ValueError, match="zip"):
        run.start()


@pytest.mark.parametrize(
    "settings",
    [
        CampaignSettings(algorithm="magic"),
        CampaignSettings(selection="magic"),
        CampaignSettings(fitness="magic"),
        CampaignSettings(mutation_operator="magic"),
        CampaignSettings(crossover_operator="x"),
        CampaignSettings.parse("[search]", "case.toml", goals=["g9"]),
        CampaignSettings(goals=("g1", "g9")),
        CampaignSettings(minimise="faults"),
    ],
)
def test_settings_that_name_what_does_not_exist_are_refused(settings, refused):
    with refused(UsageError):
        Run(settings).start()


def test_a_run_draws_nothing_from_the_global_generator():
    before = random.getstate()

    Run(CampaignSettings(generations=2)).start()

    assert random.getstate() == before


@dataclass
class Cut:
    """Evaluates so many specifications, then fails as whatever ends a run does."""

    n_left: int
    n_evaluated: int = 0

    def __call__(self, specifications: Sequence[Specification]) -> Iterator[Outcome | Failed]:
        for result in failing_if_rare(specifications):
            if self.n_left == 0:
                raise KeyboardInterrupt
            self.n_left -= 1
            self.n_evaluated += 1
            yield result


def failing_if_rare(specifications: Sequence[Specification]) -> list[Outcome | Failed]:
    return [
        Failed("Traceback: rare start")
        if specification and specification[0].start % 10 == 0
        else stand_in_outcome(specification)
        for specification in specifications
    ]


def with_triggers() -> FaultPool:
    return replace(pool_of(), triggers=drawn_triggers(Random(1), paper_mission(), pool_of()))


@slow
@pytest.mark.parametrize(
    ("algorithm", "minimise"), [*((name, None) for name in ALGORITHMS), *product(MINIMISING, COSTS)]
)
@pytest.mark.parametrize(
    ("evaluations", "pool"), [(None, pool_of), (150, pool_of), (150, with_triggers)]
)
def test_a_run_cut_anywhere_and_resumed_leaves_the_record_of_a_whole_one(
    algorithm, minimise, evaluations, pool
):
    settings = CampaignSettings(
        algorithm=algorithm,
        minimise=minimise,
        generations=6,
        evaluations=150 if algorithm == "cover" else evaluations,  # it knows no generations
        max_failures=1000,
    )
    whole = Run(settings, failing_if_rare, pool(), state_every=30)
    whole.start()
    n_all = whole.store.n_evaluations + whole.store.n_failures

    for n_before in (0, 1, 19, 20, 21, 50, n_all - 1, n_all):
        run = cut_and_resumed(whole, n_before)

        assert run.evaluate_many.n_evaluated == n_all - n_before


def cut_and_resumed(whole: Run, n_before: int) -> Run:
    """Cut a run after so many evaluations, resume it, and compare its record with a whole one."""
    run = replace(whole, evaluate_many=Cut(n_before))
    with suppress(KeyboardInterrupt):
        run.start()
    assert run.store.n_evaluations + run.store.n_failures == n_before
    n_closed = run.store.n_generations
    run.progress.clear()
    run.store.compared.clear()
    run.evaluate_many = Cut(1000)
    run.start()

    assert content(run.store) == content(whole.store)
    assert state(run.store) == state(whole.store)
    assert run.progress == whole.progress[n_closed:]
    return run


def state(store: CampaignStore) -> str | None:
    """Return the last state that a search kept, as it is stored."""
    return store.kept("state", str)


SEARCHES = {
    **{algorithm: {"algorithm": algorithm} for algorithm in ALGORITHMS if algorithm != "cover"},
    "guided by faults": {"algorithm": "guided", "minimise": "faults"},
    "guided to few goals": {"algorithm": "guided", "goals": ("g1", "g3")},
    "eaMuPlusLambda, best": {"algorithm": "eaMuPlusLambda", "selection": "best"},
    "nsga2 by fault_ticks": {"algorithm": "nsga2", "minimise": "fault_ticks"},
    "guided in three seeds": {"algorithm": "guided", "replications": 3},
    "nsga2 in three seeds": {"algorithm": "nsga2", "replications": 3},
}


@pytest.mark.parametrize("search", SEARCHES)
def test_a_search_goes_on_from_its_last_state_and_repeats_a_generation_at_least(search):
    settings = CampaignSettings(evaluations=190, max_failures=1000, **SEARCHES[search])
    replicas = (on_another_seed, evaluate_stand_in)[: settings.replications - 1]
    whole = Run(settings, failing_if_rare, replicas=replicas, state_every=40)
    whole.start()

    for n_before in (Random(search).randrange(100, 190), 190):
        run = cut_and_resumed(whole, n_before)

        n_closed = whole.store.n_generations - len(run.progress)
        assert 0 < run.store.compared[0] < n_closed


WITHOUT_STATE = {
    "no state": lambda store: store._connection.execute("DELETE FROM meta WHERE key = 'state'"),
    "other versions": lambda store: setattr(store, "manifest", Manifest(versions={"deap": "1.0"})),
}


@pytest.mark.parametrize("what", WITHOUT_STATE)
def test_a_record_without_a_usable_state_is_repeated_as_a_whole(what):
    settings = CampaignSettings(algorithm="guided", faults=1, evaluations=240, max_failures=1000)
    whole = Run(settings, failing_if_rare, state_every=20)
    whole.start()
    run = replace(whole, evaluate_many=Cut(90))
    with suppress(KeyboardInterrupt):
        run.start()
    assert state(run.store)
    WITHOUT_STATE[what](run.store)
    run.evaluate_many = Cut(90)
    run.store.compared.clear()

    with suppress(KeyboardInterrupt):
        run.start()
    assert run.store.compared[0] == 0
    run.evaluate_many = failing_if_rare
    run.store.compared.clear()
    run.start()  # from the state that the second one kept, with its versions
    assert run.store.compared[0] > 0

    assert content(run.store) == content(whole.store)


def test_of_a_search_with_a_function_of_the_user_no_state_is_kept(monkeypatch):
    kept = SimpleNamespace(creep=lambda space, specification, rng, share: specification)
    monkeypatch.setitem(sys.modules, "own_steps", kept)
    run = Run(CampaignSettings(mutation_operator="own_steps:creep"), state_every=20)

    run.start()

    assert run.store.n_evaluations > 100
    assert state(run.store) is None


def on_another_seed(specifications: Sequence[Specification]) -> list[Outcome | Failed]:
    return [
        Failed("Traceback: other seed")
        if specification[-1].finish % 10 == 0
        else outcome_of(
            *(violations // 3 for violations in stand_in_outcome(specification).believed)
        )
        for specification in specifications
    ]


@pytest.mark.parametrize("algorithm", ["paper", "nsga2", "guided"])
def test_replications_average_over_mission_seeds_and_resume(algorithm):
    settings = CampaignSettings(
        algorithm=algorithm, generations=3, replications=3, max_failures=1000
    )
    replicas = (on_another_seed, evaluate_stand_in)
    mission, pool, whole = paper_mission(), pool_of(), store_of(settings=settings)
    run_campaign(settings, mission, pool, failing_if_rare, whole, replicas=replicas)
    cut = store_of(settings=settings)
    with suppress(KeyboardInterrupt):
        run_campaign(settings, mission, pool, Cut(30), cut, replicas=replicas)

    run_campaign(settings, mission, pool, failing_if_rare, cut, replicas=replicas)

    assert whole.n_failures
    assert content(cut) == content(whole)
    assert whole.n_evaluations + whole.n_failures >= 60
    for evaluation in whole.evaluations():
        believed = stand_in_outcome(evaluation.specification).believed
        assert evaluation.outcome.believed == believed
        mean = [(v + v // 3 + v) / 3 for v in believed]
        assert evaluation.fitness[1:] == pytest.approx(mean)
        n_distinct = sum(v > 0 for v in believed) * 2 + sum(v // 3 > 0 for v in believed)
        fitness = 0.3 * sum(mean) + 0.7 * n_distinct / 3
        assert evaluation.fitness[0] == pytest.approx(fitness)


def test_a_record_that_another_fitness_function_wrote_is_refused(refused):
    run = Run(CampaignSettings(generations=1))
    run.start()
    run.settings = replace(run.settings, violations="masked")

    with refused(RecordError):
        run.start()


STATE = "UPDATE meta SET value = {} WHERE key = 'state'"
SWAP = "UPDATE evaluation SET specification = (SELECT specification FROM evaluation WHERE idx = 6)"


@pytest.mark.parametrize(
    ("state_every", "change"),
    [
        (1000, f"{SWAP} WHERE idx = 5"),
        (1000, "UPDATE generation SET random_state = '[]' WHERE idx = 1"),
        (20, f"{SWAP} WHERE idx = (SELECT max(idx) FROM evaluation)"),
        (20, "UPDATE generation SET random_state = '[]' WHERE idx = 3"),
        (20, "DELETE FROM evaluation WHERE idx > 30"),
        (20, STATE.format("""replace(value, '"counts": [', '"counts": [9')""")),
        (20, STATE.format("""replace(value, '"random": [3', '"random": [4')""")),
        (20, STATE.format("""replace(value, '"population": [', '"population": [0,')""")),
        (20, STATE.format("""'{"versions": {}}'""")),
        (20, STATE.format("'['")),
    ],
    ids=count(),
)
def test_a_record_that_does_not_follow_from_its_settings_is_refused(state_every, change, refused):
    run = Run(CampaignSettings(generations=3), state_every=state_every)
    run.start()
    run.store._connection.execute(change)

    with refused(RecordError):
        run.start()


def written(n_specifications: int, seconds_to_write: Callable[[int], float]) -> list[int]:
    """Return how many entries each append has, where one evaluation takes a second."""
    now, sizes = 0.0, []

    class Slow(CampaignStore):
        def append(self, *entries: Any) -> None:
            nonlocal now
            sizes.append(sum(map(len, entries)))
            now += seconds_to_write(sizes[-1])
            super().append(*entries)

    def one_a_second(specifications: Sequence[Specification]) -> Iterator[Outcome]:
        nonlocal now
        for specification in specifications:
            now += 1.0
            yield stand_in_outcome(specification)

    settings = CampaignSettings(population=n_specifications, generations=0)
    store = store_of(settings=settings, kind=Slow)
    sizes.clear()  # of its beginning, without anything
    run_campaign(settings, paper_mission(), pool_of(), one_a_second, store, clock=lambda: now)
    return sizes


@pytest.mark.parametrize(("write", "n_appends"), [(0.0, 61), (0.02, 61), (1.0, 4)])
def test_each_evaluation_is_written_at_once_unless_writing_takes_its_time(write, n_appends):
    sizes = written(60, lambda _: write)

    assert (len(sizes), sum(sizes)) == (n_appends, 61)


def test_no_more_than_a_thousand_results_wait_to_be_written_however_long_each_takes():
    sizes = written(2_500, float)

    assert (max(sizes), sum(sizes)) == (1_000, 2_501)


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
