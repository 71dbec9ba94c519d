"""The trace of a flight: belief and truth at every tick, as a table."""

import csv
from collections.abc import Sequence
from typing import TextIO

from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission


class TraceTable:
    """Observer that writes a CSV row a tick; floats are written so that no bit is lost.

    Columns are the tick, then per robot, sensor and goal its ID with ``.true`` and
    ``.believed`` forms, for example ``r1.x.true``, ``s4.count.believed``, ``g3.violated.true``.

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
            ["tick", *(f"{name}.{side}" for side in ("true", "believed") for name in names)]
        )

    def __call__(
        self, world: State, belief: State, true: Sequence[bool], believed: Sequence[bool]
    ) -> None:
        """Write one tick."""
        self._writer.writerow(
            [world.mission.tick, *self._values(world, true), *self._values(belief, believed)]
        )

    def _values(self, state: State, violated: Sequence[bool]) -> list[str]:
        robots = [repr(getattr(r, name)) for r in state.robots for name in self._ROBOT_FIELDS]
        sensors = [repr(getattr(s, name)) for s in state.sensors for name in self._SENSOR_FIELDS]
        goals = [
            text
            for goal, flag in zip(state.goals, violated, strict=True)
            for text in (repr(goal.count), repr(int(flag)))
        ]
        return robots + sensors + goals
