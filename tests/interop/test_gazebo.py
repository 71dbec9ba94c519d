"""The gate to Gazebo of ``examples/worlds/gazebo``, before a server of the same topics.

Gate and server are compiled against the real ignition-transport, which Debian has. Gazebo itself
is not installed here: ``gazebo_standin`` has its topics and its service, with points as bodies.
"""

import argparse
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.external_worlds import WORLDS, forgotten, loaded, started
from tests.support.missing import skip
from tests.support.processes import descendants, is_running, wait_for
from tests.support.rosbridge import code_of, digests
from tests.support.tree import ROOT

SOURCES = (
    WORLDS / "gazebo" / "gate_topics.cc",
    ROOT / "tests" / "support" / "gazebo_standin.cc",
)
LIBRARIES = ("ignition-transport11", "ignition-msgs8")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the gate and the stand-in."""
    if shutil.which("g++") is None or shutil.which("pkg-config") is None:
        skip("g++ or pkg-config is missing; apt-get install g++ pkg-config")
    flags = subprocess.run(
        ["pkg-config", "--cflags", "--libs", *LIBRARIES],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    if flags.returncode:
        skip("ignition-transport is missing; apt-get install libignition-transport-dev")
    folder = tmp_path_factory.mktemp("gazebo")
    told = ("g++", "-std=c++17", "-Wall", "-Werror")
    compilers = [
        subprocess.Popen([*told, each, "-o", folder / each.stem, *shlex.split(flags.stdout)])
        for each in SOURCES
    ]
    assert [each.wait() for each in compilers] == [0, 0]
    return folder


def words(programs: Path, server: str = "gazebo_standin") -> list[str]:
    """Return the options of a world with the stand-in, or with another program, as its server."""
    gate, standin = programs / "gate_topics", programs / server
    return ["--gate", str(gate), "--server", str(standin)]


@pytest.fixture
def make(programs: Path) -> Iterator[Callable[..., Any]]:
    """Return a function that makes the physics of a mission; after the test, it is closed."""
    with ExitStack() as ended, forgotten():
        module = loaded("gazebo")
        parser = argparse.ArgumentParser()
        module.Gazebo.add_options(parser)

        def made(mission: str, *more: str, server: str = "gazebo_standin") -> tuple[Any, Any]:
            known = sys.modules["mission"].read_mission(ROOT / "models" / mission)
            options = parser.parse_args([*words(programs, server), *more])
            physics = ended.enter_context(closing(module.Gazebo(known, options)))
            return physics, known

        yield made


def test_a_vehicle_flies_as_commanded_and_is_back_after_a_reset(make):
    physics, mission = make("uuv_sampling")
    first, second, _ = mission.robots
    starts = [robot.start for robot in mission.robots]
    first.heading, first.commanded_speed = (0.6, 0.8), 4.0

    for _ in range(2):
        physics.reset(1)
        assert physics.move() == pytest.approx([3.8, 0.0, 0.0])  # from the second of 20 steps on
        assert physics.move() == pytest.approx([4.0, 0.0, 0.0])
        (x, y, z), (x0, y0, z0) = first.position, starts[0]
        assert (x - x0, y - y0, z - z0) == pytest.approx((0.6 * 7.8, 0.8 * 7.8, 0.0))
        assert first.speed == pytest.approx(4.0)
        assert second.position == pytest.approx(starts[1])
        assert physics.late == 0


def test_the_scale_is_an_option(make):
    physics, mission = make("depot", "--unit", "0.5", "--steps", "10")
    first = mission.robots[0]
    first.heading, first.commanded_speed = (1.0, 0.0), 0.5
    physics.reset(1)

    way, *_ = physics.move()

    assert way == pytest.approx(0.45)
    assert first.position[0] - first.start[0] == pytest.approx(0.45)


def test_a_vehicle_that_an_obstacle_has_turned_flies_where_it_is_commanded(make, programs):
    turned = programs / "turned"
    turned.write_text(f"#!/bin/sh\nexec {programs}/gazebo_standin --yaw 0.7 $1\n")
    turned.chmod(0o755)
    physics, mission = make("uuv_sampling", server="turned")
    first = mission.robots[0]
    first.heading, first.commanded_speed = (0.0, -1.0), 4.0
    physics.reset(1)

    physics.move()

    (x, y, _), (x0, y0, _) = first.position, first.start
    assert (x - x0, y - y0) == pytest.approx((0.0, -3.8))
    assert first.speed == pytest.approx(4.0)
    assert physics.late == 0


def test_commands_that_come_too_late_are_counted(make, programs):
    deaf = programs / "deaf"
    deaf.write_text(f"#!/bin/sh\nexec {programs}/gazebo_standin --deaf 3 $1\n")
    deaf.chmod(0o755)
    physics, mission = make("uuv_sampling", server="deaf")
    first, second, _ = mission.robots
    late = []
    physics.reset(1)
    for speed, turn in ((4.0, 0.0), (4.0, 0.0), (4.0, 1.0), (2.0, 1.0), (2.0, 1.0)):
        first.heading, first.commanded_speed = (1.0 - turn, turn), speed
        second.heading, second.commanded_speed = (1.0, 0.0), 1.0
        physics.move()
        late.append(physics.late)

    assert late == [2, 0, 1, 1, 0]


def test_obstacles_stand_where_the_mission_has_them(make):
    physics, mission = make("depot")

    sdf = physics._world.read_text(encoding="utf-8")

    for obstacle in mission.obstacles:
        walls = [*obstacle.walls]
        assert sdf.count(f'<model name="{obstacle.name}') == (len(walls) or 1)
        for wall in walls:
            x, y, z = wall.middle
            assert f"<pose>{x!r} {y!r} {z!r} 0 0 {wall.angle!r}</pose>" in sdf
            assert f"<size>{wall.length!r} 0.1 20.0</size>" in sdf
        if not walls:
            assert f"<radius>{obstacle.radius!r}</radius>" in sdf


def flown(server: EmbeddedBridge, *seeds: int) -> list[list[str]]:
    """Return the digests of short flights of the paper's mission on the world at a server."""
    settings = EngineSettings("rosbridge", url=server.url, side="ci", is_bundled=True)
    with RosbridgeEngine(code_of("uuv_sampling", 5), 1, settings) as engine:
        return digests(engine, seeds)


def test_two_worlds_fly_beside_each_other_and_repeat_themselves(programs):
    with (
        EmbeddedBridge() as server,
        EmbeddedBridge() as other,
        started("gazebo", server.url, *words(programs)) as world,
        started("gazebo", other.url, *words(programs)) as second,
    ):
        first = flown(server, 1, 2)
        assert flown(other, 1, 2) == first != flown(server, 2, 1)
        for each in (world, second):
            each.terminate()
            assert each.wait(timeout=30) == 0


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_gate_and_server_end_with_the_world(number, programs):
    with EmbeddedBridge() as server, started("gazebo", server.url, *words(programs)) as world:
        flown(server, 1)
        beside = descendants(world.pid)
        world.send_signal(number)
        world.wait(timeout=30)
        wait_for(lambda: not any(map(is_running, beside)))

    assert len(beside) == 2


@pytest.mark.slow
def test_a_server_that_says_nothing_is_told_of(make, programs, capfd):
    silent = programs / "silent"
    silent.write_text("#!/bin/sh\nexec sleep 100\n")
    silent.chmod(0o755)
    physics, _ = make("uuv_sampling", server="silent")

    with pytest.raises(OSError, match="gate_topics ended with 1"):
        physics.reset(1)

    assert "Gazebo took no commands within 20 s" in capfd.readouterr().err


def test_a_gate_that_is_not_there_is_refused(make):
    with pytest.raises(Exception, match="--gate: found no file nowhere/gate_topics") as refused:
        make("uuv_sampling", "--gate", "nowhere/gate_topics")

    assert refused.type.__name__ == "WorldError"


def test_a_server_that_is_not_there_is_told_of(make):
    physics, _ = make("uuv_sampling", server="nowhere")

    with pytest.raises(Exception, match="nowhere cannot be started: No such file or directory"):
        physics.reset(1)
