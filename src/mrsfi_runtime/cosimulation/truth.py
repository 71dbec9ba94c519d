"""The true state of a robot as one message: for the judge of true verdicts, never for the CI."""

from mrsfi_runtime.cosimulation.heard import Heard
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.kernel.state import State


def true_values(world: State, index: int) -> list[float]:
    """Return what is true of a robot and its sensors.

    That is ``[x, y, z, speed, energy]``, then ``count, active`` of each of its sensors.
    """
    robot = world.robots[index]
    values = [robot.x, robot.y, robot.z, robot.speed, robot.energy]
    for sensor in world.sensors[robot.first_sensor : robot.first_sensor + robot.n_sensors]:
        values += (float(sensor.count), float(sensor.active))
    return values


def take_true_values(world: State, index: int, told: Heard) -> None:
    """Make a state agree with what ``true_values`` said of a robot in this tick."""
    robot = world.robots[index]
    values = told.take()["data"]
    expected = 5 + 2 * robot.n_sensors
    if len(values) != expected:
        raise ProtocolError(
            f"{told.name} carried {values!r}; expected {expected} numbers: "
            "x, y, z, speed, energy, then count and active of each of its sensors"
        )
    robot.x, robot.y, robot.z, robot.speed, robot.energy = map(float, values[:5])
    for offset in range(robot.n_sensors):
        sensor = world.sensors[robot.first_sensor + offset]
        count, active = values[5 + 2 * offset : 7 + 2 * offset]
        if active not in {0, 1} or not sensor.count <= count < 2**63 or count % 1:
            raise ProtocolError(
                f"{told.name} carried count {count} and active {active} of its sensor {offset + 1} "
                f"after count {sensor.count}; expected a whole number that never falls, and 0 or 1"
            )
        sensor.count, sensor.active = int(count), int(active)
