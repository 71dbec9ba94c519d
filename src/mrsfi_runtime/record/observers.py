"""What a flight is written down as: belief and truth of every tick, and a log for people."""

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import TextIO

from mrsfi_runtime.kernel.flight import Verdicts, no_verdicts
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.injections import FaultTally
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission
from mrsfi_runtime.model.targets import describe
from mrsfi_runtime.record.named_faults import NamedFault


class TraceTable:
    """Observer that writes a CSV row a tick; floats are written so that no bit is lost.

    Columns are the tick, then per robot, sensor and goal its ID with ``.true`` and
    ``.believed`` forms, for example ``r1.x.true``, ``s4.count.believed``, ``g3.violated.true``;
    and last, for each goal, whether it is certain to be missed: ``g3.missed.true``.

    Parameters
    ----------
    mission
        Gives the column names.
    stream
        Open text file; the caller closes it.
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


_BELIEVED: Mapping[str, Mapping[Field, tuple[str, ...]]] = MappingProxyType(
    {
        "robots": {
            Field.POSITION: ("x", "y", "z"),
            Field.SPEED: ("speed",),
            Field.ENERGY: ("energy",),
        },
        "sensors": {Field.COUNT: ("count",), Field.RATE: ("rate",), Field.COST: ("cost",)},
        "obstacles": {Field.OBSTACLE: ("x", "y")},
    }
)
"""Properties of which belief can differ from the truth, by the list of a state that has them."""


class SimulationLog:
    """Observer that writes the true state, what is believed otherwise, and what happened.

    Events are the first and the last tick at which a fault is active, and the first at which it
    changes something; changes of speed, heading and activation, the beginning and end of collisions
    and goal violations (true ones, and whether they are believed), and that a goal is from now on
    certain to be missed.

    Parameters
    ----------
    mission
        Gives the names.
    stream
        Open text file; the caller closes it.
    faults
        Those of the flight.
    tallies
        What each of them does; filled before the first tick.
    """

    def __init__(
        self,
        mission: Mission,
        stream: TextIO,
        faults: Sequence[NamedFault] = (),
        tallies: Sequence[FaultTally] = (),
    ) -> None:
        self._mission = mission
        self._stream = stream
        self._faults = faults
        self._tallies = tallies
        self._known = dict(self._judged(no_verdicts(len(mission.goals))))

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        tick = world.mission.tick
        lines = [f"tick {tick}"]
        for index, robot in enumerate(self._mission.robots):
            lines.append(f"  {robot.id} {self._robot(world, index)}")
        lines += self._mistaken(world, belief)
        lines += self._fault_events(tick)
        facts = dict([*self._facts(world), *self._judged(verdicts)])
        for subject, fact in facts.items():
            before = self._known.get(subject)
            if before is not None and before != fact:
                lines.append(f"  event {subject}: {before} -> {fact}")
        self._known = facts
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
        """Yield what is believed otherwise than it is."""
        for owners, properties in _BELIEVED.items():
            pairs = zip(getattr(belief, owners), getattr(world, owners), strict=True)
            for index, pair in enumerate(pairs):
                for affected, names in properties.items():
                    believed, true = ([getattr(side, name) for name in names] for side in pair)
                    if believed != true:
                        what = describe(self._mission, (affected, index))
                        said, so = _apart(believed, true)
                        yield f"  believed {what}: {said}, true {so}"

    def _fault_events(self, tick: int) -> Iterator[str]:
        for fault, tally in zip(self._faults, self._tallies, strict=True):
            what = f"  event fault {fault.fault.id} {fault.fault.type} on {fault.target}: "
            if fault.window is None:
                if tick == fault.timed.start:
                    yield f"{what}is active at no tick"
                continue
            first, last = fault.window
            if tick == first:
                values = f" with {fault.values}" if fault.values else ""
                yield f"{what}starts ({first} … {last}){values}"
            if tick == tally.first_changed:
                yield f"{what}first changes something"
            if tick == last:
                yield f"{what}ends"

    def _facts(self, world: State) -> Iterator[tuple[str, str]]:
        """Yield what is worth an event when it changes, as subject and value."""
        mission = self._mission
        for index, robot in enumerate(mission.robots):
            command = world.commands[index]
            degrees = math.degrees(math.atan2(command.heading_y, command.heading_x)) % 360.0
            yield f"{robot.id} speed", f"{world.robots[index].speed:g}"
            yield f"{robot.id} heading", f"{degrees:.1f} degrees"
        for k, sensor in enumerate(mission.sensors):
            yield f"{sensor.id} activation", "on" if world.sensors[k].active else "off"
        for name, gap in self._gaps(world):
            yield f"collision of {name}", "yes" if gap < 0.0 else "no"

    def _judged(self, verdicts: Verdicts) -> Iterator[tuple[str, str]]:
        """Yield what is said of each goal; before the first tick, nothing is violated or missed."""
        for index, goal in enumerate(self._mission.goal_ids):
            yield f"{goal} violated", "yes" if verdicts.is_true[index] else "no"
            yield f"{goal} believed violated", "yes" if verdicts.is_believed[index] else "no"
            yield f"{goal} missed", "yes" if verdicts.missed[index] else "no"

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


def _apart(first: Sequence[float], second: Sequence[float]) -> tuple[str, str]:
    """Return unequal values as texts that differ: with two decimals, or all digits if need be."""
    short = (" ".join(f"{n:.2f}" for n in values) for values in (first, second))
    said, so = (text.replace(".00", "") for text in short)
    if said != so:
        return said, so
    return " ".join(map(repr, first)), " ".join(map(repr, second))
