"""The front that the guided search keeps if a campaign names few goals."""

import tracemalloc
from itertools import count

import pytest

from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.algorithms import ALGORITHMS
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import Algorithm
from tests.support.search import paper_space

TWO_GOALS = ("g1", "g3")
ALL_GOALS = ("g1", "g2", "g3", "g4", "g5", "g6")


def start(goals: tuple[str, ...], algorithm: str = "guided") -> Algorithm:
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
    algorithm = start(goals)
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
    algorithm = start(TWO_GOALS)
    known = [frozenset(one) for one in algorithm.ask()]
    algorithm.tell(scores_with_a_compromise(len(known)))
    n_taken_over = 0

    for _ in range(20):
        asked = [frozenset(one) for one in algorithm.ask()]
        algorithm.tell([scored(0, 0) for _ in asked])
        n_taken_over += sum(nearest(known, child) > 0 and bool(child & known[0]) for child in asked)

    assert n_taken_over > 10


def test_it_begins_as_the_paper_does_if_two_goals_are_named():
    assert start(TWO_GOALS).ask() == start(TWO_GOALS, "paper").ask()


@pytest.mark.parametrize(
    ("goals", "others"),
    [(TWO_GOALS, TWO_GOALS), (ALL_GOALS[:3], ALL_GOALS[:3]), (ALL_GOALS, ())],
)
def test_a_search_repeats_and_naming_all_goals_of_a_mission_of_six_changes_nothing(goals, others):
    first, again = start(goals), start(others)

    while not first.is_finished:
        asked = first.ask()
        assert again.ask() == asked
        scores = [scored(*(len(one) * n % 7 for n in range(1, len(goals) + 1))) for one in asked]
        first.tell(scores)
        again.tell(scores)
    assert first.random_state() == again.random_state()


def test_what_was_asked_for_is_remembered_in_few_bytes():
    algorithm = start(TWO_GOALS)
    tracemalloc.start()
    held = []
    for _ in range(40):
        n_asked = len(algorithm.ask())
        algorithm.tell([scored(1, 1)] * n_asked)
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()

    assert (held[-1] - held[9]) / (30 * n_asked) < 300  # a specification takes thousands
