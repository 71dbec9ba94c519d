"""From when on it is certain that a goal is missed, on states laid out by hand."""

import pytest

from mrsfi_runtime.api import AvoidCollision, GatherSamples, Stay, SufficientEnergy, Track
from mrsfi_runtime.kernel.flight import count, no_verdicts
from mrsfi_runtime.kernel.goal_tasks.table import is_missed
from mrsfi_runtime.model.mission import Area, Coordinates, Outcome
from tests.support.world import MEMBERS, state

HERE = Area("here", Coordinates(0.0, 0.0), 50.0)
PATH = (Coordinates(0.0, 0.0), Coordinates(0.0, 100.0))


@pytest.mark.parametrize("violated", [0, 1])
def test_most_tasks_are_missed_from_their_first_violation_on(violated):
    assert is_missed(state(AvoidCollision(MEMBERS)), 0, violated) is bool(violated)


@pytest.mark.parametrize(("energy", "expected"), [(1e-3, False), (0.0, True)])
def test_energy_is_missed_when_a_member_has_none_left_whatever_its_forecast(energy, expected):
    world = state(SufficientEnergy())
    world.robots[1].energy = energy

    assert is_missed(world, 0, 1) is expected


@pytest.mark.parametrize(
    ("count", "tick", "energy", "expected"),
    [
        (0, 0, 1.0, False),
        (0, 97, 1.0, False),  # two ticks are left, of two samples each
        (0, 98, 1.0, True),
        (2, 98, 1.0, False),
        (3, 99, 1.0, True),
        (3, 0, 0.0, True),
        (4, 99, 0.0, False),
    ],
)
def test_samples_are_missed_when_all_that_can_still_come_are_too_few(count, tick, energy, expected):
    world = state(GatherSamples(4, "a_depth"), area=HERE, duration=100)
    world.goals[0].count = count
    world.mission.tick = tick
    world.robots[0].energy = energy

    assert is_missed(world, 0, 1) is expected


@pytest.mark.parametrize(
    ("reached", "violated", "tick", "expected"),
    [(0, 0, 98, False), (0, 0, 99, True), (1, 0, 99, False), (1, 1, 5, True)],
)
def test_stay_is_missed_by_leaving_or_by_never_entering(reached, violated, tick, expected):
    world = state(Stay(HERE), duration=100)
    world.mission.tick = tick
    for member in world.members:
        member.reached = reached

    assert is_missed(world, 0, violated) is expected


@pytest.mark.parametrize(
    ("waypoint", "violated", "tick", "expected"),
    [(1, 0, 98, False), (1, 0, 99, True), (2, 0, 99, False), (1, 1, 5, True)],
)
def test_a_track_is_missed_off_it_or_unfinished_at_the_end(waypoint, violated, tick, expected):
    world = state(Track(PATH, 5.0), duration=100)
    world.mission.tick = tick
    for member in world.members:
        member.waypoint = waypoint

    assert is_missed(world, 0, violated) is expected


@pytest.mark.parametrize(
    ("believed", "expected"),
    [
        ((0, 0, 0, 1, 0), (3, 1)),
        ((0, 0, 1, 0, 0), (3, 0)),
        ((1, 1, 0, 0, 0), (3, 3)),  # a false alarm, and nothing when it happens
        ((0, 0, 0, 0, 1), (3, 2)),
    ],
)
def test_what_is_believed_counts_from_the_first_true_violation(believed, expected):
    world = state(AvoidCollision(MEMBERS), duration=5)
    verdicts = no_verdicts(1)
    for tick, judged in enumerate(zip((0, 0, 1, 0, 1), believed, strict=True)):
        world.mission.tick = tick
        verdicts.is_true[0], verdicts.is_believed[0] = judged
        count(verdicts, world)

    assert (verdicts.broken[0], verdicts.undetected[0]) == expected


@pytest.mark.parametrize(("believed", "expected"), [(0, (1, 1)), (1, (1, 0))])
def test_what_is_missed_without_a_violation_is_broken_from_then_on(believed, expected):
    world = state(Stay(HERE), duration=3)
    verdicts = no_verdicts(1)
    for tick in range(3):
        world.mission.tick = tick
        verdicts.is_believed[0] = believed
        count(verdicts, world)

    assert (verdicts.broken[0], verdicts.undetected[0]) == expected


def test_what_was_missed_once_stays_missed():
    world = state(AvoidCollision(MEMBERS), duration=10)
    verdicts = no_verdicts(1)
    for tick, violated in enumerate((0, 0, 0, 1, 0, 1, 0, 0, 0, 0)):
        world.mission.tick = tick
        verdicts.is_true[0] = violated
        count(verdicts, world)

    outcome = Outcome((0,), (2,), (0,), (2,), tuple(verdicts.missed), (0,), (), (), "")
    assert (verdicts.true, outcome.missed, outcome.missed_since(10)) == ([2], (7,), (3,))
    assert Outcome((0,), (0,), (0,), (0,), (0,), (0,), (), (), "").missed_since(10) == (None,)
