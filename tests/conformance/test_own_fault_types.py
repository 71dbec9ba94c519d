"""Fault types that a team has added: of a known mode, and with an effect of their own.

Each is said in ``faults.ecore``; what an own effect does stands in a region. Both engines agree
to the last bit, also on a specification that follows others.
"""

import shutil
from pathlib import Path

import pytest

from m2t.generate import generate
from mrsfi_runtime.engine.compiled.compiler import CompilationError
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.region_lint import lint_regions
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import Gate, TimedFault, value_bounds
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.search.space import SearchSpace
from tests.support.cli import edit
from tests.support.edited import write_body
from tests.support.own_metamodels import (
    add_fault_type,
    add_faults,
    attribute,
    copy_metamodels,
    meaning,
    metamodels_of,
    parameter,
)
from tests.support.tree import ROOT
from tests.tiers import night, slow

START, FINISH = 30, 60
MISSION = ROOT / "models" / "uuv_sampling"
STUCK = """    robot = ci.robots[fault.target]
    if fault.age == 0:
        fault.memory[0] = robot.speed
        fault.memory[7] = robot.energy
    robot.speed = fault.memory[0] + fault.values[STUCK_REPORT_OFFSET]
    robot.energy = fault.memory[7]
"""
HOLD = """    sensor = ci.sensors[fault.target]
    fault.memory[0] += 1.0
    sensor.count = int(fault.memory[0])
"""
SHIFT = """    obstacle = ci.obstacles[fault.target]
    obstacle.x = obstacle.model_x + fault.values[0] * fault.age
"""


def _message(tag: str, values: str = "") -> str:
    return f'<{tag}{values}><affectedMessage href="mission.xmi#m8"/></{tag}>'


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the generated code of a mission whose pool has types of a team's own."""
    folder = tmp_path_factory.mktemp("own")
    faults = copy_metamodels(folder / "metamodels")
    offset = parameter("BY", "EInt", range="SPEED") + attribute("BY_MAX", "EInt")
    add_fault_type(
        faults, "FalseOdometer", "RobotFault", meaning(mode="INCREMENT", property="SPEED") + offset
    )
    add_fault_type(
        faults,
        "DrawnCount",
        "SensorFault",
        meaning(mode="RANDOM", property="COUNT")
        + parameter("LEAST", range="COUNT", role="LOWEST", search="false")
        + parameter("MOST", range="COUNT", role="HIGHEST"),
    )
    add_fault_type(
        faults,
        "StuckReport",
        "MessageFault",
        meaning(mode="OWN", property="SPEED ENERGY") + parameter("OFFSET", range="SPEED"),
    )
    add_fault_type(faults, "Held", "SensorFault", meaning(mode="OWN", property="COUNT"))
    add_fault_type(
        faults,
        "Drift",
        "ObstacleFault",
        meaning(mode="OWN", property="OBSTACLE") + parameter("BY", range="SHARE"),
    )
    models = shutil.copytree(MISSION, folder / "models" / "uuv_sampling")
    edit(models / "mission.xmi", 'duration="1000"', 'duration="90"')
    add_faults(
        models / "faults.xmi",
        {
            "odometer": '<falseOdometer BY="3" BY_MAX="7"><affectedRobot href="mission.xmi#r3"/>'
            "</falseOdometer>",
            "drawn": '<drawnCount LEAST="1.0" MOST="9.0"><affectedSensor href="mission.xmi#s4"/>'
            "</drawnCount>",
            "stuck": _message("stuckReport", ' OFFSET="1.5"'),
            "silent": '<stuckReport OFFSET="1.0"><affectedMessage href="mission.xmi#m1"/>'
            "</stuckReport>",
            "held": '<held><affectedSensor href="mission.xmi#s4"/></held>',
            "drift": '<drift BY="0.5"><affectedObstacle href="mission.xmi#o5"/></drift>',
        },
    )
    code = folder / "generated" / "uuv_sampling"
    with metamodels_of(faults.parent):
        generate(models, code)
        for kind, body in {"StuckReport": STUCK, "Held": HOLD, "Drift": SHIFT}.items():
            write_body(code / "fault_effects.py", f"{kind}.apply", body)
        assert generate(models, code).written == ()
    return code


@pytest.fixture(scope="module")
def code(target: Path) -> MissionCode:
    return load_code(target)


class Beliefs:
    """Observer that keeps speed and energy of the third robot, and what else is falsified."""

    def __init__(self):
        self.rows = []
        self.true = []

    def __call__(self, world, belief, verdicts):
        for state, rows in ((world, self.true), (belief, self.rows)):
            robot = state.robots[2]
            rows.append((robot.speed, robot.energy, state.sensors[3].count, state.obstacles[4].x))


def fly(code: MissionCode, fault: str, values: tuple[float, ...]) -> Beliefs:
    seen = Beliefs()
    timed = TimedFault(fault, START, FINISH, values)
    ReferenceEngine(code, 3).evaluate((timed,), observer=seen)
    return seen


@pytest.mark.parametrize(
    ("fault", "values", "expected"),
    [
        ("odometer", (3.0,), lambda true, _first, _age: (true[0] + 3.0, *true[1:])),
        ("stuck", (1.5,), lambda true, first, _age: (first[0] + 1.5, first[1], *true[2:])),
        ("drift", (0.5,), lambda true, _first, age: (*true[:3], true[3] + 0.5 * age)),
    ],
)
def test_types_of_a_team_act_from_start_to_finish_and_on_nothing_else(
    code, fault, values, expected
):
    seen = fly(code, fault, values)

    for tick, (believed, true) in enumerate(zip(seen.rows, seen.true, strict=True)):
        is_active = START <= tick <= FINISH
        assert believed == (expected(true, seen.true[START], tick - START) if is_active else true)


def test_a_random_count_is_whole_and_within_its_bounds(code):
    seen = fly(code, "drawn", (1.0, 9.0))

    drawn = {seen.rows[tick][2] for tick in range(START, FINISH + 1)}
    assert drawn <= set(range(1, 10))
    assert len(drawn) > 3


def test_bounds_and_conflicts_follow_from_what_the_metamodel_says(code):
    pool = code.pool
    speed = code.mission.robots[2].speed
    table = Gate(code.mission, pool).conflicts()

    assert value_bounds(code.mission, pool["odometer"]) == ((0.0, 7.0),)
    assert value_bounds(code.mission, pool["drawn"]) == ((1.0, 1.0), (0.0, 90.0))
    assert value_bounds(code.mission, pool["stuck"]) == ((0.0, 10.0 * speed),)
    assert value_bounds(code.mission, pool["drift"]) == ((0.0, 1.0),)
    assert {"odometer", "f24", "f27", "stuck"} <= table["stuck"]
    assert table["drift"] == {"f9", "drift"}
    assert SearchSpace.of(code.mission, pool).candidates["odometer"].bounds == ((0.0, 7.0),)


def test_an_own_effect_on_a_message_that_lacks_a_property_does_nothing(code):
    (outcome,) = ReferenceEngine(code, 3).evaluate_many([(TimedFault("silent", 0, 20, (1.0,)),)])

    assert outcome.applied == (0,)


SPECIFICATIONS = [
    (TimedFault("stuck", 10, 50, (1.5,)), TimedFault("held", 20, 80)),
    (TimedFault("held", 5, 30), TimedFault("drift", 7, 70, (0.25,))),
    (TimedFault("odometer", 5, 30, (4.0,)), TimedFault("drawn", 7, 70, (1.0, 5.0))),
    (TimedFault("stuck", 10, 50, (1.5,)), TimedFault("held", 20, 80)),
    (TimedFault("held", 1, 2), TimedFault("held", 20, 80), TimedFault("f1", 0, 89)),
]


@night
def test_both_engines_agree_also_after_other_specifications(code):
    reference = ReferenceEngine(code, 3)
    expected = [reference.evaluate(specification) for specification in SPECIFICATIONS]

    with CompiledEngine(code, 3) as engine:
        found = list(engine.evaluate_many(SPECIFICATIONS))
        again = [engine.evaluate(specification) for specification in reversed(SPECIFICATIONS)]

    assert found == expected
    assert again == expected[::-1]
    assert all(all(outcome.changed) for outcome in found[:4])


@slow
def test_both_engines_tell_alike_when_a_fault_first_changed_something(code):
    reference = ReferenceEngine(code, 3)

    with CompiledEngine(code, 3) as engine:
        for specification in SPECIFICATIONS:
            found, expected = [], []
            engine.evaluate(specification, tallies=found)
            reference.evaluate(specification, tallies=expected)

            assert found == expected
            assert all(
                timed.start <= tally.first_changed <= timed.finish
                for timed, tally in zip(specification, found, strict=True)
                if tally.changed
            )


@slow
def test_own_effects_fly_over_rosbridge_as_without_a_bus(code):
    expected = [ReferenceEngine(code, 3).evaluate(each) for each in SPECIFICATIONS[:2]]

    with RosbridgeEngine(code, 3, EngineSettings()) as engine:
        found = [engine.evaluate(each) for each in SPECIFICATIONS[:2]]

    assert found == expected


@slow
def test_what_does_not_compile_in_a_region_is_named_and_linted_with_its_line(target, tmp_path):
    folder = shutil.copytree(target, tmp_path / "generated")
    end = "    # protected region Held.apply end\n"
    edit(folder / "fault_effects.py", end, f"    sensor.rate = sensor.rat + fault.agee\n{end}")
    lines = (folder / "fault_effects.py").read_text(encoding="utf-8").split("\n")
    line = lines.index("    sensor.rate = sensor.rat + fault.agee") + 1

    with pytest.raises(CompilationError) as caught:
        CompiledEngine(load_code(folder), 3)

    assert "region Held.apply cannot be compiled: records have no 'rat'" in str(caught.value)
    said = [found.message for found in lint_regions(folder) if found.line == line]
    assert any("sensor.rat" in message for message in said)
    assert any("fault.agee" in message for message in said)


LINES = (
    ("ci.robots[0].speed = 99.0", "speed of ci.robots[0]"),
    ("ci.robots[fault.target].x = 99.0", "x of ci.robots[2]"),
    ("ci.commands[1].speed = 99.0", "speed of ci.commands[1]"),
    ("ci.goals[1].count = 99", "count of ci.goals[1]"),
    ("ci.goals[1].memory[3] = 99.0", "memory of ci.goals[1]"),
    ("ci.mission.tick = 99", "tick of ci.mission[0]"),
    ("ci.map.reach = 99.0", "reach of ci.map[0]"),
    ("inbox.robots[2].speed = 99.0", "speed of inbox.robots[2]"),
    ("fault.target = 1", "target of fault[0]"),
    ("fault.values[1] = 99.0", "values of fault[0]"),
    ("ci.robots[0].x = 99.0", "x of ci.robots[0]"),
)
OFFSETS = range(101, 101 + len(LINES))
"""What an effect must not do and what is said of it; the stuck report that makes it do so."""


@pytest.mark.parametrize(("line", "named"), LINES)
def test_an_effect_that_changes_what_its_type_does_not_name_is_an_error(
    target, tmp_path, line, named
):
    folder = shutil.copytree(target, tmp_path / "generated")
    end = "    # protected region StuckReport.apply end\n"
    edit(folder / "fault_effects.py", end, f"    {line}\n{end}")

    with pytest.raises(EvaluationError) as caught:
        ReferenceEngine(load_code(folder), 3).evaluate((TimedFault("stuck", 10, 50, (1.5,)),))

    assert f"region 'StuckReport.apply' of fault_effects.py changed {named}" in str(caught.value)
    assert "expected it to change only SPEED and ENERGY of its target" in str(caught.value)


@slow
def test_compiled_too_an_effect_may_change_only_what_its_type_names(target, tmp_path, monkeypatch):
    folder = shutil.copytree(target, tmp_path / "generated")
    end = "    # protected region StuckReport.apply end\n"
    lines = "".join(
        f"    if fault.age == 42 and fault.values[0] == {offset}.0:\n        {line}\n"
        for offset, (line, _) in zip(OFFSETS, LINES, strict=True)
    )
    edit(folder / "fault_effects.py", end, f"{lines}{end}")
    code = load_code(folder)
    specifications = [(TimedFault("stuck", 0, 80, (float(k),)),) for k in (1, *OFFSETS, 2)]

    with CompiledEngine(code, 3) as engine:
        engine.require_same()
        repeated = []
        attempt = ReferenceEngine.attempt
        monkeypatch.setattr(
            ReferenceEngine, "attempt", lambda *each: (repeated.append(each[1]), attempt(*each))[1]
        )
        first, *found, last = engine.evaluate_many(specifications)

    expected = [*ReferenceEngine(code, 3).evaluate_many(specifications)]
    assert repeated[: len(LINES)] == specifications[1:-1]
    assert (first, last) == (expected[0], expected[-1])
    for failure, (_, named) in zip(found, LINES, strict=True):
        assert f"'StuckReport.apply' of fault_effects.py changed {named}" in failure.traceback
