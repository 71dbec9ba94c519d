"""The two sides of a mission on plain objects, and their lock-step.

The simulation moves the true state and publishes it. The collective intelligence (CI) turns the
messages into belief and answers with commands. Generated code puts both sides together from the
parts here, one for each robot and sensor. Their topics have the same names in all missions.

Invariants: a message counts only in the tick in which it arrived, so an earlier message never
replaces a missing one. The CI never receives the true state, which has separate topics for the
judge. An effect of a user-defined fault changes only the properties that its type names; any other
change is an error (``guarded``).

Begin with ``Flight.step``. Before it are the topics and the CI's side, after it the answers
(``Mind``) and the simulation's side. docs/bus.md lists the content of the topics.

References
----------
Source paper, sections III-F and III-G, and Figure 4.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from functools import cached_property
from typing import Any, Protocol, TypeAlias

from mrsfi_runtime.errors import EvaluationError, MrsfiError, ProtocolError
from mrsfi_runtime.kernel import commands
from mrsfi_runtime.kernel.commands import reported_place, reports_position
from mrsfi_runtime.kernel.effects import Orders, issue
from mrsfi_runtime.kernel.flight import (
    MissionFunctions,
    Samples,
    Verdicts,
    hear,
    no_verdicts,
    reply,
    valid_samples,
)
from mrsfi_runtime.kernel.flight import initial_state as first_state
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.injections import OwnEffect, OwnFault, Plan
from mrsfi_runtime.kernel.state import (
    COLUMNS,
    PROPERTIES,
    RobotState,
    SensorState,
    State,
    excess,
)
from mrsfi_runtime.model.fault_types import FaultType
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.transport.topics import Payload, PubSub, Topic


class Heard:
    """The message of a topic in this tick, if there is one."""

    def __init__(self, transport: PubSub, topic: Topic) -> None:
        self.name = topic.name
        self._payload: Payload | None = None
        transport.subscribe(topic, self._receive)

    @property
    def is_new(self) -> bool:
        """Return whether there is a message that was not taken."""
        return self._payload is not None

    def forget(self) -> None:
        """Drop the message, if there is one."""
        self._payload = None

    def take(self) -> Payload:
        """Return the message of this tick, once; without one, raise ``ProtocolError``."""
        payload, self._payload = self._payload, None
        if payload is None:
            raise self.missing()
        return payload

    def missing(self) -> ProtocolError:
        """Return the error of a tick without a due message."""
        return ProtocolError(
            f"no message on {self.name}; the simulation must send one in this tick (docs/bus.md)"
        )

    def _receive(self, payload: Payload) -> None:
        self._payload = payload


class RobotTopics:
    """Topics of a robot, by its identifier: reports, true values, commands."""

    def __init__(self, robot: str) -> None:
        self.position = Topic(f"/{robot}/position", "geometry_msgs/Point")
        self.speed = Topic(f"/{robot}/speed", "std_msgs/Float64")
        self.energy = Topic(f"/{robot}/energy", "std_msgs/Float64")
        self.truth = Topic(f"/truth/{robot}", "std_msgs/Float64MultiArray")
        self.heading_command = Topic(f"/{robot}/command/heading", "geometry_msgs/Vector3")
        self.speed_command = Topic(f"/{robot}/command/speed", "std_msgs/Float64")


class SensorTopics:
    """Topics of a sensor, by two identifiers: reports of the simulation, and its switch."""

    def __init__(self, robot: str, sensor: str) -> None:
        self.samples = Topic(f"/{robot}/{sensor}/samples", "std_msgs/Int64")
        self.active = Topic(f"/{robot}/{sensor}/active", "std_msgs/Bool")
        self.active_command = Topic(f"/{robot}/{sensor}/command/active", "std_msgs/Bool")


class RobotInterface:
    """Receives the simulation's messages about a robot, and commands it."""

    def __init__(self, transport: PubSub, topics: RobotTopics) -> None:
        self._position = Heard(transport, topics.position)
        self._speed = Heard(transport, topics.speed)
        self._energy = Heard(transport, topics.energy)
        self._turn = transport.advertise(topics.heading_command)
        self._drive = transport.advertise(topics.speed_command)

    def reset(self) -> None:
        """Forget what was received."""
        for heard in (self._position, self._speed, self._energy):
            heard.forget()

    def read(self, robot: RobotState) -> None:
        """Copy the messages of this tick; a position that was not sent stays as it was."""
        if self._position.is_new:
            position = self._position.take()
            robot.x, robot.y, robot.z = (float(position[axis]) for axis in "xyz")
        robot.speed = float(self._speed.take()["data"])
        robot.energy = float(self._energy.take()["data"])

    def require_position(self, *, is_due: bool) -> None:
        """Raise ``ProtocolError`` unless a position arrived if and only if it is due."""
        if self._position.is_new and not is_due:
            raise ProtocolError(
                f"a message arrived on {self._position.name} while the robot's GPS_POSITION sensor "
                "is off; expected none (docs/bus.md)"
            )
        if is_due and not self._position.is_new:
            raise self._position.missing()

    def set_heading(self, x: float, y: float) -> None:
        """Turn the robot to a unit heading."""
        self._turn({"x": x, "y": y, "z": 0.0})

    def set_speed(self, speed: float) -> None:
        """Set its speed."""
        self._drive({"data": speed})


class SensorInterface:
    """Receives the simulation's messages about a sensor, and switches it."""

    def __init__(self, transport: PubSub, topics: SensorTopics) -> None:
        self._samples = Heard(transport, topics.samples)
        self._active = Heard(transport, topics.active)
        self._was_active: bool | None = None
        self._switch = transport.advertise(topics.active_command)

    def reset(self) -> None:
        """Forget what was received."""
        self._samples.forget()
        self._active.forget()
        self._was_active = None

    def read(self, sensor: SensorState) -> None:
        """Copy the messages of this tick; ``active`` keeps its last value."""
        count = int(self._samples.take()["data"])
        if count < sensor.count:
            raise ProtocolError(
                f"{self._samples.name} carried {count} after {sensor.count}; expected no decrease"
            )
        sensor.count = count
        sensor.active = int(self._last_active())

    def require_active(self, is_active: int) -> None:
        """Raise ``ProtocolError`` if the last message on ``active`` is not true now."""
        if self._last_active() != is_active:
            raise ProtocolError(
                f"the last message on {self._active.name} was {self._was_active}, but the true "
                f"state is {bool(is_active)}; the simulation must publish every change "
                "(docs/bus.md)"
            )

    def set_active(self, active: bool) -> None:
        """Switch the sensor on or off."""
        self._switch({"data": active})

    def _last_active(self) -> bool:
        if self._active.is_new or self._was_active is None:
            self._was_active = bool(self._active.take()["data"])
        return self._was_active


class Simulation(Protocol):
    """A generated simulation: moves the true state and publishes it."""

    world: State

    def __init__(self, transport: PubSub, mission: Mission) -> None: ...

    def reset(self, seed: int) -> None:
        """Go back to before the first tick."""

    def step(self, tick: int) -> None:
        """Fly one tick and publish the result."""

    def publish_truth(self) -> None:
        """Publish the true state, for the judge alone."""


class SimInterface(Protocol):
    """A generated simulation interface: getters and setters of the robots and sensors."""

    @property
    def robots(self) -> tuple[RobotInterface, ...]:
        """The interface of each robot."""

    @property
    def sensors(self) -> tuple[SensorInterface, ...]:
        """The interface of each sensor."""

    def __init__(self, transport: PubSub) -> None: ...

    def reset(self) -> None:
        """Forget what was received."""

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""


Observer: TypeAlias = Callable[[State, State, Verdicts], None]
"""Called at the end of every tick with the true state, the belief, and the verdicts until now."""


class Flight:
    """One run: the collective intelligence takes its steps, and every tick is judged.

    ``world`` is the true state, moved by the caller, with the last commands sent to the simulation;
    until the run begins, it is also the belief. ``plan`` are the faults, ``verdicts`` the counts so
    far, once per goal and tick. ``observer`` is called every tick. It must not change its
    arguments; the next tick changes them.
    """

    def __init__(
        self,
        functions: MissionFunctions,
        mission: Mission,
        seed: int,
        interface: SimInterface,
        plan: Plan,
        observer: Observer | None = None,
    ) -> None:
        self.world = self.belief = first_state(mission, seed)
        self.verdicts = no_verdicts(len(mission.goals))
        self._functions = functions
        self.plan = plan
        self._interface = interface
        self._inbox = first_state(mission, seed)
        self._orders = Orders(
            [replace(command) for command in self.belief.commands],
            [replace(switch) for switch in self.belief.switches],
        )
        self._observer = observer

    def begin(self, world: State, *, sends_all: bool = False) -> None:
        """Send the commands that act from the first motion on.

        These are only the forged ones, or all for a simulation that may lack the initial headings.
        """
        self.world = world
        self._interface.reset()
        issue(self.belief, self._orders, self.plan, 0)
        self._send(sends_all=sends_all)

    def step(self, tick: int) -> None:
        """Judge a tick that the simulation has flown, and let the CI answer it."""
        self.hear(tick)
        self.react()
        self.reply(tick)

    def hear(self, tick: int) -> None:
        """Judge a tick that the simulation has flown, and turn its messages into belief."""
        self._interface.read(self._inbox)
        hear(self._functions, self.world, self.belief, self._inbox, self.plan, self.verdicts, tick)

    def react(self) -> None:
        """Let the generated goals command their members."""
        self._functions.react(self.belief)

    def reply(self, tick: int) -> None:
        """Send the commands of a tick, and count the violations in it."""
        reply(self.world, self.belief, self._orders, self.plan, self.verdicts, tick)
        self._send()
        if self._observer is not None:
            self._observer(self.world, self.belief, self.verdicts)

    def _send(self, *, sends_all: bool = False) -> None:
        """Send the commands that changed, or all."""
        orders, sent, interface = self._orders, self.world, self._interface
        for index, order in enumerate(orders.commands):
            last = sent.commands[index]
            is_turned = order.heading_x != last.heading_x or order.heading_y != last.heading_y
            if sends_all or is_turned:
                last.heading_x, last.heading_y = order.heading_x, order.heading_y
                interface.robots[index].set_heading(order.heading_x, order.heading_y)
            if sends_all or order.speed != last.speed:
                last.speed = order.speed
                interface.robots[index].set_speed(order.speed)
        for index, switch in enumerate(orders.switches):
            if sends_all or switch.active != sent.switches[index].active:
                sent.switches[index].active = switch.active
                interface.sensors[index].set_active(switch.active == 1)


class Mind:
    """Writes commands into the belief of a flight in each tick: the generated reactions.

    A region may take any time.
    """

    def begin(self, flight: Flight, run: int, seed: int) -> None:
        """Get ready for a flight."""

    def soon(self, function: Callable[[], None]) -> None:
        """Call a function in the thread in which answers come."""
        function()

    def answer(self, flight: Flight, tick: int, then: Callable[[], None]) -> bool:  # noqa: ARG002
        """Answer a tick; return whether that is done, or else call a function then."""
        flight.react()
        return True

    def overdue(self, silence: float) -> MrsfiError | None:  # noqa: ARG002
        """Return the error, if any, after so many seconds without an answer."""
        return None

    def end(self) -> None:
        """Finish a flight."""


def true_values(world: State, index: int) -> list[float]:
    """Return the true values of a robot and its sensors.

    These are ``[x, y, z, speed, energy]``, then ``count, active`` of each of its sensors.
    """
    robot = world.robots[index]
    values = [robot.x, robot.y, robot.z, robot.speed, robot.energy]
    for sensor in world.sensors[robot.first_sensor : robot.first_sensor + robot.n_sensors]:
        values += (float(sensor.count), float(sensor.active))
    return values


def take_true_values(world: State, index: int, topic: Heard) -> None:
    """Copy a message of ``true_values`` about a robot into a state."""
    robot, wake = world.robots[index], world.wakes[index]
    values = topic.take()["data"]
    expected = 5 + 2 * robot.n_sensors
    if len(values) != expected:
        raise ProtocolError(
            f"{topic.name} carried {values!r}; expected {expected} numbers: "
            "x, y, z, speed, energy, then count and active of each of its sensors"
        )
    wake.x, wake.y, wake.reach = robot.x, robot.y, math.inf
    robot.x, robot.y, robot.z, robot.speed, robot.energy = map(float, values[:5])
    step = distance(wake.x, wake.y, robot.x, robot.y)
    if excess(step, robot.max_speed) > 0.0:  # which only an external simulation does
        world.longest = tuple(max(each, step) for each in world.longest)
    for offset in range(robot.n_sensors):
        sensor = world.sensors[robot.first_sensor + offset]
        count, active = values[5 + 2 * offset : 7 + 2 * offset]
        if active not in {0, 1} or not sensor.count <= count < 2**63 or count % 1:
            raise ProtocolError(
                f"{topic.name} carried count {count} and active {active} of its sensor "
                f"{offset + 1} after count {sensor.count}; expected a whole number, no decrease, "
                "and 0 or 1"
            )
        sensor.count, sensor.active = int(count), int(active)


class SimulatedRobot:
    """Publishes a robot of the true state, by its index, and applies commands to it."""

    def __init__(self, transport: PubSub, topics: RobotTopics, world: State, index: int) -> None:
        self._index = index
        self.reset(world)
        self._publish_position = transport.advertise(topics.position)
        self._publish_speed = transport.advertise(topics.speed)
        self._publish_energy = transport.advertise(topics.energy)
        self._publish_truth = transport.advertise(topics.truth)
        transport.subscribe(topics.heading_command, self._on_heading)
        transport.subscribe(topics.speed_command, self._on_speed)

    def reset(self, world: State) -> None:
        """Begin a run with another true state."""
        self._world = world
        self._robot = world.robots[self._index]
        self._command = world.commands[self._index]

    def publish(self) -> None:
        """Publish the robot; its position only while its GPS_POSITION sensor, if any, is on."""
        robot = self._robot
        if reports_position(self._world, self._index):
            x, y = reported_place(self._world, self._index)
            self._publish_position({"x": x, "y": y, "z": robot.z})
        self._publish_speed({"data": robot.speed})
        self._publish_energy({"data": robot.energy})

    def publish_truth(self) -> None:
        """Publish the true values of the robot and its sensors, only for the judge."""
        self._publish_truth({"data": true_values(self._world, self._index)})

    def _on_heading(self, payload: Payload) -> None:
        self._command.heading_x = float(payload["x"])
        self._command.heading_y = float(payload["y"])

    def _on_speed(self, payload: Payload) -> None:
        self._command.speed = float(payload["data"])


class SimulatedSensor:
    """Publishes a sensor of the true state, by its index, and applies switch commands to it."""

    def __init__(self, transport: PubSub, topics: SensorTopics, world: State, index: int) -> None:
        self._index = index
        self.reset(world)
        self._publish_samples = transport.advertise(topics.samples)
        self._publish_active = transport.advertise(topics.active)
        transport.subscribe(topics.active_command, self._on_active)

    def reset(self, world: State) -> None:
        """Begin a run with another true state."""
        self._sensor = world.sensors[self._index]
        self._switch = world.switches[self._index]
        self._published_active = -1

    def publish(self) -> None:
        """Publish the sensor; ``active`` only on change."""
        sensor = self._sensor
        self._publish_samples({"data": sensor.count})
        if sensor.active != self._published_active:
            self._published_active = sensor.active
            self._publish_active({"data": sensor.active == 1})

    def _on_active(self, payload: Payload) -> None:
        self._switch.active = int(payload["data"])


class World(State):
    """A true state."""

    @cached_property
    def samples(self) -> Samples:
        """The valid samples of each sensor, by tick; they are drawn for the first motion."""
        return valid_samples(self)


def initial_state(mission: Mission, seed: int) -> World:
    """Return the true state before the first tick, as ``kernel.flight.initial_state``."""
    state = first_state(mission, seed)
    return World(**{name: getattr(state, name) for name in State.__slots__})


def move(world: World, tick: int) -> None:
    """Fly a tick, as ``kernel.commands.move``."""
    commands.move(world, world.samples[tick], tick)


def allowed_columns(kind: FaultType) -> tuple[str, list[str]]:
    """Return the list of a state that a fault may change, and the columns of its target in it."""
    places = [PROPERTIES[affected] for affected in kind.properties]
    return places[0][0], [column for _, columns in places for column in columns]


def guarded(apply: OwnEffect, kinds: Mapping[int, FaultType]) -> OwnEffect:
    """Return an effect that raises an error if it changes a property that its type does not name.

    ``kinds`` are the fault types by the number of their effect.
    """

    def apply_guarded(ci: State, inbox: State, fault: OwnFault) -> None:
        kind = kinds[fault.effect]
        listed, columns = allowed_columns(kind)
        allowed = {(f"ci.{listed}", fault.target, column) for column in columns}
        before = _snapshot(ci, inbox, fault)
        apply(ci, inbox, fault)
        for place, value in _snapshot(ci, inbox, fault).items():
            if value != before[place] and place not in allowed:
                records, index, column = place
                named = " and ".join(affected.name for affected in kind.properties)
                raise EvaluationError(
                    f"region '{kind.name}.apply' of fault_effects.py changed {column} of "
                    f"{records}[{index}] from {before[place]} to {value}; expected it to change "
                    f"only {named} of its target, as declared in faults.ecore; correct one of them"
                )

    return apply_guarded


def _snapshot(ci: State, inbox: State, fault: OwnFault) -> Mapping[tuple[str, int, str], Any]:
    """Return all values of two states that a flight changes, and a fault without its memory.

    A key is a list such as ``ci.robots``, the index of a record in it, and a column.
    """
    records: dict[str, Sequence[Any]] = {"fault": [fault]}
    for side, state in (("ci", ci), ("inbox", inbox)):
        records |= {f"{side}.mission": [state.mission], f"{side}.map": [state.map]}
        records |= {f"{side}.{name}": getattr(state, name) for name in COLUMNS}
    snapshot = {}
    for name, listed in records.items():
        for index, record in enumerate(listed):
            for column in fields(record):
                value = getattr(record, column.name)
                is_number = isinstance(value, int | float)
                snapshot[name, index, column.name] = value if is_number else tuple(value)
    del snapshot["fault", 0, "memory"]
    return snapshot
