"""How near goals came to being violated, looked at in every tick, by [S Margins]."""

import math
from collections.abc import Iterable
from itertools import combinations

from tests.independent.simulation import Flight, Goal, View, distance, gaps, off_track

ARRIVALS = ("GatherSamples", "Visit")
"""Of them "the ticks that are left" are the margin when that is first known."""


class Margins:
    """The least margin of each goal of a flight until now, and at which tick it was."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self.seen: list[list[float]] = [[] for _ in flight.mission.goals]

    def see(self) -> None:
        """Look at the present tick; "a goal that was violated is not looked at any more"."""
        for goal in self._flight.mission.goals:
            seen = self.seen[goal.index]
            before = self._flight.counts["true"][goal.index] - self._flight.true[goal.index]
            has_arrived = goal.task in ARRIVALS and seen and seen[-1] != math.inf
            if not before and not has_arrived:
                seen.append(margin(goal, self._flight.truth))

    def agree(self, goal: Goal, found: tuple[float, int] | None) -> bool:
        """Return whether a margin that was found is the least, and was there at its tick.

        Among margins that rounding alone makes differ from 0, no tick is the first.
        """
        seen = self.seen[goal.index]
        if found is None or min(seen) == math.inf:
            return found is None and min(seen) == math.inf
        least, tick = found
        near = [math.isclose(each, least, rel_tol=1e-12, abs_tol=1e-6) for each in seen]
        is_rounded = seen[tick] != least and abs(least) < 1e-6
        is_earliest = seen.index(seen[tick]) == tick
        return (is_earliest or is_rounded) and near[tick] and near[seen.index(min(seen))]


def kth(goal: Goal, values: Iterable[float]) -> float:
    """Return "the k-th largest"; one that is undefined is infinite."""
    return sorted(values, reverse=True)[goal.required - 1]


def margin(goal: Goal, truth: View) -> float:
    """Return the margin of a goal at a tick: the table of [S Margins]; infinite if it has none."""
    notes = truth.notes[goal.index]
    places = [truth.position[robot] for robot in goal.robots or goal.members]
    match goal.task:
        case "AvoidCollision":
            found = min((way - least for way, least in gaps(goal, truth)), default=math.inf)
        case "StayWithinMissionArea":
            area = truth.mission.area
            found = kth(goal, [area.radius - distance(place, area.center) for place in places])
        case "SufficientEnergy":
            energies = [truth.energy[robot] for robot in goal.members]
            found = math.inf if truth.left else kth(goal, energies)
        case "GatherSamples":
            found = truth.left if notes.count >= goal.target else math.inf
        case "Patrol":
            found = goal.period - 1 - truth.tick + kth(goal, notes.since.values())
        case "Visit" if kth(goal, notes.reached.values()):
            found = goal.deadline - truth.tick
        case "Visit":
            found = goal.deadline - truth.tick - 1 if truth.tick >= goal.deadline else math.inf
        case "Track":
            off = [off_track(goal, truth, robot) for robot in goal.members]
            found = kth(goal, [goal.tolerance - each if each >= 0 else math.inf for each in off])
        case "Stay":
            ways = [
                distance(truth.position[robot], goal.area.center) if has_been else -math.inf
                for robot, has_been in notes.reached.items()
            ]
            found = kth(goal, [goal.area.radius - way for way in ways])
        case "FixedDistanceBetweenRobots":
            off = [abs(distance(a, b) - goal.distance) for a, b in combinations(places, 2)]
            found = goal.tolerance - max(off, default=0.0)
        case _:
            found = math.inf
    return found
