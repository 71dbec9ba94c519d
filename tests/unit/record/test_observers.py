"""What observers record of a flight, and the faults and measures that they name."""

import re
from dataclasses import replace
from io import StringIO

import pytest

from mrsfi_runtime.analysis.tables import fault_table, goal_table, in_words, ticks
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.kernel.flight import initial_state, no_verdicts
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import Event, Fault, FaultPool, TimedFault, Trigger
from mrsfi_runtime.model.mission import Area, Coordinates, Obstacle, polygon
from mrsfi_runtime.record.observers import (
    Events,
    SimulationLog,
    map_markers,
    named_faults,
    robot_markers,
)
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure
from tests.support.campaigns import outcome
from tests.support.fault_types import FAULT_TYPES
from tests.support.measures import MEANS
from tests.support.search import outcome_of, paper_mission, pool_of

UNCARRIED = Fault("silent", FAULT_TYPES["FixedSpeed"], "m2", (5.0,))
TRIGGERS = (
    Trigger("full", Event.REACHED, ("g4",), delay=5, duration=9),
    Trigger("bitten", Event.EFFECT, ("f1", "f2"), delay=1),
    Trigger("near", Event.ENTERED, ("r1",), Area("gate", Coordinates(), 9.0)),
    Trigger("low", Event.VIOLATED, ("g3",), duration=1),
)
POOL = FaultPool("p", (*pool_of(), UNCARRIED), triggers=TRIGGERS)


def test_the_log_tells_what_is_so_from_the_first_tick_on(approved):
    mission = paper_mission()
    world = initial_state(mission, 1)
    verdicts = no_verdicts(len(mission.goals))
    verdicts.is_true[0] = verdicts.missed[0] = verdicts.is_believed[2] = 1
    stream = StringIO()

    SimulationLog(mission, stream, Events(mission, (), ()))(world, world, verdicts)

    events = [line for line in stream.getvalue().splitlines() if "event" in line]
    approved(events)


def test_robots_of_one_radius_are_one_list_of_spheres():
    mission = paper_mission()
    first, *others = mission.robots
    mission = replace(mission, robots=(replace(first, radius=2.5), *others))
    world = initial_state(mission, 1)

    _, *markers = robot_markers(mission, (), world, world)["markers"]

    found = [(marker["ns"], marker["scale"]["x"], len(marker["points"])) for marker in markers]
    assert found == [
        ("robots", 5.0, 1),
        ("believed robots", 5.0, 1),
        ("robots", 2.0, 2),
        ("believed robots", 2.0, 2),
    ]


def test_polygons_are_lines_from_corner_to_corner_and_move_with_their_centre():
    mission = paper_mission()
    corners = (Coordinates(-2.0, 0.0), Coordinates(3.0, 0.0), Coordinates(1.0, 5.0))
    area = polygon("a", corners, Coordinates(1.0, 1.0, 2.0))
    mission = replace(mission, obstacles=(Obstacle("o", area),), goals=())
    world, belief = initial_state(mission, 1), initial_state(mission, 1)
    belief.obstacles[0].x += 7.0

    edge = [{"x": x, "y": y, "z": 0.0} for x, y in ((-3, -1), (2, -1), (0, 4), (-3, -1))]
    placed = map_markers(mission, ["r"] * 3)["markers"][1]
    *_, believed, _ = robot_markers(mission, (), world, belief)["markers"]
    assert [each["type"] for each in (placed, believed)] == [4, 4]
    assert [each["points"] for each in (placed, believed)] == [edge, edge]
    assert placed["pose"]["position"] == {"x": 1.0, "y": 1.0, "z": 2.0}
    assert believed["pose"]["position"] == {"x": 8.0, "y": 1.0, "z": 0.0}


def test_the_log_shows_what_is_believed_beside_what_is_so():
    mission = paper_mission()
    world, belief = initial_state(mission, 1), initial_state(mission, 1)
    belief.robots[1].x += 3.0
    belief.robots[1].speed += 1e-9
    belief.sensors[3].count = 7
    belief.sensors[3].cost = 2.5
    belief.obstacles[4].x, belief.obstacles[4].y = -1.0, 0.125
    stream = StringIO()

    SimulationLog(mission, stream, Events(mission, (), ()))(
        world, belief, no_verdicts(len(mission.goals))
    )

    robot, obstacle = world.robots[1], world.obstacles[4]
    place = f"{robot.y:g} {robot.z:g}"
    assert [line for line in stream.getvalue().splitlines() if "believed" in line] == [
        f"  believed r2 position: {robot.x + 3:g} {place}, true {robot.x:g} {place}",
        f"  believed r2 speed: {robot.speed + 1e-9!r}, true {robot.speed!r}",
        "  believed s4 count: 7, true 0",
        "  believed s4 cost: 2.50, true 2",
        f"  believed o5 obstacle: -1 0.12, true {obstacle.x:g} {obstacle.y:g}",
    ]


def test_the_log_says_when_a_fault_starts_changes_something_and_ends(approved):
    mission = paper_mission(8)
    specification = (
        TimedFault("f2", 1, 6, (3.0,)),
        TimedFault("f26", 4, 9),
        TimedFault("f8", 5, 6, (0.0,)),
    )
    tallies = [FaultTally(first_changed=3), FaultTally(), FaultTally()]
    world = initial_state(mission, 1)
    stream = StringIO()

    log = SimulationLog(
        mission,
        stream,
        Events(mission, named_faults(mission, pool_of(), specification), tallies),
    )
    for tick in range(8):
        world.mission.tick = tick
        log(world, world, no_verdicts(len(mission.goals)))

    approved(_fault_events(stream))


def test_the_log_says_from_when_on_a_fault_waits_and_when_it_starts(approved):
    """What it did is known to the tick while it flies: a forged command one tick ahead."""
    mission = paper_mission(9)
    pool = replace(pool_of(), triggers=(Trigger("low", Event.VIOLATED, ("g3",), duration=2),))
    tally, world, stream = FaultTally(), initial_state(mission, 1), StringIO()
    faults = named_faults(mission, pool, (TimedFault("f26", 1, 6, (), "low"),))
    log = SimulationLog(mission, stream, Events(mission, faults, (tally,)))
    for tick in range(8):
        world.mission.tick = tick
        if tick in (3, 4):
            tally.applied, tally.last_applied = tick - 2, tick + 1
        log(world, world, no_verdicts(len(mission.goals)))

    approved(_fault_events(stream))


def _fault_events(stream):
    return [
        (tick, line)
        for tick, text in enumerate(re.split(r"^tick \d+\n", stream.getvalue(), flags=re.M)[1:])
        for line in text.splitlines()
        if "event fault" in line
    ]


@pytest.mark.parametrize(
    ("x", "y", "told"), [(0.0, 1.0, "90.0"), (0.0, -1.0, "270.0"), (-1.0, 0.0, "180.0")]
)
def test_a_new_heading_is_told_in_degrees_from_the_x_axis_on(x, y, told):
    mission = paper_mission()
    before, after = initial_state(mission, 1), initial_state(mission, 1)
    after.commands[1].heading_x, after.commands[1].heading_y = x, y
    events, verdicts = Events(mission, (), ()), no_verdicts(len(mission.goals))
    [*events.at(before, verdicts)]

    (heading,) = events.at(after, verdicts)

    assert heading[1].startswith("r2 heading: ")
    assert heading[1].endswith(f"-> {told} degrees")


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

    assert (silent.values_in_words, block.values_in_words) == (
        told,
        f"BLOCK_DURATION 50 ticks; {told}",
    )
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


@pytest.mark.parametrize(
    ("settings", "goals"),
    [(CampaignSettings(), ("g1", "g9")), (MEANS, ("g1", "g2"))],
)
def test_goals_that_a_record_says_nothing_of_are_refused(settings, goals, refused):
    with refused(UsageError):
        Measure.of(settings, paper_mission()).require(goals)


@pytest.mark.parametrize(
    "settings",
    [
        CampaignSettings(),
        CampaignSettings(violations="missed"),
        replace(MEANS, violations="true"),
    ],
)
def test_a_measure_says_what_it_counts(settings, approved):
    approved(Measure.of(settings, paper_mission()))


@pytest.mark.parametrize(("missed", "told"), [((0, 3), ("–", "7")), ((10, 1), ("0", "9"))])
def test_a_goal_is_missed_from_a_tick_on_or_not(missed, told):
    mission = replace(paper_mission(), duration=10, goals=paper_mission().goals[:2])

    table = goal_table("", mission, replace(outcome_of(0, 0), missed=missed))

    place = table.columns.index("failed from")
    assert tuple(in_words(row[place]) for row in table.rows) == told


def test_a_count_is_whole_and_a_mean_of_counts_is_not():
    assert (ticks(3), ticks(2.5)) == ("3", "2.50")
