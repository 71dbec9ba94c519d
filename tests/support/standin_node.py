"""A node that stands for any team's: the generated reactions of a mission, behind a socket.

``python -m tests.support.standin_node CODE URL ROS SEED [PREFIX]`` hears what it is told, answers
every tick with its commands and one message more, and is reset by a service.
"""

import sys
from pathlib import Path

from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.commands import feasible, release
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.model.fault_types import plain_name
from mrsfi_runtime.transport.rosbridge import RosbridgeTransport
from mrsfi_runtime.transport.topics import Payload, PrefixedTransport, Service, Topic, Transport


class StandIn:
    """The reactions of a mission, and the belief that they act on."""

    def __init__(self, directory: Path, transport: Transport, seed: int) -> None:
        self.code = load_code(directory)
        self.transport = transport
        self.ci = initial_state(self.code.mission, seed)
        self.setup = (0, 0)
        self.heard = 0
        self.tick: list[int] | None = None
        self.told = {}
        mission = self.code.mission
        self.turn, self.drive, self.switch = [], [], []
        for index, robot in enumerate(mission.robots):
            base = f"/{plain_name(robot.id)}"
            self.hear(f"{base}/position", "geometry_msgs/Point", self.position(index))
            self.hear(f"{base}/speed", "std_msgs/Float64", self.number("robots", index, "speed"))
            self.hear(f"{base}/energy", "std_msgs/Float64", self.number("robots", index, "energy"))
            sent = self.number("commands", index, "sent_speed")
            self.hear(f"{base}/speed/sent", "std_msgs/Float64", sent)
            self.turn.append(self.say(f"{base}/command/heading", "geometry_msgs/Vector3"))
            self.drive.append(self.say(f"{base}/command/speed", "std_msgs/Float64"))
        for index, sensor in enumerate(mission.sensors):
            robot = mission.robots[mission.sensor_robot[index]]
            base = f"/{plain_name(robot.id)}/{plain_name(sensor.id)}"
            self.hear(f"{base}/samples", "std_msgs/Int64", self.number("sensors", index, "count"))
            self.hear(f"{base}/active", "std_msgs/Bool", self.number("sensors", index, "active"))
            self.switch.append(self.say(f"{base}/command/active", "std_msgs/Bool"))
        self.answer = self.say("/mission/answer", "std_msgs/Int64MultiArray")
        self.transport.subscribe(Topic("/mission/setup", "std_msgs/Int64MultiArray"), self.on_setup)
        self.transport.subscribe(Topic("/mission/tick", "std_msgs/Int64MultiArray"), self.on_tick)
        self.transport.provide(Service("/mission/reset", "std_srvs/Trigger"), self.on_reset)

    def say(self, name, kind):
        return self.transport.advertise(Topic(name, kind))

    def hear(self, name, kind, take):
        def receive(message: Payload) -> None:
            take(message)
            self.heard += 1
            self.answer_when_complete()

        self.transport.subscribe(Topic(name, kind), receive)

    def position(self, index):
        def take(message: Payload) -> None:
            robot = self.ci.robots[index]
            robot.x, robot.y, robot.z = message["x"], message["y"], message["z"]

        return take

    def number(self, listed, index, name):
        def take(message: Payload) -> None:
            record = getattr(self.ci, listed)[index]
            setattr(record, name, type(getattr(record, name))(message["data"]))

        return take

    def on_setup(self, message: Payload) -> None:
        self.setup = tuple(message["data"][:2])

    def on_reset(self, _request: Payload) -> Payload:
        run, seed = self.setup
        self.ci = initial_state(self.code.mission, seed)
        self.heard, self.tick, self.told = 0, None, {}
        return {"success": True, "message": f"run {run}"}

    def on_tick(self, message: Payload) -> None:
        self.tick = message["data"]
        self.answer_when_complete()

    def answer_when_complete(self) -> None:
        if self.tick is None or self.heard < self.tick[2]:
            return
        _, tick, _, _ = self.tick
        self.heard, self.tick = 0, None
        ci, functions = self.ci, self.code.functions
        ci.mission.tick = tick
        release(ci)
        functions.progress(ci)
        functions.react(ci)
        n_sent = 0
        for publish, told in self.commands(tick + 1 == self.code.mission.duration):
            publish(told)
            n_sent += 1
        self.answer({"data": [tick, n_sent]})

    def commands(self, tells_all):
        """Yield what to say: commands that changed, or all of the tick, as its end is recorded."""
        ci = self.ci
        for index, command in enumerate(ci.commands):
            heading = {"x": command.heading_x, "y": command.heading_y, "z": 0.0}
            speed = {"data": feasible(ci.robots[index], command.speed)}
            if command.heading_claimed and self.is_due(("heading", index), heading, tells_all):
                yield self.turn[index], heading
            if command.speed_claimed and self.is_due(("speed", index), speed, tells_all):
                yield self.drive[index], speed
        for index, switch in enumerate(ci.switches):
            active = {"data": switch.active == 1}
            if switch.claimed and self.is_due(("switch", index), active, tells_all):
                yield self.switch[index], active

    def is_due(self, place, told, tells_all):
        is_new = self.told.get(place) != told
        self.told[place] = told
        return is_new or tells_all


def main() -> None:
    """Serve until the connection is lost."""
    directory, url, ros, seed, *prefix = sys.argv[1:]
    import threading

    ended = threading.Event()
    transport = PrefixedTransport(RosbridgeTransport(url, ros=int(ros)), "".join(prefix))
    StandIn(Path(directory), transport, int(seed))
    transport.watch(lambda error: (sys.stderr.write(f"{error!r}\n"), ended.set()))
    ended.wait()


if __name__ == "__main__":
    main()
