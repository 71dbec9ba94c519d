"""What a flight writes.

How timed faults are named wherever people and scripts read of them.

What happens in a flight, and its being written down: a trace, and a log for people.
"""

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, groupby
from typing import Any, TextIO, TypeAlias

from mrsfi_runtime.kernel.flight import Verdicts, no_verdicts
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.injections import FaultTally, active_window, longest
from mrsfi_runtime.kernel.state import PROPERTIES, State
from mrsfi_runtime.model.fault_types import Units
from mrsfi_runtime.model.faults import (
    LAST,
    Fault,
    FaultPool,
    Specification,
    TimedFault,
    Trigger,
    describe,
    robots_of,
    touched,
)
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission

Window: TypeAlias = tuple[int, int]
"""First and last tick."""


@dataclass(frozen=True, slots=True)
class NamedFault:
    """A timed fault, and all that it takes to name it.

    ``touched`` is in words, ``robots`` are the places of the robots that have it or carry the
    sensors that do; ``window`` has the first and last tick at which it is active, ``None`` if it
    never is; ``units`` are those of the mission. One with a ``trigger`` is active at ``most`` ticks
    of it.
    """

    name: str
    timed: TimedFault
    fault: Fault
    touched: tuple[str, ...]
    robots: frozenset[int]
    window: Window | None
    units: Units
    trigger: Trigger | None = None
    most: int = LAST

    @property
    def target(self) -> str:
        """What it touches, after what it refers to unless that says the same: ``m8: r2 speed``."""
        refers = self.fault.target
        words = ", ".join(self.touched) or "nothing"
        is_said = bool(self.touched) and all(each.startswith(f"{refers} ") for each in self.touched)
        return words if is_said else f"{refers}: {words}"

    @property
    def words(self) -> str:
        """Its type, and its target: ``FixedSpeed on m8: r2 speed``."""
        return f"{self.fault.type} on {self.target}"

    @property
    def values(self) -> str:
        """Its values with names and units; empty if its type has no parameters."""
        return self.fault.kind.in_words(self.timed.values, self.units)

    @property
    def told(self) -> str:
        """Its values, and what it waits for; empty if it has neither."""
        waits = "" if self.trigger is None else self.trigger.words
        return "; ".join(filter(None, (self.values, waits)))

    def active(self, tally: FaultTally) -> Window | None:
        """Return when it is active in a flight, as far as that is known from what it did until now.

        A fault that waits for a trigger was active at all ticks from its first one on.
        """
        if self.trigger is None or self.window is None or not tally.applied:
            return self.window if self.trigger is None else None
        first = tally.last_applied - tally.applied + 1
        return first, min(self.window[1], first + self.most - 1)

    def as_json(self) -> dict[str, Any]:
        """Return all of it but its ID as plain values."""
        waits = {"trigger": self.trigger.id} if self.trigger is not None else {}
        return {
            "type": self.fault.type,
            "target": self.fault.target,
            "touched": list(self.touched),
            "start": self.timed.start,
            "finish": self.timed.finish,
            "window": None if self.window is None else list(self.window),
            "values": self.fault.kind.named(self.timed.values),
            **waits,
        }


def named_faults(
    mission: Mission,
    pool: FaultPool,
    specification: Specification,
    names: Sequence[str] | None = None,
) -> tuple[NamedFault, ...]:
    """Return the faults of a specification; ``names`` are IDs of the pool if left out."""
    if names is None:
        names = [timed.fault for timed in specification]
    found = []
    for name, timed in zip(names, specification, strict=True):
        fault = pool[timed.fault]
        targets = touched(mission, fault)
        words = tuple(describe(mission, target) for target in targets)
        window = active_window(mission, pool, timed)
        robots, trigger = robots_of(mission, targets), pool.triggers_by_id.get(timed.trigger)
        most = LAST if trigger is None else longest(fault.kind, timed.values, trigger)
        told = (window, mission.units, trigger, most)
        found.append(NamedFault(name, timed, fault, words, robots, *told))
    return tuple(found)


class Events:
    """Tells what happens in a flight, tick by tick from the first.

    ``tallies`` say what each fault does, and are filled before the first tick.
    """

    def __init__(
        self, mission: Mission, faults: Sequence[NamedFault], tallies: Sequence[FaultTally]
    ) -> None:
        self._mission = mission
        self._faults = faults
        self.tallies = tallies
        self._known = {
            subject: fact for _, subject, fact in self._judged(no_verdicts(len(mission.goals)))
        }

    def at(self, world: State, verdicts: Verdicts) -> Iterator[tuple[str, str]]:
        """Yield what happens at the next tick, in words, each after what it is about."""
        yield from self._of_faults(world.mission.tick)
        for kind, subject, fact in (*self._facts(world), *self._judged(verdicts)):
            before = self._known.get(subject, fact)
            self._known[subject] = fact
            if before != fact:
                yield kind, f"{subject}: {before} -> {fact}"

    def _of_faults(self, tick: int) -> Iterator[tuple[str, str]]:
        for fault, tally in zip(self._faults, self.tallies, strict=True):
            what = f"fault {fault.fault.id} {fault.words}"
            if fault.window is None:
                if tick == fault.timed.start:
                    yield "fault", f"{what}: is active at no tick"
                continue
            values = f" with {fault.values}" if fault.values else ""
            if fault.trigger is not None and tick == fault.window[0]:
                yield "fault", f"{what}: may start from now on, {fault.trigger.words}"
            first, last = fault.active(tally) or (-1, -1)
            if tick == first:
                yield "fault", f"{what}: starts ({first} … {last}){values}"
            if tick == tally.first_changed:
                yield "fault", f"{what}: first changes something"
            if tick == last:
                yield "fault", f"{what}: ends"

    def _facts(self, world: State) -> Iterator[tuple[str, str, str]]:
        """Yield what is worth an event when it changes, as subject and value."""
        mission = self._mission
        for index, robot in enumerate(mission.robots):
            command = world.commands[index]
            degrees = math.degrees(math.atan2(command.heading_y, command.heading_x)) % 360.0
            yield "command", f"{robot.id} speed", f"{world.robots[index].speed:g}"
            yield "command", f"{robot.id} heading", f"{degrees:.1f} degrees"
        for k, sensor in enumerate(mission.sensors):
            is_on = world.sensors[k].active
            yield "command", f"{sensor.id} activation", "on" if is_on else "off"
        for name, gap in self._gaps(world):
            yield "collision", f"collision of {name}", "yes" if gap < 0.0 else "no"

    def _judged(self, verdicts: Verdicts) -> Iterator[tuple[str, str, str]]:
        """Yield what is said of each goal; before the first tick, nothing is violated or missed."""
        for index, goal in enumerate(self._mission.goal_ids):
            for what, flag in (
                ("violated", verdicts.is_true[index]),
                ("believed violated", verdicts.is_believed[index]),
                ("missed", verdicts.missed[index]),
            ):
                yield "verdict", f"{goal} {what}", "yes" if flag else "no"

    def _gaps(self, world: State) -> Iterator[tuple[str, float]]:
        """Yield the gap between the discs of every two robots, and of robots and obstacles."""
        robots = list(zip(self._mission.robots, world.robots, strict=True))
        for (first, a), (second, b) in combinations(robots, 2):
            gap = distance(a.x, a.y, b.x, b.y) - 2.0 * ROBOT_RADIUS
            yield f"{first.id} and {second.id}", gap
        for obstacle, area in zip(self._mission.obstacles, world.obstacles, strict=True):
            for robot, a in robots:
                gap = distance(a.x, a.y, area.model_x, area.model_y) - area.radius - ROBOT_RADIUS
                yield f"{robot.id} and {obstacle.id}", gap


class TraceTable:
    """Observer that writes a CSV row a tick to a text file; no bit of a float is lost.

    Columns are the tick, then per robot, sensor and goal its ID with ``.true`` and ``.believed``
    forms, for example ``r1.x.true``, ``s4.count.believed``, ``g3.violated.true``; and last, for
    each goal, whether it is certain to be missed: ``g3.missed.true``.
    """

    _ROBOT_FIELDS = ("x", "y", "speed", "energy")
    _SENSOR_FIELDS = ("count", "active", "rate", "cost")

    def __init__(self, mission: Mission, stream: TextIO) -> None:
        self._writer = csv.writer(stream, lineterminator="\n")
        names = [f"{robot.id}.{name}" for robot in mission.robots for name in self._ROBOT_FIELDS]
        names += [
            f"{sensor.id}.{name}" for sensor in mission.sensors for name in self._SENSOR_FIELDS
        ]
        names += [f"{goal}.{name}" for goal in mission.goal_ids for name in ("count", "violated")]
        self._writer.writerow(
            [
                "tick",
                *(f"{name}.{side}" for side in ("true", "believed") for name in names),
                *(f"{goal}.missed.true" for goal in mission.goal_ids),
            ]
        )

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        self._writer.writerow(
            [
                world.mission.tick,
                *self._values(world, verdicts.is_true),
                *self._values(belief, verdicts.is_believed),
                *(int(missed > 0) for missed in verdicts.missed),
            ]
        )

    def _values(self, state: State, violated: Sequence[int]) -> list[str]:
        robots = [repr(getattr(r, name)) for r in state.robots for name in self._ROBOT_FIELDS]
        sensors = [repr(getattr(s, name)) for s in state.sensors for name in self._SENSOR_FIELDS]
        goals = [
            text
            for goal, flag in zip(state.goals, violated, strict=True)
            for text in (repr(goal.count), repr(int(flag)))
        ]
        return robots + sensors + goals


class SimulationLog:
    """Observer that writes the true state, what is believed otherwise, and what happened."""

    def __init__(self, mission: Mission, stream: TextIO, events: Events) -> None:
        self._mission = mission
        self._stream = stream
        self._events = events

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        lines = [f"tick {world.mission.tick}"]
        for index, robot in enumerate(self._mission.robots):
            lines.append(f"  {robot.id} {self._robot(world, index)}")
        lines += self._mistaken(world, belief)
        lines += (f"  event {said}" for _, said in self._events.at(world, verdicts))
        self._stream.write("\n".join(lines) + "\n")

    def _robot(self, world: State, index: int) -> str:
        robot = world.robots[index]
        sensors = self._mission.sensors
        samples = " ".join(
            f"{sensors[k].id}={world.sensors[k].count}"
            for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors)
        )
        return (
            f"x={robot.x:.2f} y={robot.y:.2f} speed={robot.speed:g} "
            f"energy={robot.energy:.1f} samples {samples}"
        ).rstrip()

    def _mistaken(self, world: State, belief: State) -> Iterator[str]:
        for listed, some in groupby(PROPERTIES, key=lambda each: PROPERTIES[each][0]):
            properties = [*some]
            owners, *sides = (getattr(each, listed) for each in (self._mission, belief, world))
            for owner, *pair in zip(owners, *sides, strict=True):
                for affected in properties:
                    _, names = PROPERTIES[affected]
                    believed, true = ([getattr(side, name) for name in names] for side in pair)
                    if believed != true:
                        said, so = _apart(believed, true)
                        yield f"  believed {owner.id} {affected.name.lower()}: {said}, true {so}"


def _apart(first: Sequence[float], second: Sequence[float]) -> tuple[str, str]:
    """Return unequal values as texts that differ: with two decimals, or all digits if need be."""
    short = (" ".join(f"{n:.2f}" for n in values) for values in (first, second))
    said, so = (text.replace(".00", "") for text in short)
    if said != so:
        return said, so
    return " ".join(map(repr, first)), " ".join(map(repr, second))
