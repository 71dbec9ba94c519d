import pytest

from mrsfi_runtime.analysis.tables import fault_table
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import Event, Fault, FaultPool, TimedFault, Trigger
from mrsfi_runtime.model.mission import Area, Coordinates
from mrsfi_runtime.record.observers import named_faults
from tests.support.campaigns import outcome
from tests.support.fault_types import FAULT_TYPES
from tests.support.search import paper_mission, pool_of

UNCARRIED = Fault("silent", FAULT_TYPES["FixedSpeed"], "m2", (5.0,))
TRIGGERS = (
    Trigger("full", Event.REACHED, ("g4",), delay=5, duration=9),
    Trigger("bitten", Event.EFFECT, ("f1", "f2"), delay=1),
    Trigger("near", Event.ENTERED, ("r1",), Area("gate", Coordinates(), 9.0)),
    Trigger("low", Event.VIOLATED, ("g3",), duration=1),
)
POOL = FaultPool("p", (*pool_of(), UNCARRIED), triggers=TRIGGERS)


def _named(*timed, duration=1000):
    return named_faults(paper_mission(duration), POOL, timed)


@pytest.mark.parametrize(
    ("timed", "target", "values"),
    [
        (TimedFault("f21", 2, 475), "m3: r1 position", ""),
        (TimedFault("f26", 2, 475), "r1 motion", ""),
        (TimedFault("f1", 2, 475), "s2 activation", ""),
        (TimedFault("f8", 2, 475, (200.0,)), "m10: s4 count", "DELAY 200 ticks"),
        (TimedFault("f6", 2, 475, (42.65,)), "m9: s1 cost, s2 cost", "PERCENTAGE 42.65 percent"),
        (
            TimedFault("f9", 2, 475, (812.25, -1 / 3, 1.0)),
            "o5 obstacle",
            "NEW_X 812.25, NEW_Y -0.333333, NEW_Z 1",
        ),
        (TimedFault("silent", 2, 475, (5.0,)), "m2: nothing", "FIXED_VAL 5 units per tick"),
    ],
)
def test_a_fault_is_named_by_what_it_touches_and_its_values_with_their_units(timed, target, values):
    (found,) = _named(timed)

    assert (found.target, found.values) == (target, values)


def test_every_value_of_every_type_is_named():
    specification = [TimedFault(fault.id, 3, 9, fault.values) for fault in POOL]

    for found in _named(*specification):
        assert found.fault.target in found.target
        assert all(parameter.name in found.values for parameter in found.fault.kind.parameters)


@pytest.mark.parametrize(
    ("timed", "expected"),
    [
        (TimedFault("f21", 2, 475), (2, 475)),
        (TimedFault("f21", 900, 1005), (900, 999)),
        (TimedFault("f21", 1000, 1005), None),
        (TimedFault("f2", 2, 475, (50.0,)), (2, 51)),
        (TimedFault("f2", 2, 20, (50.0,)), (2, 20)),
        (TimedFault("f8", 2, 475, (0.4,)), None),
        (TimedFault("f8", 2, 475, (500.0,)), (2, 475)),
        (TimedFault("silent", 2, 475, (5.0,)), None),
    ],
)
def test_the_window_is_when_a_fault_is_active(timed, expected):
    (found,) = _named(timed)

    assert found.window == expected


def test_a_script_gets_all_digits_and_both_windows():
    found, never = _named(TimedFault("f2", 2, 475, (50.125,)), TimedFault("silent", 9, 9, (5.0,)))

    assert found.as_json() == {
        "type": "BlockMessage",
        "target": "m4",
        "touched": ["r2 position"],
        "start": 2,
        "finish": 475,
        "window": [2, 51],
        "values": {"BLOCK_DURATION": 50.125},
    }
    assert (never.as_json()["window"], never.as_json()["touched"]) == (None, [])


def test_a_row_has_a_cell_for_each_column():
    faults = _named(TimedFault("f21", 2, 475), TimedFault("f2", 3, 4, (5.0,)))

    table = fault_table("", faults, outcome((), 2))
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]

    assert [row["values"] for row in rows] == ["–", "BLOCK_DURATION 5 ticks"]
    assert rows[0] == {
        "fault": "f21",
        "type": "RandomRobotCoordinates",
        "start": 2,
        "finish": 475,
        "applied": 1,
        "changed": 1,
        "target": "m3: r1 position",
        "values": "–",
    }


@pytest.mark.parametrize(
    ("trigger", "told"),
    [
        ("full", "when g4 is reached, 5 ticks later, for 9 ticks"),
        ("bitten", "when f1 or f2 changes something, 1 tick later"),
        ("near", "when r1 enters gate"),
        ("low", "when g3 is violated, for 1 tick"),
    ],
)
def test_what_a_fault_waits_for_is_told_after_its_values(trigger, told):
    silent, block = _named(
        TimedFault("f21", 0, 475, (), trigger), TimedFault("f2", 0, 475, (50.0,), trigger)
    )

    assert (silent.told, block.told) == (told, f"BLOCK_DURATION 50 ticks; {told}")
    assert (silent.as_json()["trigger"], silent.as_json()["window"]) == (trigger, [1, 475])


@pytest.mark.parametrize(
    ("timed", "tally", "active"),
    [
        (TimedFault("f21", 2, 475), FaultTally(), (2, 475)),
        (TimedFault("f21", 2, 475, (), "bitten"), FaultTally(), None),
        (TimedFault("f21", 2, 475, (), "bitten"), FaultTally(1, 0, 30), (30, 475)),
        (TimedFault("f21", 2, 475, (), "full"), FaultTally(4, 0, 33), (30, 38)),
        (TimedFault("f21", 2, 33, (), "full"), FaultTally(4, 0, 33), (30, 33)),
        (TimedFault("f2", 2, 475, (7.0,), "full"), FaultTally(1, 0, 30), (30, 36)),
        (TimedFault("f2", 2, 475, (70.0,), "full"), FaultTally(1, 0, 30), (30, 38)),
    ],
)
def test_when_a_fault_was_active_that_waited_follows_from_what_it_did(timed, tally, active):
    (found,) = _named(timed)

    assert found.active(tally) == active
