"""A mission in MOOS-IvP: each robot is a community with MOOSDB and uSimMarineV22.

With ``--helm``, pHelmIvP steers. With ``--reliability``, an sSensor of UNDERSEA measures for each
sensor, at the rate of the mission. MOOS cannot be stepped: its time goes on while the collective
intelligence thinks, so no flight is like another. A tick is a second of MOOS time, which ``--warp``
makes shorter than one of the clock. Commands that come later than ``--slack`` are counted as late.
"""

import argparse
import math
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory

from pymoos2.core import constants
from pymoos2.core.MOOSCommPkt import pack, unpack
from pymoos2.core.MOOSMsg import MOOSMsg
from pymoos2.core.time import moos_time, set_moos_time_warp

sys.path.append(str(Path(__file__).parents[1]))

from programs import end, start
from robots import Mission, Physics, Robot, Sensor, WorldError
from serving import serve

HERE = Path(__file__).parent
PROGRAMS = ("MOOSDB", "uSimMarineV22")
SENSOR = """
ProcessConfig = {name}
{{
  NAME        = {name}
  AppTick     = {rate}
  CommsTick   = {rate}
  RELIABILITY = {reliability}
}}
"""
TICK_S = 1.0
EXCHANGES = 20.0  # of messages with MOOSDB, in a second of MOOS time
PATIENCE_S = 8.0  # of the clock
NEAR_M = 0.5  # to the start, after a reset


class Vehicle:
    """A robot in its community, in metres; ``heard_at`` is in MOOS time."""

    def __init__(self, robot: Robot, port: int, unit_m: float, with_helm: bool) -> None:
        self._robot = robot
        self._unit_m = unit_m
        self._with_helm = with_helm
        self._x_m, self._y_m = (unit_m * each for each in robot.start[:2])
        self._readings = {sensor.name.upper(): [0, 0] for sensor in robot.sensors}
        self.x = self.y = self.speed = self.way = self.heard_at = 0.0
        self._x = 0.0
        self._socket = _reached(port)
        self._stream = self._socket.makefile("rwb")
        self._stream.write(
            constants.PROTOCOL_STRING.ljust(constants.PROTOCOL_STRING_BUFFER_SIZE, b"\0")
        )
        self._mail = [MOOSMsg(constants.MSG_DATA, sval="world", src="world")]
        self.hear()  # the welcome
        for name in ("NAV_X", "NAV_Y", "NAV_SPEED", *self._readings):
            self._mail.append(MOOSMsg(constants.MSG_REGISTER, name, src="world"))

    def reset(self) -> None:
        """Put the vehicle at its start, at rest."""
        self.command(0.0, 0.0)
        self._notify("MOOS_MANUAL_OVERRIDE", "false")
        self._notify("USM_RESET", f"x={self._x_m},y={self._y_m},speed=0,heading=0,depth=0")

    def is_at_start(self) -> bool:
        """Return whether the vehicle rests where it begins."""
        off = math.hypot(self.x - self._x_m, self.y - self._y_m)
        return self.speed == 0.0 and off < NEAR_M

    def obey(self) -> None:
        """Pass the commands of the robot on."""
        speed = self._robot.wanted_speed * self._unit_m
        self.command(*(speed * each for each in self._robot.heading))

    def command(self, x: float, y: float) -> None:
        """Command a velocity; without speed, the heading stays."""
        heading, speed = math.degrees(math.atan2(x, y)) % 360.0, math.hypot(x, y)
        for name, value in {"speed": speed, **({"heading": heading} if speed else {})}.items():
            if self._with_helm:
                self._notify(f"{name.upper()}_UPDATE", f"{name}={value}")
            else:
                self._notify(f"DESIRED_{name.upper()}", value)

    def _notify(self, key: str, value: float | str) -> None:
        kind = "sval" if isinstance(value, str) else "val"
        self._mail.append(MOOSMsg(constants.MSG_NOTIFY, key, src="world", **{kind: value}))

    def hear(self) -> None:
        """Exchange messages with MOOSDB, and take in where the vehicle is; NAV_Y follows NAV_X."""
        mail, self._mail = self._mail, []
        self._stream.write(pack(mail or [MOOSMsg(constants.MSG_NULL, src="world")]))
        self._stream.flush()
        size = self._stream.read(4)
        if not size:
            raise ConnectionError(f"MOOSDB of {self._robot.name} has ended")
        for message in unpack(size + self._stream.read(int.from_bytes(size, "little") - 4)):
            if message.key == "NAV_X":
                self._x = message.val
            elif message.key == "NAV_SPEED":
                self.speed = message.val
            elif message.key == "NAV_Y":
                self.way += math.hypot(self._x - self.x, message.val - self.y)
                self.x, self.y, self.heard_at = self._x, message.val, message.time
            elif message.key in self._readings:
                self._readings[message.key][0] += 1
                self._readings[message.key][1] += message.val > 0.0

    def read(self) -> dict[str, tuple[int, int]]:
        """Return how many samples each sensor took since the last call, and how many are valid."""
        read, self._readings = self._readings, {name: [0, 0] for name in self._readings}
        return {name: (n, n_valid) for name, (n, n_valid) in read.items()}

    def report(self) -> float:
        """Set position and speed of the robot; return its distance since the last report."""
        self._robot.position = self.x / self._unit_m, self.y / self._unit_m, self._robot.start[2]
        self._robot.speed = self.speed / self._unit_m
        way, self.way = self.way / self._unit_m, 0.0
        return way

    def close(self) -> None:
        """Leave the community."""
        self._stream.close()
        self._socket.close()


class Moos(Physics):
    """Vehicles in communities of their own; obstacles are not there for the simulator."""

    @staticmethod
    def add_options(parser: argparse.ArgumentParser) -> None:
        """Add programs, warp, slack, helm, sensors and scale."""
        parser.add_argument("--bin", type=Path, required=True, help="folder with MOOSDB and others")
        parser.add_argument("--warp", type=float, default=20.0, help="seconds of MOOS a second")
        parser.add_argument("--slack", type=float, default=0.5, help="s: later commands are late")
        parser.add_argument("--helm", action="store_true", help="pHelmIvP steers")
        parser.add_argument("--reliability", type=float, help="0 to 1: of each sSensor of UNDERSEA")
        parser.add_argument("--unit", type=float, default=1.0, help="metres a distance unit")

    def __init__(self, mission: Mission, options: argparse.Namespace) -> None:
        programs = [*PROGRAMS, *["pHelmIvP"] * options.helm]
        for name in (*programs, *["sSensor"] * (options.reliability is not None)):
            if not (options.bin / name).is_file():
                raise WorldError(f"--bin: found no program {name} in {options.bin}")
        set_moos_time_warp(options.warp)
        self._options = options
        self._folder = TemporaryDirectory()
        shutil.copy(HERE / "vehicle.bhv", self._folder.name)
        self._programs: list[subprocess.Popen[str]] = []
        ports = {robot.name: self._launched(robot, programs) for robot in mission.robots}
        self._vehicles = [
            Vehicle(robot, ports[robot.name], options.unit, options.helm)
            for robot in mission.robots
        ]

    def reset(self, _seed: int) -> None:
        """Put every vehicle at its start, at rest."""
        self._wait(lambda: all(vehicle.heard_at for vehicle in self._vehicles))
        for vehicle in self._vehicles:
            vehicle.reset()
        self._wait(lambda: all(vehicle.is_at_start() for vehicle in self._vehicles))
        for vehicle in self._vehicles:
            vehicle.report()
            vehicle.read()
        self._end = math.inf  # tick 0 begins with its commands

    def move(self) -> Sequence[float]:
        """Have all vehicles move until the tick is over; return the distance of each."""
        for vehicle in self._vehicles:
            vehicle.obey()
            vehicle.hear()
        now = moos_time()
        self.late = int(now > self._end + self._options.slack)
        self._end = (now if self.late else min(now, self._end)) + TICK_S
        self._wait(lambda: all(vehicle.heard_at >= self._end for vehicle in self._vehicles))
        self._read = {name: n for each in self._vehicles for name, n in each.read().items()}
        return [vehicle.report() for vehicle in self._vehicles]

    def measured(self, sensor: Sensor) -> tuple[int, int] | None:
        """Return the readings of an sSensor, if UNDERSEA measures."""
        return None if self._options.reliability is None else self._read[sensor.name.upper()]

    def close(self) -> None:
        """End all programs."""
        for vehicle in self._vehicles:
            vehicle.close()
        end(*self._programs)
        self._folder.cleanup()

    def _wait(self, condition: Callable[[], bool]) -> None:
        limit = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > limit:
                raise TimeoutError(f"MOOS was silent, or did not obey, for {PATIENCE_S} s")
            time.sleep(1.0 / (EXCHANGES * self._options.warp))
            for vehicle in self._vehicles:
                vehicle.hear()

    def _launched(self, robot: Robot, programs: Sequence[str]) -> int:
        """Start the community of a robot, and return its port."""
        with closing(socket.create_server(("localhost", 0))) as free:
            port = free.getsockname()[1]
        options = self._options
        fastest = robot.greatest_speed * options.unit
        x, y = (options.unit * each for each in robot.start[:2])
        words = {"name": robot.name, "port": port, "warp": options.warp, "x": x, "y": y}
        words |= {"fastest": fastest, "thrust_per_speed": 100.0 / fastest}
        file = Path(self._folder.name) / f"{robot.name}.moos"
        text = (HERE / "vehicle.moos").read_text(encoding="utf-8")
        called = {name: name for name in programs}
        text = Template(text).substitute(words)
        for each in robot.sensors if options.reliability is not None else ():
            name, rate = each.name.upper(), each.samples_per_tick
            text += SENSOR.format(name=name, rate=rate, reliability=options.reliability)
            called[name] = "sSensor"
        file.write_text(text, encoding="utf-8")
        silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        for alias, program in called.items():
            told = [(options.bin / program).absolute(), file, f"--alias={alias}"]
            self._programs.append(start(told, cwd=self._folder.name, **silent))
        return port


def _reached(port: int) -> socket.socket:
    """Return a connection to MOOSDB, which may only just begin."""
    limit = time.monotonic() + PATIENCE_S
    while True:
        try:
            return socket.create_connection(("localhost", port))
        except OSError as error:
            if time.monotonic() > limit:
                raise WorldError(f"MOOSDB opened no port {port} in {PATIENCE_S} s") from error
            time.sleep(0.05)


if __name__ == "__main__":
    sys.exit(serve("MOOS-IvP", Moos))
