"""The simulation's side of the lock-step in docs/bus.md; it imports nothing of mrsfi."""

from collections.abc import Iterator

from bus import Bus, Callback, Message
from robots import Robot, Sensor, World, WorldError

GRACE_S = 1.0  # for which announced commands may be late


class Side:
    """Flies a world tick by tick on request, and publishes reports and true values."""

    def __init__(self, bus: Bus, world: World) -> None:
        self._bus = bus
        self._world = world
        self._setup: tuple[int, int] | None = None
        self._run: int | None = None
        self._published_active: dict[str, bool] = {}
        self._begin()
        bus.where = lambda: f"run {self._run}, tick {self._tick}"

    def join(self) -> None:
        """Advertise and subscribe to everything, services last: they signal that it is ready."""
        bus = self._bus
        for robot in self._world.robots:
            self._join_robot(robot)
        bus.advertise("/clock", "rosgraph_msgs/Clock")
        bus.advertise("/mission/tick", "std_msgs/Int64MultiArray")
        bus.subscribe("/mission/setup", "std_msgs/Int64MultiArray", self._on_setup)
        bus.subscribe("/mission/go", "std_msgs/Int64MultiArray", self._on_go)
        bus.provide("/mission/reset", self._reset)
        bus.provide("/mission/stop", self._stop)

    def _join_robot(self, robot: Robot) -> None:
        base = f"/{robot.name}"
        self._bus.advertise(f"{base}/position", "geometry_msgs/Point")
        self._bus.advertise(f"{base}/speed", "std_msgs/Float64")
        self._bus.advertise(f"{base}/energy", "std_msgs/Float64")
        self._bus.advertise(f"/truth{base}", "std_msgs/Float64MultiArray")

        def turn(message: Message) -> None:
            robot.heading = float(message["x"]), float(message["y"])

        def drive(message: Message) -> None:
            robot.commanded_speed = float(message["data"])

        self._obey(f"{base}/command/heading", "geometry_msgs/Vector3", turn)
        self._obey(f"{base}/command/speed", "std_msgs/Float64", drive)
        for sensor in robot.sensors:
            self._join_sensor(f"{base}/{sensor.name}", sensor)

    def _join_sensor(self, base: str, sensor: Sensor) -> None:
        self._bus.advertise(f"{base}/samples", "std_msgs/Int64")
        self._bus.advertise(f"{base}/active", "std_msgs/Bool")

        def switch(message: Message) -> None:
            sensor.is_wanted = bool(message["data"])

        self._obey(f"{base}/command/active", "std_msgs/Bool", switch)

    def _obey(self, name: str, type_name: str, callback: Callback) -> None:
        """Subscribe to a command, and count it."""

        def count(message: Message) -> None:
            callback(message)
            self._n_obeyed += 1
            self._fly_when_complete()

        self._bus.subscribe(name, type_name, count)

    def _begin(self) -> None:
        self._tick = self._n_announced = self._n_obeyed = 0
        self._is_requested = False
        self._published_active.clear()

    def _on_setup(self, message: Message) -> None:
        run, seed, *_semantics = message["data"]  # a world has its own rules
        self._setup = run, seed

    def _reset(self) -> tuple[bool, str]:
        if self._setup is None:
            return False, "no message on /mission/setup has arrived yet"
        self._run, seed = self._setup
        self._begin()
        self._world.reset(seed)
        return True, f"run {self._run}"

    def _stop(self) -> tuple[bool, str]:
        self._run = None
        return True, ""

    def _on_go(self, message: Message) -> None:
        run, tick, n_commands = message["data"]
        if run != self._run:  # a run that is over
            return
        if tick != self._tick:
            raise WorldError(f"tick {tick} was requested; expected tick {self._tick}")
        self._is_requested = True
        self._n_announced += n_commands
        self._fly_when_complete()
        if self._is_requested:
            self._bus.call_later(GRACE_S, lambda: self._require_flown(run, tick))

    def _require_flown(self, run: int, tick: int) -> None:
        if (run, tick) == (self._run, self._tick):
            robots = ", ".join(robot.name for robot in self._world.robots)
            raise WorldError(
                f"{self._n_obeyed} of {self._n_announced} commands reached {robots} within "
                f"{GRACE_S:g} s; expected all: one was lost, or another mission is flown than "
                "that of --mission"
            )

    def _fly_when_complete(self) -> None:
        """Fly the tick once all its commands arrived: servers may deliver some after the go."""
        if not self._is_requested or self._n_obeyed < self._n_announced:
            return
        if self._n_obeyed > self._n_announced:
            raise WorldError(f"{self._n_obeyed} commands arrived; expected {self._n_announced}")
        self._is_requested = False
        self._world.step()
        messages = [each for robot in self._world.robots for each in self._messages(robot)]
        messages.append(("/clock", {"clock": self._bus.time_of(self._tick)}))
        counts = [self._run, self._tick, len(messages), self._n_obeyed]
        if self._world.late:
            counts.append(self._world.late)
        self._tick += 1
        self._bus.publish([*messages, ("/mission/tick", {"data": counts})])

    def _messages(self, robot: Robot) -> Iterator[tuple[str, Message]]:
        """Yield the reports of a robot, and its true values."""
        base, truth = f"/{robot.name}", [*robot.position, robot.speed, robot.energy]
        if all(sensor.is_active for sensor in robot.sensors if sensor.tells_position):
            yield f"{base}/position", dict(zip("xyz", robot.reported, strict=True))
        yield f"{base}/speed", {"data": robot.speed}
        yield f"{base}/energy", {"data": robot.energy}
        for sensor in robot.sensors:
            name = f"{base}/{sensor.name}"
            truth += [float(sensor.count), float(sensor.is_active)]
            yield f"{name}/samples", {"data": sensor.count}
            if self._published_active.get(name) != sensor.is_active:
                self._published_active[name] = sensor.is_active
                yield f"{name}/active", {"data": sensor.is_active}
        yield f"/truth{base}", {"data": truth}
