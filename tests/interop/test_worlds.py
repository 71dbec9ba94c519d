"""The physics of the worlds of ``examples/worlds``, without a bus."""

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.fault_types import plain_name
from tests.support.external_worlds import forgotten, loaded
from tests.support.tree import ROOT

PHYSICS = {"mujoco": "SeaWater", "irsim": "Ground", "fossen": "Sea", "pymunk": "Hall"}
LIBRARIES = {"mujoco": "mujoco", "irsim": "irsim", "fossen": "numpy", "pymunk": "pymunk"}
MISSIONS = sorted(path.parent.name for path in (ROOT / "models").glob("*/mission.xmi"))
RADIUS, FREE = 1.0, 3.0  # of a robot, and how near to an obstacle one is held


@pytest.fixture
def load():
    """Return a function that imports a world, whose modules are forgotten after the test."""
    with forgotten():
        yield lambda world, name="world": loaded(world, name, library=LIBRARIES[world])


def ready(
    module: ModuleType, world: str, *words: str, mission: Any = None, **changed: float
) -> tuple[Any, list[Any], list[Any]]:
    """Return a world, its robots and its obstacles; robots differ from the mission's as told."""
    known = sys.modules["mission"].read_mission(ROOT / "models" / "uuv_sampling")
    known = mission or replace(known, robots=[replace(each, **changed) for each in known.robots])
    physics = getattr(module, PHYSICS[world])
    parser = argparse.ArgumentParser()
    physics.add_options(parser)
    made = sys.modules["robots"].World(known.robots, physics(known, parser.parse_args(words)))
    made.reset(1)
    return made, known.robots, known.obstacles


def written(path: Path, *, obstacle: str = "", robot: str = 'speed="2.0"', more: str = "") -> Path:
    """Write the model of a mission with one robot at the origin, and return its path."""
    path.write_text(
        f"""<Mission>
  <robots ID="Scout-1" {robot}>
    <batteries totalEnergy="1e6"/>{more}
  </robots>
  {obstacle}
</Mission>""",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize("mission", MISSIONS)
def test_a_world_reads_what_mrsfi_reads(mission, load):
    load("fossen")
    expected = load_code(ROOT / "generated" / mission).mission

    known = sys.modules["mission"].read_mission(ROOT / "models" / mission)

    def place(each: Any) -> tuple[float, float, float]:
        return each.x, each.y, each.z

    assert known.name == mission
    assert [
        (
            each.name,
            each.start,
            each.energy_at_start,
            each.energy_per_distance,
            each.greatest_speed,
            each.radius,
            each.position_noise,
        )
        for each in known.robots
    ] == [
        (
            plain_name(each.id),
            place(each.position),
            each.total_energy,
            each.energy_per_distance_unit,
            each.fastest,
            each.radius,
            each.position_noise or 0.0,
        )
        for each in expected.robots
    ]
    assert [
        (each.name, each.samples_per_tick, each.energy_per_sample, each.tells_position)
        for robot in known.robots
        for each in robot.sensors
    ] == [
        (plain_name(each.id), each.samples_per_second, each.energy_per_sample, gps)
        for robot in expected.robots
        for each in robot.sensors
        for gps in [each.type == "GPS_POSITION"]
    ]
    for each, other in zip(known.obstacles, expected.obstacles, strict=True):
        corners = tuple(map(place, other.area.corners))
        assert (each.name, each.corners) == (plain_name(other.id), corners)
        if not corners:
            assert (each.center, each.radius) == (place(other.area.center), other.area.radius)


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"robot": ""}, "robots Scout-1: speed is missing; expected a number"),
        ({"robot": 'speed="fast"'}, "robots Scout-1: speed is 'fast'; expected a number"),
        ({"robot": 'speed="NaN"'}, "robots Scout-1: speed is 'NaN'; expected a number"),
        ({"more": "<batteries/>"}, "batteries: totalEnergy is missing; expected a number"),
        ({"obstacle": '<obstacles ID="o"/>'}, "area o: radius is missing; expected a number"),
        ({"obstacle": "<obstacles/>"}, "an element of obstacles has no ID"),
        ({"more": '<sensors href="a.xmi#s"/>'}, "sensors are in another file; expected them here"),
        ({"obstacle": "<robots"}, "not well-formed"),
    ],
)
def test_what_a_world_cannot_read_is_refused_with_its_place(changed, problem, load, tmp_path):
    load("fossen")
    path = written(tmp_path / "mission.xmi", **changed)

    with pytest.raises(sys.modules["robots"].WorldError) as refused:
        sys.modules["mission"].read_mission(tmp_path)

    assert str(refused.value).startswith(f"{path}: {problem}")


def test_a_robot_with_noise_reports_a_place_in_its_disc(load, tmp_path):
    module = load("fossen")
    path = written(tmp_path / "mission.xmi", robot='speed="2.0" positionNoise="3.0"')
    mission = sys.modules["mission"].read_mission(path)
    made, (robot,), _ = ready(module, "fossen", mission=mission)

    def flown(seed: int) -> list[float]:
        made.reset(seed)
        offs = []
        for _ in range(400):
            made.step()
            offs.append(math.dist(robot.reported, robot.position))
        return offs

    first, other, again = flown(1), flown(2), flown(1)

    assert first == again != other
    assert max(first) <= 3.0
    assert np.mean(np.array(first) < 3.0 / math.sqrt(2.0)) == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize(
    ("place", "speed", "way", "problem"),
    [
        ((0.0, math.nan, 0.0), 0.0, 0.0, ": robot scout_1, y is nan; expected a finite number"),
        ((0.0, 0.0), 0.0, 0.0, r": robot scout_1, position is \(0.0, 0.0\); expected x, y and z"),
        ((0.0, 0.0, 0.0), "fast", 0.0, ": robot scout_1, speed is fast; expected a finite"),
        ((0.0, 0.0, 0.0), 0.0, math.inf, ": robot scout_1, distance is inf; expected a finite"),
        ((0.0, 0.0, 0.0), 0.0, None, r" returned \[\]; expected a distance for each robot"),
    ],
)
def test_what_physics_move_wrong_is_named(place, speed, way, problem, load, tmp_path, monkeypatch):
    module = load("fossen")
    mission = sys.modules["mission"].read_mission(written(tmp_path / "mission.xmi"))
    made, (robot,), _ = ready(module, "fossen", mission=mission)

    def move(_: Any) -> list[float]:
        robot.position, robot.speed = place, speed
        return [] if way is None else [way]

    monkeypatch.setattr(module.Sea, "move", move)

    with pytest.raises(sys.modules["robots"].WorldError, match=f"^world.move{problem}"):
        made.step()


def test_physics_may_move_robots_by_numbers_of_numpy(load, tmp_path, monkeypatch):
    module = load("fossen")
    mission = sys.modules["mission"].read_mission(written(tmp_path / "mission.xmi"))
    made, (robot,), _ = ready(module, "fossen", mission=mission)

    def move(_: Any) -> np.ndarray:
        robot.position, robot.speed = np.arange(3, dtype=np.float32), np.float32(4)
        return np.ones(1, dtype=np.float32)

    monkeypatch.setattr(module.Sea, "move", move)

    made.step()

    assert {type(each) for each in (*robot.position, robot.speed, robot.energy)} == {float}
    assert (*robot.position, robot.speed) == (0.0, 1.0, 2.0, 4.0)


@pytest.mark.parametrize("world", PHYSICS)
def test_a_robot_gets_where_it_is_told_no_faster_than_it_may(world, load):
    made, robots, _ = ready(load(world), world, greatest_speed=2.0)
    first = robots[0]
    first.heading, first.commanded_speed = (0.6, 0.8), 1000.0

    for _ in range(60):
        made.step()

    (x, y, z), (x0, y0, z0) = first.position, first.start
    assert 1.0 < first.speed <= 2.0 + 1e-9
    assert np.arctan2(y - y0, x - x0) == pytest.approx(np.arctan2(0.8, 0.6), abs=0.05)
    assert 60.0 < np.hypot(x - x0, y - y0) <= 120.0
    assert z == pytest.approx(z0, abs=0.01)
    assert robots[1].position == pytest.approx(robots[1].start, abs=0.1)


@pytest.mark.parametrize("world", PHYSICS)
def test_without_energy_a_robot_comes_to_rest_and_samples_no_more(world, load):
    made, robots, _ = ready(load(world), world, energy_at_start=200.0)
    for robot in robots:
        robot.heading, robot.commanded_speed = (1.0, 0.0), 4.0

    for _ in range(60):
        made.step()

    assert {robot.energy for robot in robots} == {0.0}
    assert all(robot.speed < 0.2 for robot in robots)
    assert not any(sensor.is_active for robot in robots for sensor in robot.sensors)
    assert all(0 < sensor.count < 30 for robot in robots for sensor in robot.sensors)


HOLDING = {"mujoco": (), "irsim": (), "pymunk": ("--bounce", "0")}
"""Worlds whose obstacles hold a robot, with the options for that."""


@pytest.mark.parametrize("world", HOLDING)
def test_an_obstacle_holds_what_runs_into_it_and_lets_it_go(world, load):
    made, (first, *_), obstacles = ready(load(world), world, *HOLDING[world])
    near = next(each for each in obstacles if each.name == "o4")  # straight ahead of none but r1
    way = np.subtract(near.center, first.start)[:2]
    first.heading, first.commanded_speed = tuple(way / np.hypot(*way)), 8.0

    def distance() -> float:
        made.step()
        return float(np.hypot(*np.subtract(near.center, first.position)[:2]))

    assert any(distance() <= near.radius + FREE for _ in range(1000))
    held = [distance() for _ in range(10)]  # later, the robot of irsim slides round it
    first.heading = (-first.heading[0], -first.heading[1])
    gone = [distance() for _ in range(20)]

    assert near.radius < min(held)
    assert max(held) < near.radius + FREE
    assert gone[-1] > held[-1] + 20.0


SHELF = """<obstacles ID="shelf"><area ID="a">
  <corners x="20.0" y="-5.0"/><corners x="60.0" y="-40.0"/>
  <corners x="60.0" y="40.0"/><corners x="20.0" y="5.0"/>
</area></obstacles>"""


@pytest.mark.parametrize("world", HOLDING)
def test_a_polygon_holds_what_runs_into_it(world, load, tmp_path):
    module = load(world)
    mission = sys.modules["mission"].read_mission(written(tmp_path / "mission.xmi", obstacle=SHELF))
    made, (robot,), _ = ready(module, world, *HOLDING[world], mission=mission)
    robot.heading, robot.commanded_speed = (1.0, 0.0), 4.0

    reached = []
    for _ in range(30):
        made.step()
        reached.append(robot.position[0])

    assert 20.0 - RADIUS - 1.5 < reached[-1] < 20.0 - RADIUS + 0.5
    assert reached[-1] == pytest.approx(max(reached), abs=0.5)


def test_a_current_takes_a_vehicle_along_in_mujoco(load):
    made, robots, _ = ready(load("mujoco"), "mujoco", "--current", "0.5", "0")
    still, *_ = robots

    for _ in range(100):
        made.step()

    assert still.position[0] - still.start[0] > 0.01


@pytest.mark.parametrize("world", ["fossen", "irsim"])
def test_the_scale_is_an_option(world, load):
    ways = []
    for unit in ("0.2", "0.4"):
        made, (first, *_), _ = ready(load(world), world, "--unit", unit, greatest_speed=100.0)
        first.heading, first.commanded_speed = (1.0, 0.0), 0.5 / float(unit)
        for _ in range(60):
            made.step()
        ways.append(float(unit) * (first.position[0] - first.start[0]))

    assert ways[0] == pytest.approx(ways[1], rel=0.01)
    assert ways[0] > 20.0


def energy_of(vehicles: Any) -> np.ndarray:
    """Return kinetic and potential energy of vehicles that are left alone, in joules."""
    known = vehicles.parameters
    kinetic = (known.total_mass * vehicles.velocity**2).sum(axis=0) / 2.0
    _, _, depth, roll, pitch, _ = vehicles.pose
    upright = known.buoyancy * known.buoyancy_above * (1.0 - np.cos(roll) * np.cos(pitch))
    return kinetic + upright - (known.weight - known.buoyancy) * depth


def test_water_takes_energy_from_a_vehicle_and_gives_none(load):
    module = load("fossen", "vehicle")
    vehicles = module.Vehicles(5, module.Parameters())
    random = np.random.default_rng(1)
    vehicles.velocity[:] = random.uniform(-1.0, 1.0, (6, 5))
    before = first = energy_of(vehicles)

    for _ in range(4000):
        vehicles.step(np.zeros((6, 5)), 0.005)
        now = energy_of(vehicles)
        assert (now < before + 1e-3 * first).all()
        before = now

    assert (before < 0.1 * first).all()


def test_without_damping_energy_is_kept(load):
    module = load("fossen", "vehicle")
    none = np.zeros((6, 1))
    vehicles = module.Vehicles(3, module.Parameters(linear=none, quadratic=none))
    vehicles.velocity[:] = np.random.default_rng(2).uniform(-0.5, 0.5, (6, 3))
    before = energy_of(vehicles)

    for _ in range(2000):
        vehicles.step(np.zeros((6, 3)), 0.001)

    assert energy_of(vehicles) == pytest.approx(before, rel=0.01)


def test_a_tilted_vehicle_rights_itself(load):
    module = load("fossen", "vehicle")
    vehicles = module.Vehicles(2, module.Parameters())
    vehicles.pose[3:5] = [[0.4, 0.0], [0.0, 0.4]]

    for _ in range(6000):
        vehicles.step(np.zeros((6, 2)), 0.02)

    assert np.abs(vehicles.pose[3:5]).max() < 0.1


def test_thrust_and_drag_balance_at_the_speed_that_the_equation_has(load):
    module = load("fossen", "vehicle")
    floating = module.Parameters(volume=13.5 / module.SEA_WATER)  # or it would rise, and pitch
    vehicles = module.Vehicles(1, floating)
    push = np.array([[50.0, 0.0, 0.0, 0.0, 0.0, 0.0]]).T

    for _ in range(2000):
        vehicles.step(push, 0.01)

    (speed,) = vehicles.velocity[0]
    assert 13.7 * speed + 141.0 * speed**2 == pytest.approx(50.0)
