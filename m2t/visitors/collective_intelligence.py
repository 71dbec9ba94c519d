"""Visitor of ``collective_intelligence.py``: one check and one reaction per goal."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from m2t.metamodels import base_class
from m2t.naming import constant, identifier, snake_case
from m2t.visitors.base import ModelVisitor
from m2t.visitors.topics import robot_views

_MAX_MEMBERS = 8


@dataclass(frozen=True, slots=True)
class ConstantView:
    """A constant that names the index of a model element; ``remark`` is a display name."""

    name: str
    index: int
    remark: str = ""


@dataclass(frozen=True, slots=True)
class GoalView:
    """A goal: its identifier and constant, task class and function stem, and its members."""

    name: str
    constant: str
    task: str
    function: str
    members: str

    @property
    def check_region(self) -> str:
        """Region ID, built from the goal's ID, so that renaming or reordering keeps code."""
        return f"{self.name}.check"

    @property
    def react_region(self) -> str:
        """Region ID of the reaction."""
        return f"{self.name}.react"


class CollectiveIntelligenceVisitor(ModelVisitor):
    """Collect the goals of a mission, and constants for what their code refers to."""

    template = "collective_intelligence.py.j2"
    target = PurePosixPath("collective_intelligence.py")

    def visit_Mission(self, mission: Any) -> Mapping[str, Any]:
        """Return the template context of one mission."""
        goals = tuple(self.visit(goal) for goal in mission.goals)
        robots = robot_views(mission)
        return {
            "goals": goals,
            "constants": (
                *(ConstantView(goal.constant, index) for index, goal in enumerate(goals)),
                *(
                    ConstantView(robot.constant, robot.index, robot.display_name)
                    for robot in robots
                ),
                *(
                    ConstantView(sensor.constant, sensor.index)
                    for robot in robots
                    for sensor in robot.sensors
                ),
                *(
                    ConstantView(constant(obstacle.ID), index)
                    for index, obstacle in enumerate(mission.obstacles)
                ),
            ),
        }

    def visit_Goal(self, goal: Any) -> GoalView:
        """Return what the template needs to know about one goal."""
        task = base_class(goal.task.eClass).name
        return GoalView(
            name=identifier(goal.ID),
            constant=constant(goal.ID),
            task=task,
            function=snake_case(task),
            members=_listed([identifier(member.ID) for member in goal.members]),
        )


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:_MAX_MEMBERS])
    more = len(names) - _MAX_MEMBERS
    return f"{shown} and {more} more" if more > 0 else shown
