"""Visitor of ``collective_intelligence.py``: what each goal remembers, checks and does."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any

from m2t.elements import values
from m2t.environment import Expression
from m2t.metamodel_contract import PROGRESSING
from m2t.metamodels import base_class, is_read, slots
from m2t.naming import constant, identifier, snake_case
from m2t.visitors.base import ModelVisitor
from m2t.visitors.own_constants import OwnFeatures
from m2t.visitors.topics import robot_views
from mrsfi_runtime.errors import ModelError

if TYPE_CHECKING:
    from m2t.load import LoadedModels

_MAX_MEMBERS = 8


@dataclass(frozen=True, slots=True)
class ConstantView:
    """The index of a model element, or a value of one; ``remark`` is a display name."""

    name: str
    value: Expression
    remark: str = ""


@dataclass(frozen=True, slots=True)
class GoalView:
    """A goal: its identifier and constant, class and module of its task, and its members.

    A task of a team's own has no module: its regions are empty.
    """

    name: str
    constant: str
    task: str
    module: str | None
    has_progress: bool
    members: str

    @property
    def progress_region(self) -> str:
        """Region ID of what is noted once a tick."""
        return f"{self.name}.progress"

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

    def context(self, models: "LoadedModels") -> Mapping[str, Any]:
        """Return the template context.

        Raises
        ------
        ModelError
            If something that a team added cannot be a constant.
        """
        mission = models.mission
        constants = {view.name: view for view in _indices(mission)}
        own = OwnFeatures(_indexed(mission), models.nodes)
        for found in own.of(mission, "MISSION"):
            if found.name in constants:
                node = models.nodes[found.element or mission]
                raise ModelError(
                    f"{node.path}:{node.line}: {node.description} holds a value that code would "
                    f"know as {found.name}, which is another's name already; rename the feature "
                    "or the other element"
                )
            constants[found.name] = ConstantView(found.name, found.value)
        return {
            "goals": tuple(self.visit(goal) for goal in mission.goals),
            "constants": tuple(constants.values()),
        }

    def visit_Goal(self, goal: Any) -> GoalView:
        """Return what the template needs to know about one goal."""
        known = base_class(goal.task.eClass)
        is_own = not is_read(known)
        return GoalView(
            name=identifier(goal.ID),
            constant=constant(goal.ID),
            task=known.name,
            module=None if is_own else snake_case(known.name),
            has_progress=is_own or known.name in PROGRESSING,
            members=_listed([identifier(member.ID) for member in goal.members]),
        )


def _indices(mission: Any) -> Iterator[ConstantView]:
    """Yield the indices of goals, robots, sensors and obstacles."""
    robots = robot_views(mission)
    for index, goal in enumerate(mission.goals):
        yield ConstantView(constant(goal.ID), index)
    for robot in robots:
        yield ConstantView(robot.constant, robot.index, robot.display_name)
    for robot in robots:
        yield from (ConstantView(sensor.constant, sensor.index) for sensor in robot.sensors)
    for index, obstacle in enumerate(mission.obstacles):
        yield ConstantView(constant(obstacle.ID), index)


def _indexed(mission: Any) -> dict[Any, int]:
    """Return all that has an index: sensors over all robots, and what the mission lists."""
    sensors = (sensor for robot in mission.robots for sensor in robot.sensors)
    indices = {sensor: index for index, sensor in enumerate(sensors)}
    for slot in slots(mission.eClass).values():
        if slot.is_contained and slot.many:
            indices |= {part: index for index, part in enumerate(values(mission, slot))}
    return indices


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:_MAX_MEMBERS])
    more = len(names) - _MAX_MEMBERS
    return f"{shown} and {more} more" if more > 0 else shown
