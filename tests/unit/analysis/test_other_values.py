"""Values that a fault could have instead of the pool's."""

import pytest

from mrsfi_runtime.analysis.other_values import N_PLACES, N_STEPS, other_values
from mrsfi_runtime.model.bounds import value_bounds
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import PAPER_FAULTS, paper_mission

FAULTS = {fault.type: fault for fault in PAPER_FAULTS}


@pytest.mark.parametrize("kind", FAULT_TYPES)
def test_they_lie_within_the_bounds_each_once_and_are_not_the_pools(kind):
    mission, fault = paper_mission(), FAULTS[kind]
    bounds = value_bounds(mission, fault)

    others = other_values(mission, fault, [(1.0, 2.0), (1e9, 0.0)])

    assert len({*others}) == len(others)
    assert fault.values not in others
    for values in others:
        for value, (low, high), parameter in zip(
            values, bounds, fault.kind.parameters, strict=True
        ):
            assert low <= value <= high
            assert not parameter.is_integer or value == int(value)
    assert bool(others) == any(low < high for low, high in bounds)


def test_of_a_number_they_are_equal_steps_from_end_to_end_the_nearest_first():
    fault = FAULTS["DecrementRemainingEnergyCapacityReport"]
    ((low, high),) = value_bounds(paper_mission(), fault)
    (own,) = fault.values

    others = [value for (value,) in other_values(paper_mission(), fault)]

    steps = {low + (high - low) * step / N_STEPS for step in range(N_STEPS + 1)}
    assert {*others} == steps - {own}
    assert others == sorted(others, key=lambda value: abs(value - own))


def test_of_a_place_they_are_a_grid_landmarks_and_where_robots_come_by():
    fault = FAULTS["FixedObstacleCoordinates"]
    mission = paper_mission()
    height = fault.values[2:]

    others = other_values(mission, fault, [(12.3, -45.6)])

    assert (12.3, -45.6, *height) in others
    assert all((robot.position.x, robot.position.y, *height) in others for robot in mission.robots)
    assert len(others) > (N_PLACES + 1) ** 2
