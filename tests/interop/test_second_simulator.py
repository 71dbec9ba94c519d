"""The paper's mission on MuJoCo: somebody else's simulator behind the topics, the CI unchanged."""

import csv
import importlib
import importlib.util
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.generated_code import load_code
from tests.support.bags import read_bag
from tests.support.cli import (
    MISSION,
    ROOT,
    mrsfi,
    mrsfi_json,
    mrsfi_process,
    stop_specification,
    workspace,
)
from tests.support.missing import skip
from tests.support.page_simulator import page_simulator
from tests.support.pages import Terminal, at_free_ports, run_page
from tests.support.rosbridge import Relay, code_of, digests, process

EXAMPLE = ROOT / "examples" / "mujoco_simulator"
SIMULATOR = EXAMPLE / "simulator.py"
AREA, ENERGY, SAMPLES = "StayWithinMissionArea", "SufficientEnergy", "GatherSamples"


def require_mujoco() -> None:
    """Skip the test if MuJoCo is missing; in continuous integration, fail it."""
    if importlib.util.find_spec("mujoco") is None:
        skip("MuJoCo is missing; pip install -e '.[examples]'")


@contextmanager
def simulator(url: str) -> Iterator[subprocess.Popen[str]]:
    """Run the example until the end of the test; it must not have failed before."""
    with subprocess.Popen(
        [sys.executable, "-W", "error", SIMULATOR, "--url", url],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    ) as running:
        try:
            assert running.stdout is not None
            assert "serves at" in running.stdout.readline()
            yield running
            assert running.poll() is None
        finally:
            running.kill()
            _, told = running.communicate()
    assert told == ""


@pytest.fixture(scope="module")
def options() -> Iterator[tuple[str, ...]]:
    """Return the options that fly on the example, which runs for all tests of this module."""
    require_mujoco()
    with process("bridge", "--port", "0") as server:
        url = server.stdout.readline().strip()
        with simulator(url):
            yield ("--engine", "rosbridge", "--url", url, "--side", "ci")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with models and code of the mission."""
    return workspace(tmp_path_factory.mktemp("mujoco"))


@pytest.fixture(scope="module")
def flight(options: tuple[str, ...], place: Path) -> Any:
    """Return what a flight without faults printed."""
    return mrsfi_json("simulate", MISSION, *options, cwd=place)


def of_task(flight: Any, task: str, count: str) -> list[int]:
    return [goal[count] for goal in flight["goals"] if goal["task"] == task]


def test_the_mission_succeeds_without_faults(flight, note):
    samples = of_task(flight, SAMPLES, "samples")

    assert flight["duration"] == 1000
    assert len(flight["goals"]) == 6
    for kind in ("believed", "true"):
        assert of_task(flight, AREA, kind) == of_task(flight, ENERGY, kind) == [0]
    assert all(found >= target for found, target in zip(samples, (250, 400, 500), strict=True))
    note("MuJoCo behind the topics", ticks=flight["duration"], samples=sum(samples))


def test_the_page_of_the_example_runs_as_it_stands(place):
    require_mujoco()
    (place / "examples").symlink_to(EXAMPLE.parent)
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    page = (EXAMPLE / "README.md").read_text(encoding="utf-8")

    ran = [*run_page(at_free_ports(page), Terminal(place, {**os.environ, "PATH": path}))]

    assert len(ran) == 3


def test_the_flight_is_another_than_that_of_the_own_simulation(flight, place):
    own = mrsfi_json("simulate", MISSION, cwd=place)

    assert flight["digest"] != own["digest"]
    assert [goal["id"] for goal in flight["goals"]] == [goal["id"] for goal in own["goals"]]


def test_the_same_seed_gives_the_same_flight(flight, options, place):
    again = mrsfi_json("simulate", MISSION, *options, cwd=place)
    other = mrsfi_json("simulate", MISSION, "--seed", "2", *options, cwd=place)

    assert again == flight
    assert other["digest"] != flight["digest"]


def test_order_within_topics_is_all_that_it_needs():
    require_mujoco()
    code, flown = code_of(MISSION, 60), []
    for scatter in (0.0, 0.02):
        with (
            EmbeddedBridge() as server,
            Relay(server.url, scatter=scatter) as relay,
            simulator(relay.url),
            RosbridgeEngine(
                code, 1, EngineSettings(url=server.url, has_simulation=False)
            ) as engine,
        ):
            flown.append(digests(engine, range(2)))

    assert flown[0] == flown[1]


def test_a_stopped_vehicle_misses_its_samples(flight, options, place):
    faults = stop_specification(place / "models" / MISSION / "stopped.xmi", [(100, 900)])

    stopped = mrsfi_json("simulate", MISSION, "--faults", faults, *options, cwd=place)

    before, after = of_task(flight, SAMPLES, "samples"), of_task(stopped, SAMPLES, "samples")
    assert after[:2] == before[:2]
    assert after[2] < before[2]
    assert of_task(stopped, SAMPLES, "true")[2] > 300


def test_a_flight_on_it_is_written_as_a_bag(options, place):
    mrsfi("simulate", MISSION, *options, "--mcap", "m.mcap", "--trace", "m.csv", cwd=place)

    told = read_bag(place / "m.mcap")
    rows = list(csv.DictReader((place / "m.csv").read_text(encoding="ascii").splitlines()))
    for robot in ("r1", "r2", "r3"):
        for prefix, side in (("", "true"), ("/belief", "believed")):
            for name in ("speed", "energy"):
                values = [message.data for _, message in told[f"{prefix}/{robot}/{name}"]]
                assert values == [float(row[f"{robot}.{name}.{side}"]) for row in rows]
        spots = [message.data[:2].tolist() for _, message in told[f"/truth/{robot}"]]
        assert spots == [[float(row[f"{robot}.{axis}.true"]) for axis in "xy"] for row in rows]
        assert len(told[f"/{robot}/command/heading"]) > 1
    assert len({row["r1.speed.true"] for row in rows}) > 100  # thrusters, not mrsfi's own motion


def test_a_campaign_searches_on_it_over_one_connection(options, place):
    search = ("--population", "3", "--generations", "1", "--out", "campaign")

    told = mrsfi_process("evolve", MISSION, *search, *options, cwd=place, timeout=300)

    assert re.search(r"^campaign  .*: \d+ evaluations$", told.stdout, re.M)  # and none failed
    assert (place / "campaign" / "report.md").is_file()
    again = mrsfi_process("replay", "campaign", cwd=place, timeout=300)
    assert "same as recorded" in again.stdout
    other = mrsfi("replay", "campaign", "--engine", "reference", cwd=place, expected=2)
    assert "somebody else's simulation" in other.stderr


def test_the_simulator_imports_nothing_of_mrsfi():
    text = SIMULATOR.read_text(encoding="utf-8")

    imports = [line for line in text.splitlines() if line.startswith(("import ", "from "))]

    assert any("roslibpy" in line for line in imports)
    assert not any("mrsfi" in line or "m2t" in line for line in imports)


def test_its_world_is_that_of_the_model():
    world = ET.parse(EXAMPLE / "world.xml")
    mission = load_code(ROOT / "generated" / MISSION).mission

    numbers = {n.attrib["name"]: floats(n.attrib["data"]) for n in world.iter("numeric")}
    numbers.pop("thruster")
    starts = {b.attrib["name"]: floats(b.attrib["pos"]) for b in world.iter("body")}
    discs = {
        g.attrib["name"]: [*floats(g.attrib["pos"]), floats(g.attrib["size"])[0]]
        for g in world.iter("geom")
        if g.get("class") == "obstacle"
    }

    expected: dict[str, list[float]] = {}
    for robot in mission.robots:
        expected[robot.id] = [robot.total_energy, robot.energy_per_distance_unit, robot.fastest]
        for sensor in robot.sensors:
            expected[f"{robot.id}/{sensor.id}"] = [
                sensor.samples_per_second,
                sensor.energy_per_sample,
                sensor.type == "GPS_POSITION",
            ]
    assert numbers == expected
    assert list(numbers) == list(expected)
    assert starts == {r.id: [r.position.x, r.position.y, r.position.z] for r in mission.robots}
    assert discs == {
        o.id: [o.area.center.x, o.area.center.y, o.area.center.z, o.area.radius]
        for o in mission.obstacles
    }


def test_its_vehicles_obey_no_command_beyond_their_greatest_speed(tmp_path, monkeypatch):
    require_mujoco()
    monkeypatch.syspath_prepend(EXAMPLE)
    slow = tmp_path / "world.xml"
    text = (EXAMPLE / "world.xml").read_text(encoding="utf-8")
    slow.write_text(text.replace('"r2" data="64000 5 8"', '"r2" data="64000 5 2"'), "utf-8")
    world = importlib.import_module("simulator").World(slow)
    for robot in world.robots:
        robot.heading, robot.wanted_speed = (1.0, 0.0), 1000.0

    for _ in range(60):
        world.step()

    bounded, unbounded = world.robots[1].speed, world.robots[0].speed
    assert 1.0 < bounded <= 2.0 < unbounded


def test_the_minimal_simulator_of_the_page_flies(place):
    with process("bridge", "--port", "0") as server:
        url = server.stdout.readline().strip()
        with page_simulator(place, url):
            options = ("--engine", "rosbridge", "--url", url, "--side", "ci")
            flight = mrsfi_json("simulate", MISSION, *options, cwd=place)

    assert of_task(flight, SAMPLES, "samples") == [1000, 1000, 1000]
    assert of_task(flight, AREA, "true") == of_task(flight, ENERGY, "true") == [0]


def floats(text: str) -> list[float]:
    return [float(word) for word in text.split()]
