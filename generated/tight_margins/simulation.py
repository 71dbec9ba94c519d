# Generated from mission tight_margins by simulation.py.j2.
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
    Topic("/p1/position", "geometry_msgs/Point"),
    Topic("/p1/speed", "std_msgs/Float64"),
    Topic("/p1/energy", "std_msgs/Float64"),
    Topic("/p1/p1_gps/samples", "std_msgs/Int64"),
    Topic("/p1/p1_gps/active", "std_msgs/Bool"),
    Topic("/p1/p1_depth/samples", "std_msgs/Int64"),
    Topic("/p1/p1_depth/active", "std_msgs/Bool"),
    Topic("/p2/position", "geometry_msgs/Point"),
    Topic("/p2/speed", "std_msgs/Float64"),
    Topic("/p2/energy", "std_msgs/Float64"),
    Topic("/p2/p2_gps/samples", "std_msgs/Int64"),
    Topic("/p2/p2_gps/active", "std_msgs/Bool"),
    Topic("/p2/p2_pressure/samples", "std_msgs/Int64"),
    Topic("/p2/p2_pressure/active", "std_msgs/Bool"),
    Topic("/p3/position", "geometry_msgs/Point"),
    Topic("/p3/speed", "std_msgs/Float64"),
    Topic("/p3/energy", "std_msgs/Float64"),
    Topic("/p3/p3_gps/samples", "std_msgs/Int64"),
    Topic("/p3/p3_gps/active", "std_msgs/Bool"),
    Topic("/p3/p3_temperature/samples", "std_msgs/Int64"),
    Topic("/p3/p3_temperature/active", "std_msgs/Bool"),
)

TRUTH = (
    Topic("/truth/p1", "std_msgs/Float64MultiArray"),
    Topic("/truth/p2", "std_msgs/Float64MultiArray"),
    Topic("/truth/p3", "std_msgs/Float64MultiArray"),
)

COMMANDS = (
    Topic("/p1/command/heading", "geometry_msgs/Vector3"),
    Topic("/p1/command/speed", "std_msgs/Float64"),
    Topic("/p1/p1_gps/command/active", "std_msgs/Bool"),
    Topic("/p1/p1_depth/command/active", "std_msgs/Bool"),
    Topic("/p2/command/heading", "geometry_msgs/Vector3"),
    Topic("/p2/command/speed", "std_msgs/Float64"),
    Topic("/p2/p2_gps/command/active", "std_msgs/Bool"),
    Topic("/p2/p2_pressure/command/active", "std_msgs/Bool"),
    Topic("/p3/command/heading", "geometry_msgs/Vector3"),
    Topic("/p3/command/speed", "std_msgs/Float64"),
    Topic("/p3/p3_gps/command/active", "std_msgs/Bool"),
    Topic("/p3/p3_temperature/command/active", "std_msgs/Bool"),
)

P1 = 0
P2 = 1
P3 = 2

P1_GPS = 0
P1_DEPTH = 1
P2_GPS = 2
P2_PRESSURE = 3
P3_GPS = 4
P3_TEMPERATURE = 5


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
            self.on_p1_heading,
            self.on_p1_speed,
            self.on_p1_gps_active,
            self.on_p1_depth_active,
            self.on_p2_heading,
            self.on_p2_speed,
            self.on_p2_gps_active,
            self.on_p2_pressure_active,
            self.on_p3_heading,
            self.on_p3_speed,
            self.on_p3_gps_active,
            self.on_p3_temperature_active,
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
        self.publish_p1()
        self.publish_p1_gps()
        self.publish_p1_depth()
        self.publish_p2()
        self.publish_p2_gps()
        self.publish_p2_pressure()
        self.publish_p3()
        self.publish_p3_gps()
        self.publish_p3_temperature()

    def publish_truth(self) -> None:
        """Publish what is true of every robot and its sensors, for the judge alone."""
        truth = {"data": true_values(self.world, P1)}
        self.publishers["/truth/p1"](truth)
        truth = {"data": true_values(self.world, P2)}
        self.publishers["/truth/p2"](truth)
        truth = {"data": true_values(self.world, P3)}
        self.publishers["/truth/p3"](truth)

    def publish_p1(self) -> None:
        """Publish robot p1; its position only while it knows it."""
        robot = self.world.robots[P1]
        if reports_position(self.world, P1):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/p1/position"](position)
        self.publishers["/p1/speed"]({"data": robot.speed})
        self.publishers["/p1/energy"]({"data": robot.energy})

    def on_p1_heading(self, payload: Payload) -> None:
        """Turn robot p1."""
        command = self.world.commands[P1]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_p1_speed(self, payload: Payload) -> None:
        """Set the speed of robot p1."""
        self.world.commands[P1].speed = float(payload["data"])

    def publish_p1_gps(self) -> None:
        """Publish sensor p1_gps; whether it is active only when that changed."""
        sensor = self.world.sensors[P1_GPS]
        self.publishers["/p1/p1_gps/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P1_GPS]:
            self.told_active[P1_GPS] = sensor.active
            self.publishers["/p1/p1_gps/active"]({"data": sensor.active == 1})

    def on_p1_gps_active(self, payload: Payload) -> None:
        """Switch sensor p1_gps on or off."""
        self.world.switches[P1_GPS].active = int(payload["data"])

    def publish_p1_depth(self) -> None:
        """Publish sensor p1_depth; whether it is active only when that changed."""
        sensor = self.world.sensors[P1_DEPTH]
        self.publishers["/p1/p1_depth/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P1_DEPTH]:
            self.told_active[P1_DEPTH] = sensor.active
            self.publishers["/p1/p1_depth/active"]({"data": sensor.active == 1})

    def on_p1_depth_active(self, payload: Payload) -> None:
        """Switch sensor p1_depth on or off."""
        self.world.switches[P1_DEPTH].active = int(payload["data"])

    def publish_p2(self) -> None:
        """Publish robot p2; its position only while it knows it."""
        robot = self.world.robots[P2]
        if reports_position(self.world, P2):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/p2/position"](position)
        self.publishers["/p2/speed"]({"data": robot.speed})
        self.publishers["/p2/energy"]({"data": robot.energy})

    def on_p2_heading(self, payload: Payload) -> None:
        """Turn robot p2."""
        command = self.world.commands[P2]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_p2_speed(self, payload: Payload) -> None:
        """Set the speed of robot p2."""
        self.world.commands[P2].speed = float(payload["data"])

    def publish_p2_gps(self) -> None:
        """Publish sensor p2_gps; whether it is active only when that changed."""
        sensor = self.world.sensors[P2_GPS]
        self.publishers["/p2/p2_gps/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P2_GPS]:
            self.told_active[P2_GPS] = sensor.active
            self.publishers["/p2/p2_gps/active"]({"data": sensor.active == 1})

    def on_p2_gps_active(self, payload: Payload) -> None:
        """Switch sensor p2_gps on or off."""
        self.world.switches[P2_GPS].active = int(payload["data"])

    def publish_p2_pressure(self) -> None:
        """Publish sensor p2_pressure; whether it is active only when that changed."""
        sensor = self.world.sensors[P2_PRESSURE]
        self.publishers["/p2/p2_pressure/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P2_PRESSURE]:
            self.told_active[P2_PRESSURE] = sensor.active
            self.publishers["/p2/p2_pressure/active"]({"data": sensor.active == 1})

    def on_p2_pressure_active(self, payload: Payload) -> None:
        """Switch sensor p2_pressure on or off."""
        self.world.switches[P2_PRESSURE].active = int(payload["data"])

    def publish_p3(self) -> None:
        """Publish robot p3; its position only while it knows it."""
        robot = self.world.robots[P3]
        if reports_position(self.world, P3):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/p3/position"](position)
        self.publishers["/p3/speed"]({"data": robot.speed})
        self.publishers["/p3/energy"]({"data": robot.energy})

    def on_p3_heading(self, payload: Payload) -> None:
        """Turn robot p3."""
        command = self.world.commands[P3]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_p3_speed(self, payload: Payload) -> None:
        """Set the speed of robot p3."""
        self.world.commands[P3].speed = float(payload["data"])

    def publish_p3_gps(self) -> None:
        """Publish sensor p3_gps; whether it is active only when that changed."""
        sensor = self.world.sensors[P3_GPS]
        self.publishers["/p3/p3_gps/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P3_GPS]:
            self.told_active[P3_GPS] = sensor.active
            self.publishers["/p3/p3_gps/active"]({"data": sensor.active == 1})

    def on_p3_gps_active(self, payload: Payload) -> None:
        """Switch sensor p3_gps on or off."""
        self.world.switches[P3_GPS].active = int(payload["data"])

    def publish_p3_temperature(self) -> None:
        """Publish sensor p3_temperature; whether it is active only when that changed."""
        sensor = self.world.sensors[P3_TEMPERATURE]
        self.publishers["/p3/p3_temperature/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[P3_TEMPERATURE]:
            self.told_active[P3_TEMPERATURE] = sensor.active
            self.publishers["/p3/p3_temperature/active"]({"data": sensor.active == 1})

    def on_p3_temperature_active(self, payload: Payload) -> None:
        """Switch sensor p3_temperature on or off."""
        self.world.switches[P3_TEMPERATURE].active = int(payload["data"])
