"""The front that the guided search keeps if a campaign names few goals."""

from itertools import count

import pytest

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.guided import guided
from mrsfi_runtime.search.loop import Algorithm
from mrsfi_runtime.search.settings import CampaignSettings
from support_search import paper_space

TWO_GOALS = ("g1", "g3")
ALL_GOALS = ("g1", "g2", "g3", "g4", "g5", "g6")


def start(goals: tuple[str, ...], generations: int = 20) -> Algorithm:
    return guided(
        paper_space(),
        CampaignSettings(
            algorithm="guided", fitness="focused", goals=goals, generations=generations
        ),
    )


def scored(*goals: float) -> Score:
    return Score(sum(goals), goals)


def likeness(one: Specification, other: Specification) -> float:
    return len(set(one) & set(other)) / len(set(one) | set(other))


def late_children_of_a_compromise(goals: tuple[str, ...]) -> int:
    """Count them in a run whose other findings have ever more of one goal and none of the other.

    The compromise is best in neither goal, nor of those that violate both, and leaves the
    population early, as its sum is low.
    """
    algorithm = start(goals, generations=20)
    more = count(300)
    compromise, *others = known = algorithm.ask()
    algorithm.tell(
        [scored(50, 50), scored(0, 200), scored(190, 20), *(scored(100, 0) for _ in others[2:])]
    )
    n_children = 0
    for generation in range(1, 21):
        asked = algorithm.ask()
        if generation > 10:
            nearest = [max(known, key=lambda one: likeness(one, child)) for child in asked]
            n_children += nearest.count(compromise)
        known += asked
        algorithm.tell([scored(next(more), 0) for _ in asked])
    return n_children


def test_a_compromise_that_the_sum_forgets_stays_a_parent() -> None:
    assert late_children_of_a_compromise(TWO_GOALS) > 5


def test_no_front_is_kept_of_all_goals() -> None:
    assert late_children_of_a_compromise(()) == 0


def test_half_of_the_beginning_has_fewer_faults_if_two_goals_are_named() -> None:
    sizes = sorted(len(specification) for specification in start(TWO_GOALS).ask())

    assert 1 <= sizes[0] < 10
    assert 5 <= sum(size >= 18 for size in sizes) <= 15


@pytest.mark.parametrize("goals", [TWO_GOALS, ALL_GOALS[:3]])
def test_a_search_that_keeps_a_front_repeats(goals: tuple[str, ...]) -> None:
    first, again = start(goals), start(goals)

    while not first.is_finished:
        asked = first.ask()
        assert again.ask() == asked
        scores = [scored(*(len(one) * n % 7 for n in range(1, len(goals) + 1))) for one in asked]
        first.tell(scores)
        again.tell(scores)
    assert first.random_state() == again.random_state()


def test_naming_all_goals_of_a_mission_of_six_changes_nothing() -> None:
    named, unnamed = start(ALL_GOALS), start(())

    while not named.is_finished:
        asked = named.ask()
        assert unnamed.ask() == asked
        scores = [scored(*(len(one) * n % 7 for n in range(1, 7))) for one in asked]
        named.tell(scores)
        unnamed.tell(scores)
