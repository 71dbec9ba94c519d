"""Missions for tests of the kernel, written in the runtime's own vocabulary."""

from dataclasses import replace
from random import Random
from typing import Any

from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import (
    Area,
    Battery,
    Coordinates,
    Goal,
    GoalTask,
    Mission,
    MotionSource,
    Obstacle,
    Robot,
    Sensor,
    polygon,
)
from mrsfi_runtime.search.space import SearchSpace, random_specification
from tests.support.tree import ROOT

MEMBERS = ("a", "b")


def code_of(mission: str, duration: int | None = None) -> MissionCode:
    """Return the committed code of a mission, shortened if a duration is given."""
    code = load_code(ROOT / "generated" / mission)
    if duration is None:
        return code
    return replace(code, mission=replace(code.mission, duration=duration))


def paper_code(duration: int | None = None) -> MissionCode:
    """Return the committed code of the paper's mission, shortened if a duration is given."""
    return code_of("uuv_sampling", duration)


def cornered(mission: Mission) -> Mission:
    """Return a mission with polygons, which are not convex, in place of discs."""
    rocks = (replace(each, area=_cornered(each.area)) for each in mission.obstacles)
    goals = (
        each if each.area is None else replace(each, area=_cornered(each.area))
        for each in mission.goals
    )
    return replace(mission, obstacles=tuple(rocks), goals=tuple(goals))


def _cornered(area: Area) -> Area:
    x, y, far = area.center.x, area.center.y, area.radius
    spots = ((x - far, y - far), (x + far, y - far), (x + far, y + far), (x + far / 4, y - far / 8))
    return polygon(area.id, tuple(Coordinates(*spot) for spot in spots))


def specification(code: MissionCode, seed: int, n_faults: int = 20) -> Specification:
    """Return a random specification, the same for the same seed."""
    return random_specification(SearchSpace.of(code.mission, code.pool), n_faults, Random(seed))


def specifications(code: MissionCode, n: int, n_faults: int = 20) -> list[Specification]:
    """Return random specifications, the same again and again."""
    return [specification(code, seed, n_faults) for seed in range(n)]


def robot(name: str, x: float, y: float, *, speed: float = 4.0, energy: float = 10_000.0) -> Robot:
    """Return a robot with a GPS sensor and a depth sensor, 2 samples a tick at 3 energy units."""
    sensors = tuple(
        Sensor(f"{name}_{kind.lower()}", kind, kind, 3.0, 2) for kind in ("GPS_POSITION", "DEPTH")
    )
    return Robot(
        id=name,
        name=name,
        position=Coordinates(x, y, 1.0),
        speed=speed,
        sensors=sensors,
        batteries=(Battery(f"{name}_battery", "", energy),),
        motion_sources=(MotionSource(f"{name}_drive", "", 5.0),),
    )


def mission(
    *tasks: GoalTask,
    robots: tuple[Robot, ...] | None = None,
    obstacles: tuple[Obstacle, ...] = (),
    duration: int = 100,
    area: Area | None = None,
) -> Mission:
    """Return a mission of radius 1000 with one goal for each task, all robots its members."""
    robots = robots or (robot("a", 0.0, 0.0), robot("b", 100.0, 0.0))
    members = tuple(each.id for each in robots)
    goals = tuple(
        Goal(f"g{number}", type(task).__name__, members, task, area)
        for number, task in enumerate(tasks, 1)
    )
    return Mission(
        name="small",
        duration=duration,
        area=Area("whole", Coordinates(), 1000.0),
        robots=robots,
        servers=(),
        obstacles=obstacles,
        goals=goals,
    )


def stand(view: State) -> None:
    """Let the robots of a state have stood where they are for a tick."""
    for robot, wake in zip(view.robots, view.wakes, strict=False):
        wake.x, wake.y = robot.x, robot.y


def state(*tasks: GoalTask, **layout: Any) -> State:
    """Return the state of such a mission before its first tick."""
    return initial_state(mission(*tasks, **layout), seed=1)
