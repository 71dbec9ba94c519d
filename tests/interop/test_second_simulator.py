"""Other simulators behind the topics, the CI unchanged: the worlds of ``examples/worlds``."""

import importlib.util
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

from mrsfi_bridge.embedded import EmbeddedBridge
from mrsfi_bridge.settings import ServerSettings, TypeTable
from mrsfi_runtime.cosimulation.bus_topics import ANSWER, GO, RESET, SETUP, TICK
from mrsfi_runtime.cosimulation.node_speech import Speech, out_of_reach
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.record.engine_settings import SERVICE, EngineSettings
from mrsfi_runtime.transport.rosbridge import RosbridgeTransport
from mrsfi_runtime.transport.topics import Payload, Reply, Topic
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
from tests.support.pages import Terminal, at_free_ports, run_page
from tests.support.processes import is_running, wait_for
from tests.support.rosbridge import Relay, code_of, digests, process
from tests.support.world import paper_code, specification

WORLDS = ROOT / "examples" / "worlds"
PAGE = (WORLDS / "README.md").read_text(encoding="utf-8")
NEEDS = {"mujoco": "mujoco", "irsim": "irsim", "fossen": "numpy", "pymunk": "pymunk"}
"""Worlds by the name of their folder, and the library that each is made with."""

OURS = "fossen"
"""A world that never misses a library: what all share is tested with it alone."""

AREA, ENERGY, SAMPLES = "StayWithinMissionArea", "SufficientEnergy", "GatherSamples"


def require(world: str) -> None:
    """Skip the test if the library of a world is missing; in continuous integration, fail it."""
    if importlib.util.find_spec(NEEDS[world]) is None:
        skip(f"{NEEDS[world]} is missing; pip install -e '.[examples]'")


def started(path: Path, url: str, *options: str, mission: str = MISSION) -> subprocess.Popen[str]:
    """Start the program of a world."""
    told = ("--mission", ROOT / "models" / mission, "--url", url)
    return subprocess.Popen(
        [sys.executable, "-W", "error", path, *told, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
    )


@contextmanager
def running(
    world: str, url: str, *options: str, mission: str = MISSION
) -> Iterator[subprocess.Popen[str]]:
    """Run a world until the end of the test."""
    require(world)
    with started(WORLDS / world / "world.py", url, *options, mission=mission) as served:
        try:
            assert served.stdout is not None
            assert f"{mission} on " in (line := served.stdout.readline())
            assert "serves at" in line
            yield served
        finally:
            served.kill()


@contextmanager
def simulator(world: str, url: str, *options: str, mission: str = MISSION) -> Iterator[None]:
    """Run a world beside the body; it must not have failed before."""
    with running(world, url, *options, mission=mission) as served:
        yield
        assert served.poll() is None
        served.kill()
        assert served.communicate()[1] == ""


@contextmanager
def engine(
    url: str, duration: int = 60, mission: str = MISSION, **settings: Any
) -> Iterator[RosbridgeEngine]:
    """Yield an engine that flies a mission, shortened, on the world at a server."""
    flown = EngineSettings("rosbridge", url=url, side="ci", **settings)
    with RosbridgeEngine(code_of(mission, duration), 1, flown) as opened:
        yield opened


def flown_on(world: str, *options: str, server: EmbeddedBridge, **settings: Any) -> list[list[str]]:
    """Return the digests of two shortened flights on a world."""
    with simulator(world, server.url, *options), engine(server.url, **settings) as opened:
        return digests(opened, range(2))


@pytest.fixture(scope="module")
def options() -> Iterator[tuple[str, ...]]:
    """Return the options that fly on a world, which runs for all tests of this module."""
    with process("bridge", "--port", "0") as server:
        url = server.stdout.readline().strip()
        with simulator(OURS, url):
            yield ("--engine", "rosbridge", "--url", url, "--side", "ci", "--bundle")


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with models and code of the mission."""
    return workspace(tmp_path_factory.mktemp("worlds"))


@pytest.fixture(scope="module")
def flight(options: tuple[str, ...], place: Path) -> Any:
    """Return what a flight without faults printed."""
    return mrsfi_json("simulate", MISSION, *options, cwd=place)


def of_task(flight: Any, task: str, count: str) -> list[int]:
    return [goal[count] for goal in flight["goals"] if goal["task"] == task]


@pytest.mark.parametrize("world", NEEDS)
def test_the_page_of_the_examples_runs_as_it_stands(world, tmp_path):
    require(world)
    place = workspace(tmp_path)
    (place / "examples").symlink_to(WORLDS.parent)
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    (section,) = (each for each in PAGE.split("\n## ") if f"worlds/{world}/world.py" in each)

    ran = [*run_page(at_free_ports(section), Terminal(place, {**os.environ, "PATH": path}))]

    assert len(ran) == 3


@pytest.mark.parametrize("world", NEEDS)
def test_the_same_seed_gives_the_same_flight(world):
    seeds = (1, 2, 1)
    with (
        EmbeddedBridge() as server,
        simulator(world, server.url),
        engine(server.url, is_bundled=True) as opened,
    ):
        first, second, again = digests(opened, (0, 1, 0))
        samples = [opened.evaluate((), seed).samples for seed in seeds]

    assert first == again != second
    assert samples[0] == samples[2] != samples[1]


@pytest.mark.parametrize("mission", ["depot", "undersea", "fleet_30"])
def test_a_world_serves_any_mission(mission):
    with (
        EmbeddedBridge() as server,
        simulator(OURS, server.url, mission=mission),
        engine(server.url, mission=mission, is_bundled=True) as opened,
    ):
        first, second, again = digests(opened, (0, 1, 0))

    assert first == again != second


def test_the_flight_is_another_than_that_of_the_own_simulation(flight, place):
    own = mrsfi_json("simulate", MISSION, cwd=place)

    assert flight["digest"] != own["digest"]
    assert [goal["id"] for goal in flight["goals"]] == [goal["id"] for goal in own["goals"]]


def test_messages_prefix_and_ros_change_no_flight():
    with EmbeddedBridge() as server:
        plain = flown_on(OURS, server=server)
        bundled = flown_on(OURS, server=server, is_bundled=True)
    with EmbeddedBridge(ServerSettings(types=TypeTable(ros=2))) as server:
        newer = flown_on(OURS, "--ros", "2", server=server, ros=2)
    with EmbeddedBridge() as server:
        prefixed = [
            flown_on(
                OURS, "--prefix", "/w", server=server, world_prefix="/w", is_bundled=is_bundled
            )
            for is_bundled in (False, True)
        ]

    assert bundled == newer == plain
    assert prefixed == [plain, plain]


def test_a_node_of_a_team_flies_in_a_world_of_a_team_as_generated_code_does():
    reached = paper_code()
    unreached = out_of_reach(reached.mission, reached.pool, Speech.of("", reached.mission))
    reached = replace(reached, pool=reached.pool.without(unreached))
    specifications = [(), specification(reached, 100)] * 2
    words = (sys.executable, "-m", "tests.support.standin_node", str(reached.directory))
    with EmbeddedBridge() as server, running(OURS, server.url, "--prefix", "/world"):
        generated = EngineSettings("rosbridge", server.url, side="ci", world_prefix="/world")
        node = replace(
            generated,
            side="injector",
            node=f"{shlex.join(words)} {{url}} 1 {{seed}} /node",
            node_pace=ANSWER,
            node_reset=SERVICE,
            node_prefix="/node",
        )
        flown = []
        for settings in (node, generated):
            with open_engine(settings, reached, 1) as opened:
                flown.append([opened.evaluate(each) for each in specifications])

    injected, expected = flown
    assert injected == expected
    assert injected[:2] == injected[2:]
    assert injected[0] != injected[1]


def test_order_within_topics_is_all_that_it_needs():
    flown = []
    for scatter in (0.0, 0.02):
        with EmbeddedBridge() as server, Relay(server.url, scatter=scatter) as relay:  # noqa: SIM117
            with simulator(OURS, relay.url), engine(server.url) as opened:
                flown.append(digests(opened, range(2)))

    assert flown[0] == flown[1]


@contextmanager
def going(url: str, *words: int, listened: Sequence[Topic] = ()) -> Iterator[Queue[Payload]]:
    """Begin run 1 of a world, and go with some numbers; yield the messages of topics."""
    messages: Queue[Payload] = Queue()
    transport = RosbridgeTransport(url)
    for each in listened:
        transport.subscribe(each, messages.put)
    setup, go = transport.advertise(SETUP), transport.advertise(GO)

    def begin() -> None:
        setup({"data": [1, 1, 2]})
        transport.call(RESET, {}, begun)

    def begun(reply: Reply) -> None:
        if reply.values.get("success"):
            go({"data": [*words]})
        else:  # the reset overtook the setup
            transport.call_later(0.1, begin)

    begin()
    try:
        yield messages
    finally:
        transport.close()


@pytest.mark.parametrize(
    ("words", "begin", "message"),
    [
        ((1, 5, 0), "", "tick 5 was requested; expected tick 0\n"),
        ((1, 0, 12), "", "0 of 12 commands reached r1, r2, r3 within 1 s; expected all: one was l"),
        ((1, 0), "Traceback", "ValueError: not enough values to unpack (expected 3, got 2)\n"),
    ],
)
def test_what_goes_wrong_ends_a_world_with_its_reason(words, begin, message):
    with (
        EmbeddedBridge() as server,
        running(OURS, server.url) as served,
        going(server.url, *words),
    ):
        _, told = served.communicate(timeout=30)

    assert served.returncode == 1
    assert told.startswith(begin or "run 1, tick 0: ")
    assert f"\nrun 1, tick 0: {message}" in f"\n{told}"


def test_a_lost_connection_ends_a_world_with_its_reason():
    with EmbeddedBridge() as server, running(OURS, server.url) as served:
        server.close()
        _, told = served.communicate(timeout=30)

    assert (served.returncode, told) == (1, "the connection was lost\n")


def test_a_stopped_vehicle_misses_its_samples(flight, options, place):
    faults = stop_specification(place / "models" / MISSION / "stopped.xmi", [(100, 900)])

    stopped = mrsfi_json("simulate", MISSION, "--faults", faults, *options, cwd=place)

    before, after = of_task(flight, SAMPLES, "samples"), of_task(stopped, SAMPLES, "samples")
    assert after[:2] == before[:2]
    assert after[2] < before[2]
    assert of_task(stopped, SAMPLES, "true")[2] > 300


def test_a_campaign_searches_on_it_over_one_connection(options, place):
    search = ("--population", "3", "--generations", "1", "--out", "campaign")

    told = mrsfi_process("evolve", MISSION, *search, *options, cwd=place, timeout=300)

    assert re.search(r"^campaign  .*: \d+ evaluations$", told.stdout, re.M)  # and none failed
    assert (place / "campaign" / "report.md").is_file()
    again = mrsfi_process("replay", "campaign", cwd=place, timeout=300)
    assert "same as recorded" in again.stdout
    other = mrsfi("replay", "campaign", "--engine", "reference", cwd=place, expected=2)
    assert "this campaign was flown with an external simulation" in other.stderr


def test_the_worlds_import_nothing_of_mrsfi():
    texts = [path.read_text(encoding="utf-8") for path in WORLDS.rglob("*.py")]

    imports = [
        line for text in texts for line in text.splitlines() if re.match(r" *(import|from) ", line)
    ]

    assert "import roslibpy" in imports
    assert not any("mrsfi" in line or "m2t" in line for line in imports)


ANCHORED = ROOT / "tests" / "support" / "anchored_world.py"


@contextmanager
def anchored(url: str, *options: str) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run a world that has started a program; yield it and the process ID of the program."""
    with started(ANCHORED, url, *options, mission="undersea") as served:
        try:
            assert served.stdout is not None
            program = int(served.stdout.readline())
            assert "serves at" in served.stdout.readline()
            assert is_running(program)
            yield served, program
        finally:
            served.kill()


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 0), (signal.SIGKILL, -9)]
)
def test_a_signal_ends_a_world_and_what_it_started(number, code):
    with EmbeddedBridge() as server, anchored(server.url) as (served, program):
        served.send_signal(number)
        assert served.wait(timeout=30) == code
        wait_for(lambda: not is_running(program))


def test_an_error_ends_what_a_world_started():
    with EmbeddedBridge() as server, anchored(server.url) as (served, program):
        with going(server.url, 1, 5, 0):
            assert served.wait(timeout=30) == 1
        assert not is_running(program)


def test_a_lost_connection_ends_what_a_world_started():
    with EmbeddedBridge() as server, anchored(server.url) as (served, program):
        server.close()
        assert served.wait(timeout=30) == 1
        assert not is_running(program)


@pytest.mark.parametrize(("late", "expected"), [("0", []), ("3", [3])])
def test_a_world_reports_how_many_commands_came_too_late(late, expected):
    with (
        EmbeddedBridge() as server,
        anchored(server.url, "--late", late),
        going(server.url, 1, 0, 0, listened=[TICK]) as messages,
    ):
        *_, n_obeyed = (numbers := messages.get(timeout=30)["data"])[:4]

    assert n_obeyed == 0
    assert numbers[4:] == expected


def test_a_world_may_sample_by_itself():
    topics = [Topic("/nautilus/sensor1/samples", "std_msgs/Int64")]
    energy = [Topic("/nautilus/energy", "std_msgs/Float64")]
    with EmbeddedBridge() as server, anchored(server.url):
        with going(server.url, 1, 0, 0, listened=topics) as messages:
            n_valid = messages.get(timeout=30)["data"]
        with going(server.url, 1, 0, 0, listened=energy) as messages:
            left = messages.get(timeout=30)["data"]

    assert n_valid == 2
    assert left == pytest.approx(27000.0 - 3 * (3.0 + 2.4 + 2.1))


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--mission", "nowhere"), "nowhere: [Errno 2] No such file or directory: 'nowhere'"),
        (("--prefix", "world"), "--prefix: found 'world'; expected a name such as /world"),
    ],
)
def test_what_a_world_does_not_fly_is_refused_in_one_line(options, problem):
    with started(WORLDS / OURS / "world.py", "ws://127.0.0.1:9", *options) as refused:
        _, told = refused.communicate(timeout=30)

    assert refused.returncode == 2
    assert told.endswith(f"{problem}\n")
    assert "Traceback" not in told
