# Generated from mission uuv_sampling by sim_interface.py.j2.
# Edit inside protected regions only.
"""The simulation interface: what the collective intelligence hears and says."""

from functools import partial

from mrsfi_runtime.api import Payload, State, Topic, Transport

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


class SimInterface:
    """Getters for what the simulation publishes, setters for what it obeys.

    ``set_heading`` and ``set_speed`` hold the setters by index of the robot, ``set_active``
    by index of the sensor.
    """

    def __init__(self, transport: Transport) -> None:
        self.latest: dict[str, Payload] = {}
        for topic in TOPICS:
            transport.subscribe(topic, partial(self.receive, topic.name))
        self.publishers = {topic.name: transport.advertise(topic) for topic in COMMANDS}
        self.set_heading = (
            self.set_r1_heading,
            self.set_r2_heading,
            self.set_r3_heading,
        )
        self.set_speed = (
            self.set_r1_speed,
            self.set_r2_speed,
            self.set_r3_speed,
        )
        self.set_active = (
            self.set_s1_active,
            self.set_s2_active,
            self.set_s3_active,
            self.set_s4_active,
            self.set_s5_active,
            self.set_s6_active,
        )

    def reset(self) -> None:
        """Forget what was received."""
        self.latest.clear()

    def receive(self, topic: str, payload: Payload) -> None:
        """Keep the newest message of a topic."""
        self.latest[topic] = payload

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
        self.read_r1(inbox)
        self.read_s1(inbox)
        self.read_s2(inbox)
        self.read_r2(inbox)
        self.read_s3(inbox)
        self.read_s4(inbox)
        self.read_r3(inbox)
        self.read_s5(inbox)
        self.read_s6(inbox)

    def get_r1_position(self) -> tuple[float, float, float]:
        """Return where robot r1 says it is."""
        position = self.latest["/r1/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_r1_speed(self) -> float:
        """Return the speed of robot r1."""
        return float(self.latest["/r1/speed"]["data"])

    def get_r1_energy(self) -> float:
        """Return the energy that robot r1 has left."""
        return float(self.latest["/r1/energy"]["data"])

    def read_r1(self, inbox: State) -> None:
        """Copy robot r1; a position that it never told stays as it was."""
        robot = inbox.robots[R1]
        if "/r1/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_r1_position()
        robot.speed = self.get_r1_speed()
        robot.energy = self.get_r1_energy()

    def set_r1_heading(self, x: float, y: float) -> None:
        """Turn robot r1 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/r1/command/heading"](heading)

    def set_r1_speed(self, speed: float) -> None:
        """Set the speed of robot r1."""
        self.publishers["/r1/command/speed"]({"data": speed})

    def get_s1_samples(self) -> int:
        """Return how many samples sensor s1 has taken."""
        return int(self.latest["/r1/s1/samples"]["data"])

    def get_s1_active(self) -> bool:
        """Return whether sensor s1 is active."""
        return bool(self.latest["/r1/s1/active"]["data"])

    def read_s1(self, inbox: State) -> None:
        """Copy sensor s1."""
        sensor = inbox.sensors[S1]
        sensor.count = self.get_s1_samples()
        sensor.active = int(self.get_s1_active())

    def set_s1_active(self, active: bool) -> None:
        """Switch sensor s1 on or off."""
        self.publishers["/r1/s1/command/active"]({"data": active})

    def get_s2_samples(self) -> int:
        """Return how many samples sensor s2 has taken."""
        return int(self.latest["/r1/s2/samples"]["data"])

    def get_s2_active(self) -> bool:
        """Return whether sensor s2 is active."""
        return bool(self.latest["/r1/s2/active"]["data"])

    def read_s2(self, inbox: State) -> None:
        """Copy sensor s2."""
        sensor = inbox.sensors[S2]
        sensor.count = self.get_s2_samples()
        sensor.active = int(self.get_s2_active())

    def set_s2_active(self, active: bool) -> None:
        """Switch sensor s2 on or off."""
        self.publishers["/r1/s2/command/active"]({"data": active})

    def get_r2_position(self) -> tuple[float, float, float]:
        """Return where robot r2 says it is."""
        position = self.latest["/r2/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_r2_speed(self) -> float:
        """Return the speed of robot r2."""
        return float(self.latest["/r2/speed"]["data"])

    def get_r2_energy(self) -> float:
        """Return the energy that robot r2 has left."""
        return float(self.latest["/r2/energy"]["data"])

    def read_r2(self, inbox: State) -> None:
        """Copy robot r2; a position that it never told stays as it was."""
        robot = inbox.robots[R2]
        if "/r2/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_r2_position()
        robot.speed = self.get_r2_speed()
        robot.energy = self.get_r2_energy()

    def set_r2_heading(self, x: float, y: float) -> None:
        """Turn robot r2 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/r2/command/heading"](heading)

    def set_r2_speed(self, speed: float) -> None:
        """Set the speed of robot r2."""
        self.publishers["/r2/command/speed"]({"data": speed})

    def get_s3_samples(self) -> int:
        """Return how many samples sensor s3 has taken."""
        return int(self.latest["/r2/s3/samples"]["data"])

    def get_s3_active(self) -> bool:
        """Return whether sensor s3 is active."""
        return bool(self.latest["/r2/s3/active"]["data"])

    def read_s3(self, inbox: State) -> None:
        """Copy sensor s3."""
        sensor = inbox.sensors[S3]
        sensor.count = self.get_s3_samples()
        sensor.active = int(self.get_s3_active())

    def set_s3_active(self, active: bool) -> None:
        """Switch sensor s3 on or off."""
        self.publishers["/r2/s3/command/active"]({"data": active})

    def get_s4_samples(self) -> int:
        """Return how many samples sensor s4 has taken."""
        return int(self.latest["/r2/s4/samples"]["data"])

    def get_s4_active(self) -> bool:
        """Return whether sensor s4 is active."""
        return bool(self.latest["/r2/s4/active"]["data"])

    def read_s4(self, inbox: State) -> None:
        """Copy sensor s4."""
        sensor = inbox.sensors[S4]
        sensor.count = self.get_s4_samples()
        sensor.active = int(self.get_s4_active())

    def set_s4_active(self, active: bool) -> None:
        """Switch sensor s4 on or off."""
        self.publishers["/r2/s4/command/active"]({"data": active})

    def get_r3_position(self) -> tuple[float, float, float]:
        """Return where robot r3 says it is."""
        position = self.latest["/r3/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_r3_speed(self) -> float:
        """Return the speed of robot r3."""
        return float(self.latest["/r3/speed"]["data"])

    def get_r3_energy(self) -> float:
        """Return the energy that robot r3 has left."""
        return float(self.latest["/r3/energy"]["data"])

    def read_r3(self, inbox: State) -> None:
        """Copy robot r3; a position that it never told stays as it was."""
        robot = inbox.robots[R3]
        if "/r3/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_r3_position()
        robot.speed = self.get_r3_speed()
        robot.energy = self.get_r3_energy()

    def set_r3_heading(self, x: float, y: float) -> None:
        """Turn robot r3 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/r3/command/heading"](heading)

    def set_r3_speed(self, speed: float) -> None:
        """Set the speed of robot r3."""
        self.publishers["/r3/command/speed"]({"data": speed})

    def get_s5_samples(self) -> int:
        """Return how many samples sensor s5 has taken."""
        return int(self.latest["/r3/s5/samples"]["data"])

    def get_s5_active(self) -> bool:
        """Return whether sensor s5 is active."""
        return bool(self.latest["/r3/s5/active"]["data"])

    def read_s5(self, inbox: State) -> None:
        """Copy sensor s5."""
        sensor = inbox.sensors[S5]
        sensor.count = self.get_s5_samples()
        sensor.active = int(self.get_s5_active())

    def set_s5_active(self, active: bool) -> None:
        """Switch sensor s5 on or off."""
        self.publishers["/r3/s5/command/active"]({"data": active})

    def get_s6_samples(self) -> int:
        """Return how many samples sensor s6 has taken."""
        return int(self.latest["/r3/s6/samples"]["data"])

    def get_s6_active(self) -> bool:
        """Return whether sensor s6 is active."""
        return bool(self.latest["/r3/s6/active"]["data"])

    def read_s6(self, inbox: State) -> None:
        """Copy sensor s6."""
        sensor = inbox.sensors[S6]
        sensor.count = self.get_s6_samples()
        sensor.active = int(self.get_s6_active())

    def set_s6_active(self, active: bool) -> None:
        """Switch sensor s6 on or off."""
        self.publishers["/r3/s6/command/active"]({"data": active})
