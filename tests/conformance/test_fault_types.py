"""Every fault type of the paper's pool, alone: what is believed while it is active, and after.

The expected value of each type is computed here from the true state of the tick, apart from
the kernel's own code.
"""

import pytest

from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.fault_types import Field, Mode
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault, touched
from tests.support.fault_types import FAULT_TYPES
from tests.support.trace import fields_of
from tests.support.world import paper_code

DURATION = 160
START, FINISH = 40, 119
DELAY, BLOCKED = 15, 20

CODE = paper_code(DURATION)


class Flight:
    """Observer that keeps truth and belief of every tick, by property and index."""

    def __init__(self):
        self.true, self.believed, self.commanded, self.forced = [], [], [], []

    def __call__(self, world, belief, verdicts):
        self.true.append(fields_of(world))
        self.believed.append(fields_of(belief))
        self.commanded.append([command.speed for command in belief.commands])
        self.forced.append([switch.active for switch in belief.switches])


def fly(fault, values=None):
    pool = FaultPool("one", (fault,))
    flight = Flight()
    timed = TimedFault(fault.id, START, FINISH, fault.values if values is None else values)
    outcome = ReferenceEngine(CODE, 3).evaluate((timed,), pool=pool, observer=flight)
    return outcome, flight


def of_type(name):
    return next(fault for fault in CODE.pool if fault.type == name)


REPORTS = [
    kind.name
    for kind in FAULT_TYPES.values()
    if kind.properties not in ((), (Field.MOTION,), (Field.ACTIVATION,))
]


def expected_range(fault, true):
    """Return the least and greatest value that may be believed in place of a true one."""
    a, b = (*fault.values, 0.0, 0.0)[:2]
    match fault.kind.mode:
        case Mode.ZERO:
            low = high = 0.0
        case Mode.FIXED:
            low = high = a
        case Mode.INCREMENT:
            low = high = true + a
        case Mode.DECREMENT:
            low = high = true - a
        case Mode.INCREMENT_PERCENT:
            low = high = true * (1 + a / 100)
        case Mode.DECREMENT_PERCENT:
            low = high = true * (1 - a / 100)
        case _:
            low, high = a, b
    return max(low, 0.0), max(high, 0.0)


@pytest.mark.parametrize("name", REPORTS)
def test_a_report_is_falsified_within_its_window_from_the_true_value_and_restored_after(name):
    fault = of_type(name)
    targets = touched(CODE.mission, fault)

    outcome, flight = fly(fault)

    assert targets
    assert outcome.applied == (FINISH - START + 1,)
    assert outcome.changed[0] > 0
    for tick in range(DURATION):
        true, believed = flight.true[tick], flight.believed[tick]
        active = START <= tick <= FINISH
        for key, value in believed.items():
            if not (active and key in targets):
                assert value == true[key], (tick, key)
            elif isinstance(value, tuple):
                check_place(fault, value)
            else:
                low, high = expected_range(fault, true[key])
                assert low <= value <= high, (tick, key)


def check_place(fault, place):
    if fault.kind.mode is Mode.FIXED:
        assert place[:2] == fault.values[:2]
    else:
        assert place[0] ** 2 + place[1] ** 2 <= 2000.0**2


@pytest.mark.parametrize("name", [name for name in REPORTS if name.startswith("Random")])
def test_random_faults_draw_anew_every_tick_and_whole_speeds_and_rates(name):
    fault = of_type(name)
    target = touched(CODE.mission, fault)[0]

    _, flight = fly(fault)

    drawn = {flight.believed[tick][target] for tick in range(START, FINISH + 1)}
    assert len(drawn) > 5
    assert name not in {"RandomSpeed", "RandomSampleRate"} or not any(one % 1 for one in drawn)


@pytest.mark.parametrize("message", list(CODE.mission.message_goal))
def test_a_delay_lets_every_field_of_its_message_arrive_late_and_in_order(message):
    fault = Fault("late", FAULT_TYPES["DelayMessage"], message, (float(DELAY),))
    targets = touched(CODE.mission, fault)

    outcome, flight = fly(fault)

    assert targets
    assert outcome.applied == (FINISH - START + 1,)
    for tick in range(DURATION):
        for key, value in flight.believed[tick].items():
            if key in targets and START <= tick < START + DELAY:
                assert value == flight.true[START - 1][key], (tick, key)
            elif key in targets and START + DELAY <= tick <= FINISH:
                assert value == flight.true[tick - DELAY][key], (tick, key)
            else:
                assert value == flight.true[tick][key], (tick, key)


@pytest.mark.parametrize(
    ("fault", "robot"),
    [
        (Fault("late", FAULT_TYPES["DelayMessage"], "m1", (500.0,)), "r2"),
        (Fault("blind", FAULT_TYPES["DeactivateSensor"], "s5"), "r3"),
    ],
    ids=["a delay longer than its window", "a GPS that is forced off"],
)
def test_a_robot_that_is_not_heard_of_is_believed_where_it_was(fault, robot):
    _, flight = fly(fault)

    key = (Field.POSITION, CODE.mission.robot_index[robot])
    for tick in range(START, FINISH + 1):
        assert flight.believed[tick][key] == flight.true[START - 1][key]
    assert flight.believed[FINISH + 1][key] == flight.true[FINISH + 1][key]


@pytest.mark.parametrize("message", list(CODE.mission.message_goal))
def test_a_block_loses_every_field_of_its_message_for_its_duration(message):
    fault = Fault("lost", FAULT_TYPES["BlockMessage"], message, (float(BLOCKED),))
    targets = touched(CODE.mission, fault)

    outcome, flight = fly(fault)

    assert outcome.applied == (BLOCKED,)
    for tick in range(DURATION):
        for key, value in flight.believed[tick].items():
            lost = key in targets and START <= tick < START + BLOCKED
            expected = flight.true[START - 1 if lost else tick][key]
            assert value == expected, (tick, key)


def test_a_block_ends_with_its_window():
    fault = Fault("lost", FAULT_TYPES["BlockMessage"], "m1", (10_000.0,))

    outcome, _ = fly(fault)

    assert outcome.applied == (FINISH - START + 1,)


@pytest.mark.parametrize(
    ("name", "forced", "target"),
    [
        ("StopRobot", 0.0, "r1"),
        ("StartRobot", 5.0, "r1"),
        ("DeactivateSensor", 0, "s4"),
        ("ActivateSensor", 1, "s4"),
    ],
)
def test_a_forged_command_holds_from_the_motion_of_start_to_that_of_finish(name, forced, target):
    outcome, flight = fly(Fault("forged", FAULT_TYPES[name], target))

    if target == "r1":
        index, field, commanded = CODE.mission.robot_index[target], Field.SPEED, flight.commanded
    else:
        index, field, commanded = CODE.mission.sensor_index[target], Field.ACTIVATION, flight.forced
    assert outcome.applied == (FINISH - START + 1,)
    for tick in range(1, DURATION):
        expected = forced if START <= tick <= FINISH else commanded[tick - 1][index]
        assert flight.true[tick][field, index] == expected, tick


def test_a_sensor_forced_off_takes_no_samples_and_costs_nothing():
    sensor, robot = CODE.mission.sensor_index["s4"], CODE.mission.robot_index["r2"]

    _, flight = fly(Fault("off", FAULT_TYPES["DeactivateSensor"], "s4"))
    _, free = fly(Fault("none", FAULT_TYPES["StartRobot"], "r2"))

    counts = {flight.true[tick][Field.COUNT, sensor] for tick in range(START, FINISH + 1)}
    assert len(counts) == 1
    saved = flight.true[FINISH][Field.ENERGY, robot] - free.true[FINISH][Field.ENERGY, robot]
    assert saved == (FINISH - START + 1) * 5 * 2.0


def test_a_forged_command_acts_from_the_very_first_motion():
    fault = Fault("stop", FAULT_TYPES["StopRobot"], "r1")
    flight = Flight()

    ReferenceEngine(CODE, 3).evaluate(
        (TimedFault("stop", 0, 2, ()),), pool=FaultPool("one", (fault,)), observer=flight
    )

    robot = CODE.mission.robot_index["r1"]
    speeds = [flight.true[tick][Field.SPEED, robot] for tick in range(4)]
    assert speeds[:3] == [0.0, 0.0, 0.0]
    assert speeds[3] > 0.0


def test_a_fault_whose_message_does_not_carry_its_field_does_nothing():
    outcome, flight = fly(Fault("odd", FAULT_TYPES["FixedSpeed"], "m1", (50.0,)))

    assert outcome.applied == (0,)
    assert flight.believed == flight.true


@pytest.mark.parametrize(
    ("message", "sensors"), [("m11", ["s6"]), ("m8", ["s5", "s6"]), ("m9", ["s1", "s2"])]
)
def test_a_rate_fault_touches_the_sensor_of_its_goal_or_else_all_of_its_sender(message, sensors):
    fault = Fault("rate", FAULT_TYPES["FixedSampleRate"], message, (1.0,))

    targets = touched(CODE.mission, fault)

    index = CODE.mission.sensor_index
    assert targets == tuple((Field.RATE, index[sensor]) for sensor in sensors)
