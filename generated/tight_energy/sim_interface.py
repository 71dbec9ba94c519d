# Generated from mission tight_energy by sim_interface.py.j2.
# Edit inside protected regions only.
"""The simulation interface: what the collective intelligence hears and says."""

from functools import partial

from mrsfi_runtime.api import Payload, State, Topic, Transport

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
            self.set_e1_heading,
            self.set_e2_heading,
            self.set_e3_heading,
        )
        self.set_speed = (
            self.set_e1_speed,
            self.set_e2_speed,
            self.set_e3_speed,
        )
        self.set_active = (
            self.set_e1_gps_position_active,
            self.set_e1_temperature_active,
            self.set_e2_gps_position_active,
            self.set_e2_depth_active,
            self.set_e3_gps_position_active,
            self.set_e3_pressure_active,
        )

    def reset(self) -> None:
        """Forget what was received."""
        self.latest.clear()

    def receive(self, topic: str, payload: Payload) -> None:
        """Keep the newest message of a topic."""
        self.latest[topic] = payload

    def read(self, inbox: State) -> None:
        """Copy the newest message of every topic into the inbox."""
        self.read_e1(inbox)
        self.read_e1_gps_position(inbox)
        self.read_e1_temperature(inbox)
        self.read_e2(inbox)
        self.read_e2_gps_position(inbox)
        self.read_e2_depth(inbox)
        self.read_e3(inbox)
        self.read_e3_gps_position(inbox)
        self.read_e3_pressure(inbox)

    def get_e1_position(self) -> tuple[float, float, float]:
        """Return where robot e1 says it is."""
        position = self.latest["/e1/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_e1_speed(self) -> float:
        """Return the speed of robot e1."""
        return float(self.latest["/e1/speed"]["data"])

    def get_e1_energy(self) -> float:
        """Return the energy that robot e1 has left."""
        return float(self.latest["/e1/energy"]["data"])

    def read_e1(self, inbox: State) -> None:
        """Copy robot e1; a position that it never told stays as it was."""
        robot = inbox.robots[E1]
        if "/e1/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_e1_position()
        robot.speed = self.get_e1_speed()
        robot.energy = self.get_e1_energy()

    def set_e1_heading(self, x: float, y: float) -> None:
        """Turn robot e1 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/e1/command/heading"](heading)

    def set_e1_speed(self, speed: float) -> None:
        """Set the speed of robot e1."""
        self.publishers["/e1/command/speed"]({"data": speed})

    def get_e1_gps_position_samples(self) -> int:
        """Return how many samples sensor e1_gps_position has taken."""
        return int(self.latest["/e1/e1_gps_position/samples"]["data"])

    def get_e1_gps_position_active(self) -> bool:
        """Return whether sensor e1_gps_position is active."""
        return bool(self.latest["/e1/e1_gps_position/active"]["data"])

    def read_e1_gps_position(self, inbox: State) -> None:
        """Copy sensor e1_gps_position."""
        sensor = inbox.sensors[E1_GPS_POSITION]
        sensor.count = self.get_e1_gps_position_samples()
        sensor.active = int(self.get_e1_gps_position_active())

    def set_e1_gps_position_active(self, active: bool) -> None:
        """Switch sensor e1_gps_position on or off."""
        self.publishers["/e1/e1_gps_position/command/active"]({"data": active})

    def get_e1_temperature_samples(self) -> int:
        """Return how many samples sensor e1_temperature has taken."""
        return int(self.latest["/e1/e1_temperature/samples"]["data"])

    def get_e1_temperature_active(self) -> bool:
        """Return whether sensor e1_temperature is active."""
        return bool(self.latest["/e1/e1_temperature/active"]["data"])

    def read_e1_temperature(self, inbox: State) -> None:
        """Copy sensor e1_temperature."""
        sensor = inbox.sensors[E1_TEMPERATURE]
        sensor.count = self.get_e1_temperature_samples()
        sensor.active = int(self.get_e1_temperature_active())

    def set_e1_temperature_active(self, active: bool) -> None:
        """Switch sensor e1_temperature on or off."""
        self.publishers["/e1/e1_temperature/command/active"]({"data": active})

    def get_e2_position(self) -> tuple[float, float, float]:
        """Return where robot e2 says it is."""
        position = self.latest["/e2/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_e2_speed(self) -> float:
        """Return the speed of robot e2."""
        return float(self.latest["/e2/speed"]["data"])

    def get_e2_energy(self) -> float:
        """Return the energy that robot e2 has left."""
        return float(self.latest["/e2/energy"]["data"])

    def read_e2(self, inbox: State) -> None:
        """Copy robot e2; a position that it never told stays as it was."""
        robot = inbox.robots[E2]
        if "/e2/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_e2_position()
        robot.speed = self.get_e2_speed()
        robot.energy = self.get_e2_energy()

    def set_e2_heading(self, x: float, y: float) -> None:
        """Turn robot e2 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/e2/command/heading"](heading)

    def set_e2_speed(self, speed: float) -> None:
        """Set the speed of robot e2."""
        self.publishers["/e2/command/speed"]({"data": speed})

    def get_e2_gps_position_samples(self) -> int:
        """Return how many samples sensor e2_gps_position has taken."""
        return int(self.latest["/e2/e2_gps_position/samples"]["data"])

    def get_e2_gps_position_active(self) -> bool:
        """Return whether sensor e2_gps_position is active."""
        return bool(self.latest["/e2/e2_gps_position/active"]["data"])

    def read_e2_gps_position(self, inbox: State) -> None:
        """Copy sensor e2_gps_position."""
        sensor = inbox.sensors[E2_GPS_POSITION]
        sensor.count = self.get_e2_gps_position_samples()
        sensor.active = int(self.get_e2_gps_position_active())

    def set_e2_gps_position_active(self, active: bool) -> None:
        """Switch sensor e2_gps_position on or off."""
        self.publishers["/e2/e2_gps_position/command/active"]({"data": active})

    def get_e2_depth_samples(self) -> int:
        """Return how many samples sensor e2_depth has taken."""
        return int(self.latest["/e2/e2_depth/samples"]["data"])

    def get_e2_depth_active(self) -> bool:
        """Return whether sensor e2_depth is active."""
        return bool(self.latest["/e2/e2_depth/active"]["data"])

    def read_e2_depth(self, inbox: State) -> None:
        """Copy sensor e2_depth."""
        sensor = inbox.sensors[E2_DEPTH]
        sensor.count = self.get_e2_depth_samples()
        sensor.active = int(self.get_e2_depth_active())

    def set_e2_depth_active(self, active: bool) -> None:
        """Switch sensor e2_depth on or off."""
        self.publishers["/e2/e2_depth/command/active"]({"data": active})

    def get_e3_position(self) -> tuple[float, float, float]:
        """Return where robot e3 says it is."""
        position = self.latest["/e3/position"]
        return float(position["x"]), float(position["y"]), float(position["z"])

    def get_e3_speed(self) -> float:
        """Return the speed of robot e3."""
        return float(self.latest["/e3/speed"]["data"])

    def get_e3_energy(self) -> float:
        """Return the energy that robot e3 has left."""
        return float(self.latest["/e3/energy"]["data"])

    def read_e3(self, inbox: State) -> None:
        """Copy robot e3; a position that it never told stays as it was."""
        robot = inbox.robots[E3]
        if "/e3/position" in self.latest:
            robot.x, robot.y, robot.z = self.get_e3_position()
        robot.speed = self.get_e3_speed()
        robot.energy = self.get_e3_energy()

    def set_e3_heading(self, x: float, y: float) -> None:
        """Turn robot e3 to a unit heading."""
        heading = {"x": x, "y": y, "z": 0.0}
        self.publishers["/e3/command/heading"](heading)

    def set_e3_speed(self, speed: float) -> None:
        """Set the speed of robot e3."""
        self.publishers["/e3/command/speed"]({"data": speed})

    def get_e3_gps_position_samples(self) -> int:
        """Return how many samples sensor e3_gps_position has taken."""
        return int(self.latest["/e3/e3_gps_position/samples"]["data"])

    def get_e3_gps_position_active(self) -> bool:
        """Return whether sensor e3_gps_position is active."""
        return bool(self.latest["/e3/e3_gps_position/active"]["data"])

    def read_e3_gps_position(self, inbox: State) -> None:
        """Copy sensor e3_gps_position."""
        sensor = inbox.sensors[E3_GPS_POSITION]
        sensor.count = self.get_e3_gps_position_samples()
        sensor.active = int(self.get_e3_gps_position_active())

    def set_e3_gps_position_active(self, active: bool) -> None:
        """Switch sensor e3_gps_position on or off."""
        self.publishers["/e3/e3_gps_position/command/active"]({"data": active})

    def get_e3_pressure_samples(self) -> int:
        """Return how many samples sensor e3_pressure has taken."""
        return int(self.latest["/e3/e3_pressure/samples"]["data"])

    def get_e3_pressure_active(self) -> bool:
        """Return whether sensor e3_pressure is active."""
        return bool(self.latest["/e3/e3_pressure/active"]["data"])

    def read_e3_pressure(self, inbox: State) -> None:
        """Copy sensor e3_pressure."""
        sensor = inbox.sensors[E3_PRESSURE]
        sensor.count = self.get_e3_pressure_samples()
        sensor.active = int(self.get_e3_pressure_active())

    def set_e3_pressure_active(self, active: bool) -> None:
        """Switch sensor e3_pressure on or off."""
        self.publishers["/e3/e3_pressure/command/active"]({"data": active})
