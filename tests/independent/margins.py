"""How near goals came to being violated, looked at in every tick, by [S Margins]."""

import math
from collections.abc import Iterable
from itertools import combinations

from tests.independent.simulation import Flight, Goal, View, distance, gaps, off_track

ARRIVALS = ("GatherSamples", "Visit")
"""Of them "the ticks left" are the margin when that is first known."""

FORECASTS = ("SufficientEnergy", "GatherSamples")
"""They "have none" after a violation."""


class Margins:
    """The margins of each goal of a flight at all ticks until now."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._alone: list[list[float]] = [[] for _ in flight.mission.goals]
        self._arrived: set[int] = set()
        self.seen: list[list[float]] = [[] for _ in flight.mission.goals]

    def see(self) -> None:
        """Look at the present tick."""
        truth = self._flight.truth
        for goal in self._flight.mission.goals:
            k, alone = goal.index, self._alone[goal.index]
            before = self._flight.counts["true"][k] - self._flight.true[k]
            is_over = k in self._arrived or (goal.task in FORECASTS and before)
            alone.append(math.inf if is_over else margin(goal, truth))
            if has_arrived(goal, truth):
                self._arrived.add(k)
            # "the greatest of this tick and the `grace` ticks before"
            lasting = alone[-goal.grace - 1 :]
            is_known = len(lasting) > goal.grace or goal.task in (*ARRIVALS, *FORECASTS)
            now = alone[-1] if goal.task in (*ARRIVALS, *FORECASTS) else max(lasting)
            self.seen[k].append(now if is_known else math.inf)

    def agree(self, goal: Goal, found: tuple[float, int] | None) -> bool:
        """Return whether a margin that was found is the least, and was there at its tick.

        Where rounding alone makes margins differ, no tick is the first.
        """
        seen = self.seen[goal.index]
        if found is None or min(seen) == math.inf:
            return found is None and min(seen) == math.inf
        least, tick = found
        near = [math.isclose(each, least, rel_tol=1e-12, abs_tol=1e-6) for each in seen]
        is_rounded = seen[tick] != least
        is_earliest = seen.index(seen[tick]) == tick
        return (is_earliest or is_rounded) and near[tick] and near[seen.index(min(seen))]


def kth(goal: Goal, values: Iterable[float]) -> float:
    """Return "the k-th largest"; one that is undefined is infinite."""
    return sorted(values, reverse=True)[goal.required - 1]


def has_arrived(goal: Goal, truth: View) -> bool:
    """Return whether a goal of ``ARRIVALS`` has what it waits for."""
    notes = truth.notes[goal.index]
    if goal.task == "GatherSamples":
        return notes.count >= goal.target
    return goal.task == "Visit" and bool(kth(goal, notes.reached.values()))


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
            found = truth.left if has_arrived(goal, truth) else math.inf
        case "Patrol":
            found = goal.period - 1 - truth.tick + kth(goal, notes.since.values())
        case "Visit":
            left = goal.deadline + goal.grace - truth.tick
            is_late = left <= 0 and not has_arrived(goal, truth)
            found = left - is_late if is_late or has_arrived(goal, truth) else math.inf
        case "Track":
            off = [off_track(goal, truth, robot) for robot in goal.members]
            found = kth(goal, [goal.tolerance - each if each >= 0 else math.inf for each in off])
        case "Stay":
            ways = [
                goal.area.off(truth.position[robot]) if has_been else -math.inf
                for robot, has_been in notes.reached.items()
            ]
            found = kth(goal, [goal.area.radius - way for way in ways])
        case "FixedDistanceBetweenRobots":
            off = [abs(distance(a, b) - goal.distance) for a, b in combinations(places, 2)]
            found = goal.tolerance - max(off, default=0.0)
        case _:
            found = math.inf
    return found
