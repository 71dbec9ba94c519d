import random
from collections import Counter
from random import Random

import pytest
from deap import tools
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import (
    Individual,
    best,
    lent_to_deap,
    roulette,
    tournament,
    uniform,
)


def population_of(*fitness: float) -> list[Individual]:
    individuals = []
    for place, value in enumerate(fitness):
        individual = Individual((TimedFault("f1", place, place),))
        individual.assess(Score(value, ()))
        individuals.append(individual)
    return individuals


def shares(selected: list[Individual], population: list[Individual]) -> list[float]:
    counts = Counter(id(individual) for individual in selected)
    return [round(counts[id(individual)] / len(selected), 1) for individual in population]


@pytest.mark.parametrize(
    ("select", "fitness", "expected"),
    [
        (roulette, (0.0, 0.0, 0.0, 0.0, 0.0), [0.2] * 5),
        (uniform, (0.0, 1.0, 1000.0, 0.0, 5.0), [0.2] * 5),
        (tournament, (0.0, 1.0), [0.1, 0.9]),  # of three: 1/8 and 7/8
    ],
)
def test_shares_of_those_that_are_selected(select, fitness, expected):
    population = population_of(*fitness)

    assert shares(select(population, 5000, Random(1)), population) == expected


@given(st.lists(st.floats(0.0, 1e6), min_size=1).filter(sum), st.integers(0, 2**32))
def test_roulette_selects_whom_deap_selects(fitness, seed):
    population = population_of(*fitness)
    rng = Random(seed)

    selected = roulette(population, 50, rng)

    again = Random(seed)
    with lent_to_deap(again):
        expected = tools.selRoulette(population, 50)
    n_selected = len(expected)  # fewer where a spin ended behind the last slot
    assert list(map(id, selected[:n_selected])) == list(map(id, expected))
    assert n_selected < 50 or rng.getstate() == again.getstate()


@pytest.mark.parametrize("scale", [5e-324, 1e-300, 0.1, 1e300])
def test_roulette_returns_as_many_as_wanted_at_any_scale(scale):
    population = population_of(*(scale * place for place in range(1, 8)))

    assert len(roulette(population, 500, Random(1))) == 500


def test_roulette_refuses_negative_fitness(refused):
    with refused(EvaluationError):
        roulette(population_of(3.0, -1.0), 2, Random(1))


def test_the_best_are_each_selected_once():
    population = population_of(3.0, 1.0, 2.0)

    assert best(population, 2, Random(1)) == [population[0], population[2]]


@pytest.mark.parametrize("select", [roulette, tournament, uniform])
def test_selection_repeats_from_its_seed_and_leaves_the_global_generator_alone(select):
    population = population_of(1.0, 2.0, 3.0)
    before = random.getstate()
    rng = Random(5)

    first, second = select(population, 20, rng), select(population, 20, rng)

    assert random.getstate() == before
    assert first != second
    assert first == select(population, 20, Random(5))
