"""Algorithms: operators, selection, individuals, guided searches and those that minimise."""

import json
import random
import statistics
import tracemalloc
from collections import Counter
from collections.abc import Sequence
from itertools import count
from random import Random
from typing import Any

import pytest
from deap import tools
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import EvaluationError, UsageError
from mrsfi_runtime.model.faults import COSTS, Specification, TimedFault
from mrsfi_runtime.record.database import specification_text
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.search.algorithms import ALGORITHMS, Breeder, _hash
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import (
    Algorithm,
    Criticality,
    GenerationSummary,
    Individual,
    best,
    foremost,
    lent_to_deap,
    roulette,
    tournament,
    uniform,
)
from mrsfi_runtime.search.space import random_specification
from tests.support.search import paper_space, random_pair, stand_in_outcome

TWO_GOALS = ("g1", "g3")
ALL_GOALS = ("g1", "g2", "g3", "g4", "g5", "g6")
SPACE = paper_space()
N_FAULTS = 12


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


def test_specifications_that_differ_in_the_sign_of_a_zero_are_the_same_to_the_guided_search():
    rows = [(0.0, -0.05, 0.0), (-0.0, -0.05, -0.0), (0.0, 0.05, 0.0)]

    texts = [specification_text((TimedFault("f-0.0", 1, 2, values),)) for values in rows]

    one, same, other = map(_hash, texts)
    assert one == same != other


def start_on(goals: tuple[str, ...], algorithm: str = "guided") -> Algorithm:
    return ALGORITHMS[algorithm](
        paper_space(),
        CampaignSettings(algorithm=algorithm, fitness="focused", goals=goals, generations=40),
    )


def scored(*goals: float) -> Score:
    return Score(sum(goals), goals)


def nearest(known: list[frozenset[TimedFault]], child: frozenset[TimedFault]) -> int:
    """Return the place of the one that shares most with the child, of what either has."""
    likeness = [len(one & child) / len(one | child) for one in known]
    return likeness.index(max(likeness))


def scores_with_a_compromise(n_scores: int) -> list[Score]:
    """Return the compromise's first."""
    return [scored(50, 50), scored(0, 200), scored(190, 20), *[scored(100, 0)] * (n_scores - 3)]


def late_children_of_a_compromise(goals: tuple[str, ...]) -> int:
    """Count them in a run whose other findings have ever more of one goal and none of the other.

    The compromise is best in neither goal, nor of those that violate both, and leaves the
    population early, as its sum is low.
    """
    algorithm = start_on(goals)
    more = count(300)
    known = [frozenset(one) for one in algorithm.ask()]
    algorithm.tell(scores_with_a_compromise(len(known)))
    n_children = 0
    for generation in range(1, 41):
        asked = [frozenset(one) for one in algorithm.ask()]
        if generation > 10:
            n_children += sum(nearest(known, child) == 0 for child in asked)
        known += asked
        algorithm.tell([scored(next(more), 0) for _ in asked])
    return n_children


def test_a_compromise_that_the_sum_forgets_stays_a_parent():
    assert late_children_of_a_compromise(TWO_GOALS) > 10


def test_no_front_is_kept_of_all_goals():
    assert late_children_of_a_compromise(()) == 0


def test_faults_are_taken_over_from_a_compromise_that_is_best_in_no_goal():
    algorithm = start_on(TWO_GOALS)
    known = [frozenset(one) for one in algorithm.ask()]
    algorithm.tell(scores_with_a_compromise(len(known)))
    n_taken_over = 0

    for _ in range(20):
        asked = [frozenset(one) for one in algorithm.ask()]
        algorithm.tell([scored(0, 0) for _ in asked])
        n_taken_over += sum(nearest(known, child) > 0 and bool(child & known[0]) for child in asked)

    assert n_taken_over > 10


def test_it_begins_as_the_paper_does_if_two_goals_are_named():
    assert start_on(TWO_GOALS).ask() == start_on(TWO_GOALS, "paper").ask()


@pytest.mark.parametrize(
    ("goals", "others"),
    [(TWO_GOALS, TWO_GOALS), (ALL_GOALS[:3], ALL_GOALS[:3]), (ALL_GOALS, ())],
)
def test_a_search_repeats_and_naming_all_goals_of_a_mission_of_six_changes_nothing(goals, others):
    first, again = start_on(goals), start_on(others)

    while not first.is_finished:
        asked = first.ask()
        assert again.ask() == asked
        scores = [scored(*(len(one) * n % 7 for n in range(1, len(goals) + 1))) for one in asked]
        first.tell(scores)
        again.tell(scores)
    assert first.random_state() == again.random_state()


def test_what_was_asked_for_is_remembered_in_few_bytes():
    algorithm = start_on(TWO_GOALS)
    tracemalloc.start()
    held = []
    for _ in range(40):
        n_asked = len(algorithm.ask())
        algorithm.tell([scored(1, 1)] * n_asked)
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()

    assert (held[-1] - held[9]) / (30 * n_asked) < 300  # a specification takes thousands


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
