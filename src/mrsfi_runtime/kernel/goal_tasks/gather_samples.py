"""GatherSamples: a sensor takes a number of samples inside the goal's area."""

from dataclasses import dataclass, replace
from typing import ClassVar

from mrsfi_runtime.kernel.commands import switch_sensor
from mrsfi_runtime.kernel.forecast import endurance, sample_reserve, ticks_left
from mrsfi_runtime.kernel.geometry import in_area
from mrsfi_runtime.kernel.goal_tasks.common import NEVER, NO_MARGIN, next_area
from mrsfi_runtime.kernel.guidance import roam_in
from mrsfi_runtime.kernel.state import State, kernel
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Goal, GoalTask, Terms


@dataclass(frozen=True, slots=True)
class GatherSamples(GoalTask):
    """Gather samples with one sensor (by ID) inside the goal's area."""

    keeps_robots: ClassVar[bool] = True
    spares: ClassVar[Range] = Range.TICKS
    target_sample_number: int
    sensor: str

    def terms(self, goal: Goal) -> Terms:
        """Return the sensor, how many samples it is to take, and where."""
        return replace(GoalTask.terms(self, goal), area=goal.area)


@kernel
def progress(view: State, g: int) -> None:
    """Count new samples: taken inside the area, and not where the sample before was taken."""
    goal = view.goals[g]
    sensor = view.sensors[goal.sensor]
    robot = view.robots[sensor.robot]
    new = max(sensor.count - goal.seen, 0)
    goal.seen = sensor.count
    if not in_area(view, next_area(view, goal.first_member), robot.x, robot.y):
        return
    if goal.count == 0 or robot.x != goal.sampled_x or robot.y != goal.sampled_y:
        goal.count += new
        goal.sampled_x = robot.x if new > 0 else goal.sampled_x
        goal.sampled_y = robot.y if new > 0 else goal.sampled_y


@kernel
def violated(view: State, g: int) -> bool:
    """Return whether a goal below its target is at risk of not reaching it.

    It is if its sensor is inactive, its robot is outside the goal's area, or the forecast is
    below the target.
    """
    goal = view.goals[g]
    if goal.count >= goal.target:
        return False
    sensor = view.sensors[goal.sensor]
    if sensor.active == 0:
        return True
    robot, area = view.robots[sensor.robot], next_area(view, goal.first_member)
    return not in_area(view, area, robot.x, robot.y) or sample_reserve(view, goal) < 0.0


@kernel
def margin(world: State, g: int, least: float) -> tuple[float, int]:
    """Return the ticks to spare when the target is reached; before that, the margin is undefined.

    The next tick to check assumes that all samples are valid (the earliest success), or that none
    are or the robot spends the most energy it can (the earliest failure).
    """
    goal = world.goals[g]
    missing = goal.target - goal.count
    if least < NO_MARGIN:
        return least, NEVER
    if missing <= 0:
        return float(ticks_left(world)), NEVER
    sensor = world.sensors[goal.sensor]
    ticks = int(missing / sensor.nominal_rate)
    return NO_MARGIN, max(
        min(ticks, ticks_left(world) - ticks - 1, endurance(world, sensor.robot)), 1
    )


@kernel
def is_out_of_reach(world: State, g: int) -> bool:
    """Return whether a goal below its target can no longer reach it.

    Its robot has no energy, or too few ticks are left even if all samples are valid.
    """
    goal = world.goals[g]
    if goal.count >= goal.target:
        return False
    sensor = world.sensors[goal.sensor]
    at_most = goal.count + ticks_left(world) * sensor.nominal_rate
    return world.robots[sensor.robot].energy <= 0.0 or at_most < goal.target


@kernel
def react(ci: State, g: int) -> None:
    """Let the robot roam in the goal's area, with its sensor on until the target is reached."""
    goal = ci.goals[g]
    sensor = ci.sensors[goal.sensor]
    switch_sensor(ci, goal.sensor, 1 if goal.count < goal.target else 0)
    roam_in(ci, next_area(ci, goal.first_member), sensor.robot)
