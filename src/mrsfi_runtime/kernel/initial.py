"""Lays a mission out as the records that the kernel works on."""

from mrsfi_runtime.kernel.commands import SPEED_LIMIT
from mrsfi_runtime.kernel.directions import DIRECTIONS, N_DIRECTIONS
from mrsfi_runtime.kernel.goal_tasks.avoid_collision import AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.clearance import LOOK_AHEAD, MARGIN
from mrsfi_runtime.kernel.goal_tasks.table import number
from mrsfi_runtime.kernel.neighbours import n_buckets, stride
from mrsfi_runtime.kernel.obstacles import SIDE, Survey, drawn
from mrsfi_runtime.kernel.randomness import PURPOSE_HEADING, choice, seed_key
from mrsfi_runtime.kernel.state import (
    ChartedState,
    CommandState,
    GoalState,
    LookupState,
    MapState,
    MemberState,
    MissionState,
    ObstacleState,
    PointState,
    RobotState,
    SensorState,
    State,
    SwitchState,
)
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Area, Coordinates, Goal, Mission

CHANCE_PRECISION = 2**32


def sample_chances(n: int) -> tuple[int, ...]:
    """Return the cumulative chances of 0, 1, 2 … valid samples, in units of 2**-32.

    Each of ``n`` samples of a tick is valid with chance ``1 / n``, so their number is
    binomial; one draw against these bounds replaces ``n`` draws. The list ends where the
    rest is below the precision of a draw.
    """
    if n == 1:
        return (0,)
    bounds: list[int] = []
    chance = (1.0 - 1.0 / n) ** n
    total = 0.0
    for k in range(n):
        total += chance
        bound = round(total * CHANCE_PRECISION)
        if bound >= CHANCE_PRECISION:
            break
        bounds.append(bound)
        chance *= (n - k) / ((k + 1) * (n - 1))
    return tuple(bounds)


def initial_state(mission: Mission, seed: int) -> State:
    """Return the state of a mission before its first tick.

    Parameters
    ----------
    mission
        The mission.
    seed
        Mission seed, a non-negative integer: decides the first headings, the samples drawn,
        the reference behaviour's choices and the values of random faults.

    Notes
    -----
    A sensor is active from the start. Headings are drawn per robot from the table of
    directions. A robot's speed before the first motion is 0.
    """
    key = seed_key(seed)
    state = State(
        mission=MissionState(
            seed=key,
            tick=0,
            duration=mission.duration,
            x=float(mission.area.center.x),
            y=float(mission.area.center.y),
            radius=float(mission.area.radius),
        ),
        robots=[],
        sensors=[],
        obstacles=[_obstacle(obstacle.area) for obstacle in mission.obstacles],
        goals=[],
        members=[],
        hazards=[],
        waypoints=[],
        chances=(),
        directions=DIRECTIONS,
        commands=[],
        switches=[],
        map=MapState(0.0, 0.0, 1.0, 0.0, 0),
        cells=(),
        mapped=(),
        lookup=LookupState(1.0, 0, 0, [], [], [], [0] * len(mission.robots)),
    )
    all_chances: list[int] = []
    for index, robot in enumerate(mission.robots):
        gps = [k for k, sensor in enumerate(robot.sensors) if sensor.type == "GPS_POSITION"]
        state.robots.append(
            RobotState(
                x=float(robot.position.x),
                y=float(robot.position.y),
                z=float(robot.position.z),
                speed=0.0,
                energy=float(robot.total_energy),
                nominal_speed=float(robot.speed),
                energy_per_distance=float(robot.energy_per_distance_unit),
                first_sensor=len(state.sensors),
                n_sensors=len(robot.sensors),
                gps=len(state.sensors) + gps[0] if gps else -1,
            )
        )
        heading = state.directions[choice(N_DIRECTIONS, key, 0, index, PURPOSE_HEADING)]
        state.commands.append(
            CommandState(
                heading_x=heading.x,
                heading_y=heading.y,
                speed=float(robot.speed),
                heading_claimed=0,
                speed_claimed=0,
            )
        )
        for sensor in robot.sensors:
            chances = sample_chances(sensor.samples_per_second)
            state.sensors.append(
                SensorState(
                    robot=index,
                    count=0,
                    active=1,
                    rate=float(sensor.samples_per_second),
                    cost=float(sensor.energy_per_sample),
                    nominal_rate=float(sensor.samples_per_second),
                    nominal_cost=float(sensor.energy_per_sample),
                    first_chance=len(all_chances),
                    n_chances=len(chances),
                )
            )
            all_chances += chances
            state.switches.append(SwitchState(active=1, claimed=0))
    state.chances = tuple(all_chances)
    for goal in mission.goals:
        _add_goal(state, mission, goal)
    _draw_map(state, mission)
    _make_room(state, mission)
    return state


def _draw_map(state: State, mission: Mission) -> None:
    """Draw the map of the mission area; it reaches as far as any reaction looks ahead."""
    fastest = SPEED_LIMIT * max((robot.nominal_speed for robot in state.robots), default=0.0)
    area = mission.area
    survey = Survey(
        left=(float(area.center.x) - area.radius, float(area.center.y) - area.radius),
        cells_per_unit=SIDE / max(2.0 * area.radius, 1.0),
        reach=MARGIN + LOOK_AHEAD * fastest + ROBOT_RADIUS,
        obstacles=tuple((each.model_x, each.model_y, each.radius) for each in state.obstacles),
    )
    state.map = MapState(*survey.left, survey.cells_per_unit, survey.reach, 0)
    state.cells, state.mapped = drawn(survey)


def _make_room(state: State, mission: Mission) -> None:
    """Make room for the grid of the AvoidCollision goal with the most robots."""
    wanted = [
        len(goal.terms.robots) for goal in mission.goals if isinstance(goal.task, AvoidCollision)
    ]
    buckets = n_buckets(max(wanted, default=0))
    if buckets:
        lookup = state.lookup
        lookup.n_buckets, lookup.stride = buckets, stride(buckets)
        lookup.heads = [0] * (buckets + 1)
        lookup.buckets = [0] * max(wanted)
        lookup.charted = [ChartedState(0, 0.0, 0.0) for _ in range(max(wanted))]


def _obstacle(area: Area) -> ObstacleState:
    x, y = float(area.center.x), float(area.center.y)
    return ObstacleState(x=x, y=y, radius=float(area.radius), model_x=x, model_y=y)


def _add_goal(state: State, mission: Mission, goal: Goal) -> None:
    terms = goal.terms
    area = terms.area or goal.area or Area(goal.id, Coordinates(), 0.0)
    state.goals.append(
        GoalState(
            task=number(goal.task),
            x=float(area.center.x),
            y=float(area.center.y),
            radius=float(area.radius),
            first_member=len(state.members),
            n_members=len(terms.robots),
            first_hazard=len(state.hazards),
            n_hazards=len(terms.obstacles),
            first_waypoint=len(state.waypoints),
            n_waypoints=len(terms.waypoints),
            sensor=-1 if terms.sensor is None else mission.sensor_index[terms.sensor],
            target=terms.target,
            tolerance=float(terms.tolerance),
            distance=float(terms.distance),
            period=terms.period,
            deadline=terms.deadline,
            count=0,
            seen=0,
            sampled_x=0.0,
            sampled_y=0.0,
        )
    )
    state.members.extend(
        MemberState(robot=mission.robot_index[robot], since=-1, reached=0, waypoint=0)
        for robot in terms.robots
    )
    state.hazards.extend(mission.obstacle_index[obstacle] for obstacle in terms.obstacles)
    state.waypoints.extend(PointState(float(p.x), float(p.y)) for p in terms.waypoints)
