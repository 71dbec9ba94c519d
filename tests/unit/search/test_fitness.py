import sys
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import (
    FITNESS_FUNCTIONS,
    FitnessInput,
    Judge,
    Score,
    averaged,
)
from tests.support.search import outcome_of, paper_mission

VIOLATIONS = (10, 0, 5, 0, 0, 85)


def findings_of(violations: tuple[int, ...], duration: int = 1000) -> FitnessInput:
    return FitnessInput(outcome_of(*violations), violations, (0, 2), duration)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("weighted", 0.3 * 100 + 0.7 * 3),
        ("weighted_normalised", 0.3 * (100 / 6000) + 0.7 * (3 / 6)),
        ("focused", 15.0),
    ],
)
def test_fitness_follows_its_equation(name, expected):
    assert FITNESS_FUNCTIONS[name](findings_of(VIOLATIONS)) == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("violations", "margin", "expected"),
    [(0, (3.0, 9), 0.25), (0, (0.0, 9), 1.0), (0, None, 0.0), (2, (-1.0, 9), 2.0)],
)
def test_nearest_points_to_a_goal_that_is_not_violated_and_never_beyond_one(
    violations, margin, expected
):
    outcome = replace(outcome_of(violations), margins=(margin,))

    assert FITNESS_FUNCTIONS["nearest"](FitnessInput(outcome, (violations,), (0,), 9)) == expected


@pytest.mark.parametrize("name", FITNESS_FUNCTIONS)
def test_a_mission_without_violations_has_fitness_zero(name):
    assert FITNESS_FUNCTIONS[name](findings_of((0, 0, 0))) == 0.0


def test_normalised_fitness_is_one_when_every_goal_is_always_violated():
    fitness = FITNESS_FUNCTIONS["weighted_normalised"](findings_of((50, 50), 50))

    assert fitness == pytest.approx(1.0)


def test_goal_vector_keeps_the_order_of_the_chosen_goals():
    judge = Judge(CampaignSettings(goals=("g6", "g1")), paper_mission())

    assert judge.goals(outcome_of(*VIOLATIONS)) == (85, 10)


@pytest.mark.parametrize(
    ("violations", "expected"),
    [("believed", (10.0, 3)), ("true", (8.0, 4)), ("masked", (3.0, 2)), ("missed", (5.0, 0))],
)
def test_a_campaign_chooses_which_violations_are_judged(violations, expected):
    counts = {
        "believed": (3, 0, 7),
        "true": (4, 1, 4),
        "phantom": (1, 0, 4),
        "masked": (2, 1, 1),
        "missed": (0, 9, 5),
    }
    padded = {name: (*count, 0, 0, 0) for name, count in counts.items()}
    outcome = Outcome(**padded, samples=(0,) * 6, applied=(), changed=(), digest="")
    settings = CampaignSettings(fitness="focused", goals=("g3", "g1"), violations=violations)

    score = Judge(settings, paper_mission()).score(outcome)

    fitness, first_goal = expected
    assert score == Score(fitness, (int(fitness) - first_goal, first_goal))


def judged_by(monkeypatch, value):
    monkeypatch.setitem(sys.modules, "own", SimpleNamespace(fitness=lambda _: value))
    judge = Judge(CampaignSettings(fitness="own:fitness"), paper_mission())
    return judge.score(outcome_of(*VIOLATIONS)).fitness


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (7, 7.0),
        (True, 1.0),
        (Fraction(1, 3), 1 / 3),
        (np.float32(0.5), 0.5),
        (np.int64(7), 7.0),
        (-1e100, -1e100),
        (10**30 + 1, 1e30),
    ],
    ids=repr,
)
def test_any_real_number_is_a_fitness_as_a_float(monkeypatch, value, expected):
    found = judged_by(monkeypatch, value)

    assert (found, type(found)) == (expected, float)


@pytest.mark.parametrize(
    "value",
    [
        10**400,
        -(10**5000),
        Fraction(10**400),
        Fraction(-(10**400), 3),
        float("nan"),
        np.float32("-inf"),
        1.7e308,
    ],
    ids=["int", "negative int", "Fraction", "negative Fraction", "nan", "float32", "huge float"],
)
def test_a_fitness_that_is_no_finite_float_is_refused(monkeypatch, value, refused):
    with refused(EvaluationError):
        judged_by(monkeypatch, value)


@pytest.mark.parametrize("value", [None, "3", 1j, Decimal(3), np.array([3.0])], ids=repr)
def test_what_is_no_real_number_is_no_fitness(monkeypatch, value, refused):
    with refused(EvaluationError):
        judged_by(monkeypatch, value)


def test_scores_of_several_mission_seeds_are_averaged():
    scores = [Score(1.0, (0, 4)), Score(2.0, (3, 4)), Score(6.0, (3, 1))]

    assert averaged(scores) == Score(3.0, (2.0, 3.0))
