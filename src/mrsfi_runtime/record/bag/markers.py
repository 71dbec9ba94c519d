"""What viewers draw of a flight: the map of a mission, and at each tick its robots.

References
----------
https://docs.ros.org/en/humble/p/visualization_msgs/msg/Marker.html
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

from mrsfi_runtime.kernel.state import RobotState, State
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Coordinates, Mission
from mrsfi_runtime.record.named_faults import NamedFault

Message: TypeAlias = dict[str, Any]
"""Fields of a message to values; what is left out is zero or empty."""

Place: TypeAlias = tuple[float, float, float]
Colour: TypeAlias = tuple[float, float, float, float]

FRAME = "map"
_CYLINDER, _LINE_STRIP, _LINE_LIST, _SPHERES, _TEXT = 3, 4, 5, 7, 9
_DELETE_ALL = 3
_FLAT, _LETTER, _THIN = 0.1, 2.0, 0.3  # height of a disc, of a letter, width of a line

_TRUE, _BELIEVED, _STRUCK = (0.1, 0.4, 0.7, 1.0), (0.1, 0.4, 0.7, 0.35), (0.85, 0.4, 0.15, 1.0)
_AREA, _GOAL = (0.1, 0.4, 0.7, 0.06), (0.15, 0.55, 0.4, 0.25)
_ROCK, _INK = (0.4, 0.45, 0.5, 1.0), (0.1, 0.15, 0.2, 1.0)


def stamped(tick: int, frame: str = FRAME) -> Message:
    """Return the header of what is at a place of a frame at a tick."""
    return {"stamp": {"sec": tick, "nanosec": 0}, "frame_id": frame}


def map_markers(mission: Mission, frames: Sequence[str]) -> Message:
    """Return what never changes: areas, waypoints and obstacles, and the names of the robots.

    A name is drawn in the frame of its robot, and so moves with it.
    """
    markers = [_disc("mission area", _of(mission.area.center), mission.area.radius, _AREA)]
    for disc in mission.goal_discs:
        spot = (disc.x, disc.y, 0.0)
        markers += [_disc("goals", spot, disc.radius, _GOAL), _text("goals", spot, disc.goal.id)]
    for goal in mission.goals:
        if goal.terms.trajectory:
            path = [_of(each) for each in goal.terms.trajectory]
            markers.append(_points("waypoints", _LINE_STRIP, _THIN, path))
    for obstacle in mission.obstacles:
        spot = _of(obstacle.area.center)
        markers += [
            _disc("obstacles", spot, obstacle.area.radius, _ROCK),
            _text("obstacles", spot, obstacle.id),
        ]
    for robot, frame in zip(mission.robots, frames, strict=True):
        name = _text("robots", (0.0, 0.0, 0.0), robot.id)
        markers.append({**name, "header": stamped(0, frame), "frame_locked": True})
    return _array(0, markers)


class RobotMarkers:
    """Draws robots where they are and where they are believed to be, and misplaced obstacles.

    Robots that an active fault touches are drawn in another colour.
    """

    def __init__(self, mission: Mission, faults: Sequence[NamedFault]) -> None:
        self._mission = mission
        self._struck = [
            (fault.window, fault.robots) for fault in faults if fault.window is not None
        ]

    def at(self, world: State, belief: State) -> Message:
        """Return all of a tick; it replaces what was drawn before."""
        tick = world.mission.tick
        active = (robots for (first, last), robots in self._struck if first <= tick <= last)
        struck = frozenset[int]().union(*active)
        true, believed = ([_of(robot) for robot in side.robots] for side in (world, belief))
        colours = [_STRUCK if index in struck else _TRUE for index in range(len(true))]
        errors = [
            spot for pair in zip(true, believed, strict=True) if pair[0] != pair[1] for spot in pair
        ]
        markers: list[Message] = [
            {"action": _DELETE_ALL},
            _points("robots", _SPHERES, 2.0 * ROBOT_RADIUS, true, colours),
            _points(
                "believed robots", _SPHERES, 2.0 * ROBOT_RADIUS, believed, [_BELIEVED] * len(true)
            ),
        ]
        if errors:
            markers.append(_points("errors", _LINE_LIST, _THIN, errors))
        obstacles = zip(self._mission.obstacles, world.obstacles, belief.obstacles, strict=True)
        for obstacle, is_at, is_believed_at in obstacles:
            said = (is_believed_at.x, is_believed_at.y, 0.0)
            if said != (is_at.x, is_at.y, 0.0):
                markers += [
                    _disc("believed obstacles", said, obstacle.area.radius, _BELIEVED),
                    _text("believed obstacles", said, obstacle.id),
                ]
        return _array(tick, markers)


def point(place: Place) -> Message:
    """Return a place as a point or vector."""
    return dict(zip("xyz", place, strict=True))


def _array(tick: int, markers: Iterable[Message]) -> Message:
    """Return an array of markers with the header of a tick, numbered within their namespaces."""
    header = stamped(tick)
    numbers: Counter[str] = Counter()
    numbered = []
    for marker in markers:
        namespace = marker.get("ns", "")
        numbered.append({"header": header, "id": numbers[namespace], **marker})
        numbers[namespace] += 1
    return {"markers": numbered}


def _disc(namespace: str, spot: Place, radius: float, colour: Colour) -> Message:
    wide = 2.0 * radius
    return _marker(namespace, _CYLINDER, spot, (wide, wide, _FLAT), colour)


def _text(namespace: str, spot: Place, text: str) -> Message:
    return {**_marker(f"{namespace}: names", _TEXT, spot, (0.0, 0.0, _LETTER), _INK), "text": text}


def _points(
    namespace: str,
    kind: int,
    wide: float,
    path: Sequence[Place],
    colours: Sequence[Colour] = (),
) -> Message:
    return {
        **_marker(namespace, kind, (0.0, 0.0, 0.0), (wide, wide, wide), _INK),
        "points": [point(place) for place in path],
        "colors": [dict(zip("rgba", colour, strict=True)) for colour in colours],
    }


def _marker(namespace: str, kind: int, spot: Place, scale: Place, colour: Colour) -> Message:
    return {
        "ns": namespace,
        "type": kind,
        "pose": {"position": point(spot), "orientation": {"w": 1.0}},
        "scale": point(scale),
        "color": dict(zip("rgba", colour, strict=True)),
    }


def _of(each: RobotState | Coordinates) -> Place:
    return each.x, each.y, each.z
