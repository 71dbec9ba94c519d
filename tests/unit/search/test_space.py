from collections import Counter
from dataclasses import replace
from random import Random

import pytest

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import Event, FaultPool, TimedFault, Trigger, fault_ticks
from mrsfi_runtime.search.loop import MUTATIONS, filled, forced
from mrsfi_runtime.search.space import SearchSpace, random_specification, random_window
from tests.support.search import paper_mission, paper_space, pool_of


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

    for draw in (lambda space, rng: filled(space, (), 1, rng), lambda s, rng: forced(s, (), rng)):
        one, other = (draw(space, Random(5)) for space in (plain, declared))
        assert [timed._replace(trigger="") for timed in other] == [*one]
