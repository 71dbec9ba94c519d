import json
import statistics
from random import Random

import pytest

from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.algorithms import ALGORITHMS
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import Algorithm, GenerationSummary
from mrsfi_runtime.search.space import random_specification
from tests.support.search import paper_space, stand_in_outcome


def score_of(specification: Specification) -> Score:
    goals = stand_in_outcome(specification).believed
    return Score(float(sum(goals)), goals)


def scores(n_scores: int, fitness: float = 0.0) -> list[Score]:
    return [Score(fitness, (fitness,) * 6)] * n_scores


def start(settings: CampaignSettings, duration: int = 1000, *fault_ids: str) -> Algorithm:
    return ALGORITHMS[settings.algorithm](paper_space(duration, *fault_ids), settings)


def run(algorithm: Algorithm) -> tuple[list[list[Specification]], list[GenerationSummary]]:
    asked, summaries = [], []
    while not algorithm.is_finished:
        asked.append(algorithm.ask())
        summaries.append(algorithm.tell([score_of(s) for s in asked[-1]]))
    return asked, summaries


@pytest.mark.parametrize("name", ALGORITHMS)
@pytest.mark.parametrize("n_evaluations", [1, 20, 137])
def test_a_number_of_evaluations_is_met_exactly(name, n_evaluations):
    settings = CampaignSettings(algorithm=name, generations=3, evaluations=n_evaluations)

    asked, summaries = run(start(settings))

    assert sum(map(len, asked)) == n_evaluations
    assert sum(summary.statistics["n_evaluations"] for summary in summaries) == n_evaluations


@pytest.mark.parametrize("name", ["paper", "drift", "eaSimple"])
def test_generations_without_a_new_specification_do_not_end_a_run(name):
    settings = CampaignSettings(
        algorithm=name, population=2, generations=3, crossover=0.0, mutation=0.05, evaluations=40
    )

    asked, _ = run(start(settings))

    assert sum(map(len, asked)) == 40
    assert [] in asked[4:]


@pytest.mark.parametrize("name", ["paper", "drift"])
def test_a_run_in_which_nothing_can_change_ends_after_a_thousand_generations(name):
    settings = CampaignSettings(
        algorithm=name, generations=3, crossover=0.0, mutation=0.0, evaluations=500
    )

    asked, summaries = run(start(settings))

    assert [len(specifications) for specifications in asked] == [20] + [0] * 1000
    assert len(summaries) == 1001


@pytest.mark.parametrize("name", ALGORITHMS)
def test_the_same_seed_repeats_the_run_and_another_does_not(name):
    settings = CampaignSettings(algorithm=name, generations=4, seed=5)

    first, again = start(settings), start(settings)
    other = start(CampaignSettings(algorithm=name, generations=4, seed=6))

    assert run(first) == run(again)
    assert first.random_state() == again.random_state()
    assert run(other) != run(start(settings))


def test_the_random_state_continues_the_run():
    algorithm = start(CampaignSettings(algorithm="random", generations=1))
    algorithm.tell(scores(len(algorithm.ask())))
    version, words, gauss = json.loads(algorithm.random_state())
    rng = Random()
    rng.setstate((version, tuple(words), gauss))

    expected = [random_specification(paper_space(), 20, rng) for _ in range(20)]

    assert algorithm.ask() == expected


@pytest.mark.parametrize("name", ALGORITHMS)
def test_statistics_are_those_of_the_population(name):
    asked, summaries = run(start(CampaignSettings(algorithm=name, generations=6)))
    specifications = [specification for generation in asked for specification in generation]

    for generation, summary in zip(asked, summaries, strict=True):
        fitness = [score_of(specifications[number]).fitness for number in summary.population]
        assert summary.statistics == {
            "n_evaluations": len(generation),
            "mean": statistics.fmean(fitness),
            "std": statistics.pstdev(fitness),
            "min": min(fitness),
            "max": max(fitness),
        }


def test_selection_raises_fitness_where_drift_does_not():
    _, paper = run(start(CampaignSettings(mutation_share=0.1)))
    _, drift = run(start(CampaignSettings(algorithm="drift", mutation_share=0.1)))

    def late(summaries: list[GenerationSummary]) -> float:
        return statistics.fmean(summary.statistics["mean"] for summary in summaries[-10:])

    assert late(paper) > paper[0].statistics["mean"] > late(drift)


@pytest.mark.parametrize(
    "settings",
    [
        CampaignSettings(algorithm="guided", generations=20),
        CampaignSettings(algorithm="eaMuPlusLambda", selection="best", generations=20),
    ],
)
def test_elitists_never_lose_their_best(settings):
    asked, summaries = run(start(settings))

    best = [summary.statistics["max"] for summary in summaries]
    assert best == sorted(best)
    assert best[-1] == max(score_of(found).fitness for turn in asked for found in turn)


@pytest.mark.parametrize("n_goals", [1, 2, 6])
def test_nsga2_never_loses_the_most_violations_of_a_goal(n_goals):
    algorithm = start(CampaignSettings(algorithm="nsga2", generations=20))
    told: list[Score] = []
    most = []

    while not algorithm.is_finished:
        new = [score_of(specification) for specification in algorithm.ask()]
        told += [Score(0.0, score.goals[:n_goals]) for score in new]
        summary = algorithm.tell(told[-len(new) :])
        most.append(max(told[number].goals[0] for number in summary.population))

    assert most == sorted(most)
    assert most[-1] == max(score.goals[0] for score in told)


def test_nsga2_does_not_look_at_the_fitness():
    def asked_with(fitness: float) -> list[list[Specification]]:
        algorithm = start(CampaignSettings(algorithm="nsga2", generations=4))
        asked = []
        while not algorithm.is_finished:
            asked.append(algorithm.ask())
            goals = [score_of(specification).goals for specification in asked[-1]]
            algorithm.tell([Score(fitness * place, goal) for place, goal in enumerate(goals)])
        return asked

    assert asked_with(1.0) == asked_with(-1.0)


def test_a_model_of_good_specifications_learns():
    _, summaries = run(start(CampaignSettings(algorithm="eaGenerateUpdate")))

    means = [summary.statistics["mean"] for summary in summaries]
    assert statistics.fmean(means[-5:]) > max(means[:5])


def test_the_guided_search_begins_with_long_windows_at_landmarks():
    space = paper_space()

    first = start(CampaignSettings(algorithm="guided")).ask()

    assert len(first) == 20
    for specification in first:
        whole = [timed for timed in specification if (timed.start, timed.finish) == (0, 999)]
        assert 15 <= len(whole) <= len(specification) <= 20
        places = {
            timed.values[:2] for timed in specification if space.candidates[timed.fault].is_place
        }
        landmarks = {values[:2] for f in ("f9", "f11") for values in space.candidates[f].landmarks}
        assert places <= landmarks


def test_the_guided_search_asks_for_nothing_twice():
    asked, _ = run(start(CampaignSettings(algorithm="guided", generations=20)))
    specifications = [specification for generation in asked for specification in generation]

    assert len(set(specifications)) == len(specifications)


def test_a_comma_strategy_needs_as_many_offspring_as_individuals(refused):
    settings = CampaignSettings(algorithm="eaMuCommaLambda", population=20, offspring=19)

    with refused(UsageError):
        start(settings)


@pytest.mark.parametrize(("name", "n_offspring"), [("eaMuPlusLambda", 7), ("eaMuCommaLambda", 31)])
def test_strategies_breed_as_many_as_set(name, n_offspring):
    settings = CampaignSettings(
        algorithm=name, offspring=n_offspring, crossover=0.5, mutation=0.5, generations=3
    )

    asked, summaries = run(start(settings))

    assert [len(generation) for generation in asked] == [20, *[n_offspring] * 3]
    assert all(len(summary.population) == 20 for summary in summaries)


@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_population_of_zero_fitness_evolves_on(name):
    algorithm = start(CampaignSettings(algorithm=name, generations=3))

    while not algorithm.is_finished:
        summary = algorithm.tell(scores(len(algorithm.ask())))

    assert len(summary.population) == 20


@pytest.mark.parametrize("name", ALGORITHMS)
@pytest.mark.parametrize("population", [1, 2, 3, 20])
def test_populations_of_any_size_evolve_for_as_many_generations_as_set(name, population):
    settings = CampaignSettings(algorithm=name, population=population, generations=3)

    asked, summaries = run(start(settings))

    assert [summary.index for summary in summaries] == [0, 1, 2, 3]
    assert len(asked[0]) == population
    assert [len(summary.population) for summary in summaries] == [population] * 4


@pytest.mark.parametrize("name", ALGORITHMS)
def test_a_mission_of_one_tick_and_a_pool_of_one_fault_can_be_searched(name):
    _, summaries = run(start(CampaignSettings(algorithm=name, generations=3), 1, "f26"))

    assert len(summaries) == 4


def test_as_many_scores_are_told_as_were_asked_for():
    algorithm = start(CampaignSettings(generations=0))
    asked = algorithm.ask()

    with pytest.raises(ValueError, match="zip"):
        algorithm.tell(scores(len(asked) - 1))
