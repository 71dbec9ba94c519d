"""The world of ``examples/worlds/moos`` before stand-ins of MOOSDB and uSimMarineV22.

The client is pymoos2, over real sockets. The stand-ins are Python, and their vehicle obeys at once;
MOOS-IvP itself is in no package. Its time cannot be stopped: on a busy machine ticks are longer, so
distances have lower bounds.
"""

import argparse
import math
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from tests.support.external_worlds import forgotten, loaded, started
from tests.support.processes import descendants, is_running, wait_for
from tests.support.tree import ROOT

WARP = ("--warp", "4")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the programs of a community."""
    folder = tmp_path_factory.mktemp("moos")
    standin = f"{sys.executable} {ROOT / 'tests' / 'support' / 'moos_standin.py'}"
    known = {"uSimMarineV22": "sleep 600"}
    for name, words in (known | dict.fromkeys(("MOOSDB", "sSensor"), f'{standin} "$@"')).items():
        (folder / name).write_text(f"#!/bin/sh\nexec {words}\n", encoding="utf-8")
        (folder / name).chmod(0o755)
    return folder


@pytest.fixture
def make(programs: Path) -> Iterator[Callable[..., Any]]:
    """Return a function that makes the physics of a mission; after the test, it is closed."""
    with ExitStack() as ended, forgotten():
        module = loaded("moos", library="pymoos2")
        parser = argparse.ArgumentParser()
        module.Moos.add_options(parser)

        def made(mission: str, *more: str) -> tuple[Any, Any]:
            known = sys.modules["mission"].read_mission(ROOT / "models" / mission)
            options = parser.parse_args(["--bin", str(programs), *WARP, *more])
            return ended.enter_context(closing(module.Moos(known, options))), known

        yield made


def test_a_vehicle_goes_where_it_is_told_and_is_back_after_a_reset(make):
    physics, mission = make("uuv_sampling")
    first, second, _ = mission.robots
    first.heading, first.commanded_speed = (0.6, -0.8), 4.0

    for _ in range(2):
        physics.reset(1)
        ways = [physics.move()[0] for _ in range(5)]
        (x, y, z), (x0, y0, z0) = first.position, first.start
        assert math.atan2(y - y0, x - x0) == pytest.approx(math.atan2(-0.8, 0.6), abs=0.01)
        assert math.hypot(x - x0, y - y0) > 16.0
        assert sum(ways) == pytest.approx(math.hypot(x - x0, y - y0))
        assert z == z0
        assert first.speed == 4.0
        assert second.position == second.start


def test_the_scale_is_an_option(make):
    physics, mission = make("depot", "--unit", "5")
    first, second = mission.robots[:2]
    first.heading, first.commanded_speed = (1.0, 0.0), 0.8
    physics.reset(1)

    ways = [physics.move()[0] for _ in range(5)]

    assert first.speed == pytest.approx(0.8)
    assert first.position[0] - first.start[0] == pytest.approx(sum(ways))
    assert sum(ways) > 3.2
    assert second.position == pytest.approx(second.start)


@pytest.mark.parametrize(("slack", "expected", "least"), [("1", 1, 10.0), ("1000", 0, 7.0)])
def test_a_tick_that_begins_late_is_counted_and_lasts_a_second(slack, expected, least, make):
    physics, mission = make("uuv_sampling", "--slack", slack)
    first, *_ = mission.robots
    first.heading, first.commanded_speed = (1.0, 0.0), 4.0
    physics.reset(1)
    physics.move()
    time.sleep(2.0 / 4.0)  # two seconds of MOOS time

    way, *_ = physics.move()

    assert physics.late == expected
    assert way > least


def test_sensors_of_undersea_measure_at_the_rate_of_the_mission(make):
    physics, mission = make("undersea", "--reliability", "0.5")
    (nautilus,) = mission.robots
    physics.reset(1)
    read = {sensor.name: [0, 0] for sensor in nautilus.sensors}

    for _ in range(12):
        physics.move()
        for sensor in nautilus.sensors:
            for n, each in enumerate(physics.measured(sensor)):
                read[sensor.name][n] += each

    for sensor in nautilus.sensors:
        n, n_valid = read[sensor.name]
        assert n > 0.6 * 12 * sensor.samples_per_tick
        assert n / read["sensor1"][0] == pytest.approx(sensor.samples_per_tick / 3, rel=0.25)
        assert n_valid == pytest.approx(n / 2, abs=1)


def test_without_undersea_samples_are_drawn(make):
    physics, mission = make("undersea")
    physics.reset(1)
    physics.move()

    assert physics.measured(mission.robots[0].sensors[0]) is None


def test_a_program_that_is_missing_is_refused(make):
    with pytest.raises(Exception, match="--bin: found no program pHelmIvP in ") as refused:
        make("undersea", "--helm")

    assert refused.type.__name__ == "WorldError"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_communities_end_with_the_world(number, programs):
    told = ("--bin", programs, *WARP)
    with EmbeddedBridge() as server, started("moos", server.url, *told) as world:
        beside = descendants(world.pid)
        world.send_signal(number)
        world.wait(timeout=30)
        wait_for(lambda: not any(map(is_running, beside)))

    assert len(beside) == 2 * 3
