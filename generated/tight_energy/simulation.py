# Generated from mission tight_energy by simulation.py.j2.
# Edit inside protected regions only.
"""The simulation: moves the true state of the mission and publishes it."""

from mrsfi_runtime.api import (
    Mission,
    Payload,
    State,
    Topic,
    Transport,
    advance,
    initial_state,
    reports_position,
    true_values,
)

TOPICS = (
    Topic("/e1/position", "geometry_msgs/Point"),
    Topic("/e1/speed", "std_msgs/Float64"),
    Topic("/e1/energy", "std_msgs/Float64"),
    Topic("/e1/e1_gps_position/samples", "std_msgs/Int64"),
    Topic("/e1/e1_gps_position/active", "std_msgs/Bool"),
    Topic("/e1/e1_temperature/samples", "std_msgs/Int64"),
    Topic("/e1/e1_temperature/active", "std_msgs/Bool"),
    Topic("/e2/position", "geometry_msgs/Point"),
    Topic("/e2/speed", "std_msgs/Float64"),
    Topic("/e2/energy", "std_msgs/Float64"),
    Topic("/e2/e2_gps_position/samples", "std_msgs/Int64"),
    Topic("/e2/e2_gps_position/active", "std_msgs/Bool"),
    Topic("/e2/e2_depth/samples", "std_msgs/Int64"),
    Topic("/e2/e2_depth/active", "std_msgs/Bool"),
    Topic("/e3/position", "geometry_msgs/Point"),
    Topic("/e3/speed", "std_msgs/Float64"),
    Topic("/e3/energy", "std_msgs/Float64"),
    Topic("/e3/e3_gps_position/samples", "std_msgs/Int64"),
    Topic("/e3/e3_gps_position/active", "std_msgs/Bool"),
    Topic("/e3/e3_pressure/samples", "std_msgs/Int64"),
    Topic("/e3/e3_pressure/active", "std_msgs/Bool"),
)

TRUTH = (
    Topic("/truth/e1", "std_msgs/Float64MultiArray"),
    Topic("/truth/e2", "std_msgs/Float64MultiArray"),
    Topic("/truth/e3", "std_msgs/Float64MultiArray"),
)

COMMANDS = (
    Topic("/e1/command/heading", "geometry_msgs/Vector3"),
    Topic("/e1/command/speed", "std_msgs/Float64"),
    Topic("/e1/e1_gps_position/command/active", "std_msgs/Bool"),
    Topic("/e1/e1_temperature/command/active", "std_msgs/Bool"),
    Topic("/e2/command/heading", "geometry_msgs/Vector3"),
    Topic("/e2/command/speed", "std_msgs/Float64"),
    Topic("/e2/e2_gps_position/command/active", "std_msgs/Bool"),
    Topic("/e2/e2_depth/command/active", "std_msgs/Bool"),
    Topic("/e3/command/heading", "geometry_msgs/Vector3"),
    Topic("/e3/command/speed", "std_msgs/Float64"),
    Topic("/e3/e3_gps_position/command/active", "std_msgs/Bool"),
    Topic("/e3/e3_pressure/command/active", "std_msgs/Bool"),
)

E1 = 0
E2 = 1
E3 = 2

E1_GPS_POSITION = 0
E1_TEMPERATURE = 1
E2_GPS_POSITION = 2
E2_DEPTH = 3
E3_GPS_POSITION = 4
E3_PRESSURE = 5


class Simulation:
    """The mission's side of the bus: publishes every topic and obeys every command."""

    world: State

    def __init__(self, transport: Transport, mission: Mission) -> None:
        self.mission = mission
        self.world = initial_state(mission, 0)
        self.is_running = False
        self.told_active = [-1] * len(self.world.sensors)
        self.publishers = {topic.name: transport.advertise(topic) for topic in (*TOPICS, *TRUTH)}
        callbacks = (
            self.on_e1_heading,
            self.on_e1_speed,
            self.on_e1_gps_position_active,
            self.on_e1_temperature_active,
            self.on_e2_heading,
            self.on_e2_speed,
            self.on_e2_gps_position_active,
            self.on_e2_depth_active,
            self.on_e3_heading,
            self.on_e3_speed,
            self.on_e3_gps_position_active,
            self.on_e3_pressure_active,
        )
        for topic, callback in zip(COMMANDS, callbacks, strict=True):
            transport.subscribe(topic, callback)

    def reset(self, seed: int) -> None:
        """Go back to before the first tick."""
        self.world = initial_state(self.mission, seed)
        self.told_active = [-1] * len(self.world.sensors)
        self.is_running = True

    def step(self, tick: int) -> None:
        """Fly one tick and publish the result."""
        self.world.mission.tick = tick
        advance(self.world)
        self.publish()

    def stop(self) -> None:
        """End the run."""
        self.is_running = False

    def publish(self) -> None:
        """Publish the state of every robot and sensor."""
        self.publish_e1()
        self.publish_e1_gps_position()
        self.publish_e1_temperature()
        self.publish_e2()
        self.publish_e2_gps_position()
        self.publish_e2_depth()
        self.publish_e3()
        self.publish_e3_gps_position()
        self.publish_e3_pressure()

    def publish_truth(self) -> None:
        """Publish what is true of every robot and its sensors, for the judge alone."""
        truth = {"data": true_values(self.world, E1)}
        self.publishers["/truth/e1"](truth)
        truth = {"data": true_values(self.world, E2)}
        self.publishers["/truth/e2"](truth)
        truth = {"data": true_values(self.world, E3)}
        self.publishers["/truth/e3"](truth)

    def publish_e1(self) -> None:
        """Publish robot e1; its position only while it knows it."""
        robot = self.world.robots[E1]
        if reports_position(self.world, E1):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/e1/position"](position)
        self.publishers["/e1/speed"]({"data": robot.speed})
        self.publishers["/e1/energy"]({"data": robot.energy})

    def on_e1_heading(self, payload: Payload) -> None:
        """Turn robot e1."""
        command = self.world.commands[E1]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_e1_speed(self, payload: Payload) -> None:
        """Set the speed of robot e1."""
        self.world.commands[E1].speed = float(payload["data"])

    def publish_e1_gps_position(self) -> None:
        """Publish sensor e1_gps_position; whether it is active only when that changed."""
        sensor = self.world.sensors[E1_GPS_POSITION]
        self.publishers["/e1/e1_gps_position/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E1_GPS_POSITION]:
            self.told_active[E1_GPS_POSITION] = sensor.active
            self.publishers["/e1/e1_gps_position/active"]({"data": sensor.active == 1})

    def on_e1_gps_position_active(self, payload: Payload) -> None:
        """Switch sensor e1_gps_position on or off."""
        self.world.switches[E1_GPS_POSITION].active = int(payload["data"])

    def publish_e1_temperature(self) -> None:
        """Publish sensor e1_temperature; whether it is active only when that changed."""
        sensor = self.world.sensors[E1_TEMPERATURE]
        self.publishers["/e1/e1_temperature/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E1_TEMPERATURE]:
            self.told_active[E1_TEMPERATURE] = sensor.active
            self.publishers["/e1/e1_temperature/active"]({"data": sensor.active == 1})

    def on_e1_temperature_active(self, payload: Payload) -> None:
        """Switch sensor e1_temperature on or off."""
        self.world.switches[E1_TEMPERATURE].active = int(payload["data"])

    def publish_e2(self) -> None:
        """Publish robot e2; its position only while it knows it."""
        robot = self.world.robots[E2]
        if reports_position(self.world, E2):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/e2/position"](position)
        self.publishers["/e2/speed"]({"data": robot.speed})
        self.publishers["/e2/energy"]({"data": robot.energy})

    def on_e2_heading(self, payload: Payload) -> None:
        """Turn robot e2."""
        command = self.world.commands[E2]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_e2_speed(self, payload: Payload) -> None:
        """Set the speed of robot e2."""
        self.world.commands[E2].speed = float(payload["data"])

    def publish_e2_gps_position(self) -> None:
        """Publish sensor e2_gps_position; whether it is active only when that changed."""
        sensor = self.world.sensors[E2_GPS_POSITION]
        self.publishers["/e2/e2_gps_position/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E2_GPS_POSITION]:
            self.told_active[E2_GPS_POSITION] = sensor.active
            self.publishers["/e2/e2_gps_position/active"]({"data": sensor.active == 1})

    def on_e2_gps_position_active(self, payload: Payload) -> None:
        """Switch sensor e2_gps_position on or off."""
        self.world.switches[E2_GPS_POSITION].active = int(payload["data"])

    def publish_e2_depth(self) -> None:
        """Publish sensor e2_depth; whether it is active only when that changed."""
        sensor = self.world.sensors[E2_DEPTH]
        self.publishers["/e2/e2_depth/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E2_DEPTH]:
            self.told_active[E2_DEPTH] = sensor.active
            self.publishers["/e2/e2_depth/active"]({"data": sensor.active == 1})

    def on_e2_depth_active(self, payload: Payload) -> None:
        """Switch sensor e2_depth on or off."""
        self.world.switches[E2_DEPTH].active = int(payload["data"])

    def publish_e3(self) -> None:
        """Publish robot e3; its position only while it knows it."""
        robot = self.world.robots[E3]
        if reports_position(self.world, E3):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/e3/position"](position)
        self.publishers["/e3/speed"]({"data": robot.speed})
        self.publishers["/e3/energy"]({"data": robot.energy})

    def on_e3_heading(self, payload: Payload) -> None:
        """Turn robot e3."""
        command = self.world.commands[E3]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_e3_speed(self, payload: Payload) -> None:
        """Set the speed of robot e3."""
        self.world.commands[E3].speed = float(payload["data"])

    def publish_e3_gps_position(self) -> None:
        """Publish sensor e3_gps_position; whether it is active only when that changed."""
        sensor = self.world.sensors[E3_GPS_POSITION]
        self.publishers["/e3/e3_gps_position/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E3_GPS_POSITION]:
            self.told_active[E3_GPS_POSITION] = sensor.active
            self.publishers["/e3/e3_gps_position/active"]({"data": sensor.active == 1})

    def on_e3_gps_position_active(self, payload: Payload) -> None:
        """Switch sensor e3_gps_position on or off."""
        self.world.switches[E3_GPS_POSITION].active = int(payload["data"])

    def publish_e3_pressure(self) -> None:
        """Publish sensor e3_pressure; whether it is active only when that changed."""
        sensor = self.world.sensors[E3_PRESSURE]
        self.publishers["/e3/e3_pressure/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[E3_PRESSURE]:
            self.told_active[E3_PRESSURE] = sensor.active
            self.publishers["/e3/e3_pressure/active"]({"data": sensor.active == 1})

    def on_e3_pressure_active(self, payload: Payload) -> None:
        """Switch sensor e3_pressure on or off."""
        self.world.switches[E3_PRESSURE].active = int(payload["data"])
