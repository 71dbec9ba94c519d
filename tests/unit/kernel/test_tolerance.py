"""No verdict turns on the last bit."""

import math

import pytest

from mrsfi_runtime.api import (
    GatherSamples,
    Patrol,
    SufficientEnergy,
)
from mrsfi_runtime.kernel.commands import move, steer
from mrsfi_runtime.kernel.goal_tasks import table as goal_tasks
from mrsfi_runtime.kernel.state import excess
from mrsfi_runtime.model.mission import Area, Coordinates
from tests.support.world import state

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
SHORT, LONG = 1.0 - 1e-12, 1.0 + 1e-12
"""Factors that rounding may well amount to."""


@pytest.mark.parametrize(
    ("value", "expected"),
    [(100.0 + 5e-8, 0.0), (100.0 - 5e-8, 0.0), (101.0, 1.0), (99.0, -1.0), (100.0 + 2e-7, 2e-7)],
)
def test_what_differs_by_less_than_a_billionth_is_equal(value, expected):
    assert excess(value, 100.0) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("share", [SHORT, 1.0, LONG])
def test_energy_that_covers_the_need_but_for_rounding_suffices(share):
    view = state(SufficientEnergy(), duration=11)
    for each in view.robots:
        each.energy = share * 10 * (4.0 * 5.0 + 2 * 3.0 * 2)

    assert not goal_tasks.sufficient_energy.violated(view, 0)


@pytest.mark.parametrize("share", [SHORT, 1.0, LONG])
def test_the_edge_of_an_area_is_inside(share):
    patrol = state(Patrol(HERE, 1))
    gather = state(GatherSamples(5, "a_depth"), area=HERE)
    for view in (patrol, gather):
        for each in view.robots:
            each.x = share * 50.0
    patrol.mission.tick = 1

    goal_tasks.patrol.progress(patrol, 0)

    assert not goal_tasks.patrol.violated(patrol, 0)
    assert not goal_tasks.gather_samples.violated(gather, 0)


@pytest.mark.parametrize("share", [SHORT, 1.0, LONG])
def test_energy_that_is_used_up_but_for_rounding_is_used_up(share):
    world = state(SufficientEnergy())
    world.robots[0].energy = share * (4.0 * 5.0 + 2 * 3.0 * 2)

    move(world, [0] * 4, 0)

    assert world.robots[0].energy == 0.0


def test_a_direction_that_is_nothing_but_rounding_is_ignored():
    ci = state()
    before = ci.commands[0].heading_x

    steer(ci, 0, math.ulp(1.0), 0.0)

    assert ci.commands[0].heading_x == before
