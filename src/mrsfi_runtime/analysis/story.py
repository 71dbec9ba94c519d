"""A flight as a story in space and time: who was where, what was active, what was violated."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.analysis.table import Table, every
from mrsfi_runtime.engine.recording import SIDES, Recording
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission
from mrsfi_runtime.record.observers import NamedFault, Window

Places: TypeAlias = npt.NDArray[np.float64]
"""Points of the plane, in distance units; the last axis has x and y."""

_MOST_PLACES = 20_000  # rows of a table of places
_BOX = 32  # ticks of a way that a box is put around


@dataclass(frozen=True, slots=True)
class Judged:
    """When a goal was violated, as windows, and from which tick on its purpose was missed."""

    believed: Sequence[Window]
    true: Sequence[Window]
    missed: int | None


@dataclass(frozen=True, slots=True)
class Collision:
    """Two that overlapped, the first of which is a robot, by its place, and when."""

    names: str
    robot: int
    window: Window


@dataclass(frozen=True, slots=True)
class Story:
    """What figures tell of a flight.

    The ``window`` of a fault is that in which it was active, also if it waited for a trigger.
    Goals stand in model order; ``collisions`` are true ones; ``true`` and ``believed`` say where
    robots were, and were believed to be, shape ``(n_ticks, n_robots, 2)``.
    """

    title: str
    mission: Mission
    faults: Sequence[NamedFault]
    goals: Sequence[Judged]
    collisions: Sequence[Collision]
    true: Places
    believed: Places

    @property
    def struck(self) -> frozenset[int]:
        """The places of the robots that its faults strike."""
        return frozenset(robot for fault in self.faults for robot in fault.robots)


def story_of(
    title: str, mission: Mission, faults: Sequence[NamedFault], recording: Recording
) -> Story:
    """Return what figures tell of a recorded flight."""
    true, believed = (
        np.stack([recording[side]["robots"][axis] for axis in ("x", "y")], axis=-1)
        for side in SIDES
    )
    met = tuple(collisions(mission, true))
    flown = tuple(
        replace(fault, window=fault.active(recording.tallies[place])) if fault.trigger else fault
        for place, fault in enumerate(faults)
    )
    return Story(title, mission, flown, judged(recording), met, true, believed)


def collisions(mission: Mission, true: Places) -> Iterator[Collision]:
    """Yield which robots overlapped each other or an obstacle, as windows."""
    near = _near(true)
    discs = [each.area for each in mission.obstacles]
    centres = np.array([(disc.center.x, disc.center.y) for disc in discs]).reshape(-1, 1, 2)
    reach = np.array([[ROBOT_RADIUS + disc.radius] for disc in discs]).reshape(-1, 1)
    for k, robot in enumerate(mission.robots):
        for i in near(k):
            is_hit = np.hypot(*(true[:, k] - true[:, i]).T) < 2 * ROBOT_RADIUS
            for window in runs(is_hit):
                yield Collision(f"{robot.id} and {mission.robots[i].id}", k, window)
        hits = np.hypot(*np.moveaxis(true[:, k] - centres, -1, 0)) < reach
        for j in np.flatnonzero(hits.any(axis=1)):
            for window in runs(hits[j]):
                yield Collision(f"{robot.id} and {mission.obstacles[j].id}", k, window)


def _near(true: Places) -> Callable[[int], Iterable[int]]:
    """Return what tells which robots before one may have met it, by the boxes around their ways."""
    begins = np.arange(0, len(true), _BOX)
    low, high = (reach.reduceat(true, begins) for reach in (np.fmin, np.fmax))
    reach = 2.001 * ROBOT_RADIUS

    def near(k: int) -> Iterable[int]:
        apart = np.maximum(low[:, :k] - high[:, k, None], low[:, k, None] - high[:, :k])
        return np.flatnonzero((apart < reach).all(axis=2).any(axis=0)).tolist()

    return near


def judged(recording: Recording) -> tuple[Judged, ...]:
    """Return what was said of each goal of a flight, in model order."""
    verdicts = (recording[name].T for name in ("is_believed", "is_true", "missed"))
    return tuple(
        Judged(runs(believed), runs(true), first(missed > 0))
        for believed, true, missed in zip(*verdicts, strict=True)
    )


def runs(flags: npt.NDArray[np.generic]) -> list[Window]:
    """Return the windows in which flags, shape ``(n_ticks,)``, are set."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags != 0, [0]))))
    return [(int(start), int(after) - 1) for start, after in edges.reshape(-1, 2)]


def first(flags: npt.NDArray[np.bool_]) -> int | None:
    """Return the first tick at which flags, shape ``(n_ticks,)``, are set."""
    return int(flags.argmax()) if flags.any() else None


def working_window(mission: Mission) -> tuple[float, float, float]:
    """Return x, y and half width of the square around robots' starts, obstacles and goal areas."""
    discs = [(disc.x, disc.y, disc.radius) for disc in mission.goal_discs]
    discs += [(robot.position.x, robot.position.y, ROBOT_RADIUS) for robot in mission.robots]
    discs += [
        (obstacle.area.center.x, obstacle.area.center.y, obstacle.area.radius)
        for obstacle in mission.obstacles
    ]
    left, right = min(x - r for x, _, r in discs), max(x + r for x, _, r in discs)
    low, high = min(y - r for _, y, r in discs), max(y + r for _, y, r in discs)
    half = max(right - left, high - low) / 2
    return (left + right) / 2, (low + high) / 2, max(half * 1.12, mission.area.radius * 0.01)


def seen(mission: Mission, places: Places) -> tuple[float, float, float]:
    """Return the same of the square around these and around places, shape ``(…, 2)``."""
    x, y, half = working_window(mission)
    reach = float(np.abs(places - (x, y)).max())
    return x, y, max(half, reach * 1.05)


def timeline_table(story: Story) -> Table:
    """Return the windows of a flight: of active faults, violated goals and collisions."""
    return Table(story.title, ("kind", "name", "what", "first", "last"), [*windows(story)])


def windows(story: Story) -> Iterator[tuple[str, str, str, int, int]]:
    """Yield what was so for a while: its kind, whose it was, what, first and last tick."""
    for fault in story.faults:
        if fault.window is not None:
            yield "fault", fault.name, fault.words, *fault.window
    last = story.mission.duration - 1
    for goal, said in zip(story.mission.goals, story.goals, strict=True):
        for what, times in (("believed violated", said.believed), ("truly violated", said.true)):
            for window in times:
                yield "goal", goal.id, what, *window
        if said.missed is not None:
            yield "goal", goal.id, "certain to be missed", said.missed, last
    for each in story.collisions:
        yield "collision", each.names, "truly", *each.window


def places_table(story: Story) -> Table:
    """Return where robots were and were believed to be, at every tick or at each so many-th."""
    robots, duration = story.mission.robots, story.mission.duration
    rows = [
        (tick, robot.id, *story.true[tick, k].tolist(), *story.believed[tick, k].tolist())
        for tick in range(0, duration, every(duration * len(robots), _MOST_PLACES))
        for k, robot in enumerate(robots)
    ]
    return Table(story.title, ("tick", "robot", "x", "y", "believed_x", "believed_y"), rows)
