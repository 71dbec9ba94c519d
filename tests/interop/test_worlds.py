"""The physics of the worlds of ``examples/worlds``, without a bus."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from tests.support.missing import skip
from tests.support.tree import ROOT

WORLDS = ROOT / "examples" / "worlds"
PHYSICS = {"mujoco": "SeaWater", "irsim": "Ground", "fossen": "Sea"}
SHARED = ("robots", "serving", "side", "bus", "vehicle")


@pytest.fixture
def load(monkeypatch):
    """Return a function that imports a world, whose modules are forgotten after the test."""

    def loaded(world: str, name: str = "world") -> ModuleType:
        if importlib.util.find_spec(world) is None and world != "fossen":
            skip(f"{world} is missing; pip install -e '.[examples]'")
        for folder in (WORLDS, WORLDS / world):
            monkeypatch.syspath_prepend(folder)
        monkeypatch.setattr(sys, "path", [*sys.path])
        spec = importlib.util.spec_from_file_location(
            f"{world}_{name}", Path(sys.path[0], f"{name}.py")
        )
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    before = set(sys.modules)
    yield loaded
    for name in set(sys.modules) - before & {*SHARED}:
        del sys.modules[name]


def ready(module: ModuleType, world: str, **changed: float) -> tuple[Any, list[Any], list[Any]]:
    """Return a world, its robots and its obstacles; robots differ from the mission's as told."""
    robots, obstacles = sys.modules["robots"].read_mission()
    robots = [replace(robot, **changed) for robot in robots]
    made = sys.modules["robots"].World(robots, getattr(module, PHYSICS[world])(robots, obstacles))
    return made, robots, obstacles


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


@pytest.mark.parametrize("world", ["mujoco", "irsim"])
def test_an_obstacle_holds_what_runs_into_it_and_lets_it_go(world, load):
    made, (first, *_), obstacles = ready(load(world), world)
    near = next(each for each in obstacles if each.name == "o4")  # straight ahead of none but r1
    way = np.subtract(near.center, first.start)[:2]
    first.heading, first.commanded_speed = tuple(way / np.hypot(*way)), 8.0

    def distance() -> float:
        made.step()
        return float(np.hypot(*np.subtract(near.center, first.position)[:2]))

    assert any(distance() <= near.radius + 3.0 for _ in range(1000))
    held = [distance() for _ in range(10)]  # later, the robot of irsim slides round it
    first.heading = (-first.heading[0], -first.heading[1])
    gone = [distance() for _ in range(20)]

    assert near.radius < min(held)
    assert max(held) < near.radius + 3.0
    assert gone[-1] > held[-1] + 20.0


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
