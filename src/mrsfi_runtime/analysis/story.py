"""Describe a recorded flight in space and time, for figures, tables and the page.

A ``Story`` has true and believed positions, windows in which faults were active and goals were
violated, and collisions; ``story_of`` makes one. ``flight_content`` packs a flight for the page:
series to a stated resolution, verdicts as windows, and events. ``packed`` makes text of it.
"""

import json
import zlib
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from math import floor, log10
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.analysis.tables import Table, every
from mrsfi_runtime.engine.recording import SIDES, Recording
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Area, Mission
from mrsfi_runtime.model.polygons import off_way
from mrsfi_runtime.record.observers import NamedFault, Window

Places: TypeAlias = npt.NDArray[np.float64]
"""Points of the plane, in distance units; the last axis has x and y."""


@dataclass(frozen=True, slots=True)
class Judged:
    """The windows in which a goal was violated, and the tick from which on it was missed."""

    believed: Sequence[Window]
    true: Sequence[Window]
    missed: int | None


@dataclass(frozen=True, slots=True)
class Collision:
    """Two IDs that overlapped, the index of the robot that is the first, and the window."""

    names: str
    robot: int
    window: Window


@dataclass(frozen=True, slots=True)
class Story:
    """A flight as figures show it.

    The ``window`` of a fault is the one in which it was active, also after a trigger. Goals are in
    model order. ``collisions`` are true ones. ``true`` and ``believed`` are positions of robots,
    shape ``(n_ticks, n_robots, 2)``.
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
        """The indices of the robots that its faults touch."""
        return frozenset(robot for fault in self.faults for robot in fault.robots)


def story_of(
    title: str, mission: Mission, faults: Sequence[NamedFault], recording: Recording
) -> Story:
    """Return the story of a recorded flight."""
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
    """Yield the windows in which robots overlapped each other or an obstacle, at ticks or before.

    A tick counts if discs overlapped on their way to it from the tick before, as in
    ``kernel.goal_tasks.avoid_collision``.
    """
    radii = np.array([robot.radius for robot in mission.robots])
    start = [(robot.position.x, robot.position.y) for robot in mission.robots]
    before = np.concatenate((np.array(start).reshape(1, -1, 2), true[:-1]))
    near = _near(before, true, radii)
    discs = [each.area for each in mission.obstacles]
    centres = np.array([(disc.center.x, disc.center.y) for disc in discs]).reshape(-1, 1, 2)
    for k, robot in enumerate(mission.robots):
        now, was = true[:, k], before[:, k]
        for i in near(k):
            off = _least(now - true[:, i], was - before[:, i])
            for window in runs(off < radii[k] + radii[i]):
                yield Collision(f"{robot.id} and {mission.robots[i].id}", k, window)
        for disc, obstacle, off in zip(
            discs, mission.obstacles, _least(now - centres, was - centres), strict=True
        ):
            hits = off < radii[k] + disc.radius
            for tick in np.flatnonzero(hits) if disc.corners else ():
                edge, end, way = disc.corners, now[tick], was[tick] - now[tick]
                hits[tick] = off_way(edge, 0, len(edge), *end, *way) < radii[k]
            for window in runs(hits) if hits.any() else ():
                yield Collision(f"{robot.id} and {obstacle.id}", k, window)


def _least(now: Places, was: Places) -> npt.NDArray[np.float64]:
    """Return the least distances from the origin on straight ways, one for each pair of points."""
    way = was - now
    square = (way * way).sum(-1)
    share = np.divide(-(now * way).sum(-1), square, out=np.zeros_like(square), where=square > 0.0)
    least: Places = np.hypot(*np.moveaxis(now + share.clip(0.0, 1.0)[..., None] * way, -1, 0))
    return least


def _near(
    before: Places, true: Places, radii: npt.NDArray[np.float64]
) -> Callable[[int], Iterable[int]]:
    """Return a function of a robot's index that returns earlier ones whose boxes come near."""
    begins = np.arange(0, len(true), 32)  # first ticks of the parts of a path that have a box
    low = np.fmin.reduceat(np.fmin(before, true), begins)
    high = np.fmax.reduceat(np.fmax(before, true), begins)

    def near(k: int) -> Iterable[int]:
        apart = np.maximum(low[:, :k] - high[:, k, None], low[:, k, None] - high[:, :k])
        reach = 1.001 * (radii[:k, None] + radii[k])
        return np.flatnonzero((apart < reach).all(axis=2).any(axis=0)).tolist()

    return near


def judged(recording: Recording) -> tuple[Judged, ...]:
    """Return the verdicts on each goal of a flight, in model order."""
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
    discs = [(each.area.center, each.area.radius) for each in mission.goal_discs]
    discs += [(each.area.center, each.area.radius) for each in mission.obstacles]
    discs += [(each.position, each.radius) for each in mission.robots]
    left, right = min(at.x - r for at, r in discs), max(at.x + r for at, r in discs)
    low, high = min(at.y - r for at, r in discs), max(at.y + r for at, r in discs)
    half = max(right - left, high - low) / 2
    return (left + right) / 2, (low + high) / 2, max(half * 1.12, mission.area.radius * 0.01)


def window_around(mission: Mission, places: Places) -> tuple[float, float, float]:
    """Return x, y and half width of a square that also includes places, shape ``(…, 2)``."""
    x, y, half = working_window(mission)
    reach = float(np.abs(places - (x, y)).max())
    return x, y, max(half, reach * 1.05)


def timeline_table(story: Story) -> Table:
    """Return the windows of a flight: of active faults, violated goals and collisions."""
    return Table(story.title, ("kind", "name", "what", "first", "last"), [*windows(story)])


def windows(story: Story) -> Iterator[tuple[str, str, str, int, int]]:
    """Yield states that last: kind, owner, state, first and last tick."""
    for fault in story.faults:
        if fault.window is not None:
            yield "fault", fault.name, fault.words, *fault.window
    last = story.mission.duration - 1
    for goal, each in zip(story.mission.goals, story.goals, strict=True):
        for what, times in (("violated in belief", each.believed), ("truly violated", each.true)):
            for window in times:
                yield "goal", goal.id, what, *window
        if each.missed is not None:
            yield "goal", goal.id, "failed", each.missed, last
    for collision in story.collisions:
        yield "collision", collision.names, "truly", *collision.window


def places_table(story: Story) -> Table:
    """Return true and believed positions of robots, at every tick or at every n-th."""
    robots, duration = story.mission.robots, story.mission.duration
    step = every(duration * len(robots), 20_000)  # rows, at most
    rows = [
        (tick, robot.id, *story.true[tick, k].tolist(), *story.believed[tick, k].tolist())
        for tick in range(0, duration, step)
        for k, robot in enumerate(robots)
    ]
    return Table(story.title, ("tick", "robot", "x", "y", "believed_x", "believed_y"), rows)


MOST_VALUES = 6_000_000
"""Numbers of all series of a page, at most; longer series leave out ticks."""

_SERIES = ("x", "y", "speed", "energy")


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight, about a goal or none, and the flights without one fault, by the fault's index."""

    title: str
    faults: Sequence[NamedFault]
    recording: Recording
    others: dict[int, Recording]
    goal: str = ""
    first: int = 0


def mission_content(mission: Mission) -> dict[str, Any]:
    """Return what the page shows of a mission without a flight."""
    area, units = mission.area, mission.units
    length, speed = units.distance, units.of(Range.SPEED) if units.distance else ""
    return {
        "name": mission.name,
        "duration": mission.duration,
        "units": {"x": length, "y": length, "speed": speed, "energy": units.energy},
        "area": [area.center.x, area.center.y, area.radius],
        "robots": [
            {"id": robot.id, "name": robot.name, "radius": robot.radius} for robot in mission.robots
        ],
        "obstacles": [{"id": each.id, **_shape(each.area)} for each in mission.obstacles],
        "goals": [
            {"id": goal.id, "name": goal.name, "label": goal.name or goal.id}
            for goal in mission.goals
        ],
        "discs": [{"goal": disc.label, **_shape(disc.area)} for disc in mission.goal_discs],
    }


def _shape(area: Area) -> dict[str, Any]:
    """Return a disc; of a polygon also its corners."""
    found = {"x": area.center.x, "y": area.center.y, "radius": area.radius}
    return found | ({"corners": area.offsets} if area.corners else {})


def flight_content(mission: Mission, flown: Flown, stride: int) -> dict[str, Any]:
    """Return what the page shows of a flight, with motion at every ``stride``-th tick.

    The page has the flight without faults once. So it is left out of the flights of a single fault.
    """
    story = story_of(flown.title, mission, flown.faults, flown.recording)
    whole = motion(mission, flown.recording, stride)
    steps, flights = whole["steps"], [{"without": None, **whole}]
    for place, recording in flown.others.items():
        is_fault_free = len(flown.faults) == 1
        other = {} if is_fault_free else motion(mission, recording, stride)
        flights.append({"without": place, **other})
    ticks = "every tick" if stride == 1 else f"every {stride}th tick, with straight lines between"
    kept = ", ".join(f"{name} to within {steps[name] / 2:g}" for name in _SERIES if name != "y")
    return {
        "title": flown.title,
        "goal": flown.goal,
        "first": flown.first,
        "robots": sorted(story.struck),
        "window": _whole(mission, window_around(mission, story.true)),
        "faults": [
            {
                "name": fault.name,
                "type": fault.fault.type,
                "target": fault.target,
                "values": fault.values_in_words,
                "window": fault.window,
                **({"waits": fault.timed[1:3]} if fault.trigger else {}),
            }
            for fault in story.faults
        ],
        "flights": flights,
        "displaced": list(_displaced(mission, flown.recording)),
        "samples": [*_samples(mission, flown.recording, steps["x"])],
        "events": sorted(_events(story), key=lambda event: event[0]),
        "said": f"Shown for {ticks}; {kept.replace('x to', 'positions to')}, in mission units.",
    }


def stride(mission: Mission, n_flights: int) -> int:
    """Return the distance of the ticks that a page with ``n_flights`` keeps."""
    n_values = n_flights * mission.duration * len(mission.robots) * 2 * len(_SERIES)
    return every(n_values, MOST_VALUES)


def _whole(mission: Mission, window: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return x, y and half width of a square around the mission area and a window."""
    area, (x, y, half) = mission.area, window
    apart = max(abs(x - area.center.x), abs(y - area.center.y))
    return area.center.x, area.center.y, max(area.radius * 1.05, apart + half)


def packed(content: Any) -> str:
    """Return plain values as text: base64 of zlib of JSON. The page reads it when it is shown."""
    text = json.dumps(content, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return b64encode(zlib.compress(text.encode(), 9)).decode()


def motion(mission: Mission, recording: Recording, stride: int) -> dict[str, Any]:
    """Return positions, speeds and energies of robots, and the verdicts on each goal."""
    world, belief = (recording[side]["robots"] for side in SIDES)
    steps = {name: _step(world[name], belief[name]) for name in _SERIES}
    steps["x"] = steps["y"] = max(steps["x"], steps["y"])
    kept = sorted({*range(0, mission.duration, stride), mission.duration - 1})
    series = {}
    for name in _SERIES:
        true, believed = (
            np.rint(recording[side]["robots"][name][kept] / steps[name]).astype(np.int32)
            for side in SIDES
        )
        series[name] = _packed(true)
        series[f"believed_{name}"] = _packed(believed - true)
    return {
        "stride": stride,
        "steps": steps | {f"believed_{name}": step for name, step in steps.items()},
        "digits": {name: _digits(step) for name, step in steps.items()},
        "packed": series,
        "goals": [asdict(each) for each in judged(recording)],
    }


def _packed(values: npt.NDArray[np.int32]) -> str:
    """Return numbers, shape ``(n_ticks, n)``, as text: zlib of their differences between ticks.

    The lowest bytes of all differences come first, then the second, and so on.
    """
    differences = np.diff(values, axis=0, prepend=np.zeros((1, values.shape[1]), np.int32))
    planes = np.ascontiguousarray(differences.astype("<i4")).view(np.uint8).reshape(-1, 4).T
    return b64encode(zlib.compress(planes.tobytes(), 9)).decode()


def _step(*values: npt.NDArray[Any]) -> float:
    """Return the power of ten that gives the largest value six digits."""
    largest = max(float(np.abs(each).max(initial=1.0)) for each in values)
    return float(10.0 ** (floor(log10(max(largest, 1.0))) - 5))


def _digits(step: float) -> int:
    """Return the number of decimals that distinguish numbers one step apart."""
    return max(0, -floor(log10(step)))


def _displaced(mission: Mission, recording: Recording) -> Iterator[tuple[Any, ...]]:
    """Yield wrong beliefs about obstacles: window, believed place, ID and radius."""
    true, believed = (
        np.stack([recording[side]["obstacles"][axis] for axis in "xy"]) for side in SIDES
    )
    for k, obstacle in enumerate(mission.obstacles):
        x, y = believed[:, :, k]
        is_wrong = (believed != true)[:, :, k].any(axis=0)
        if not is_wrong.any():
            continue
        moved = np.flatnonzero((np.diff(x) != 0) | (np.diff(y) != 0)) + 1
        for first, after in pairwise([0, *moved.tolist(), len(x)]):
            if is_wrong[first]:
                place = float(x[first]), float(y[first])
                yield first, after - 1, *place, obstacle.id, obstacle.area.radius


def _samples(
    mission: Mission, recording: Recording, step: float
) -> Iterator[tuple[str, float, str]]:
    """Yield goal ID, step of places, and the samples that truly counted: ticks and places."""
    goals = recording["world"]["goals"]
    count, *places = (goals[name] for name in ("count", "sampled_x", "sampled_y"))
    for k, goal in enumerate(mission.goals):
        if goal.terms.sensor is None:
            continue
        counted = np.flatnonzero(np.diff(count[:, k], prepend=0) > 0)
        x, y = (np.rint(each[counted, k] / step) for each in places)
        yield goal.id, step, _packed(np.stack([counted, x, y], axis=1).astype(np.int32))


def _events(story: Story) -> Iterator[tuple[int, str]]:
    for kind, name, what, first, last in windows(story):
        if kind == "fault":
            yield first, f"{name} ({what}) starts"
            yield last, f"{name} ({what}) ends"
            continue
        so = "colliding" if kind == "collision" else what
        yield first, f"{name} {so}"
        if last + 1 < story.mission.duration:
            yield last + 1, f"{name} no longer {so}"
