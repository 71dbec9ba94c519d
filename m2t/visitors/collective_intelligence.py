"""Visitor of ``collective_intelligence.py``: what each goal remembers, checks and does."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from m2t.load import LoadedModels
from m2t.metaclasses import base_class, is_read, slots, values
from m2t.metamodel_contract import PROGRESSING
from m2t.naming import constant, identifier, snake_case
from m2t.visitors.own_constants import Constant, OwnFeatures

_MAX_MEMBERS = 8


@dataclass(frozen=True, slots=True)
class GoalView:
    """A goal: its identifier and constant, class and module of its task, and its members.

    A task of a team's own has no module: its regions are empty. Regions are named after the
    identifier, so that renaming or reordering goals keeps code.
    """

    name: str
    constant: str
    task: str
    module: str | None
    has_progress: bool
    members: str


def visit(models: LoadedModels) -> Mapping[str, Any]:
    """Collect the goals of the mission, and constants for what their code refers to.

    What a team added and cannot be a constant raises a ``ModelError``.
    """
    mission = models.mission
    indices = _indices(mission)
    constants = {known.name: known for known in _named(mission, indices)}
    own = OwnFeatures(indices, models.nodes)
    for element, found in own.of(mission, "MISSION"):
        if found.name in constants:
            raise own.error(
                element or mission,
                f"holds a value that code would know as {found.name}, which is another's name "
                "already; rename the feature or the other element",
            )
        constants[found.name] = found
    return {
        "goals": tuple(_goal(goal) for goal in mission.goals),
        "constants": tuple(constants.values()),
    }


def _goal(goal: Any) -> GoalView:
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


def _named(mission: Any, indices: Mapping[Any, int]) -> Iterator[Constant]:
    remarks = {robot: robot.name for robot in mission.robots}
    for element in (*mission.goals, *mission.robots, *_sensors(mission), *mission.obstacles):
        yield Constant(constant(element.ID), indices[element], remarks.get(element, ""))


def _sensors(mission: Any) -> Iterator[Any]:
    return (sensor for robot in mission.robots for sensor in robot.sensors)


def _indices(mission: Any) -> dict[Any, int]:
    """Return all that has an index: sensors over all robots, and what the mission lists."""
    indices = {sensor: index for index, sensor in enumerate(_sensors(mission))}
    for slot in slots(mission.eClass).values():
        if slot.is_contained and slot.many:
            indices |= {part: index for index, part in enumerate(values(mission, slot))}
    return indices


def _listed(names: list[str]) -> str:
    shown = ", ".join(names[:_MAX_MEMBERS])
    more = len(names) - _MAX_MEMBERS
    return f"{shown} and {more} more" if more > 0 else shown
