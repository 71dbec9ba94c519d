import re
from dataclasses import replace
from io import StringIO

import pytest

from mrsfi_runtime.kernel.flight import initial_state, no_verdicts
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.model.faults import Event, TimedFault, Trigger
from mrsfi_runtime.record.observers import Events, SimulationLog, named_faults
from tests.support.search import paper_mission, pool_of


def test_the_log_tells_what_is_so_from_the_first_tick_on(approved):
    mission = paper_mission()
    world = initial_state(mission, 1)
    verdicts = no_verdicts(len(mission.goals))
    verdicts.is_true[0] = verdicts.missed[0] = verdicts.is_believed[2] = 1
    stream = StringIO()

    SimulationLog(mission, stream, Events(mission, (), ()))(world, world, verdicts)

    events = [line for line in stream.getvalue().splitlines() if "event" in line]
    approved(events)


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
