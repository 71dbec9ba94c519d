"""Forecasts to the end of a mission: ticks left, energy spent, samples gathered."""

from mrsfi_runtime.kernel.state import GoalState, State, excess, kernel


@kernel
def ticks_left(view: State) -> int:
    """Return how many ticks follow the present one."""
    return view.mission.duration - 1 - view.mission.tick


@kernel
def sensor_power(view: State, index: int) -> float:
    """Return the energy that a robot's active sensors spend in a tick, in the given state."""
    robot = view.robots[index]
    power = 0.0
    for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
        sensor = view.sensors[k]
        if sensor.active == 1:
            power += sensor.rate * sensor.cost
    return power


@kernel
def endurance(view: State, index: int) -> int:
    """Return for how many ticks a robot's energy lasts whatever it does, at least 1."""
    robot = view.robots[index]
    power = robot.max_speed * robot.energy_per_distance
    for k in range(robot.first_sensor, robot.first_sensor + robot.n_sensors):
        power += view.sensors[k].nominal_rate * view.sensors[k].nominal_cost
    if robot.energy >= view.mission.duration * power:
        return view.mission.duration
    return max(int(robot.energy / power), 1)


@kernel
def energy_reserve(view: State, index: int) -> float:
    """Return the energy that a robot has beyond its forecast need; negative if it lacks some.

    The forecast assumes the present speed, sensor rates and costs for all ticks left.
    """
    robot = view.robots[index]
    power = robot.speed * robot.energy_per_distance + sensor_power(view, index)
    return excess(robot.energy, ticks_left(view) * power)


@kernel
def sample_reserve(view: State, goal: GoalState) -> float:
    """Return the samples that a goal's forecast has beyond its target; negative if it lacks some.

    The forecast is one valid sample per tick, scaled by believed over nominal rate.
    """
    sensor = view.sensors[goal.sensor]
    expected = goal.count + ticks_left(view) * (sensor.rate / sensor.nominal_rate)
    return excess(expected, float(goal.target))
