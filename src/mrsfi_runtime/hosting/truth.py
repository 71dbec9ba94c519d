"""The true state of a robot as one message: for the judge of true verdicts, never for the CI."""

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.kernel.state import State


def true_values(world: State, index: int) -> list[float]:
    """Return what is true of a robot and its sensors.

    Returns
    -------
    list[float]
        ``[x, y, z, speed, energy]``, then ``count, active`` of each of its sensors.
    """
    robot = world.robots[index]
    values = [robot.x, robot.y, robot.z, robot.speed, robot.energy]
    for sensor in world.sensors[robot.first_sensor : robot.first_sensor + robot.n_sensors]:
        values += (float(sensor.count), float(sensor.active))
    return values


def take_true_values(world: State, index: int, values: object) -> None:
    """Make a state agree with what ``true_values`` said of a robot.

    Raises
    ------
    ProtocolError
        If the values do not fit the robot.
    """
    robot = world.robots[index]
    expected = 5 + 2 * robot.n_sensors
    if (
        not isinstance(values, list)
        or len(values) != expected
        or not all(isinstance(value, int | float) for value in values)
    ):
        raise ProtocolError(
            f"the true state of robot {index} is {values!r}; expected {expected} numbers: "
            "x, y, z, speed, energy, then count and active of each of its sensors"
        )
    robot.x, robot.y, robot.z, robot.speed, robot.energy = (float(value) for value in values[:5])
    for offset in range(robot.n_sensors):
        sensor = world.sensors[robot.first_sensor + offset]
        sensor.count = int(values[5 + 2 * offset])
        sensor.active = int(values[6 + 2 * offset])
