"""Generation from models to files: repeatable, formatted, typed, and true to the model."""

import os

import pytest

from m2t.generate import diff, generate, plan, rendered_file
from m2t.models.load import load_mission_folder
from mrsfi_runtime.api import (
    AvoidCollision,
    FixedDistanceBetweenRobots,
    GatherSamples,
    Patrol,
    Stay,
    StayWithinMissionArea,
    SufficientEnergy,
    Track,
    Visit,
)
from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.generated_code import load_code, pool_from_text
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.model.mission import (
    Area,
    Coordinates,
    DoubleProperty,
    IntProperty,
    StringProperty,
)
from mrsfi_runtime.transport.topics import LocalBus
from tests.support.models.copies import edit
from tests.support.models.generation import (
    ALL_TASKS,
    BARE,
    FILES,
    GENERATED,
    ROOT,
    contents,
    run_module,
    write_mission,
)


@pytest.fixture
def target(tmp_path):
    return tmp_path / "generated" / "uuv_sampling"


@pytest.fixture
def all_shapes(tmp_path):
    """Folders of generated code: the committed one and those of missions of other shapes."""
    folders = [GENERATED]
    for name, text in (("all_tasks", ALL_TASKS), ("bare", BARE)):
        folders.append(tmp_path / "generated" / name)
        generate(write_mission(tmp_path, name, text), folders[-1])
    return folders


def test_generated_code_is_formatted(all_shapes):
    run_module("ruff", "format", "--check", "--config", ROOT / "pyproject.toml", *all_shapes)


def test_generated_code_is_free_of_lint(all_shapes):
    """The collective intelligence imports what regions usually need, used or not."""
    unused = "'collective_intelligence.py' = ['F401']"
    rules = (
        f"lint.per-file-ignores = {{'**' = ['I', 'E501', 'D205', 'INP001', 'TID252'], {unused}}}"
    )
    options = ("--config", ROOT / "pyproject.toml", "--config", rules)

    run_module("ruff", "check", "--no-cache", *options, *all_shapes)


def test_generated_code_is_typed(all_shapes):
    for folder in all_shapes:
        run_module("mypy", "--strict", folder, **os.environ, MYPYPATH=str(folder.parent))


def test_all_tasks_reach_the_mission(tmp_path):
    target = tmp_path / "generated" / "all_tasks"
    generate(write_mission(tmp_path, "all_tasks", ALL_TASKS), target)

    code = load_code(target)

    origin = Coordinates()
    assert [goal.task for goal in code.mission.goals] == [
        AvoidCollision(("Scout-1", "Scout-2"), ("o1",)),
        StayWithinMissionArea(),
        SufficientEnergy(),
        GatherSamples(3, "scout_gps"),
        Patrol(Area("a3", origin, 20.0), 50),
        Visit(Coordinates(10.0), 1.0, 90),
        Track((origin, Coordinates(10.0)), 500.0),
        Stay(Area("a4", origin, 400.0)),
        FixedDistanceBetweenRobots(50.0, 5.0),
    ]
    assert code.mission.goals[0].dependent_goals == ("area",)
    robot, server = code.mission.robots[0], code.mission.servers[0]
    assert robot.int_properties == (IntProperty("hull number", 7),)
    assert robot.string_properties == (StringProperty("skipper", "none"),)
    assert robot.double_properties == (DoubleProperty("draught", 1.5),)
    assert server.string_properties == (StringProperty("place", "{{ ashore }}"),)
    assert code.mission.robots[1].position == Coordinates(50.0, 1e-05)
    assert len(code.pool) == 0
    state = initial_state(code.mission, 1)
    violated = [-1] * 9
    code.functions.progress(state)
    code.functions.check(state, violated)
    code.functions.react(state)
    assert violated == [0] * 9


def test_bounds_and_windows_reach_the_pool(models):
    edit(
        models / "faults.xmi",
        'BLOCK_DURATION="5.0"',
        'BLOCK_DURATION="5.0" BLOCK_DURATION_MAX="10.0"',
    )
    edit(models / "faults.xmi", 'ID="f2" name="f2"', 'ID="f2.1" name="f2" start="0" finish="20"')

    pool = pool_from_text(rendered_file("fault_loader.py", load_mission_folder(models)))

    assert pool["f2.1"].bounds == {"BLOCK_DURATION": (None, 10.0)}
    assert (pool["f2.1"].start, pool["f2.1"].finish) == (0, 20)
    assert (pool["f1"].start, pool["f1"].finish) == (None, None)


@pytest.mark.parametrize("mission", [None, ALL_TASKS, BARE], ids=["paper", "all_tasks", "bare"])
def test_interface_reads_what_the_simulation_publishes(tmp_path, models, mission):
    target = tmp_path / "generated" / "mission"
    generate(write_mission(tmp_path, "other", mission) if mission else models, target)
    code, interface, simulation = on_one_bus(load_code(target))
    inbox = initial_state(code.mission, 99)

    for tick in range(5):
        simulation.step(tick)
    interface.read(inbox)

    def reported(state):
        robots = [(robot.x, robot.y, robot.z, robot.speed, robot.energy) for robot in state.robots]
        return robots, [(sensor.count, sensor.active) for sensor in state.sensors]

    assert reported(inbox) == reported(simulation.world)
    assert simulation.world.mission.tick == 4


@pytest.fixture
def sides(models, target):
    """Code of the paper's mission, the interface and the simulation of it on one bus."""
    generate(models, target)
    return on_one_bus(load_code(target))


def on_one_bus(code):
    bus = LocalBus()
    interface, simulation = code.interface(bus), code.simulation(bus, code.mission)
    simulation.reset(seed=3)
    return code, interface, simulation


def test_reset_forgets_what_was_received(sides):
    code, interface, simulation = sides
    simulation.step(0)

    interface.reset()

    with pytest.raises(ProtocolError, match="/r1/speed"):
        interface.read(initial_state(code.mission, 99))


def test_check_and_diff_write_nothing(models, target):
    assert plan(models, target).stale == (*FILES, "manifest.json")
    assert diff(models, target).startswith("--- /dev/null\n+++ b/mission_loader.py\n")
    assert not target.exists()

    generate(models, target)
    edit(models / "mission.xmi", 'name="LEN" speed="5.0"', 'name="LEN" speed="6.5"')
    before = contents(target)

    assert plan(models, target).stale == ("mission_loader.py", "manifest.json")
    diff(models, target)
    assert contents(target) == before


def test_another_layout_of_a_model_makes_nothing_stale_and_is_remembered(models, target):
    generate(models, target)
    before = contents(target)
    edit(models / "mission.xmi", "  <robots", "\t<!-- one of three -->\n<robots")

    assert plan(models, target).stale == ()
    assert diff(models, target) == ""
    assert generate(models, target).written == ()
    changed = [name for name, content in contents(target).items() if content != before[name]]
    assert changed == ["manifest.json"]
