"""The files of a flight: a log for people, a trace as CSV, a bag for viewers of ROS 2.

``NamedFault`` describes a timed fault for messages, tables and JSON. ``Events`` yields the events
of each tick in words. ``TraceTable``, ``SimulationLog`` and ``Bag`` are observers: an engine calls
them with truth, belief and verdicts of every tick, and they change none of these. The same flight
writes the same bytes. docs/bags.md lists the topics of a bag.

References
----------
https://mcap.dev/spec/registry, schema encoding ``ros2msg``, and
https://docs.ros.org/en/humble/p/visualization_msgs/msg/Marker.html.
"""

import csv
import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, count, groupby
from types import MappingProxyType
from typing import IO, TYPE_CHECKING, Any, TextIO, TypeAlias

from mrsfi_runtime.cosimulation.bus_topics import CLOCK
from mrsfi_runtime.cosimulation.lockstep import RobotTopics, SensorTopics, true_values
from mrsfi_runtime.kernel.commands import reports_position
from mrsfi_runtime.kernel.flight import Verdicts, no_verdicts
from mrsfi_runtime.kernel.injections import FaultShapes, FaultTally, active_window, longest
from mrsfi_runtime.kernel.state import PROPERTIES, RobotState, State
from mrsfi_runtime.model.fault_types import Units, plain_name
from mrsfi_runtime.model.faults import (
    LAST,
    Fault,
    FaultPool,
    Specification,
    TimedFault,
    Trigger,
    describe,
    robots_of,
)
from mrsfi_runtime.model.mission import Coordinates, Mission, Offsets
from mrsfi_runtime.model.polygons import off_segment, off_way
from mrsfi_runtime.transport.topics import Topic, time_of, type_name

if TYPE_CHECKING:
    from mcap.records import Schema


Window: TypeAlias = tuple[int, int]
"""First and last tick."""


@dataclass(frozen=True, slots=True)
class NamedFault:
    """A timed fault, and what is needed to describe it.

    ``touched`` names the affected properties. ``robots`` are the indexes of the robots that have
    them or carry the sensors that do. ``window`` has the first and last tick at which the fault is
    active, ``None`` if it never is; ``units`` are those of the mission. With a ``trigger``, it is
    active for at most ``most`` ticks of the window.
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
        """The affected properties, after the element that it refers to: ``m8: r2 speed``.

        The element is left out if the properties name it.
        """
        refers = self.fault.target
        words = ", ".join(self.touched) or "nothing"
        names = bool(self.touched) and all(each.startswith(f"{refers} ") for each in self.touched)
        return words if names else f"{refers}: {words}"

    @property
    def words(self) -> str:
        """Its type, and its target: ``FixedSpeed on m8: r2 speed``."""
        return f"{self.fault.type} on {self.target}"

    @property
    def values(self) -> str:
        """Its values with names and units; empty if its type has no parameters."""
        return self.fault.kind.in_words(self.timed.values, self.units)

    @property
    def values_in_words(self) -> str:
        """Its values and its trigger; empty if it has neither."""
        return "; ".join(filter(None, (self.values, self.trigger.words if self.trigger else "")))

    def active(self, tally: FaultTally) -> Window | None:
        """Return when it is active in a flight, as far as its tally shows until now.

        A fault with a trigger is active at all ticks from its first one on.
        """
        if self.trigger is None or self.window is None or not tally.applied:
            return self.window if self.trigger is None else None
        first = tally.last_applied - tally.applied + 1
        return first, min(self.window[1], first + self.most - 1)

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values, without its ID."""
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
    shapes = FaultShapes(mission, pool)

    @cache
    def touching(fault: str) -> tuple[tuple[str, ...], frozenset[int]]:
        targets = shapes[fault].targets
        return tuple(describe(mission, each) for each in targets), robots_of(mission, targets)

    def named(name: str, timed: TimedFault) -> NamedFault:
        fault, trigger = pool[timed.fault], pool.triggers_by_id.get(timed.trigger)
        return NamedFault(
            name,
            timed,
            fault,
            *touching(fault.id),
            window=active_window(shapes, timed),
            units=mission.units,
            trigger=trigger,
            most=LAST if trigger is None else longest(fault.kind, timed.values, trigger),
        )

    if names is None:
        names = [timed.fault for timed in specification]
    return tuple(named(*pair) for pair in zip(names, specification, strict=True))


class Events:
    """Describes the events of a flight, tick by tick from the first.

    ``tallies`` count what each fault does; the engine adds them before the first tick.
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
        """Yield kind and description of each event at the next tick."""
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
                    yield "fault", f"{what}: is never active"
                continue
            values = f" with {fault.values}" if fault.values else ""
            if fault.trigger is not None and tick == fault.window[0]:
                yield "fault", f"{what}: can start from this tick on, {fault.trigger.words}"
            first, last = fault.active(tally) or (-1, -1)
            if tick == first:
                yield "fault", f"{what}: starts ({first} … {last}){values}"
            if tick == tally.first_changed:
                yield "fault", f"{what}: has its first effect"
            if tick == last:
                yield "fault", f"{what}: ends"

    def _facts(self, world: State) -> Iterator[tuple[str, str, str]]:
        """Yield kind, subject and value of all facts whose change is an event."""
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
        """Yield the verdicts on each goal; before the first tick, none is violated or failed."""
        for index, goal in enumerate(self._mission.goal_ids):
            for what, flag in (
                ("violated", verdicts.is_true[index]),
                ("believed violated", verdicts.is_believed[index]),
                ("failed", verdicts.missed[index]),
            ):
                yield "verdict", f"{goal} {what}", "yes" if flag else "no"

    def _gaps(self, world: State) -> Iterator[tuple[str, float]]:
        """Yield the gap between the discs of every two robots, and of robots and obstacles.

        It is the least on their way from the tick before, as in ``goal_tasks.avoid_collision``.
        """
        robots = list(zip(self._mission.robots, world.robots, world.wakes, strict=False))
        for (first, a, was_a), (second, b, was_b) in combinations(robots, 2):
            dx, dy = b.x - a.x, b.y - a.y
            gap = off_segment(-dx, -dy, was_b.x - was_a.x - dx, was_b.y - was_a.y - dy)
            yield f"{first.id} and {second.id}", gap - (first.radius + second.radius)
        for obstacle, area in zip(self._mission.obstacles, world.outlines, strict=True):
            for robot, a, was in robots:
                dx, dy, way_x, way_y = a.x - area.x, a.y - area.y, was.x - a.x, was.y - a.y
                if area.n_corners:
                    corners = world.corners, area.first_corner, area.n_corners
                    gap = off_way(*corners, dx, dy, way_x, way_y)
                else:
                    gap = off_segment(-dx, -dy, way_x, way_y) - area.radius
                yield f"{robot.id} and {obstacle.id}", gap - robot.radius


class TraceTable:
    """Observer that writes a CSV row a tick to a text file; floats keep every bit.

    Columns are the tick, then values of each robot, sensor and goal, true and believed, for
    example ``r1.x.true``, ``s4.count.believed``, ``g3.violated.true``. Last comes, for each goal,
    whether it can no longer be met: ``g3.missed.true``.
    """

    _FIELDS: Mapping[str, Sequence[str]] = MappingProxyType(
        {"robots": ("x", "y", "speed", "energy"), "sensors": ("count", "active", "rate", "cost")}
    )

    def __init__(self, mission: Mission, stream: TextIO) -> None:
        self._writer = csv.writer(stream, lineterminator="\n")
        names = [
            f"{each.id}.{name}"
            for listed, fields in self._FIELDS.items()
            for each in getattr(mission, listed)
            for name in fields
        ]
        names += [f"{goal}.{name}" for goal in mission.goal_ids for name in ("count", "violated")]
        sides = [f"{name}.{side}" for side in ("true", "believed") for name in names]
        missed = (f"{goal}.missed.true" for goal in mission.goal_ids)
        self._writer.writerow(["tick", *sides, *missed])

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        true = self._values(world, verdicts.is_true)
        believed = self._values(belief, verdicts.is_believed)
        missed = (int(missed > 0) for missed in verdicts.missed)
        self._writer.writerow([world.mission.tick, *true, *believed, *missed])

    def _values(self, state: State, violated: Sequence[int]) -> Iterator[str]:
        for listed, fields in self._FIELDS.items():
            for each in getattr(state, listed):
                yield from (repr(getattr(each, name)) for name in fields)
        for goal, flag in zip(state.goals, violated, strict=True):
            yield from (repr(goal.count), repr(int(flag)))


class SimulationLog:
    """Observer that writes the true state, beliefs that differ from it, and events."""

    def __init__(self, mission: Mission, stream: TextIO, events: Events) -> None:
        self._mission = mission
        self._stream = stream
        self._events = events

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        lines = [f"tick {world.mission.tick}"]
        for each, robot in zip(self._mission.robots, world.robots, strict=True):
            samples = "".join(
                f" {self._mission.sensors[k].id}={world.sensors[k].count}"
                for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors)
            )
            lines.append(
                f"  {each.id} x={robot.x:.2f} y={robot.y:.2f} speed={robot.speed:g} "
                f"energy={robot.energy:.1f} samples{samples}"
            )
        lines += self._mistaken(world, belief)
        lines += (f"  event {event}" for _, event in self._events.at(world, verdicts))
        self._stream.write("\n".join(lines) + "\n")

    def _mistaken(self, world: State, belief: State) -> Iterator[str]:
        for listed, group in groupby(PROPERTIES, key=lambda each: PROPERTIES[each][0]):
            properties = [*group]
            owners, *sides = (getattr(each, listed) for each in (self._mission, belief, world))
            for owner, *pair in zip(owners, *sides, strict=True):
                for affected in properties:
                    _, names = PROPERTIES[affected]
                    believed, true = ([getattr(side, name) for name in names] for side in pair)
                    if believed != true:
                        first, second = _apart(believed, true)
                        name = f"{owner.id} {affected.name.lower()}"
                        yield f"  believed {name}: {first}, true {second}"


def _apart(first: Sequence[float], second: Sequence[float]) -> tuple[str, str]:
    """Return unequal values as texts that differ: with two decimals, or all digits if need be."""
    short = (" ".join(f"{n:.2f}" for n in values) for values in (first, second))
    texts = tuple(text.replace(".00", "") for text in short)
    if texts[0] != texts[1]:
        return texts[0], texts[1]
    return " ".join(map(repr, first)), " ".join(map(repr, second))


Message: TypeAlias = dict[str, Any]
"""Fields of a message to values; missing ones are zero or empty."""

Published: TypeAlias = tuple[Topic, Message]
"""A message, and its topic."""

Place: TypeAlias = tuple[float, float, float]
Colour: TypeAlias = tuple[float, float, float, float]

LOG = Topic("/rosout", "rcl_interfaces/Log")
TRANSFORMS = Topic("/tf", "tf2_msgs/TFMessage")
MAP = Topic("/mission_map", "visualization_msgs/MarkerArray")
ROBOTS = Topic("/markers", "visualization_msgs/MarkerArray")

_LEVELS = {"command": 10, "fault": 30, "collision": 40, "verdict": 40}
"""Severities of ``rcl_interfaces/Log``: DEBUG, WARN and ERROR."""

_CYLINDER, _LINE_STRIP, _LINE_LIST, _SPHERES, _TEXT = 3, 4, 5, 7, 9
_THIN = 0.3  # width of a line
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
        for topic, message in self._messages(world, belief, verdicts):
            nanoseconds = world.mission.tick * 1_000_000_000
            self._writer.write_message(topic.name, self._schema(topic.type), message, nanoseconds)

    def finish(self) -> None:
        """Write the end of the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _registered(self, name: str) -> "Schema":
        full = type_name(name, "msg", 2)
        return self._writer.register_msgdef(full, self._types.generate_msgdef(full, 2)[0])

    def _messages(self, world: State, belief: State, verdicts: Verdicts) -> Iterator[Published]:
        """Yield the messages of a tick; values that seldom change come only when they do."""
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
        for kind, event in self._events.at(world, verdicts):
            yield LOG, {"stamp": time, "level": _LEVELS[kind], "name": kind, "msg": event}
        yield TRANSFORMS, self._transforms(world, belief)
        tallied = zip(self._faults, self._events.tallies, strict=True)
        active = [(fault.robots, fault.active(tally)) for fault, tally in tallied]
        yield ROBOTS, robot_markers(self._mission, active, world, belief)

    def _numbers(self, state: State) -> Iterator[Published]:
        for robot, of_robot in zip(state.robots, self._robots, strict=True):
            yield of_robot.speed, {"data": robot.speed}
            yield of_robot.energy, {"data": robot.energy}
        for sensor, of_sensor in zip(state.sensors, self._sensors, strict=True):
            yield of_sensor.samples, {"data": sensor.count}

    def _switched(self, state: State) -> Iterator[Published]:
        for sensor, of_sensor in zip(state.sensors, self._sensors, strict=True):
            yield of_sensor.active, {"data": bool(sensor.active)}

    def _commands(self, world: State) -> Iterator[Published]:
        """Yield the commands for the next tick, faulty ones included."""
        for command, of_robot in zip(world.commands, self._robots, strict=True):
            heading = (command.heading_x, command.heading_y, 0.0)
            yield of_robot.heading_command, point(heading)
            yield of_robot.speed_command, {"data": command.speed}
        for switch, of_sensor in zip(world.switches, self._sensors, strict=True):
            yield of_sensor.active_command, {"data": bool(switch.active)}

    def _judged(self, verdicts: Verdicts) -> Iterator[Published]:
        lists = (verdicts.is_believed, verdicts.is_true, verdicts.missed)
        for what, flags in zip(("believed", "true", "missed"), lists, strict=True):
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


def _of_belief(published: Published) -> Published:
    topic, message = published
    return Topic(f"/belief{topic.name}", topic.type), message


def stamped(tick: int, frame: str = "map") -> Message:
    """Return the header of a message about a frame at a tick."""
    return {"stamp": time_of(tick, 2), "frame_id": frame}


def map_markers(mission: Mission, frames: Sequence[str]) -> Message:
    """Return all fixed markers: areas, waypoints, obstacles, and names that move with robots."""
    markers = [_shape("mission area", _of(mission.area.center), mission.area.radius, (), _AREA)]
    for disc in mission.goal_discs:
        area, spot = disc.area, (disc.area.center.x, disc.area.center.y, 0.0)
        markers.append(_shape("goals", spot, area.radius, area.offsets, _GOAL))
        markers.append(_text("goals", spot, disc.label))
    paths = ([_of(each) for each in goal.terms.path] for goal in mission.goals)
    markers += [_points("waypoints", _LINE_STRIP, _THIN, path) for path in paths if path]
    for obstacle in mission.obstacles:
        spot, area = _of(obstacle.area.center), obstacle.area
        markers.append(_shape("obstacles", spot, area.radius, area.offsets, _ROCK))
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
    """Return the true and believed places of robots, and misplaced obstacles, at a tick.

    ``active`` has, for each fault, its robots and its active window; robots with an active fault
    have another colour. The markers replace all earlier ones.
    """
    tick = world.mission.tick
    windows = ((robots, window or (0, -1)) for robots, window in active)
    struck = {each for robots, (first, last) in windows if first <= tick <= last for each in robots}
    true, believed = ([_of(robot) for robot in side.robots] for side in (world, belief))
    colours = [_STRUCK if index in struck else _TRUE for index in range(len(true))]
    pairs = zip(true, believed, strict=True)
    errors = [spot for pair in pairs if pair[0] != pair[1] for spot in pair]
    markers: list[Message] = [{"action": 3}]  # deletes all
    for radius in dict.fromkeys(robot.radius for robot in mission.robots):
        some = [k for k, robot in enumerate(mission.robots) if robot.radius == radius]
        for namespace, spots, shades in (
            ("robots", true, colours),
            ("believed robots", believed, [_BELIEVED] * len(true)),
        ):
            spheres = [spots[k] for k in some], [shades[k] for k in some]
            markers.append(_points(namespace, _SPHERES, 2.0 * radius, *spheres))
    if errors:
        markers.append(_points("errors", _LINE_LIST, _THIN, errors))
    obstacles = zip(mission.obstacles, world.obstacles, belief.obstacles, strict=True)
    for obstacle, is_at, is_believed_at in obstacles:
        spot, namespace = (is_believed_at.x, is_believed_at.y, 0.0), "believed obstacles"
        if spot != (is_at.x, is_at.y, 0.0):
            area = obstacle.area
            markers.append(_shape(namespace, spot, area.radius, area.offsets, _BELIEVED))
            markers.append(_text(namespace, spot, obstacle.id))
    return _array(tick, markers)


def point(place: Place) -> Message:
    """Return a place as a point or vector."""
    return dict(zip("xyz", place, strict=True))


def _array(tick: int, markers: Iterable[Message]) -> Message:
    """Return an array of markers with the header of a tick, numbered within their namespaces."""
    numbers: dict[str, Iterator[int]] = defaultdict(count)
    header = stamped(tick)
    return {
        "markers": [
            {"header": header, "id": next(numbers[marker.get("ns", "")]), **marker}
            for marker in markers
        ]
    }


def _shape(namespace: str, spot: Place, radius: float, offsets: Offsets, colour: Colour) -> Message:
    """Return a disc, or the edges of a polygon."""
    if not offsets:
        return _marker(namespace, _CYLINDER, spot, (2.0 * radius, 2.0 * radius, 0.1), colour)
    edge = [point((dx, dy, 0.0)) for dx, dy in (*offsets, offsets[0])]
    return {**_marker(namespace, _LINE_STRIP, spot, (_THIN,) * 3, colour), "points": edge}


def _text(namespace: str, spot: Place, text: str) -> Message:
    return {**_marker(f"{namespace}: names", _TEXT, spot, (0.0, 0.0, 2.0), _INK), "text": text}


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
