"""Fault types that a team has added: of a known mode, and with an effect of their own.

Each is said in ``faults.ecore``; what an own effect does stands in a region. Both engines agree
to the last bit, also on a specification that follows others.
"""

import shutil
from pathlib import Path
from random import Random

import pytest

from m2t.generate import generate
from mrsfi_runtime.cosimulation.waiting import Patience
from mrsfi_runtime.engine.compiled.compilation_errors import CompilationError
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.engine.region_lint import lint_regions
from mrsfi_runtime.engine.rosbridge import RosbridgeEngine
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.model.targets import conflicts
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from mrsfi_runtime.search.steps import crept
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
from tests.tiers import slow

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
        faults, "WheelSlip", "RobotFault", meaning(mode="INCREMENT", property="SPEED") + offset
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
            "slip": '<wheelSlip BY="3" BY_MAX="7"><affectedRobot href="mission.xmi#r3"/>'
            "</wheelSlip>",
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


def test_a_type_of_a_known_mode_acts_on_a_robot_without_any_message(code):
    seen = fly(code, "slip", (3.0,))

    for tick, (believed, true) in enumerate(zip(seen.rows, seen.true, strict=True)):
        expected = true[0] + 3.0 if START <= tick <= FINISH else true[0]
        assert believed[0] == expected
        assert believed[1:] == true[1:]


def test_a_random_count_is_whole_and_within_its_bounds(code):
    seen = fly(code, "drawn", (1.0, 9.0))

    drawn = {seen.rows[tick][2] for tick in range(START, FINISH + 1)}
    assert drawn <= set(range(1, 10))
    assert len(drawn) > 3


def test_bounds_and_conflicts_follow_from_what_the_metamodel_says(code):
    pool = code.pool
    speed = code.mission.robots[2].speed
    table = conflicts(code.mission, pool)

    assert value_bounds(code.mission, pool["slip"]) == ((0.0, 7.0),)
    assert value_bounds(code.mission, pool["drawn"]) == ((1.0, 1.0), (0.0, 90.0))
    assert value_bounds(code.mission, pool["stuck"]) == ((0.0, 10.0 * speed),)
    assert value_bounds(code.mission, pool["drift"]) == ((0.0, 1.0),)
    assert {"slip", "f24", "f27", "stuck"} <= table["stuck"]
    assert table["drift"] == {"f9", "drift"}
    assert SearchSpace.of(code.mission, pool).candidates["slip"].bounds == ((0.0, 7.0),)


def test_an_own_effect_remembers_from_its_start_to_its_finish(code):
    seen = fly(code, "stuck", (1.5,))

    at_start = seen.true[START]
    for tick, (believed, true) in enumerate(zip(seen.rows, seen.true, strict=True)):
        if START <= tick <= FINISH:
            assert believed[:2] == (at_start[0] + 1.5, at_start[1])
        else:
            assert believed[:2] == true[:2]
        assert believed[2:] == true[2:]


def test_an_own_effect_moves_an_obstacle_on_the_map_and_back(code):
    seen = fly(code, "drift", (0.5,))

    for tick, (believed, true) in enumerate(zip(seen.rows, seen.true, strict=True)):
        shift = 0.5 * (tick - START) if START <= tick <= FINISH else 0.0
        assert believed[3] == true[3] + shift


def test_an_own_effect_on_a_message_that_lacks_a_property_does_nothing(code):
    (outcome,) = ReferenceEngine(code, 3).evaluate_many([(TimedFault("silent", 0, 20, (1.0,)),)])

    assert outcome.applied == (0,)


SPECIFICATIONS = [
    (TimedFault("stuck", 10, 50, (1.5,)), TimedFault("held", 20, 80)),
    (TimedFault("held", 5, 30), TimedFault("drift", 7, 70, (0.25,))),
    (TimedFault("slip", 5, 30, (4.0,)), TimedFault("drawn", 7, 70, (1.0, 5.0))),
    (TimedFault("stuck", 10, 50, (1.5,)), TimedFault("held", 20, 80)),
    (TimedFault("held", 1, 2), TimedFault("held", 20, 80), TimedFault("f1", 0, 89)),
]


@slow
@pytest.mark.turn(1)
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

    with RosbridgeEngine(code, 3, patience=Patience()) as engine:
        found = [engine.evaluate(each) for each in SPECIFICATIONS[:2]]

    assert found == expected


def test_search_evolves_own_types_within_the_bounds_of_their_ranges(code):
    space = SearchSpace.of(code.mission, code.pool)
    rng = Random(5)

    drawn = [
        timed
        for _ in range(60)
        for timed in crept(space, random_specification(space, 20, rng), rng)
        if timed.fault in {"slip", "drawn", "stuck", "drift"}
    ]

    assert {timed.fault for timed in drawn} == {"slip", "drawn", "stuck", "drift"}
    for timed in drawn:
        for value, (low, high) in zip(
            timed.values, space.candidates[timed.fault].bounds, strict=True
        ):
            assert low <= value <= high
    assert all(timed.values[0] % 1 == 0 for timed in drawn if timed.fault == "slip")


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


@pytest.mark.parametrize(
    ("line", "named"),
    [
        ("ci.robots[0].speed = 99.0", "speed of ci.robots[0]"),
        ("ci.robots[fault.target].x = 99.0", "x of ci.robots[2]"),
        ("ci.commands[1].speed = 99.0", "speed of ci.commands[1]"),
        ("ci.goals[1].count = 99", "count of ci.goals[1]"),
        ("ci.mission.tick = 99", "tick of ci.mission[0]"),
        ("inbox.robots[2].speed = 99.0", "speed of inbox.robots[2]"),
        ("fault.target = 1", "target of fault[0]"),
        ("fault.values[0] = 99.0", "values of fault[0]"),
    ],
)
def test_an_effect_that_changes_what_its_type_does_not_name_is_an_error(
    target, tmp_path, line, named
):
    folder = shutil.copytree(target, tmp_path / "generated")
    end = "    # protected region StuckReport.apply end\n"
    edit(folder / "fault_effects.py", end, f"    {line}\n{end}")

    with pytest.raises(EvaluationError) as caught:
        ReferenceEngine(load_code(folder), 3).evaluate((TimedFault("stuck", 10, 50, (1.5,)),))

    assert f"region 'StuckReport.apply' of fault_effects.py changed {named}" in str(caught.value)
    assert "expected it to change SPEED and ENERGY of its target alone" in str(caught.value)


LINES = {
    101: ("ci.robots[0].speed = 99.0", "speed of ci.robots[0]"),
    102: ("ci.robots[fault.target].x = 99.0", "x of ci.robots[2]"),
    103: ("ci.commands[1].speed = 99.0", "speed of ci.commands[1]"),
    104: ("ci.goals[1].memory[3] = 99.0", "memory of ci.goals[1]"),
    105: ("ci.mission.tick = 99", "tick of ci.mission[0]"),
    106: ("ci.map.reach = 99.0", "reach of ci.map[0]"),
    107: ("inbox.robots[2].speed = 99.0", "speed of inbox.robots[2]"),
    108: ("fault.target = 1", "target of fault[0]"),
    109: ("fault.values[1] = 99.0", "values of fault[0]"),
    110: ("ci.robots[0].x = 99.0", "x of ci.robots[0]"),
}
"""Offset of a stuck report, what it makes the effect do from tick 42 on, and what that is."""


@slow
def test_compiled_too_an_effect_may_change_only_what_its_type_names(target, tmp_path, monkeypatch):
    folder = shutil.copytree(target, tmp_path / "generated")
    end = "    # protected region StuckReport.apply end\n"
    lines = "".join(
        f"    if fault.age == 42 and fault.values[0] == {offset}.0:\n        {line}\n"
        for offset, (line, _) in LINES.items()
    )
    edit(folder / "fault_effects.py", end, f"{lines}{end}")
    code = load_code(folder)
    specifications = [(TimedFault("stuck", 0, 80, (float(k),)),) for k in (1, *LINES, 2)]

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
    for failure, (_, named) in zip(found, LINES.values(), strict=True):
        assert f"'StuckReport.apply' of fault_effects.py changed {named}" in failure.traceback
