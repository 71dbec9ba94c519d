"""The mission uuv_sampling on MuJoCo, behind the topics that docs/bus.md describes.

It knows nothing of mrsfi but these topics, and speaks to them through roslibpy.
"""

import argparse
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import roslibpy

Message = dict[str, Any]

WORLD = Path(__file__).with_name("world.xml")
TICK_S = 1.0


@dataclass(slots=True)
class Sensor:
    """A sensor, and whether its robot was told to have it on."""

    name: str
    samples_per_tick: int
    energy_per_sample: float
    tells_position: bool
    count: int = 0
    is_active: bool = False
    is_wanted: bool = True


@dataclass(slots=True)
class Robot:
    """A vehicle and what it was told: a unit heading and a speed."""

    name: str
    energy: float
    energy_per_metre: float
    greatest_speed: float
    sensors: list[Sensor]
    heading: tuple[float, float] = (0.0, 0.0)
    wanted_speed: float = 0.0
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.0


class World:
    """Vehicles with inertia and drag in water; they are stopped by what they run into.

    Attributes
    ----------
    robots
        Vehicles in the order of the world description, the same objects for ever.
    """

    def __init__(self, path: Path = WORLD) -> None:
        self._model = mujoco.MjModel.from_xml_path(str(path))
        self._data = mujoco.MjData(self._model)
        self._gain, self._greatest_thrust = self._model.numeric("thruster").data
        bodies = [self._model.body(n) for n in range(self._model.nbody)]
        vehicles = [body for body in bodies if body.jntnum[0]]
        self._start = np.array([body.pos for body in vehicles])
        self.robots = [self._robot(body.name) for body in vehicles]
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Go back to the start, with another seed of the samples."""
        mujoco.mj_resetData(self._model, self._data)
        self._random = np.random.default_rng(seed)
        for robot in self.robots:
            robot.energy = float(self._model.numeric(robot.name).data[0])
            robot.heading, robot.wanted_speed = (0.0, 0.0), 0.0
            for sensor in robot.sensors:
                sensor.count, sensor.is_active, sensor.is_wanted = 0, False, True

    def step(self) -> None:
        """Fly one tick."""
        has_power = np.array([robot.energy > 0.0 for robot in self.robots])
        metres = self._move(has_power)
        ends = self._start.copy()
        ends[:, :2] += self._data.qpos.reshape(-1, 2)
        speeds = np.hypot(*self._data.qvel.reshape(-1, 2).T)
        for n, robot in enumerate(self.robots):
            x, y, z = map(float, ends[n])
            robot.position, robot.speed = (x, y, z), float(speeds[n])
            spent = float(metres[n]) * robot.energy_per_metre + self._sample(robot)
            robot.energy = max(robot.energy - spent, 0.0) if has_power[n] else 0.0

    def _robot(self, name: str) -> Robot:
        return Robot(name, *map(float, self._model.numeric(name).data), self._sensors(name))

    def _sensors(self, robot: str) -> list[Sensor]:
        found = []
        for n in range(self._model.nnumeric):
            numeric = self._model.numeric(n)
            owner, _, name = numeric.name.partition("/")
            if owner == robot and name:
                samples, energy, tells_position = numeric.data
                found.append(Sensor(name, int(samples), float(energy), bool(tells_position)))
        return found

    def _move(self, has_power: np.ndarray) -> np.ndarray:
        """Move all vehicles for a tick and return how far each of them went."""
        wanted = np.array([robot.heading for robot in self.robots])
        speeds = [min(robot.wanted_speed, robot.greatest_speed) for robot in self.robots]
        wanted *= np.array([speeds]).T
        velocity = self._data.qvel.reshape(-1, 2)  # a view: it changes with every step
        step_s = self._model.opt.timestep
        metres = np.zeros(len(self.robots))
        for _ in range(round(TICK_S / step_s)):
            thrust = self._gain * (wanted - velocity)
            size = np.hypot(*thrust.T)
            share = has_power * self._greatest_thrust / np.maximum(size, self._greatest_thrust)
            self._data.qfrc_applied[:] = (thrust * share[:, None]).ravel()
            mujoco.mj_step(self._model, self._data)
            metres += np.hypot(*velocity.T) * step_s
        return metres

    def _sample(self, robot: Robot) -> float:
        """Have each active sensor take its samples; return the energy that they cost."""
        spent = 0.0
        for sensor in robot.sensors:
            n = sensor.samples_per_tick
            n_valid = int(self._random.binomial(n, 1.0 / n))  # drawn whether it is on or off
            sensor.is_active = sensor.is_wanted and robot.energy > 0.0
            if sensor.is_active:
                sensor.count += n_valid
                spent += n * sensor.energy_per_sample
        return spent


@dataclass(slots=True)
class Side:
    """The simulation's side of the bus: flies a tick whenever it is told to."""

    ros: roslibpy.Ros
    world: World
    ended: threading.Event = field(default_factory=threading.Event)
    closed: threading.Event = field(default_factory=threading.Event)
    problem: str = ""
    _topics: dict[str, roslibpy.Topic] = field(default_factory=dict)
    _setup: tuple[int, int] | None = None
    _run: int | None = None
    _tick: int = 0
    _is_told: bool = False
    _n_announced: int = 0
    _n_obeyed: int = 0
    _n_sent: int = 0
    _told: dict[str, bool] = field(default_factory=dict)

    def join(self) -> None:
        """Advertise and subscribe to everything; the services last, for they say it is ready."""
        for robot in self.world.robots:
            self._join_robot(robot)
        self._advertise("/clock", "rosgraph_msgs/Clock")
        self._advertise("/mission/tick", "std_msgs/Int64MultiArray")
        self._advertise("/mission/failure", "std_msgs/String")
        self._subscribe("/mission/setup", "std_msgs/Int64MultiArray", self._on_setup)
        self._subscribe("/mission/go", "std_msgs/Int64MultiArray", self._on_go)
        self.ros.on("close", self._on_close)
        for name, handler in (("reset", self._on_reset), ("stop", self._on_stop)):
            service = roslibpy.Service(self.ros, f"/mission/{name}", "std_srvs/Trigger")
            service.advertise(handler)

    def _join_robot(self, robot: Robot) -> None:
        base = f"/{robot.name}"
        self._advertise(f"{base}/position", "geometry_msgs/Point")
        self._advertise(f"{base}/speed", "std_msgs/Float64")
        self._advertise(f"{base}/energy", "std_msgs/Float64")
        self._advertise(f"/truth{base}", "std_msgs/Float64MultiArray")

        def turn(message: Message) -> None:
            robot.heading = float(message["x"]), float(message["y"])

        def drive(message: Message) -> None:
            robot.wanted_speed = float(message["data"])

        self._obey(f"{base}/command/heading", "geometry_msgs/Vector3", turn)
        self._obey(f"{base}/command/speed", "std_msgs/Float64", drive)
        for sensor in robot.sensors:
            self._join_sensor(f"{base}/{sensor.name}", sensor)

    def _join_sensor(self, base: str, sensor: Sensor) -> None:
        self._advertise(f"{base}/samples", "std_msgs/Int64")
        self._advertise(f"{base}/active", "std_msgs/Bool")

        def switch(message: Message) -> None:
            sensor.is_wanted = bool(message["data"])

        self._obey(f"{base}/command/active", "std_msgs/Bool", switch)

    def _advertise(self, name: str, type_name: str) -> None:
        self._topics[name] = roslibpy.Topic(self.ros, name, type_name)
        self._topics[name].advertise()

    def _subscribe(self, name: str, type_name: str, callback: Callable[[Message], None]) -> None:
        """Have a callback hear a topic; roslibpy would only log what goes wrong in it."""

        def hear(message: Message) -> None:
            try:
                callback(message)
            except Exception as error:  # noqa: BLE001 - whatever it is ends the simulation
                reason = f"run {self._run}, tick {self._tick}: {type(error).__name__}: {error}"
                self._topics["/mission/failure"].publish({"data": reason})
                self._end(reason)

        roslibpy.Topic(self.ros, name, type_name).subscribe(hear)

    def _obey(self, name: str, type_name: str, callback: Callable[[Message], None]) -> None:
        """Subscribe to a command, and count it."""

        def count(message: Message) -> None:
            callback(message)
            self._n_obeyed += 1
            self._fly_when_complete()

        self._subscribe(name, type_name, count)

    def _on_setup(self, message: Message) -> None:
        run, seed, *_semantics = message["data"]  # this world has rules of its own
        self._setup = run, seed

    def _on_reset(self, _request: Any, response: Any) -> bool:
        if self._setup is None:
            response.update(success=False, message="no message on /mission/setup came yet")
            return True
        self._run, seed = self._setup
        self.world.reset(seed)
        self._tick = self._n_announced = self._n_obeyed = self._n_sent = 0
        self._is_told = False
        self._told.clear()
        response.update(success=True, message=f"run {self._run}")
        return True

    def _on_stop(self, _request: Any, response: Any) -> bool:
        self._run = None
        response.update(success=True, message="")
        return True

    def _on_go(self, message: Message) -> None:
        run, tick, n_commands = message["data"]
        if run != self._run:  # a run that is over
            return
        if tick != self._tick:
            raise ValueError(f"told to fly tick {tick}; expected tick {self._tick}")
        self._is_told = True
        self._n_announced += n_commands
        self._fly_when_complete()

    def _fly_when_complete(self) -> None:
        """Fly the tick once all its commands came: servers may deliver some after the go."""
        if not self._is_told or self._n_obeyed < self._n_announced:
            return
        if self._n_obeyed > self._n_announced:
            raise ValueError(f"{self._n_obeyed} commands came; expected {self._n_announced}")
        self._is_told = False
        self.world.step()
        for robot in self.world.robots:
            self._tell(robot)
        self._send("/clock", clock={"secs": self._tick, "nsecs": 0})
        self._send("/mission/tick", data=[self._run, self._tick, self._n_sent, self._n_obeyed])
        self._tick, self._n_sent = self._tick + 1, 0

    def _tell(self, robot: Robot) -> None:
        base, (x, y, z) = f"/{robot.name}", robot.position
        truth = [x, y, z, robot.speed, robot.energy]
        if all(sensor.is_active for sensor in robot.sensors if sensor.tells_position):
            self._send(f"{base}/position", x=x, y=y, z=z)
        self._send(f"{base}/speed", data=robot.speed)
        self._send(f"{base}/energy", data=robot.energy)
        for sensor in robot.sensors:
            name = f"{base}/{sensor.name}"
            truth += [float(sensor.count), float(sensor.is_active)]
            self._send(f"{name}/samples", data=sensor.count)
            if self._told.get(name) != sensor.is_active:
                self._told[name] = sensor.is_active
                self._send(f"{name}/active", data=sensor.is_active)
        self._send(f"/truth{base}", data=truth)

    def _send(self, name: str, **message: Any) -> None:
        self._topics[name].publish(message)
        self._n_sent += 1

    def _on_close(self, _protocol: Any) -> None:
        self.closed.set()
        self._end("the connection was lost")

    def _end(self, problem: str) -> None:
        if not self.ended.is_set():
            self.problem = problem
            self.ended.set()


def serve(ros: roslibpy.Ros, url: str) -> int:
    """Serve until Ctrl-C; return 1 when something went wrong."""
    side = Side(ros, World())
    try:
        side.join()
        print(f"uuv_sampling on MuJoCo serves at {url}; Ctrl-C ends it", flush=True)
        side.ended.wait()
    except KeyboardInterrupt:
        return 0
    finally:
        ros.close()
        side.closed.wait(5.0)
    sys.stderr.write(f"{side.problem}\n")
    return 1


def main() -> int:
    """Connect and serve; return the exit code."""
    parser = argparse.ArgumentParser(description="Simulate the mission uuv_sampling on MuJoCo.")
    parser.add_argument("--url", default="ws://127.0.0.1:9090", help="rosbridge server")
    url = parser.parse_args().url
    ros = roslibpy.Ros(url, transport="asyncio")
    try:
        ros.run()
        return serve(ros, url)
    except roslibpy.core.RosTimeoutError:
        sys.stderr.write(f"nobody answers at {url}; start one: mrsfi bridge\n")
        return 1
    finally:
        ros.terminate()


if __name__ == "__main__":
    sys.exit(main())
