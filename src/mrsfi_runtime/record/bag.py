"""Writes a flight as a bag that viewers of ROS 2 open: topics of the bus, events, map and robots.

docs/bags.md says what is on which topic. The same flight gives the same bytes.

References
----------
https://mcap.dev/spec/registry, schema encoding ``ros2msg``, and
https://docs.ros.org/en/humble/p/visualization_msgs/msg/Marker.html.
"""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import IO, TYPE_CHECKING, Any, TypeAlias

from mrsfi_runtime.cosimulation.bus_topics import CLOCK
from mrsfi_runtime.cosimulation.lockstep import RobotTopics, SensorTopics, true_values
from mrsfi_runtime.kernel.commands import reports_position
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import RobotState, State
from mrsfi_runtime.model.fault_types import plain_name
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Coordinates, Mission
from mrsfi_runtime.record.observers import Events, NamedFault, Window
from mrsfi_runtime.transport.topics import Topic, time_of, type_name

if TYPE_CHECKING:
    from mcap.records import Schema

Message: TypeAlias = dict[str, Any]
"""Fields of a message to values; what is left out is zero or empty."""

Said: TypeAlias = tuple[Topic, Message]
"""A message, and the topic that it is on."""

Place: TypeAlias = tuple[float, float, float]
Colour: TypeAlias = tuple[float, float, float, float]

LOG = Topic("/rosout", "rcl_interfaces/Log")
TRANSFORMS = Topic("/tf", "tf2_msgs/TFMessage")
MAP = Topic("/mission_map", "visualization_msgs/MarkerArray")
ROBOTS = Topic("/markers", "visualization_msgs/MarkerArray")

_LEVELS: Mapping[str, int] = MappingProxyType(
    {"command": 10, "fault": 30, "collision": 40, "verdict": 40}
)
"""Severities of ``rcl_interfaces/Log``: DEBUG, WARN and ERROR."""

_SECOND = 1_000_000_000  # nanoseconds
_CYLINDER, _LINE_STRIP, _LINE_LIST, _SPHERES, _TEXT = 3, 4, 5, 7, 9
_DELETE_ALL = 3
_FLAT, _LETTER, _THIN = 0.1, 2.0, 0.3  # height of a disc, of a letter, width of a line
_ORIGIN = (0.0, 0.0, 0.0)

_TRUE, _BELIEVED, _STRUCK = (0.1, 0.4, 0.7, 1.0), (0.1, 0.4, 0.7, 0.35), (0.85, 0.4, 0.15, 1.0)
_AREA, _GOAL = (0.1, 0.4, 0.7, 0.06), (0.15, 0.55, 0.4, 0.25)
_ROCK, _INK = (0.4, 0.45, 0.5, 1.0), (0.1, 0.15, 0.2, 1.0)


class Bag:
    """Observer that writes a flight into an MCAP file of profile ``ros2``; tick k is k seconds.

    The caller closes the stream, a binary file, after ``finish``.
    """

    def __init__(
        self, mission: Mission, stream: IO[bytes], faults: Sequence[NamedFault], events: Events
    ) -> None:
        self._mission = mission
        self._faults = faults
        self._events = events
        robots = [plain_name(robot.id) for robot in mission.robots]
        self._frames = [(name, f"believed/{name}") for name in robots]
        self._robots = [RobotTopics(name) for name in robots]
        self._sensors = [
            SensorTopics(robots[robot], plain_name(sensor.id))
            for robot, sensor in zip(mission.sensor_robot, mission.sensors, strict=True)
        ]
        self._goals = [f"/goals/{plain_name(goal)}" for goal in mission.goal_ids]
        self._known: dict[str, Message] = {}
        from mcap_ros2.writer import Writer  # noqa: PLC0415 - for bags alone
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - for bags alone

        self._writer = Writer(stream)
        self._types = get_typestore(Stores.ROS2_HUMBLE)
        self._schema = cache(self._registered)

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        for topic, message in self._said(world, belief, verdicts):
            schema = self._schema(topic.type)
            time = world.mission.tick * _SECOND
            self._writer.write_message(topic.name, schema, message, time)

    def finish(self) -> None:
        """Write what belongs to the end of the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _registered(self, name: str) -> "Schema":
        full = type_name(name, "msg", 2)
        return self._writer.register_msgdef(full, self._types.generate_msgdef(full, 2)[0])

    def _said(self, world: State, belief: State, verdicts: Verdicts) -> Iterator[Said]:
        """Yield what is written of a tick; of what seldom changes, only what does."""
        tick = world.mission.tick
        time = time_of(tick, 2)
        yield CLOCK, {"clock": time}
        if tick == 0:
            yield MAP, map_markers(self._mission, [frame for frame, _ in self._frames])
        for index, topics in enumerate(self._robots):
            if reports_position(world, index):
                yield topics.position, point(_of(world.robots[index]))
            yield topics.truth, {"data": true_values(world, index)}
        yield from self._numbers(world)
        for index, topics in enumerate(self._robots):
            yield _of_belief((topics.position, point(_of(belief.robots[index]))))
        yield from map(_of_belief, self._numbers(belief))
        for topic, message in (
            *self._switched(world),
            *map(_of_belief, self._switched(belief)),
            *self._judged(verdicts),
            *self._commands(world),
        ):
            if self._known.get(topic.name) != message:
                self._known[topic.name] = message
                yield topic, message
        for kind, said in self._events.at(world, verdicts):
            yield LOG, {"stamp": time, "level": _LEVELS[kind], "name": kind, "msg": said}
        yield TRANSFORMS, self._transforms(world, belief)
        told = zip(self._faults, self._events.tallies, strict=True)
        active = [(fault.robots, fault.active(tally)) for fault, tally in told]
        yield ROBOTS, robot_markers(self._mission, active, world, belief)

    def _numbers(self, state: State) -> Iterator[Said]:
        for robot, of_robot in zip(state.robots, self._robots, strict=True):
            yield of_robot.speed, {"data": robot.speed}
            yield of_robot.energy, {"data": robot.energy}
        for sensor, of_sensor in zip(state.sensors, self._sensors, strict=True):
            yield of_sensor.samples, {"data": sensor.count}

    def _switched(self, state: State) -> Iterator[Said]:
        for sensor, of_sensor in zip(state.sensors, self._sensors, strict=True):
            yield of_sensor.active, {"data": bool(sensor.active)}

    def _commands(self, world: State) -> Iterator[Said]:
        """Yield what was commanded for the tick after, be it by a fault."""
        for command, of_robot in zip(world.commands, self._robots, strict=True):
            heading = (command.heading_x, command.heading_y, 0.0)
            yield of_robot.heading_command, point(heading)
            yield of_robot.speed_command, {"data": command.speed}
        for switch, of_sensor in zip(world.switches, self._sensors, strict=True):
            yield of_sensor.active_command, {"data": bool(switch.active)}

    def _judged(self, verdicts: Verdicts) -> Iterator[Said]:
        for what, flags in (
            ("believed", verdicts.is_believed),
            ("true", verdicts.is_true),
            ("missed", verdicts.missed),
        ):
            for name, flag in zip(self._goals, flags, strict=True):
                yield Topic(f"{name}/{what}", "std_msgs/Bool"), {"data": flag > 0}

    def _transforms(self, world: State, belief: State) -> Message:
        return {
            "transforms": [
                {
                    "header": stamped(world.mission.tick),
                    "child_frame_id": frame,
                    "transform": {"translation": point(_of(robot)), "rotation": {"w": 1.0}},
                }
                for *both, frames in zip(world.robots, belief.robots, self._frames, strict=True)
                for robot, frame in zip(both, frames, strict=True)
            ]
        }


def _of_belief(said: Said) -> Said:
    topic, message = said
    return Topic(f"/belief{topic.name}", topic.type), message


def stamped(tick: int, frame: str = "map") -> Message:
    """Return the header of what is at a place of a frame at a tick."""
    return {"stamp": time_of(tick, 2), "frame_id": frame}


def map_markers(mission: Mission, frames: Sequence[str]) -> Message:
    """Return what never changes: areas, waypoints, obstacles, and names that move with robots."""
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
        markers.append(_disc("obstacles", spot, obstacle.area.radius, _ROCK))
        markers.append(_text("obstacles", spot, obstacle.id))
    for robot, frame in zip(mission.robots, frames, strict=True):
        name = _text("robots", _ORIGIN, robot.id)
        markers.append({**name, "header": stamped(0, frame), "frame_locked": True})
    return _array(0, markers)


def robot_markers(
    mission: Mission,
    active: Iterable[tuple[Collection[int], Window | None]],
    world: State,
    belief: State,
) -> Message:
    """Return robots where they are and are believed to be, and misplaced obstacles, at a tick.

    Robots that an active fault touches have another colour, by their places and when it is active.
    It replaces what was drawn before.
    """
    tick, wide = world.mission.tick, 2.0 * ROBOT_RADIUS
    windows = ((robots, window or (0, -1)) for robots, window in active)
    struck = {each for robots, (first, last) in windows if first <= tick <= last for each in robots}
    true, believed = ([_of(robot) for robot in side.robots] for side in (world, belief))
    colours = [_STRUCK if index in struck else _TRUE for index in range(len(true))]
    errors = [
        spot for pair in zip(true, believed, strict=True) if pair[0] != pair[1] for spot in pair
    ]
    markers: list[Message] = [
        {"action": _DELETE_ALL},
        _points("robots", _SPHERES, wide, true, colours),
        _points("believed robots", _SPHERES, wide, believed, [_BELIEVED] * len(true)),
    ]
    if errors:
        markers.append(_points("errors", _LINE_LIST, _THIN, errors))
    obstacles = zip(mission.obstacles, world.obstacles, belief.obstacles, strict=True)
    for obstacle, is_at, is_believed_at in obstacles:
        said = (is_believed_at.x, is_believed_at.y, 0.0)
        if said != (is_at.x, is_at.y, 0.0):
            radius, namespace = obstacle.area.radius, "believed obstacles"
            markers.append(_disc(namespace, said, radius, _BELIEVED))
            markers.append(_text(namespace, said, obstacle.id))
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
    namespace: str, kind: int, wide: float, path: Sequence[Place], colours: Sequence[Colour] = ()
) -> Message:
    return {
        **_marker(namespace, kind, _ORIGIN, (wide, wide, wide), _INK),
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
