from random import Random
from typing import Any

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.algorithms import Breeder
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import Individual
from tests.support.search import paper_space, random_pair


def evaluated_pair() -> tuple[Individual, Individual]:
    first, second = map(Individual, random_pair(paper_space(), 20, Random(1)))
    first.assess(Score(3.0, ()))
    second.assess(Score(4.0, ()))
    first.number, second.number = 0, 1
    return first, second


def operators(share: float) -> Any:
    return Breeder(paper_space(), CampaignSettings(mutation_share=share)).toolbox(Random(2))


def test_variation_of_copies_leaves_the_parents_untouched():
    parents = evaluated_pair()
    before = [(parent.specification, parent.fitness.values) for parent in parents]
    first, second = map(Individual.clone, parents)

    operators(1.0).mate(first, second)
    operators(1.0).mutate(first)

    assert [(parent.specification, parent.fitness.values) for parent in parents] == before
    assert [parent.number for parent in parents] == [0, 1]
    assert first.specification != parents[0].specification
    assert second.specification != parents[1].specification


def test_a_changed_individual_loses_its_fitness_and_number():
    first, second = evaluated_pair()

    operators(1.0).mate(first, second)

    assert not first.is_evaluated
    assert not second.is_evaluated
    assert first.number is None


def test_an_individual_that_variation_left_as_it_was_keeps_its_fitness():
    first, _ = evaluated_pair()
    twin = first.clone()

    operators(0.0).mate(first, twin)
    operators(0.0).mutate(first)

    assert first.fitness.values == twin.fitness.values == (3.0,)
    assert first.number == twin.number == 0
