import pytest

from mrsfi_runtime.search.fitness import FITNESS_FUNCTIONS, goal_vector
from support_search import outcome_of

OUTCOME = outcome_of(10, 0, 5, 0, 0, 85)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("weighted", 0.3 * 100 + 0.7 * 3),
        ("weighted_normalised", 0.3 * (100 / 6000) + 0.7 * (3 / 6)),
        ("focused", 15.0),
    ],
)
def test_fitness_follows_its_equation(name: str, expected: float) -> None:
    assert FITNESS_FUNCTIONS[name](OUTCOME, (0, 2), 1000) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("name", FITNESS_FUNCTIONS)
def test_a_mission_without_violations_has_fitness_zero(name: str) -> None:
    assert FITNESS_FUNCTIONS[name](outcome_of(0, 0, 0), (0, 1), 1000) == 0.0


def test_normalised_fitness_is_one_when_every_goal_is_always_violated() -> None:
    fitness = FITNESS_FUNCTIONS["weighted_normalised"](outcome_of(50, 50), (0, 1), 50)

    assert fitness == pytest.approx(1.0)


def test_goal_vector_keeps_the_order_of_the_chosen_goals() -> None:
    assert goal_vector(OUTCOME, (5, 0)) == (85, 10)
