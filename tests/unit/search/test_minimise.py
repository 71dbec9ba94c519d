"""Searches for much harm with few faults, or few ticks of them."""

from collections.abc import Sequence

import pytest

from mrsfi_runtime.model.faults import COSTS, Specification, TimedFault
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.search.algorithms import ALGORITHMS
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import Criticality, Individual, foremost
from tests.support.search import paper_space, stand_in_outcome

SPACE = paper_space()
N_FAULTS = 12


def settings_of(algorithm: str, **values: object) -> CampaignSettings:
    return CampaignSettings(
        algorithm=algorithm, faults=N_FAULTS, generations=60, fitness="focused", **values
    )


def searched(settings: CampaignSettings) -> list[list[tuple[Specification, Score]]]:
    """Return what each generation asked for, and what it was told."""
    algorithm = ALGORITHMS[settings.algorithm](SPACE, settings)
    columns = [int(goal[1:]) - 1 for goal in settings.goals] or range(6)
    generations = []
    while not algorithm.is_finished:
        asked = algorithm.ask()
        goals = [tuple(stand_in_outcome(one).believed[c] for c in columns) for one in asked]
        scores = [Score(float(sum(each)), each) for each in goals]
        algorithm.tell(scores)
        generations.append(list(zip(asked, scores, strict=True)))
    return generations


@pytest.mark.parametrize("goals", [(), ("g2",), ("g1", "g3")])
@pytest.mark.parametrize("minimise", COSTS)
@pytest.mark.parametrize("algorithm", MINIMISING)
def test_individuals_have_one_to_all_faults_and_keep_the_restriction(algorithm, minimise, goals):
    generations = searched(settings_of(algorithm, minimise=minimise, goals=goals))

    first = {len(specification) for specification, _ in generations[0]}
    later = [specification for asked in generations[1:] for specification, _ in asked]
    assert min(first) < 5
    assert max(first) > 8
    assert all(1 <= size <= N_FAULTS for size in first)
    assert {len(specification) for specification in later} > {1, 2, 3}
    for specification in later:
        assert 1 <= len(specification) <= N_FAULTS
        assert SPACE.require(specification, "search") == specification


@pytest.mark.parametrize("algorithm", MINIMISING)
def test_without_it_individuals_begin_with_all_their_faults(algorithm):
    first, *_ = searched(settings_of(algorithm))

    assert {len(specification) for specification, _ in first} == {N_FAULTS}


def most_by_one(generations: Sequence[Sequence[tuple[Specification, Score]]]) -> float:
    """Return the most violations that a single fault did."""
    found = [score.fitness for asked in generations for each, score in asked if len(each) == 1]
    return max(found, default=0.0)


@pytest.mark.parametrize(("algorithm", "least"), [("guided", 1000), ("nsga2", 800)])
def test_few_faults_are_driven_to_much_harm(algorithm, least):
    generations = searched(settings_of(algorithm, minimise="faults", goals=("g2",)))

    assert most_by_one(generations[:1]) < most_by_one(generations)
    assert most_by_one(generations) >= least


def test_of_equal_harm_the_fewest_are_foremost_and_of_equal_size_the_most_harmful():
    def individual(n_faults: int, violations: float) -> Individual:
        made = Individual(tuple(TimedFault("f8", 9 * n, 9 * n) for n in range(n_faults)))
        made.assess(Score(violations, (violations,)))
        return made

    few, many, harmless, worst = (
        individual(*each) for each in ((2, 50.0), (3, 50.0), (2, 40.0), (9, 60.0))
    )

    best = foremost(
        [harmless, many, worst, few], 2, lambda one: Criticality(one.score.goals, (len(one),))
    )

    assert {id(one) for one in best} == {id(few), id(worst)}
    assert few.fitness.weights == (1.0, -1.0)
