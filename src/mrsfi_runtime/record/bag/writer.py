"""Writes a flight as a bag that viewers of ROS 2 open: topics of the bus, events, map and robots.

docs/bags.md says what is on which topic. The same flight gives the same bytes.

References
----------
https://mcap.dev/spec/registry, schema encoding ``ros2msg``.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import IO, TypeAlias

from mcap.records import Schema
from mcap_ros2.writer import Writer
from rosbags.typesys import Stores, get_typestore

from mrsfi_runtime.cosimulation.lockstep_topics import CLOCK
from mrsfi_runtime.cosimulation.team_topics import RobotTopics, SensorTopics
from mrsfi_runtime.cosimulation.truth import true_values
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.motion import reports_position
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.names import plain_name
from mrsfi_runtime.record.bag.markers import (
    Message,
    RobotMarkers,
    map_markers,
    point,
    stamped,
)
from mrsfi_runtime.record.events import Event, Events, Kind
from mrsfi_runtime.record.named_faults import NamedFault
from mrsfi_runtime.transport.topics import Topic

Said: TypeAlias = tuple[Topic, Message]
"""A message, and the topic that it is on."""

LOG = Topic("/rosout", "rcl_interfaces/Log")
TRANSFORMS = Topic("/tf", "tf2_msgs/TFMessage")
MAP = Topic("/mission_map", "visualization_msgs/MarkerArray")
ROBOTS = Topic("/markers", "visualization_msgs/MarkerArray")

_LEVELS: Mapping[Kind, int] = MappingProxyType(
    {Kind.COMMAND: 10, Kind.FAULT: 30, Kind.COLLISION: 40, Kind.VERDICT: 40}
)
"""Severities of ``rcl_interfaces/Log``: DEBUG, WARN and ERROR."""

_SECOND = 1_000_000_000  # nanoseconds


class Bag:
    """Observer that writes a flight into an MCAP file of profile ``ros2``; tick k is k seconds.

    The caller closes the stream, a binary file, after ``finish``.
    """

    def __init__(
        self, mission: Mission, stream: IO[bytes], faults: Sequence[NamedFault], events: Events
    ) -> None:
        self._mission = mission
        self._events = events
        self._markers = RobotMarkers(mission, faults)
        robots = [plain_name(robot.id) for robot in mission.robots]
        self._frames = [(name, f"believed/{name}") for name in robots]
        self._robots = [RobotTopics(name) for name in robots]
        self._sensors = [
            SensorTopics(robots[robot], plain_name(sensor.id))
            for robot, sensor in zip(mission.sensor_robot, mission.sensors, strict=True)
        ]
        self._goals = [f"/goals/{plain_name(goal)}" for goal in mission.goal_ids]
        self._known: dict[str, Message] = {}
        self._writer = Writer(stream)
        self._types = get_typestore(Stores.ROS2_HUMBLE)
        self._schema = cache(self._registered)

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Write one tick."""
        tick = world.mission.tick
        time = {"sec": tick, "nanosec": 0}
        self._write(tick, (CLOCK, {"clock": time}))
        if tick == 0:
            self._write(
                tick, (MAP, map_markers(self._mission, [frame for frame, _ in self._frames]))
            )
        for said in (*self._reported(world), *self._believed(belief)):
            self._write(tick, said)
        for topic, message in (
            *self._switched(world),
            *map(_of_belief, self._switched(belief)),
            *self._judged(verdicts),
            *self._commands(world),
        ):
            if self._known.get(topic.name) != message:
                self._known[topic.name] = message
                self._write(tick, (topic, message))
        for event in self._events.at(world, verdicts):
            self._write(tick, (LOG, _logged(time, event)))
        self._write(tick, (TRANSFORMS, self._transforms(world, belief)))
        self._write(tick, (ROBOTS, self._markers.at(world, belief)))

    def finish(self) -> None:
        """Write what belongs to the end of the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _write(self, tick: int, said: Said) -> None:
        topic, message = said
        schema = self._schema(topic.type)
        self._writer.write_message(topic.name, schema, message, tick * _SECOND)

    def _registered(self, name: str) -> Schema:
        full = name.replace("/", "/msg/")
        return self._writer.register_msgdef(full, self._types.generate_msgdef(full, 2)[0])

    def _reported(self, world: State) -> Iterator[Said]:
        """Yield what the simulation says on the bus."""
        for index, topics in enumerate(self._robots):
            if reports_position(world, index):
                yield _position(topics, world, index)
            yield topics.truth, {"data": true_values(world, index)}
        yield from self._numbers(world)

    def _believed(self, belief: State) -> Iterator[Said]:
        """Yield the same as the collective intelligence believes it."""
        for index, topics in enumerate(self._robots):
            yield _of_belief(_position(topics, belief, index))
        for said in self._numbers(belief):
            yield _of_belief(said)

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
        header = stamped(world.mission.tick)
        return {
            "transforms": [
                {
                    "header": header,
                    "child_frame_id": frame,
                    "transform": {
                        "translation": point((robot.x, robot.y, robot.z)),
                        "rotation": {"w": 1.0},
                    },
                }
                for true, believed, frames in zip(
                    world.robots, belief.robots, self._frames, strict=True
                )
                for robot, frame in zip((true, believed), frames, strict=True)
            ]
        }


def _position(topics: RobotTopics, state: State, index: int) -> Said:
    robot = state.robots[index]
    return topics.position, point((robot.x, robot.y, robot.z))


def _of_belief(said: Said) -> Said:
    topic, message = said
    return Topic(f"/belief{topic.name}", topic.type), message


def _logged(time: Message, event: Event) -> Message:
    return {
        "stamp": time,
        "level": _LEVELS[event.kind],
        "name": event.kind.value,
        "msg": str(event),
    }
