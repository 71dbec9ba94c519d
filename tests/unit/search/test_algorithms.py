import json
import statistics
from random import Random

import pytest

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.algorithms import ALGORITHMS, Algorithm, GenerationSummary
from mrsfi_runtime.search.settings import CampaignSettings
from mrsfi_runtime.search.specifications import random_specification
from support_search import paper_space, stand_in_outcome


def fitness_of(specification: Specification) -> float:
    return float(sum(stand_in_outcome(specification).believed))


def start(settings: CampaignSettings, duration: int = 1000, *fault_ids: str) -> Algorithm:
    return ALGORITHMS[settings.algorithm](paper_space(duration, *fault_ids), settings)


def run(algorithm: Algorithm) -> tuple[list[list[Specification]], list[GenerationSummary]]:
    asked, summaries = [], []
    while not algorithm.is_finished:
        asked.append(algorithm.ask())
        summaries.append(algorithm.tell([fitness_of(s) for s in asked[-1]]))
    return asked, summaries


@pytest.mark.parametrize("name", ALGORITHMS)
def test_generation_zero_is_followed_by_as_many_as_set(name: str) -> None:
    asked, summaries = run(start(CampaignSettings(algorithm=name, generations=5)))

    assert [summary.index for summary in summaries] == [0, 1, 2, 3, 4, 5]
    assert len(asked[0]) == 20
    assert all(len(summary.population) == 20 for summary in summaries)


@pytest.mark.parametrize("name", ALGORITHMS)
@pytest.mark.parametrize("n_evaluations", [1, 20, 137])
def test_a_number_of_evaluations_is_met_exactly(name: str, n_evaluations: int) -> None:
    settings = CampaignSettings(algorithm=name, generations=3, evaluations=n_evaluations)

    asked, summaries = run(start(settings))

    assert sum(map(len, asked)) == n_evaluations
    assert sum(summary.statistics["n_evaluations"] for summary in summaries) == n_evaluations


@pytest.mark.parametrize("name", ["paper", "drift"])
def test_a_run_in_which_nothing_can_change_ends_without_its_evaluations(name: str) -> None:
    settings = CampaignSettings(
        algorithm=name, generations=3, crossover=0.0, mutation=0.0, evaluations=500
    )

    asked, summaries = run(start(settings))

    assert sum(map(len, asked)) == 20
    assert len(summaries) == 4


@pytest.mark.parametrize("name", ALGORITHMS)
def test_the_same_seed_repeats_the_run_and_another_does_not(name: str) -> None:
    settings = CampaignSettings(algorithm=name, generations=4, seed=5)

    first, again = start(settings), start(settings)
    other = start(CampaignSettings(algorithm=name, generations=4, seed=6))

    assert run(first) == run(again)
    assert first.random_state() == again.random_state()
    assert run(other) != run(start(settings))


def test_the_random_state_continues_the_run() -> None:
    algorithm = start(CampaignSettings(algorithm="random", generations=1))
    algorithm.tell([0.0] * len(algorithm.ask()))
    version, words, gauss = json.loads(algorithm.random_state())
    rng = Random()
    rng.setstate((version, tuple(words), gauss))

    expected = [random_specification(paper_space(), 20, rng) for _ in range(20)]

    assert algorithm.ask() == expected


def test_statistics_are_those_of_the_population() -> None:
    asked, summaries = run(start(CampaignSettings(generations=6)))
    specifications = [specification for generation in asked for specification in generation]

    for generation, summary in zip(asked, summaries, strict=True):
        fitness = [fitness_of(specifications[number]) for number in summary.population]
        assert summary.statistics == {
            "n_evaluations": len(generation),
            "mean": statistics.fmean(fitness),
            "std": statistics.pstdev(fitness),
            "min": min(fitness),
            "max": max(fitness),
        }


def test_selection_raises_fitness_where_drift_does_not() -> None:
    _, paper = run(start(CampaignSettings(mutation_share=0.1)))
    _, drift = run(start(CampaignSettings(algorithm="drift", mutation_share=0.1)))

    def late(summaries: list[GenerationSummary]) -> float:
        return statistics.fmean(summary.statistics["mean"] for summary in summaries[-10:])

    assert late(paper) > paper[0].statistics["mean"] > late(drift)


def test_a_population_of_zero_fitness_evolves_on() -> None:
    algorithm = start(CampaignSettings(generations=3))

    while not algorithm.is_finished:
        summary = algorithm.tell([0.0] * len(algorithm.ask()))

    assert len(summary.population) == 20


@pytest.mark.parametrize("population", [1, 2, 3])
def test_small_populations_evolve(population: int) -> None:
    _, summaries = run(start(CampaignSettings(population=population, generations=3)))

    assert [len(summary.population) for summary in summaries] == [population] * 4


def test_a_mission_of_one_tick_and_a_pool_of_one_fault_can_be_searched() -> None:
    _, summaries = run(start(CampaignSettings(generations=3), 1, "f26"))

    assert len(summaries) == 4


def test_asking_and_telling_out_of_turn_is_refused() -> None:
    algorithm = start(CampaignSettings(generations=0))

    with pytest.raises(ValueError, match="expected 0 after an ask"):
        algorithm.tell([1.0])
    asked = algorithm.ask()
    with pytest.raises(ValueError, match="found another ask"):
        algorithm.ask()
    with pytest.raises(ValueError, match="found 1 fitness values; expected 20"):
        algorithm.tell([1.0])
    algorithm.tell([1.0] * len(asked))
    with pytest.raises(ValueError, match="found another ask"):
        algorithm.ask()


def test_fitness_that_is_not_a_number_is_refused() -> None:
    algorithm = start(CampaignSettings())
    n_asked = len(algorithm.ask())

    with pytest.raises(EvaluationError, match="expected a finite number"):
        algorithm.tell([float("nan")] * n_asked)
