from dataclasses import replace

import pytest

from mrsfi_runtime.errors import SpecificationError
from mrsfi_runtime.model.faults import Fault, value_bounds
from mrsfi_runtime.model.mission import Area, Coordinates, Message, MessageData
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import PAPER_FAULTS, paper_mission

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
