"""Lays a mission out as the records that the kernel works on."""

import math

from mrsfi_runtime.kernel.goal_tasks.avoid_collision import LOOK_AHEAD, MARGIN, AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.table import number
from mrsfi_runtime.kernel.neighbours import LISTED, STRAYS, n_buckets, stride
from mrsfi_runtime.kernel.obstacles import mapped
from mrsfi_runtime.kernel.randomness import PURPOSE_HEADING, choice, seed_key
from mrsfi_runtime.kernel.samples import sample_chances
from mrsfi_runtime.kernel.state import (
    ChartedState,
    CommandState,
    DirectionState,
    GoalState,
    LookupState,
    MemberState,
    MissionState,
    ObstacleState,
    PointState,
    RobotState,
    SensorState,
    State,
    SwitchState,
    TraitState,
)
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Area, Coordinates, Goal, Mission, Robot

DIRECTIONS = tuple(
    DirectionState(math.cos(angle), math.sin(angle)) for angle in map(math.radians, range(360))
)
"""All trigonometry of the kernel, but for turn rates.

A table reads the same in the interpreter and in compiled code, where ``math.sin`` need not.
States carry it, because a compiler would copy a constant tuple at every use.
"""


def initial_state(mission: Mission, seed: int) -> State:
    """Return the state of a mission before its first tick.

    The mission seed, a non-negative integer, decides the first headings, the samples drawn, the
    reference behaviour's choices and the values of random faults.

    Notes
    -----
    A sensor is active from the start. Headings are drawn per robot from the table of
    directions. A robot's speed before the first motion is its nominal one, as if that had been
    reported. The map reaches as far as any reaction looks ahead.
    """
    area = mission.area
    fastest = max((robot.fastest for robot in mission.robots), default=0.0)
    map_, cells, shown = mapped(
        area, mission.obstacles, MARGIN + 3.0 * LOOK_AHEAD * fastest + ROBOT_RADIUS
    )
    state = State(
        mission=MissionState(
            seed=seed_key(seed),
            tick=0,
            duration=mission.duration,
            x=float(area.center.x),
            y=float(area.center.y),
            radius=float(area.radius),
        ),
        obstacles=[_obstacle(obstacle.area) for obstacle in mission.obstacles],
        traits=tuple(map(_traits, mission.robots)),
        directions=DIRECTIONS,
        map=map_,
        cells=cells,
        mapped=shown,
        lookup=_lookup(mission),
    )
    for robot in mission.robots:
        _add_robot(state, robot)
    for goal in mission.goals:
        _add_goal(state, mission, goal)
    return state


def _lookup(mission: Mission) -> LookupState:
    """Return room for the grid of the AvoidCollision goal with the most robots."""
    most = max(
        (len(goal.terms.robots) for goal in mission.goals if isinstance(goal.task, AvoidCollision)),
        default=0,
    )
    buckets = n_buckets(most)
    n_charted = most if buckets else 0
    n_robots = len(mission.robots)
    return LookupState(
        n_buckets=buckets,
        stride=stride(buckets),
        heads=[0] * (buckets + 1),
        buckets=[0] * n_charted,
        charted=[ChartedState(0, 0.0, 0.0) for _ in range(n_charted)],
        nearby=[0] * n_robots,
        strays=[0] * STRAYS,
        first_listed=[0] * n_robots,
        n_listed=[0] * n_robots,
        listed=[0] * (LISTED * n_charted),
    )


def _add_robot(state: State, robot: Robot) -> None:
    index = len(state.robots)
    first = len(state.sensors)
    gps = [k for k, sensor in enumerate(robot.sensors, first) if sensor.type == "GPS_POSITION"]
    state.robots.append(
        RobotState(
            x=float(robot.position.x),
            y=float(robot.position.y),
            z=float(robot.position.z),
            speed=float(robot.speed),
            energy=float(robot.total_energy),
            nominal_speed=float(robot.speed),
            max_speed=float(robot.fastest),
            energy_per_distance=float(robot.energy_per_distance_unit),
            first_sensor=first,
            n_sensors=len(robot.sensors),
            gps=gps[0] if gps else -1,
        )
    )
    heading = DIRECTIONS[choice(len(DIRECTIONS), state.mission.seed, 0, index, PURPOSE_HEADING)]
    speed = float(robot.speed)
    state.commands.append(CommandState(heading.x, heading.y, speed, speed, 0, 0))
    for sensor in robot.sensors:
        chances = sample_chances(sensor.samples_per_second)
        rate, cost = float(sensor.samples_per_second), float(sensor.energy_per_sample)
        state.sensors.append(
            SensorState(
                robot=index,
                count=0,
                active=1,
                rate=rate,
                cost=cost,
                nominal_rate=rate,
                nominal_cost=cost,
                first_chance=len(state.chances),
                n_chances=len(chances),
            )
        )
        state.chances += chances
        state.switches.append(SwitchState(active=1, claimed=0))


def _traits(robot: Robot) -> TraitState:
    turn = math.radians(robot.turn_rate)
    turn_y = math.sin(turn) if robot.turn_rate < 180.0 else 0.0  # no last bit is left of it
    return TraitState(math.cos(turn), turn_y, float(robot.position_noise))


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
            n_waypoints=len(terms.trajectory),
            sensor=-1 if terms.sensor is None else mission.sensor_index[terms.sensor],
            target=terms.target_sample_number,
            tolerance=float(terms.tolerance),
            distance=float(terms.fixed_distance),
            period=terms.period,
            deadline=terms.deadline,
        )
    )
    state.members.extend(MemberState(mission.robot_index[robot]) for robot in terms.robots)
    state.hazards.extend(mission.obstacle_index[obstacle] for obstacle in terms.obstacles)
    state.waypoints.extend(PointState(float(p.x), float(p.y)) for p in terms.trajectory)
