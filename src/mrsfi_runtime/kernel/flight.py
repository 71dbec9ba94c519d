"""One flight of a mission, tick by tick, written once for every engine.

A flight begins with the first commands (``issue``), which faults may forge. Every tick then moves
the robots (``move``), sends their messages (``send``), and lets the collective intelligence answer
(``hear``, react, ``reply``). Over a bus, the simulation on the bus moves and sends. A user-defined
node that is the collective intelligence runs between ``hear`` and ``reply``.

Invariant: a mission, its seed and a plan of faults determine a flight. The number of valid samples
of each sensor depends only on the mission seed, so it is drawn once for all flights of a seed
(``valid_samples``).

Begin with ``answer``. ``initial_state`` before it turns a mission into records; ``count`` and
``measure`` after it keep the verdicts.

References
----------
Source paper, Figure 4. Its three unsynchronised threads (section V-D b) are one loop here.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, TypeAlias, get_type_hints

from mrsfi_runtime.kernel.commands import release
from mrsfi_runtime.kernel.effects import Orders, arm, deliver, disturb, falsify, issue
from mrsfi_runtime.kernel.forecast import ticks_left
from mrsfi_runtime.kernel.goal_tasks.avoid_collision import LOOK_AHEAD, AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN
from mrsfi_runtime.kernel.goal_tasks.table import (
    AVOID,
    LASTING,
    is_forecast,
    is_missed,
    margin,
    number,
)
from mrsfi_runtime.kernel.injections import OwnEffect, Plan
from mrsfi_runtime.kernel.neighbours import LISTED, STRAYS, mapped, n_buckets, stride
from mrsfi_runtime.kernel.randomness import PURPOSE_HEADING, PURPOSE_SAMPLES, choice, draw, seed_key
from mrsfi_runtime.kernel.state import (
    AreaState,
    ChartedState,
    CommandState,
    DirectionState,
    GapState,
    GoalState,
    GraceState,
    HeardState,
    LookupState,
    MemberState,
    MissionState,
    ObstacleState,
    PointState,
    RobotState,
    RouteState,
    ScopeState,
    SensorState,
    State,
    SwitchState,
    TraitState,
    WakeState,
    WishState,
    kernel,
)
from mrsfi_runtime.model.mission import Area, Coordinates, Goal, Mission, Robot, turn_width
from mrsfi_runtime.model.polygons import off_polygon

Corners: TypeAlias = tuple[PointState, ...]

Samples: TypeAlias = tuple[bytes, ...]
"""Valid samples of each sensor, one row per tick, each below 256; ``commands.move`` adds them."""


def sample_chances(n: int) -> tuple[int, ...]:
    """Return the cumulative chances of 0, 1, 2 … valid samples, in units of 2**-32.

    Each of the ``n`` samples of a tick is valid with probability ``1 / n``, so their number is
    binomial; one draw against these bounds replaces ``n`` draws. The list ends where the rest
    is below the precision of a draw.
    """
    if n == 1:
        return (0,)
    bounds: list[int] = []
    chance = (1.0 - 1.0 / n) ** n
    total = 0.0
    for k in range(n):
        total += chance
        bound = round(total * 2**32)
        if bound >= 2**32:
            break
        bounds.append(bound)
        chance *= (n - k) / ((k + 1) * (n - 1))
    return tuple(bounds)


def reached(state: State) -> Iterator[tuple[int, ...]]:
    """Yield the cumulative chances of each sensor; as many samples are valid as a draw reaches."""
    for sensor in state.sensors:
        yield state.chances[sensor.first_chance : sensor.first_chance + sensor.n_chances]


def valid_samples(state: State) -> Samples:
    """Return the valid samples of a mission and seed, from a state before its first tick.

    It needs no numpy, whose import takes longer; ``engine.compiled.layout.sample_table`` draws
    the same for many robots at once.
    """
    return _drawn(state.mission.seed, state.mission.duration, tuple(reached(state)))


@lru_cache(maxsize=8)
def _drawn(seed: int, duration: int, chances: tuple[tuple[int, ...], ...]) -> Samples:
    return tuple(
        bytes(
            bisect_right(bounds, draw(seed, tick, sensor, PURPOSE_SAMPLES))
            for sensor, bounds in enumerate(chances)
        )
        for tick in range(duration)
    )


DIRECTIONS = tuple(
    DirectionState(math.cos(angle), math.sin(angle)) for angle in map(math.radians, range(360))
)
"""Unit vectors of whole degrees: all trigonometry of the kernel, except turn rates.

A table is identical in the interpreter and in compiled code; ``math.sin`` may differ. States hold
it, because a compiler would copy a constant tuple at every use.
"""


def initial_state(mission: Mission, seed: int) -> State:
    """Return the state of a mission before its first tick.

    The mission seed, a non-negative integer, decides the first headings, the samples drawn, the
    reference behaviour's choices and the values of random faults.

    Notes
    -----
    Sensors are active from the start. The heading of each robot is drawn from the table of
    directions. A robot's speed before its first motion is its nominal one. The map reaches as
    far as any reaction looks ahead.
    """
    area = mission.area
    corners = tuple(
        PointState(float(x), float(y)) for each in mission.polygons for x, y in each.offsets
    )
    fastest = max((robot.fastest for robot in mission.robots), default=0.0)
    widest = max((robot.radius for robot in mission.robots), default=0.0)
    clearance = max((goal.terms.clearance for goal in mission.goals), default=0.0)
    map_, cells, shown = mapped(
        area, mission.obstacles, widest + 3.0 * LOOK_AHEAD * fastest + (widest + clearance)
    )
    outlines = tuple(_area(mission, corners, each.area) for each in mission.obstacles)
    state = State(
        mission=MissionState(
            seed=seed_key(seed),
            tick=0,
            duration=mission.duration,
            x=float(area.center.x),
            y=float(area.center.y),
            radius=float(area.radius),
        ),
        obstacles=[ObstacleState(at.x, at.y, at.radius, at.x, at.y) for at in outlines],
        traits=tuple(map(_traits, mission.robots)),
        directions=DIRECTIONS,
        outlines=outlines,
        corners=corners,
        map=map_,
        cells=cells,
        mapped=shown,
        lookup=_lookup(mission),
    )
    for robot in mission.robots:
        _add_robot(state, robot)
    for own, trait in zip(state.robots, state.traits, strict=True):
        state.wakes.append(WakeState(own.x, own.y, own.max_speed + 2.0 * trait.position_noise))
    state.wakes += [WakeState(rock.x, rock.y) for rock in state.obstacles]
    for goal in mission.goals:
        _add_goal(state, mission, goal)
    state.wishes = [WishState() for _ in state.robots]
    state.gaps = [GapState() for _ in state.goals]
    state.heard = [HeardState(own.x, own.y, own.z, own.speed, own.energy) for own in state.robots]
    state.heard += [HeardState() for _ in state.sensors]
    state.heard += [HeardState(rock.x, rock.y) for rock in state.obstacles]
    if any(robot.position_noise for robot in mission.robots):
        state.aims = [0] * len(state.members)
    if any(goal.grace for goal in mission.goals):
        for each, goal in zip(state.goals, mission.goals, strict=True):
            is_lasting = goal.grace > 0 and each.task in LASTING
            state.grace.append(GraceState(goal.grace, len(state.latest) if is_lasting else -1))
            state.latest += [NO_MARGIN] * ((goal.grace + 2) * is_lasting)
    return state


def _lookup(mission: Mission) -> LookupState:
    """Return scratch space for the grid of the AvoidCollision goal with the most robots."""
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


def _scope(robot: Robot, clearance: float) -> ScopeState:
    """Return the scope of a member; a tick more than the look-ahead exceeds rounding errors."""
    trait = _traits(robot)
    step = float(robot.fastest) + 2.0 * trait.position_noise
    berth = trait.position_noise + 0.5 * step * (trait.turn_width - 1.0)
    return ScopeState((LOOK_AHEAD + 1) * step + 2.0 * trait.radius + berth + clearance, step)


def _traits(robot: Robot) -> TraitState:
    turn = math.radians(robot.turn_rate)
    turn_y = math.sin(turn) if robot.turn_rate < 180.0 else 0.0  # exactly 0, which sin(pi) is not
    width = turn_width(robot.turn_rate) if turn_y else 1.0
    noise, radius = float(robot.position_noise), float(robot.radius)
    return TraitState(math.cos(turn), turn_y, width, noise, radius)


def _area(mission: Mission, corners: Corners, area: Area, tolerance: float = 0.0) -> AreaState:
    x, y, radius = float(area.center.x), float(area.center.y), float(area.radius)
    if not area.corners:
        return AreaState(x, y, radius + float(tolerance), 0, 0, 0.0)
    first, n = mission.polygons[area], len(area.corners)
    return AreaState(x, y, radius, first, n, -off_polygon(corners, first, n, 0.0, 0.0))


def _add_goal(state: State, mission: Mission, goal: Goal) -> None:
    terms = goal.terms
    areas = terms.areas or (goal.area or Area(goal.id, Coordinates(), 0.0),)
    area = areas[0]
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
            distance=float(terms.fixed_distance or terms.clearance),
            period=terms.period,
            deadline=terms.deadline,
        )
    )
    state.required += (goal.required_members or len(terms.robots),)
    members = [mission.robots[mission.robot_index[robot]] for robot in terms.robots]
    radii = [float(robot.radius) for robot in members]
    state.apart += (2.0 * max(radii, default=0.0) + float(terms.clearance),)
    reaches = [state.wakes[mission.robot_index[robot]].reach for robot in terms.robots]
    state.longest += (max(reaches, default=0.0),)
    state.routes += (RouteState(len(state.areas), len(areas)),) * len(terms.robots)
    state.areas += tuple(_area(mission, state.corners, each, terms.tolerance) for each in areas)
    state.scopes += tuple(_scope(robot, float(terms.clearance)) for robot in members)
    state.members.extend(MemberState(mission.robot_index[robot]) for robot in terms.robots)
    state.hazards.extend(mission.obstacle_index[obstacle] for obstacle in terms.obstacles)
    state.waypoints.extend(PointState(float(p.x), float(p.y)) for p in terms.trajectory)


class MissionFunctions(NamedTuple):
    """Functions of a mission's generated code that a flight calls, for all goals in model order.

    ``progress`` updates the goals to the tick of a state. ``check`` writes 1 for every goal that is
    violated in it, else 0. ``react`` lets every goal command its members; the first goal to claim a
    channel keeps it. ``apply`` applies a fault of a user-defined type.
    """

    progress: Callable[[State], None]
    check: Callable[[State, list[int]], None]
    react: Callable[[State], None]
    apply: OwnEffect


@dataclass(slots=True)
class Verdicts:
    """Goals violated at the present tick (0 or 1), and counts of ticks so far.

    Each list has an entry for each goal. ``phantom`` violations were believed but not true,
    ``masked`` ones true but not believed. ``missed`` counts from the tick at which the goal can no
    longer be met. ``broken`` counts from the first tick at which the goal is truly violated or
    missed, ``undetected`` from that tick until the belief first shows a violation.

    ``margin`` is the least margin of the goal in truth, and ``nearest`` its tick. ``due`` is the
    next tick at which the margin can be less, or at which the goal can be missed without a
    violation.
    """

    is_true: list[int]
    is_believed: list[int]
    believed: list[int]
    true: list[int]
    phantom: list[int]
    masked: list[int]
    missed: list[int]
    broken: list[int]
    undetected: list[int]
    margin: list[float]
    nearest: list[int]
    due: list[int]


def no_verdicts(n_goals: int) -> Verdicts:
    """Return verdicts before the first tick."""
    counts = {name: [0] * n_goals for name in get_type_hints(Verdicts) if name != "margin"}
    return Verdicts(**counts, margin=[0.0] * n_goals)


@kernel
def answer(
    functions: MissionFunctions,
    world: State,
    ci: State,
    inbox: State,
    orders: Orders | State,
    plan: Plan,
    verdicts: Verdicts,
    tick: int,
) -> None:
    """Complete a tick after the robots have moved and their messages have arrived.

    ``inbox`` has the newest message of every topic. ``orders`` receive the commands for the motion
    of the next tick, ``verdicts`` the violations of this one.
    """
    hear(functions, world, ci, inbox, plan, verdicts, tick)
    functions.react(ci)
    reply(world, ci, orders, plan, verdicts, tick)


@kernel
def hear(
    functions: MissionFunctions,
    world: State,
    ci: State,
    inbox: State,
    plan: Plan,
    verdicts: Verdicts,
    tick: int,
) -> None:
    """Check the goals in truth, turn the tick's messages into belief, and check the goals there.

    Faults triggered at this tick begin at the next one, with the commands that are issued now.
    """
    judge(functions, world, verdicts.is_true)
    perceive(functions, ci, inbox, plan, tick)
    judge(functions, ci, verdicts.is_believed)
    if len(plan.triggers) > 0:
        arm(world, plan, verdicts.is_true, tick)


@kernel
def reply(
    world: State, ci: State, orders: Orders | State, plan: Plan, verdicts: Verdicts, tick: int
) -> None:
    """Issue the commands after the reactions of a tick, and count its violations."""
    issue(ci, orders, plan, tick + 1)
    count(verdicts, world)


@kernel
def perceive(functions: MissionFunctions, ci: State, inbox: State, plan: Plan, tick: int) -> None:
    """Turn the messages of a tick into belief: delivery, then faults; then free all channels.

    References
    ----------
    Source paper, Figure 4: ``updateSystemState`` and ``executeFaults``.
    """
    ci.mission.tick = tick
    deliver(ci, inbox, plan)
    falsify(ci, plan)
    disturb(functions.apply, ci, inbox, plan)
    release(ci)


@kernel
def judge(functions: MissionFunctions, view: State, violated: list[int]) -> None:
    """Update the progress of all goals, then check which are violated in a state.

    A goal is violated while its rule is broken, and was at each of the ticks of its grace before.
    """
    functions.progress(view)
    functions.check(view, violated)
    for goal in range(len(view.grace)):
        grace = view.grace[goal]
        grace.n_broken = grace.n_broken + 1 if violated[goal] == 1 else 0
        violated[goal] = 1 if grace.n_broken > grace.n_ticks else 0


@kernel
def count(verdicts: Verdicts, world: State) -> None:
    """Count the violations of a tick, once per goal, and the tick of each missed goal.

    Margins, and goals missed without a violation, are checked only when they can change. Of most
    goals nothing changes at most ticks: one that was ever missed is broken, too.
    """
    tick = world.mission.tick
    for goal in range(len(verdicts.is_true)):
        true = verdicts.is_true[goal]
        believed = verdicts.is_believed[goal]
        is_due = tick >= verdicts.due[goal]
        if not (true or believed or is_due or verdicts.broken[goal] > 0):
            continue
        if true or believed:
            verdicts.true[goal] += true
            verdicts.believed[goal] += believed
            verdicts.phantom[goal] += believed and not true
            verdicts.masked[goal] += true and not believed
        if verdicts.missed[goal] > 0 or ((true or is_due) and is_missed(world, goal, true)):
            verdicts.missed[goal] += 1
            true = 1
        if true or verdicts.broken[goal] > 0:
            is_hidden = not believed and verdicts.undetected[goal] == verdicts.broken[goal]
            verdicts.undetected[goal] += is_hidden
            verdicts.broken[goal] += 1
        if is_due:
            measure(verdicts, world, goal)


@kernel
def measure(verdicts: Verdicts, world: State, goal: int) -> None:
    """Record a goal's margin if it is the least so far; of a violated goal, only below 0.

    The last tick is always checked, unless no violation can be nearer. Of AvoidCollision, no margin
    is below 0 without a violation.
    """
    tick, task = world.mission.tick, world.goals[goal].task
    least = NO_MARGIN if verdicts.due[goal] == 0 else verdicts.margin[goal]
    is_lasting = len(world.grace) > 0 and world.grace[goal].first >= 0
    if task == AVOID and least <= 0.0 and verdicts.is_true[goal] == 0 and not is_lasting:
        return
    left, wait = margin(world, goal, task, least)
    if is_lasting:
        left, wait = lasting(world, world.grace[goal], left), 1
    is_nearer = left < least and (left < 0.0 or verdicts.true[goal] == verdicts.is_true[goal])
    if is_nearer or verdicts.due[goal] == 0:
        verdicts.margin[goal] = left
        verdicts.nearest[goal] = tick
    world.gaps[goal].limit = max(verdicts.margin[goal], 0.0)
    is_over = verdicts.true[goal] > 0 and verdicts.missed[goal] > 0 and is_forecast(task)
    verdicts.due[goal] = NEVER if is_over else tick + min(wait, max(ticks_left(world), 1))


@kernel
def lasting(world: State, grace: GraceState, left: float) -> float:
    """Return the greatest margin of this tick and those of the grace before; undefined until then.

    Ticks form blocks of that many. In ``world.latest``, the margins of this block precede, for each
    place in the rest of the block before, the greatest from there on; last is the greatest of this
    block.
    """
    latest = world.latest
    last = grace.first + grace.n_ticks + 1
    at = grace.first + world.mission.tick % (grace.n_ticks + 1)
    if at == grace.first:
        for place in range(last - 2, at - 1, -1):
            latest[place] = max(latest[place], latest[place + 1])
        latest[last] = left
    latest[at] = left
    latest[last] = max(latest[last], left)
    return max(latest[last], latest[at + 1])
