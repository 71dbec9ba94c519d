"""How the reference collective intelligence guides a robot: to a point, or about inside an area."""

from mrsfi_runtime.kernel.commands import set_speed, steer
from mrsfi_runtime.kernel.geometry import distance, inside, well_in_area
from mrsfi_runtime.kernel.randomness import PURPOSE_ROAM, choice
from mrsfi_runtime.kernel.state import AreaState, GoalState, State, kernel

ROAM_ATTEMPTS = 8  # headings that a roaming robot draws before it turns to the middle of its area


@kernel
def pace(ci: State, index: int) -> float:
    """Return the distance that a robot may move in a tick, by its command and nominal speed."""
    return max(ci.commands[index].speed, ci.robots[index].nominal_speed)


@kernel
def leeway(ci: State, index: int) -> float:
    """Return how far from an edge a robot has to turn back, as it turns slowly and is misplaced.

    If it turns at once and reports its exact position, that is 0. Otherwise it flies straight on
    for a tick, then along its turning circle; it is within its noise of where it says, and says it
    within its noise.
    """
    trait = ci.traits[index]
    reserve = 2.0 * trait.position_noise
    if trait.turn_y != 0.0:
        reserve += pace(ci, index) * (trait.turn_width + 0.5)
    return reserve


@kernel
def berth(ci: State, index: int) -> float:
    """Return by how much wider a robot counts, as it turns slowly and reports inexactly.

    It is its noise, and by how much its turning circle is wider than that of one that turns at
    once, in radius.
    """
    trait = ci.traits[index]
    return trait.position_noise + 0.5 * pace(ci, index) * (trait.turn_width - 1.0)


@kernel
def approach(ci: State, index: int, x: float, y: float) -> None:
    """Head for a point at nominal speed, slower only where its turning circle might miss it.

    For a robot that turns at once, that is the last step.
    """
    robot = ci.robots[index]
    steer(ci, index, x - robot.x, y - robot.y)
    slow = distance(robot.x, robot.y, x, y) / ci.traits[index].turn_width
    set_speed(ci, index, min(robot.nominal_speed, slow))


@kernel
def is_surely_at(ci: State, index: int, x: float, y: float, tolerance: float) -> bool:
    """Return whether a robot is within tolerance of a point, wherever its noise has it.

    If its noise is more than half the tolerance, it is within half the tolerance by belief.
    """
    robot = ci.robots[index]
    reach = max(tolerance - ci.traits[index].position_noise, 0.5 * tolerance)
    return inside(robot.x, robot.y, x, y, reach)


@kernel
def roam(ci: State, goal: GoalState, index: int) -> None:
    """Head for a goal's area from outside; inside, turn to a random heading before leaving it."""
    roam_in(ci, ci.areas[ci.routes[goal.first_member].first_area], index)


@kernel
def roam_in(ci: State, area: AreaState, index: int) -> None:
    """Head for an area from outside; inside, turn to a random heading before leaving it."""
    robot, edge = ci.robots[index], leeway(ci, index)
    if not well_in_area(ci, area, robot.x, robot.y, edge):
        steer(ci, index, area.x - robot.x, area.y - robot.y)
        return
    step = pace(ci, index)
    command = ci.commands[index]
    x, y = robot.x + step * command.heading_x, robot.y + step * command.heading_y
    if well_in_area(ci, area, x, y, edge):
        return
    mission = ci.mission
    for attempt in range(ROAM_ATTEMPTS):
        entity = index * ROAM_ATTEMPTS + attempt
        degrees = choice(len(ci.directions), mission.seed, mission.tick, entity, PURPOSE_ROAM)
        turn = ci.directions[degrees]
        x, y = robot.x + 2.0 * step * turn.x, robot.y + 2.0 * step * turn.y
        if well_in_area(ci, area, x, y, edge):
            steer(ci, index, turn.x, turn.y)
            return
    steer(ci, index, area.x - robot.x, area.y - robot.y)
