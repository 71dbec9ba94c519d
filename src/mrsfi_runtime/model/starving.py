"""Which goals starve, as a goal that reacts first keeps their robots somewhere else for ever.

References
----------
``docs/semantics.md``, reactions: the first goal that claims the heading of a robot has it.
"""

from math import hypot

from mrsfi_runtime.model.mission import Area, Goal, Mission, Robot, Terms


def starvation(mission: Mission, goal: Goal) -> str:
    """Say, as a sentence goes on, which goals keep robots of one elsewhere, if any do.

    So the tasks react; regions may do otherwise.
    """
    wanted = _robots(mission, goal)
    held = []
    for holder in mission.goals[: mission.goals.index(goal)]:
        area = holder.terms.area
        if holder.task.keeps_robots and area is not None and _is_elsewhere(area, goal.terms):
            kept = [each.name or each.id for each in _robots(mission, holder) if each in wanted]
            if kept:
                told = f"{mission.label_of(holder)}, which reacts first, keeps"
                held.append(f"{told} {' and '.join(kept)} in area {area.id}")
    return f"as {' and '.join(held)}" if held else ""


def _robots(mission: Mission, goal: Goal) -> list[Robot]:
    """Return the robots that a goal steers: that of its sensor, or else its members."""
    sensor = goal.terms.sensor
    if sensor is not None:
        return [mission.robots[mission.sensor_robot[mission.sensor_index[sensor]]]]
    return [mission.robots[mission.robot_index[each]] for each in goal.members]


def _is_elsewhere(area: Area, terms: Terms) -> bool:
    discs = [(point, terms.tolerance) for point in terms.trajectory]
    if terms.area is not None:
        discs.append((terms.area.center, terms.area.radius + terms.tolerance))
    return any(
        hypot(point.x - area.center.x, point.y - area.center.y) > area.radius + reach
        for point, reach in discs
    )
