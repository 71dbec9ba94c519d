"""Flights as the page shows them: positions to a stated resolution, verdicts as windows, events."""

import zlib
from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from math import floor, log10
from typing import Any

import numpy as np
import numpy.typing as npt

from mrsfi_runtime.analysis.story import Story, judged, seen, story_of, windows
from mrsfi_runtime.analysis.table import every
from mrsfi_runtime.engine.recording import SIDES, Recording
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission
from mrsfi_runtime.record.observers import NamedFault

MOST_VALUES = 6_000_000
"""Numbers of all series of a page, at most; where there were more, ticks between are left out."""

_SERIES = ("x", "y", "speed", "energy")
_DIGITS = 6  # of the largest value of a series


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight about a goal, if about one, and those without one of its faults, by its place."""

    title: str
    faults: Sequence[NamedFault]
    recording: Recording
    others: dict[int, Recording]
    goal: str = ""
    first: int = 0


def mission_content(mission: Mission) -> dict[str, Any]:
    """Return what the page shows of a mission before anything flies."""
    area, units = mission.area, mission.units
    return {
        "name": mission.name,
        "duration": mission.duration,
        "robot_radius": ROBOT_RADIUS,
        "units": {
            "x": units.distance,
            "y": units.distance,
            "speed": units.of(Range.SPEED) if units.distance else "",
            "energy": units.energy,
        },
        "area": [area.center.x, area.center.y, area.radius],
        "robots": [{"id": robot.id, "name": robot.name} for robot in mission.robots],
        "obstacles": [
            {
                "id": each.id,
                "x": each.area.center.x,
                "y": each.area.center.y,
                "radius": each.area.radius,
            }
            for each in mission.obstacles
        ],
        "goals": [
            {"id": goal.id, "name": goal.name, "label": goal.name or goal.id}
            for goal in mission.goals
        ],
        "discs": [
            {"goal": disc.goal.id, "x": disc.x, "y": disc.y, "radius": disc.radius}
            for disc in mission.goal_discs
        ],
    }


def flight_content(mission: Mission, flown: Flown, stride: int) -> dict[str, Any]:
    """Return what the page shows of a flight, of motion every so many-th tick (``stride``)."""
    world = flown.recording["world"]["robots"]
    story = story_of(flown.title, mission, flown.faults, flown.recording)
    steps = {
        name: _step(world[name], flown.recording["belief"]["robots"][name]) for name in _SERIES
    }
    steps["x"] = steps["y"] = max(steps["x"], steps["y"])
    flights = [(None, flown.recording), *flown.others.items()]
    return {
        "title": flown.title,
        "goal": flown.goal,
        "first": flown.first,
        "robots": sorted(story.struck),
        "window": seen(mission, story.true),
        "faults": [
            {
                "name": fault.name,
                "type": fault.fault.type,
                "target": fault.target,
                "values": fault.told,
                "window": fault.window,
                **({"waits": fault.timed[1:3]} if fault.trigger else {}),
            }
            for fault in story.faults
        ],
        "flights": [
            {"without": place, **_flight(mission, recording, steps, stride)}
            for place, recording in flights
        ],
        "displaced": list(_displaced(mission, flown.recording)),
        "samples": list(_samples(mission, flown.recording, _digits(steps["x"]))),
        "events": sorted(_events(story), key=lambda event: event[0]),
        "said": _resolution(steps, stride),
    }


def stride(mission: Mission, n_flights: int) -> int:
    """Return the distance of the ticks that a page with so many flights keeps of each."""
    n_values = n_flights * mission.duration * len(mission.robots) * 2 * len(_SERIES)
    return every(n_values, MOST_VALUES)


def _flight(
    mission: Mission, recording: Recording, steps: dict[str, float], stride: int
) -> dict[str, Any]:
    kept = sorted({*range(0, mission.duration, stride), mission.duration - 1})
    packed = {}
    for name in _SERIES:
        true, believed = (
            np.rint(recording[side]["robots"][name][kept] / steps[name]).astype(np.int32)
            for side in ("world", "belief")
        )
        packed[name] = _packed(true)
        packed[f"believed_{name}"] = _packed(believed - true)
    return {
        "stride": stride,
        "steps": steps | {f"believed_{name}": step for name, step in steps.items()},
        "digits": {name: _digits(step) for name, step in steps.items()},
        "packed": packed,
        "goals": [asdict(said) for said in judged(recording)],
    }


def _packed(values: npt.NDArray[np.int32]) -> str:
    """Return numbers, shape ``(n_ticks, n)``, as text: zlib of the bytes of their differences.

    The lowest bytes of all differences from tick to tick come first, then the second, and so on.
    """
    differences = np.diff(values, axis=0, prepend=np.zeros((1, values.shape[1]), np.int32))
    planes = np.ascontiguousarray(differences.astype("<i4")).view(np.uint8).reshape(-1, 4).T
    return b64encode(zlib.compress(planes.tobytes(), 9)).decode()


def _step(*values: npt.NDArray[Any]) -> float:
    """Return the power of ten that leaves the largest of values so many digits."""
    largest = max(float(np.abs(each).max(initial=1.0)) for each in values)
    return float(10.0 ** (floor(log10(max(largest, 1.0))) + 1 - _DIGITS))


def _digits(step: float) -> int:
    """Return how many digits behind the point tell numbers apart that differ by a step."""
    return max(0, -floor(log10(step)))


def _resolution(steps: dict[str, float], stride: int) -> str:
    ticks = "every tick" if stride == 1 else f"every {stride}th tick and on straight lines between"
    kept = ", ".join(f"{name} to {step / 2:g}" for name, step in steps.items() if name != "y")
    return f"Of {ticks}: {kept.replace('x to', 'positions to')}, in units of the mission."


def _displaced(mission: Mission, recording: Recording) -> Iterator[tuple[Any, ...]]:
    """Yield where obstacles were believed to be elsewhere: window, place, ID and radius."""
    true, believed = (
        np.stack([recording[side]["obstacles"][axis] for axis in "xy"]) for side in SIDES
    )
    for k, obstacle in enumerate(mission.obstacles):
        x, y = believed[:, :, k]
        is_wrong = (believed != true)[:, :, k].any(axis=0)
        if not is_wrong.any():
            continue
        moved = np.flatnonzero((np.diff(x) != 0) | (np.diff(y) != 0)) + 1
        edges = [0, *moved.tolist(), len(x)]
        for first, after in pairwise(edges):
            if is_wrong[first]:
                place = float(x[first]), float(y[first])
                yield first, after - 1, *place, obstacle.id, obstacle.area.radius


def _samples(
    mission: Mission, recording: Recording, digits: int
) -> Iterator[tuple[int, str, float, float]]:
    """Yield the samples that truly counted: tick, ID of the goal, and where."""
    goals = recording["world"]["goals"]
    count, *places = (goals[name] for name in ("count", "sampled_x", "sampled_y"))
    for k, goal in enumerate(mission.goals):
        if goal.terms.sensor is None:
            continue
        counted = np.flatnonzero(np.diff(count[:, k], prepend=0) > 0)
        for tick in counted.tolist():
            x, y = (round(float(each[tick, k]), digits) for each in places)
            yield tick, goal.id, x, y


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
