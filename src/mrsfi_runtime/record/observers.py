"""What a flight is written down as: belief and truth of every tick, and a log for people."""

import csv
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TextIO

from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.packing import PROPERTIES
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.events import Events


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
        lines += (f"  event {event}" for event in self._events.at(world, verdicts))
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
