"""The space of fault specifications: draws, bounds, and the fitness of what is drawn."""

import sys
from collections import Counter
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest

from mrsfi_runtime.errors import EvaluationError, SpecificationError
from mrsfi_runtime.model.faults import (
    Event,
    Fault,
    FaultPool,
    TimedFault,
    Trigger,
    fault_ticks,
    value_bounds,
)
from mrsfi_runtime.model.mission import Area, Coordinates, Message, MessageData, Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import FITNESS_FUNCTIONS, FitnessInput, Judge, Score, averaged
from mrsfi_runtime.search.loop import MUTATIONS, filled, forced
from mrsfi_runtime.search.space import (
    SearchSpace,
    drawn_as,
    draws,
    random_specification,
    random_window,
    varied_fault,
)
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import PAPER_FAULTS, outcome_of, paper_mission, paper_space, pool_of

REACH = (-3000.0, 3000.0)
DEFAULTS = {
    "f2": ((1.0, 1000.0),),
    "f4": ((0.0, 100.0),),
    "f5": ((0.0, 50.0),),
    "f6": ((0.0, 100.0),),
    "f7": ((0.0, 40.0),),
    "f8": ((1.0, 1000.0),),
    "f9": (REACH, REACH, (1.0, 1.0)),
    "f10": ((0.0, 100000.0),),
    "f11": (REACH, REACH, (1.0, 1.0)),
    "f12": ((0.0, 120.0),),  # ten times nominal is 50: widened to the pool's own value
    "f13": ((0.0, 20.0),),
    "f14": ((0.0, 50.0),),  # likewise, from 40
    "f15": ((0.0, 100.0),),
    "f16": ((0.0, 50.0),),
    "f17": ((0.0, 100.0),),
    "f18": ((0.0, 40.0),),
    "f20": ((255.0, 255.0), (1000.0, 1000.0)),
    "f22": ((1.0, 1.0), (50.0, 50.0)),
    "f23": ((11.0, 11.0), (30.0, 30.0)),
    "f24": ((-8.0, -8.0), (8.0, 8.0)),
}
VIOLATIONS = (10, 0, 5, 0, 0, 85)


def test_free_windows_lie_between_conflicting_faults_only():
    space = paper_space(100)
    others = [
        TimedFault("f27", 50, 99),
        TimedFault("f4", 10, 19, (10.0,)),
        TimedFault("f26", 0, 99),
    ]

    assert space.free_windows("f10", others) == [(0, 9), (20, 49)]
    assert space.free_windows("f26", others) == []
    assert space.free_windows("f1", others) == [(0, 99)]


def test_random_windows_are_those_of_two_ticks_drawn_until_they_are_free():
    rng = Random(3)
    n_draws = 20_000

    drawn = Counter(random_window([(0, 0), (5, 6)], rng) for _ in range(n_draws))

    shares = {window: round(count / n_draws, 1) for window, count in drawn.items()}
    assert shares == {(0, 0): 0.2, (5, 5): 0.2, (6, 6): 0.2, (5, 6): 0.4}


def test_the_same_set_of_timed_faults_has_one_order():
    space = paper_space(100)
    faults = [
        TimedFault("f10", 5, 9, (1.0,)),
        TimedFault("f9", 5, 9, (0.0, 0.0, 1.0)),
        TimedFault("f30", 5, 8),
        TimedFault("f1", 0, 99),
    ]

    assert [timed.fault for timed in space.ordered(faults)] == ["f1", "f30", "f9", "f10"]
    assert space.ordered(reversed(faults)) == space.ordered(faults)


def test_an_empty_pool_is_refused(refused):
    with refused(SpecificationError):
        SearchSpace.of(paper_mission(), FaultPool("fs", ()))


@pytest.mark.parametrize(
    ("duration", "pool", "n_faults"),
    [(1000, "", 20), (1, "f9", 1), (7, "f9", 7), (20, "f9", 20), (30, "f9", 20)],
)
def test_individuals_of_the_paper_have_20_faults_or_what_fits_with_the_pools_values(
    duration, pool, n_faults
):
    space = paper_space(duration, *pool.split())

    specification = random_specification(space, 20, Random(1))

    assert len(specification) == n_faults
    assert all(each.values == space.candidates[each.fault].values for each in specification)


def test_every_fault_of_the_pool_is_drawn():
    space, rng = paper_space(), Random(1)

    drawn = {t.fault for _ in range(50) for t in random_specification(space, 20, rng)}

    assert drawn == set(space.candidates)


def test_fault_ticks_count_what_lies_inside_the_mission():
    specification = (TimedFault("f1", 0, 9), TimedFault("f3", 95, 120), TimedFault("f9", 200, 300))

    assert fault_ticks(specification, 100) == 10 + 5


@pytest.mark.parametrize(
    "timed",
    [
        TimedFault("f9", 15.08, 20, (1.0, 2.0, 3.0)),
        TimedFault("f8", 15, 20, (2.5,)),
        TimedFault("f99", 0, 1),
        TimedFault("f1", 0, 1000),
        TimedFault("f9", 0, 1, (1e9, 0.0, 0.0)),
    ],
)
def test_an_operators_offspring_passes_the_gate_and_stays_within_bounds(timed, refused):
    with refused(SpecificationError):
        paper_space().require((timed,), "mine")


TRIGGERS = (
    Trigger("low", Event.VIOLATED, ("g3",)),
    Trigger("of_f1", Event.EFFECT, ("f1",)),
    Trigger("of_two", Event.EFFECT, ("f1", "f2")),
)


def test_a_fault_waits_for_nothing_or_for_any_trigger_but_that_of_its_own_effect_alone():
    space = SearchSpace.of(paper_mission(), replace(pool_of("f1", "f2"), triggers=TRIGGERS))

    assert space.candidates["f1"].triggers == ("", "low", "of_two")
    assert space.candidates["f2"].triggers == ("", "low", "of_f1", "of_two")


@pytest.mark.parametrize("vary", MUTATIONS.values(), ids=MUTATIONS)
def test_random_and_mutated_faults_wait_for_each_trigger_as_often(vary):
    space = SearchSpace.of(paper_mission(), replace(pool_of(), triggers=TRIGGERS[::2]))
    rng = Random(1)
    drawn = [random_specification(space, 12, rng) for _ in range(100)]
    changed = [vary(space, each, rng, 1.0) for each in drawn]

    for some in (drawn, changed):
        n_waiting = Counter(timed.trigger for each in some for timed in each)
        assert n_waiting.keys() == {"", "low", "of_two"}
        assert all(300 < n < 500 for n in n_waiting.values())


def test_triggers_change_nothing_else_of_what_is_drawn_first():
    """Beside one draw each, which comes last."""
    plain, declared = (
        SearchSpace.of(paper_mission(), replace(pool_of(), triggers=triggers))
        for triggers in ((), TRIGGERS[:1])
    )

    replaced = (TimedFault("f9", 0, 9, (200.0, -450.0)),)
    for draw in (lambda s, rng: filled(s, (), 1, rng), lambda s, rng: forced(s, replaced, rng)):
        one, other = (draw(space, Random(5)) for space in (plain, declared))
        assert [timed._replace(trigger="") for timed in other] == [*one]


def fault_of(fault_id: str) -> Fault:
    return next(fault for fault in PAPER_FAULTS if fault.id == fault_id)


@pytest.mark.parametrize("fault", PAPER_FAULTS, ids=lambda fault: fault.type)
def test_defaults_come_from_the_mission(fault):
    assert value_bounds(paper_mission(), fault) == DEFAULTS.get(fault.id, ())


@pytest.mark.parametrize(
    ("bounds", "expected"),
    [
        ((None, 10.0), (1.0, 10.0)),
        ((3.0, None), (3.0, 1000.0)),
        ((3.0, 10.0), (3.0, 10.0)),
        ((2.5, 9.5), (3.0, 9.0)),
        ((7.0, 9.0), (5.0, 9.0)),
        ((1.0, 4.0), (1.0, 5.0)),
        ((9.0, 2.0), (5.0, 5.0)),
    ],
)
def test_bounds_of_the_model_replace_defaults_and_include_the_pools_value(bounds, expected):
    fault = replace(fault_of("f2"), bounds={"BLOCK_DURATION": bounds})

    assert value_bounds(paper_mission(), fault) == (expected,)


def test_a_value_with_no_whole_number_in_its_bounds_is_fixed():
    fault = replace(fault_of("f2"), values=(2.5,), bounds={"BLOCK_DURATION": (2.2, 2.8)})

    assert value_bounds(paper_mission(), fault) == ((2.5, 2.5),)


def test_delay_in_a_mission_of_one_tick_still_includes_the_pools_value():
    assert value_bounds(paper_mission(1), fault_of("f8")) == ((1.0, 200.0),)


def test_coordinates_are_bounded_around_the_centre_of_the_mission_area():
    mission = replace(paper_mission(), area=Area("a", Coordinates(1000.0, -500.0), 200.0))
    fault = replace(fault_of("f9"), values=(1000.0, -500.0, 1.0))

    assert value_bounds(mission, fault) == ((700.0, 1300.0), (-800.0, -200.0), (1.0, 1.0))


def test_rates_and_costs_follow_the_largest_of_the_touched_sensors():
    mission = paper_mission()
    robot = mission.robots[1]
    sensors = (robot.sensors[0], replace(robot.sensors[1], samples_per_second=9))
    mission = replace(
        mission, robots=(mission.robots[0], replace(robot, sensors=sensors), mission.robots[2])
    )
    fault = Fault("x", FAULT_TYPES["FixedSampleRate"], "m7", (1.0,))

    assert value_bounds(mission, fault) == ((0.0, 90.0),)


def test_a_fault_in_a_servers_message_has_nothing_nominal_to_exceed():
    mission = paper_mission()
    message = Message("m99", "sv1", "r1", (MessageData("SPEED", "Int"),))
    goal = replace(mission.goals[0], messages=(message,))
    mission = replace(mission, goals=(goal, *mission.goals[1:]))

    assert value_bounds(mission, Fault("x", FAULT_TYPES["FixedSpeed"], "m99", (3.0,))) == (
        (0.0, 3.0),
    )
    assert value_bounds(mission, Fault("x", FAULT_TYPES["FixedSampleRate"], "m99", (3.0,))) == (
        (0.0, 3.0),
    )


def test_an_unknown_message_is_refused(refused):
    with refused(SpecificationError):
        value_bounds(paper_mission(), Fault("x", FAULT_TYPES["FixedSpeed"], "m77", (3.0,)))


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


@pytest.mark.parametrize("fault", ["f2", "f11", "f26"])
def test_a_way_to_draw_a_fault_alone_is_as_likely_as_it_comes_up(fault):
    rng, space = Random(1), paper_space()
    whole = [(0, space.duration - 1)]

    drawn = Counter(drawn_as(space, varied_fault(space, fault, whole, rng)) for _ in range(6000))

    chances = {way: chance for way, (chance, _) in draws(space, fault).items()}
    assert sum(chances.values()) == pytest.approx(1.0)
    assert {way: n / 6000 for way, n in drawn.items()} == pytest.approx(chances, abs=0.02)
