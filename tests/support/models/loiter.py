"""A goal task of a team's own: stay near a robot's home, away for a few ticks at most."""

from pathlib import Path

from tests.support.edited import COLLECTIVE, write_body
from tests.support.own_metamodels import (
    OwnMetamodels,
    a_class,
    an_enumeration,
    attribute,
    many,
    part,
    reference,
)

LOITER = (
    an_enumeration("Mood", "CALM", "BOLD"),
    a_class("Mark", "", attribute("depth", "EDouble") + attribute("word")),
    a_class(
        "Loiter",
        "#//GoalTask",
        attribute("radius", "EDouble")
        + attribute("awayTicks", "EInt")
        + attribute("isStrict", "EBoolean")
        + attribute("word")
        + attribute("mood", "#//Mood")
        + attribute("legs", "EDouble", many())
        + reference("leader", "Robot")
        + reference("probes", "Sensor", many())
        + reference("twin", "Goal")
        + part("home", "Coordinates")
        + part("stops", "Coordinates", many())
        + part("zone", "Area")
        + part("marks", "Mark", many())
        + part("mark", "Mark"),
    ),
)

MISSION = Path(__file__).with_name("loiter.xmi").read_text(encoding="ascii")
"""A mission with a goal of the task."""

CONSTANTS = {
    "NEAR_RADIUS": 20.0,
    "NEAR_AWAY_TICKS": 4,
    "NEAR_IS_STRICT": True,
    "NEAR_WORD": "so",
    "NEAR_MOOD": "BOLD",
    "NEAR_LEGS": (1.5, 2.5),
    "NEAR_LEADER": 0,
    "NEAR_PROBES": (0, 1),
    "NEAR_TWIN": -1,
    "NEAR_HOME": (30.0, 0.0, 0.0),
    "NEAR_STOPS": ((1.0, 0.0, 0.0), (0.0, 2.0, 3.0)),
    "NEAR_ZONE": (7.0, 0.0, 0.0, 5.0),
    "NEAR_MARKS_DEPTH": (1.0, 2.0),
    "NEAR_MARKS_WORD": ("one", ""),
    "NEAR_MARK_DEPTH": 3.0,
    "NEAR_MARK_WORD": "",
    "NEAR_REQUIRED_MEMBERS": 1,
}
"""What the features of the goal and its task become."""

BODIES = {
    "near.progress": (
        "    goal = ci.goals[NEAR]\n"
        "    robot = ci.robots[NEAR_LEADER]\n"
        "    goal.memory[1] = geometry.distance(robot.x, robot.y, NEAR_HOME[0], NEAR_HOME[1])\n"
        "    goal.memory[0] = goal.memory[0] + 1 if goal.memory[1] > NEAR_RADIUS else 0\n"
    ),
    "near.check": (
        '    limit = NEAR_AWAY_TICKS if NEAR_IS_STRICT and NEAR_MOOD == "BOLD" else 1000\n'
        "    return ci.goals[NEAR].memory[0] > limit\n"
    ),
    "near.react": (
        "    ci.goals[NEAR].memory[7] += NEAR_LEGS[1]\n"
        "    if ci.goals[NEAR].memory[1] > 0.5 * NEAR_RADIUS:\n"
        "        guidance.approach(ci, NEAR_LEADER, NEAR_HOME[0], NEAR_HOME[1])\n"
    ),
}
"""What a team writes into the regions of the goal, by region."""


def write_loiter(folder: Path, own_metamodels: OwnMetamodels) -> Path:
    """Add the task to the metamodel, and return a mission folder with a goal of it."""
    own_metamodels.add(*LOITER)
    models = folder / "models" / "own_task"
    models.mkdir(parents=True)
    (models / "mission.xmi").write_text(MISSION, encoding="ascii")
    return models


def fill(generated: Path, bodies: dict[str, str] = BODIES) -> None:
    """Write bodies into regions of the generated collective intelligence."""
    for region, body in bodies.items():
        write_body(generated / COLLECTIVE, region, body)
