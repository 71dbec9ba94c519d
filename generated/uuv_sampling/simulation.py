# Generated from mission uuv_sampling by simulation.py.j2.
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
    Topic("/r1/position", "geometry_msgs/Point"),
    Topic("/r1/speed", "std_msgs/Float64"),
    Topic("/r1/energy", "std_msgs/Float64"),
    Topic("/r1/s1/samples", "std_msgs/Int64"),
    Topic("/r1/s1/active", "std_msgs/Bool"),
    Topic("/r1/s2/samples", "std_msgs/Int64"),
    Topic("/r1/s2/active", "std_msgs/Bool"),
    Topic("/r2/position", "geometry_msgs/Point"),
    Topic("/r2/speed", "std_msgs/Float64"),
    Topic("/r2/energy", "std_msgs/Float64"),
    Topic("/r2/s3/samples", "std_msgs/Int64"),
    Topic("/r2/s3/active", "std_msgs/Bool"),
    Topic("/r2/s4/samples", "std_msgs/Int64"),
    Topic("/r2/s4/active", "std_msgs/Bool"),
    Topic("/r3/position", "geometry_msgs/Point"),
    Topic("/r3/speed", "std_msgs/Float64"),
    Topic("/r3/energy", "std_msgs/Float64"),
    Topic("/r3/s5/samples", "std_msgs/Int64"),
    Topic("/r3/s5/active", "std_msgs/Bool"),
    Topic("/r3/s6/samples", "std_msgs/Int64"),
    Topic("/r3/s6/active", "std_msgs/Bool"),
)

TRUTH = (
    Topic("/truth/r1", "std_msgs/Float64MultiArray"),
    Topic("/truth/r2", "std_msgs/Float64MultiArray"),
    Topic("/truth/r3", "std_msgs/Float64MultiArray"),
)

COMMANDS = (
    Topic("/r1/command/heading", "geometry_msgs/Vector3"),
    Topic("/r1/command/speed", "std_msgs/Float64"),
    Topic("/r1/s1/command/active", "std_msgs/Bool"),
    Topic("/r1/s2/command/active", "std_msgs/Bool"),
    Topic("/r2/command/heading", "geometry_msgs/Vector3"),
    Topic("/r2/command/speed", "std_msgs/Float64"),
    Topic("/r2/s3/command/active", "std_msgs/Bool"),
    Topic("/r2/s4/command/active", "std_msgs/Bool"),
    Topic("/r3/command/heading", "geometry_msgs/Vector3"),
    Topic("/r3/command/speed", "std_msgs/Float64"),
    Topic("/r3/s5/command/active", "std_msgs/Bool"),
    Topic("/r3/s6/command/active", "std_msgs/Bool"),
)

R1 = 0
R2 = 1
R3 = 2

S1 = 0
S2 = 1
S3 = 2
S4 = 3
S5 = 4
S6 = 5


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
            self.on_r1_heading,
            self.on_r1_speed,
            self.on_s1_active,
            self.on_s2_active,
            self.on_r2_heading,
            self.on_r2_speed,
            self.on_s3_active,
            self.on_s4_active,
            self.on_r3_heading,
            self.on_r3_speed,
            self.on_s5_active,
            self.on_s6_active,
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
        self.publish_r1()
        self.publish_s1()
        self.publish_s2()
        self.publish_r2()
        self.publish_s3()
        self.publish_s4()
        self.publish_r3()
        self.publish_s5()
        self.publish_s6()

    def publish_truth(self) -> None:
        """Publish what is true of every robot and its sensors, for the judge alone."""
        truth = {"data": true_values(self.world, R1)}
        self.publishers["/truth/r1"](truth)
        truth = {"data": true_values(self.world, R2)}
        self.publishers["/truth/r2"](truth)
        truth = {"data": true_values(self.world, R3)}
        self.publishers["/truth/r3"](truth)

    def publish_r1(self) -> None:
        """Publish robot r1; its position only while it knows it."""
        robot = self.world.robots[R1]
        if reports_position(self.world, R1):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/r1/position"](position)
        self.publishers["/r1/speed"]({"data": robot.speed})
        self.publishers["/r1/energy"]({"data": robot.energy})

    def on_r1_heading(self, payload: Payload) -> None:
        """Turn robot r1."""
        command = self.world.commands[R1]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_r1_speed(self, payload: Payload) -> None:
        """Set the speed of robot r1."""
        self.world.commands[R1].speed = float(payload["data"])

    def publish_s1(self) -> None:
        """Publish sensor s1; whether it is active only when that changed."""
        sensor = self.world.sensors[S1]
        self.publishers["/r1/s1/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S1]:
            self.told_active[S1] = sensor.active
            self.publishers["/r1/s1/active"]({"data": sensor.active == 1})

    def on_s1_active(self, payload: Payload) -> None:
        """Switch sensor s1 on or off."""
        self.world.switches[S1].active = int(payload["data"])

    def publish_s2(self) -> None:
        """Publish sensor s2; whether it is active only when that changed."""
        sensor = self.world.sensors[S2]
        self.publishers["/r1/s2/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S2]:
            self.told_active[S2] = sensor.active
            self.publishers["/r1/s2/active"]({"data": sensor.active == 1})

    def on_s2_active(self, payload: Payload) -> None:
        """Switch sensor s2 on or off."""
        self.world.switches[S2].active = int(payload["data"])

    def publish_r2(self) -> None:
        """Publish robot r2; its position only while it knows it."""
        robot = self.world.robots[R2]
        if reports_position(self.world, R2):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/r2/position"](position)
        self.publishers["/r2/speed"]({"data": robot.speed})
        self.publishers["/r2/energy"]({"data": robot.energy})

    def on_r2_heading(self, payload: Payload) -> None:
        """Turn robot r2."""
        command = self.world.commands[R2]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_r2_speed(self, payload: Payload) -> None:
        """Set the speed of robot r2."""
        self.world.commands[R2].speed = float(payload["data"])

    def publish_s3(self) -> None:
        """Publish sensor s3; whether it is active only when that changed."""
        sensor = self.world.sensors[S3]
        self.publishers["/r2/s3/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S3]:
            self.told_active[S3] = sensor.active
            self.publishers["/r2/s3/active"]({"data": sensor.active == 1})

    def on_s3_active(self, payload: Payload) -> None:
        """Switch sensor s3 on or off."""
        self.world.switches[S3].active = int(payload["data"])

    def publish_s4(self) -> None:
        """Publish sensor s4; whether it is active only when that changed."""
        sensor = self.world.sensors[S4]
        self.publishers["/r2/s4/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S4]:
            self.told_active[S4] = sensor.active
            self.publishers["/r2/s4/active"]({"data": sensor.active == 1})

    def on_s4_active(self, payload: Payload) -> None:
        """Switch sensor s4 on or off."""
        self.world.switches[S4].active = int(payload["data"])

    def publish_r3(self) -> None:
        """Publish robot r3; its position only while it knows it."""
        robot = self.world.robots[R3]
        if reports_position(self.world, R3):
            position = {"x": robot.x, "y": robot.y, "z": robot.z}
            self.publishers["/r3/position"](position)
        self.publishers["/r3/speed"]({"data": robot.speed})
        self.publishers["/r3/energy"]({"data": robot.energy})

    def on_r3_heading(self, payload: Payload) -> None:
        """Turn robot r3."""
        command = self.world.commands[R3]
        command.heading_x = float(payload["x"])
        command.heading_y = float(payload["y"])

    def on_r3_speed(self, payload: Payload) -> None:
        """Set the speed of robot r3."""
        self.world.commands[R3].speed = float(payload["data"])

    def publish_s5(self) -> None:
        """Publish sensor s5; whether it is active only when that changed."""
        sensor = self.world.sensors[S5]
        self.publishers["/r3/s5/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S5]:
            self.told_active[S5] = sensor.active
            self.publishers["/r3/s5/active"]({"data": sensor.active == 1})

    def on_s5_active(self, payload: Payload) -> None:
        """Switch sensor s5 on or off."""
        self.world.switches[S5].active = int(payload["data"])

    def publish_s6(self) -> None:
        """Publish sensor s6; whether it is active only when that changed."""
        sensor = self.world.sensors[S6]
        self.publishers["/r3/s6/samples"]({"data": sensor.count})
        if sensor.active != self.told_active[S6]:
            self.told_active[S6] = sensor.active
            self.publishers["/r3/s6/active"]({"data": sensor.active == 1})

    def on_s6_active(self, payload: Payload) -> None:
        """Switch sensor s6 on or off."""
        self.world.switches[S6].active = int(payload["data"])
