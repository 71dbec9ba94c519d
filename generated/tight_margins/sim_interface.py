# Generated from mission tight_margins by sim_interface.py.j2.
# Edit inside protected regions only.
"""The simulation interface: what the collective intelligence hears and says."""

from functools import partial

from mrsfi_runtime.api import Payload, State, Topic, Transport

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
            self.set_p1_heading,
            self.set_p2_heading,
            self.set_p3_heading,
        )
        self.set_speed = (
            self.set_p1_speed,
            self.set_p2_speed,
            self.set_p3_speed,
        )
        self.set_active = (
            self.set_p1_gps_active,
            self.set_p1_depth_active,
            self.set_p2_gps_active,
            self.set_p2_pressure_active,
            self.set_p3_gps_active,
            self.set_p3_temperature_active,
        )

    def reset(self) -> None:
        """Forget what was received."""
        self.latest.clear()

    def receive(self, topic: str, payload: Payload) -> None:
        """Keep the newest message of a topic."""
        self.latest[topic] = payload

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
        self.read_p1(inbox)
        self.read_p1_gps(inbox)
        self.read_p1_depth(inbox)
        self.read_p2(inbox)
        self.read_p2_gps(inbox)
        self.read_p2_pressure(inbox)
        self.read_p3(inbox)
        self.read_p3_gps(inbox)
        self.read_p3_temperature(inbox)

    def get_p1_position(self) -> tuple[float, float, float]:
        """Return where robot p1 says it is."""
        position = self.latest["/p1/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_p1_speed(self) -> float:
        """Return the speed of robot p1."""
        return float(self.latest["/p1/speed"]["data"])

    def get_p1_energy(self) -> float:
        """Return the energy that robot p1 has left."""
        return float(self.latest["/p1/energy"]["data"])

    def read_p1(self, inbox: State) -> None:
        """Copy robot p1; a position that it never told stays as it was."""
        robot = inbox.robots[P1]
        if "/p1/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_p1_position()
        robot.speed = self.get_p1_speed()
        robot.energy = self.get_p1_energy()

    def set_p1_heading(self, x: float, y: float) -> None:
        """Turn robot p1 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/p1/command/heading"](heading)

    def set_p1_speed(self, speed: float) -> None:
        """Set the speed of robot p1."""
        self.publishers["/p1/command/speed"]({"data": speed})

    def get_p1_gps_samples(self) -> int:
        """Return how many samples sensor p1_gps has taken."""
        return int(self.latest["/p1/p1_gps/samples"]["data"])

    def get_p1_gps_active(self) -> bool:
        """Return whether sensor p1_gps is active."""
        return bool(self.latest["/p1/p1_gps/active"]["data"])

    def read_p1_gps(self, inbox: State) -> None:
        """Copy sensor p1_gps."""
        sensor = inbox.sensors[P1_GPS]
        sensor.count = self.get_p1_gps_samples()
        sensor.active = int(self.get_p1_gps_active())

    def set_p1_gps_active(self, active: bool) -> None:
        """Switch sensor p1_gps on or off."""
        self.publishers["/p1/p1_gps/command/active"]({"data": active})

    def get_p1_depth_samples(self) -> int:
        """Return how many samples sensor p1_depth has taken."""
        return int(self.latest["/p1/p1_depth/samples"]["data"])

    def get_p1_depth_active(self) -> bool:
        """Return whether sensor p1_depth is active."""
        return bool(self.latest["/p1/p1_depth/active"]["data"])

    def read_p1_depth(self, inbox: State) -> None:
        """Copy sensor p1_depth."""
        sensor = inbox.sensors[P1_DEPTH]
        sensor.count = self.get_p1_depth_samples()
        sensor.active = int(self.get_p1_depth_active())

    def set_p1_depth_active(self, active: bool) -> None:
        """Switch sensor p1_depth on or off."""
        self.publishers["/p1/p1_depth/command/active"]({"data": active})

    def get_p2_position(self) -> tuple[float, float, float]:
        """Return where robot p2 says it is."""
        position = self.latest["/p2/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_p2_speed(self) -> float:
        """Return the speed of robot p2."""
        return float(self.latest["/p2/speed"]["data"])

    def get_p2_energy(self) -> float:
        """Return the energy that robot p2 has left."""
        return float(self.latest["/p2/energy"]["data"])

    def read_p2(self, inbox: State) -> None:
        """Copy robot p2; a position that it never told stays as it was."""
        robot = inbox.robots[P2]
        if "/p2/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_p2_position()
        robot.speed = self.get_p2_speed()
        robot.energy = self.get_p2_energy()

    def set_p2_heading(self, x: float, y: float) -> None:
        """Turn robot p2 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/p2/command/heading"](heading)

    def set_p2_speed(self, speed: float) -> None:
        """Set the speed of robot p2."""
        self.publishers["/p2/command/speed"]({"data": speed})

    def get_p2_gps_samples(self) -> int:
        """Return how many samples sensor p2_gps has taken."""
        return int(self.latest["/p2/p2_gps/samples"]["data"])

    def get_p2_gps_active(self) -> bool:
        """Return whether sensor p2_gps is active."""
        return bool(self.latest["/p2/p2_gps/active"]["data"])

    def read_p2_gps(self, inbox: State) -> None:
        """Copy sensor p2_gps."""
        sensor = inbox.sensors[P2_GPS]
        sensor.count = self.get_p2_gps_samples()
        sensor.active = int(self.get_p2_gps_active())

    def set_p2_gps_active(self, active: bool) -> None:
        """Switch sensor p2_gps on or off."""
        self.publishers["/p2/p2_gps/command/active"]({"data": active})

    def get_p2_pressure_samples(self) -> int:
        """Return how many samples sensor p2_pressure has taken."""
        return int(self.latest["/p2/p2_pressure/samples"]["data"])

    def get_p2_pressure_active(self) -> bool:
        """Return whether sensor p2_pressure is active."""
        return bool(self.latest["/p2/p2_pressure/active"]["data"])

    def read_p2_pressure(self, inbox: State) -> None:
        """Copy sensor p2_pressure."""
        sensor = inbox.sensors[P2_PRESSURE]
        sensor.count = self.get_p2_pressure_samples()
        sensor.active = int(self.get_p2_pressure_active())

    def set_p2_pressure_active(self, active: bool) -> None:
        """Switch sensor p2_pressure on or off."""
        self.publishers["/p2/p2_pressure/command/active"]({"data": active})

    def get_p3_position(self) -> tuple[float, float, float]:
        """Return where robot p3 says it is."""
        position = self.latest["/p3/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_p3_speed(self) -> float:
        """Return the speed of robot p3."""
        return float(self.latest["/p3/speed"]["data"])

    def get_p3_energy(self) -> float:
        """Return the energy that robot p3 has left."""
        return float(self.latest["/p3/energy"]["data"])

    def read_p3(self, inbox: State) -> None:
        """Copy robot p3; a position that it never told stays as it was."""
        robot = inbox.robots[P3]
        if "/p3/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_p3_position()
        robot.speed = self.get_p3_speed()
        robot.energy = self.get_p3_energy()

    def set_p3_heading(self, x: float, y: float) -> None:
        """Turn robot p3 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/p3/command/heading"](heading)

    def set_p3_speed(self, speed: float) -> None:
        """Set the speed of robot p3."""
        self.publishers["/p3/command/speed"]({"data": speed})

    def get_p3_gps_samples(self) -> int:
        """Return how many samples sensor p3_gps has taken."""
        return int(self.latest["/p3/p3_gps/samples"]["data"])

    def get_p3_gps_active(self) -> bool:
        """Return whether sensor p3_gps is active."""
        return bool(self.latest["/p3/p3_gps/active"]["data"])

    def read_p3_gps(self, inbox: State) -> None:
        """Copy sensor p3_gps."""
        sensor = inbox.sensors[P3_GPS]
        sensor.count = self.get_p3_gps_samples()
        sensor.active = int(self.get_p3_gps_active())

    def set_p3_gps_active(self, active: bool) -> None:
        """Switch sensor p3_gps on or off."""
        self.publishers["/p3/p3_gps/command/active"]({"data": active})

    def get_p3_temperature_samples(self) -> int:
        """Return how many samples sensor p3_temperature has taken."""
        return int(self.latest["/p3/p3_temperature/samples"]["data"])

    def get_p3_temperature_active(self) -> bool:
        """Return whether sensor p3_temperature is active."""
        return bool(self.latest["/p3/p3_temperature/active"]["data"])

    def read_p3_temperature(self, inbox: State) -> None:
        """Copy sensor p3_temperature."""
        sensor = inbox.sensors[P3_TEMPERATURE]
        sensor.count = self.get_p3_temperature_samples()
        sensor.active = int(self.get_p3_temperature_active())

    def set_p3_temperature_active(self, active: bool) -> None:
        """Switch sensor p3_temperature on or off."""
        self.publishers["/p3/p3_temperature/command/active"]({"data": active})
