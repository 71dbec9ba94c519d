"""The digest of a flight of the independent simulation, written from [S Digest] alone."""

import struct
from collections.abc import Iterable, Iterator
from hashlib import sha256

from tests.independent.simulation import Flight, Goal, Intelligence, View

TASKS = (
    "AvoidCollision",
    "StayWithinMissionArea",
    "SufficientEnergy",
    "GatherSamples",
    "Patrol",
    "Visit",
    "Track",
    "Stay",
    "FixedDistanceBetweenRobots",
)
"""Tasks are "numbered from 0 in the order of the table"."""
MEASURES = ("believed", "true", "phantom", "masked", "missed")


def digest(flight: Flight) -> str:
    """Return "the SHA-256 of the counts, the last truth and the last belief"."""
    lists = [flight.counts[name] for name in MEASURES]
    lists.append([notes.count for notes in flight.truth.notes])
    lists += [[getattr(each, name) for each in flight.faults] for name in ("applied", "changed")]
    found = sha256(in_parentheses(in_parentheses(map(str, each)) for each in lists).encode())
    for view in (flight.truth, flight.belief):
        for number in fields(view, flight.belief):
            found.update(struct.pack("<d", number + 0.0))  # "−0 is written as 0"
    return found.hexdigest()


def in_parentheses(texts: Iterable[str]) -> str:
    """Return a list as text: "`()` is empty, `(3,)` has one number"."""
    listed = list(texts)
    return f"({', '.join(listed)}{',' if len(listed) == 1 else ''})"


def fields(view: View, ci: Intelligence) -> Iterator[float]:
    """Yield "the fields of this table, record after record"."""
    mission = view.mission
    for k, robot in enumerate(mission.robots):
        yield from (*view.position[k], view.speed[k], view.energy[k])
        yield from (robot.speed, robot.max_speed, robot.cost)
        yield sum(len(each.sensors) for each in mission.robots[:k])
        yield from (len(robot.sensors), -1 if robot.gps is None else robot.gps.index)
    n_bounds = [len(each.bounds) or 1 for each in mission.sensors]
    for k, sensor in enumerate(mission.sensors):
        yield from (sensor.robot, view.count[k], view.active[k], view.rate[k], view.cost[k])
        yield from (sensor.rate, sensor.cost, sum(n_bounds[:k]), n_bounds[k])
    for place, disc in zip(view.obstacle, mission.obstacles, strict=True):
        yield from (*place[:2], disc.radius, *disc.center[:2])
    n_before = [0, 0, 0]
    for goal in mission.goals:
        yield from fields_of_goal(goal, view, n_before)
    for goal in mission.goals:
        notes = view.notes[goal.index]
        for robot in goal.robots or goal.members:
            since, reached = notes.since.get(robot, -1), notes.reached.get(robot, False)
            yield from (robot, since, reached, notes.waypoint.get(robot, 0))
    yield from commands(view, ci)
    memory = [number for notes in view.notes for number in notes.memory]
    yield from memory if any(memory) else ()


def fields_of_goal(goal: Goal, view: View, n_before: list[int]) -> Iterator[float]:
    """Yield "the number of its task; x, y, radius of its place", and so on; count what it has."""
    yield from (TASKS.index(goal.task), *goal.place.center[:2], goal.place.radius)
    for k, own in enumerate((goal.robots or goal.members, goal.obstacles, goal.trajectory)):
        yield from (n_before[k], len(own))
        n_before[k] += len(own)
    kept = goal.clearance or goal.distance
    yield from (goal.sensor, goal.target, goal.tolerance, kept, goal.period, goal.deadline)
    notes = view.notes[goal.index]
    yield from (notes.count, notes.seen, *(notes.counted_at or (0, 0)))


def commands(view: View, ci: Intelligence) -> Iterator[float]:
    """Yield those of belief; truth has "those that were sent last, for the motion of tick `T`"."""
    if view is ci:
        for k, heading in enumerate(ci.heading):
            taken = (channel in ci.taken for channel in (("heading", k), ("speed", k)))
            yield from (*heading, ci.command[k], ci.sent_speed[k], *taken)
        for k, switch in enumerate(ci.switch):
            yield from (switch, ("sensor", k) in ci.taken)
    else:
        for robot, heading in zip(view.mission.robots, ci.sent_heading, strict=True):
            yield from (*heading, ci.sent_speed[robot.index], robot.speed, 0, 0)
        for switch in ci.sent_switch:
            yield from (switch, 0)
