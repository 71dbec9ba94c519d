"""Every goal task, generated and flown: kept without faults, violated under a fault.

Each mission is a small model with one goal of the task; the code is what `mrsfi generate`
makes of it, unedited.
"""

from dataclasses import replace

import pytest

from m2t.generate import generate
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.goal_tasks.table import TASKS as KNOWN
from mrsfi_runtime.model.faults import Fault, FaultPool, TimedFault
from tests.support.fault_types import FAULT_TYPES
from tests.support.models.generation import write_mission

ROBOT = """  <robots ID="{name}" name="{name}" speed="{speed}">
    <position x="{x}" y="{y}"/>
    <sensors ID="{name}_gps" name="" type="GPS_POSITION" energyPerSample="1.0" \
samplesPerSecond="4"/>
    <sensors ID="{name}_depth" name="" type="DEPTH" energyPerSample="1.0" samplesPerSecond="4"/>
    <batteries ID="{name}_battery" name="" totalEnergy="20000.0"/>
    <motionSources ID="{name}_drive" name="" energyPerDistanceUnit="2.0"/>
  </robots>
"""

MISSION = """<?xml version="1.0" encoding="ASCII"?>
<mission:Mission xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="one task" duration="300">
  <missionArea ID="whole" radius="400.0"/>
{robots}  <servers ID="base" name="base"/>
  <obstacles ID="rock">
    <area ID="rock_area" radius="20.0">
      <center x="60.0"/>
    </area>
  </obstacles>
  <goals ID="goal" name="goal" members="{members}">
{area}    <task xsi:type="mission:{task}"{attributes}>{content}</task>
    <messages ID="from_a" sender="a" receiver="base">
      <body name="POSITION" type="Coordinates"/>
      <body name="ENERGY" type="Double"/>
      <body name="SPEED" type="Int"/>
    </messages>
  </goals>
</mission:Mission>
"""

ALONE = ROBOT.format(name="a", speed="3.0", x="0.0", y="0.0")
BESIDE = ROBOT.format(name="b", speed="3.0", x="0.0", y="50.0")
PLACE = '<area ID="place" radius="40.0"/>'
PATH = '<trajectory/><trajectory y="120.0"/><trajectory x="-90.0" y="120.0"/>'

TASKS = {
    "AvoidCollision": (ALONE + BESIDE, 'robots="a b" obstacles="rock"', ""),
    "StayWithinMissionArea": (ALONE, "", ""),
    "SufficientEnergy": (ALONE, "", ""),
    "GatherSamples": (ALONE, 'targetSampleNumber="150" sensor="a_depth"', ""),
    "Patrol": (ALONE, 'period="30"', PLACE),
    "Visit": (ALONE, 'tolerance="1.0" deadline="50"', '<coordinates y="100.0"/>'),
    "Track": (ALONE, 'tolerance="6.0"', PATH),
    "Stay": (ALONE, "", PLACE),
    "FixedDistanceBetweenRobots": (ALONE + BESIDE, 'fixedDistance="50.0" tolerance="12.0"', ""),
}

KNOWING = [task for task in TASKS if task not in ("Visit", "Track", "FixedDistanceBetweenRobots")]
"""Tasks whose reactions know of turn rates and noise."""

STRAY = Fault("stray", FAULT_TYPES["FixedRobotCoordinates"], "from_a", (500.0, 500.0, 0.0))
HIT = Fault("hit", FAULT_TYPES["FixedRobotCoordinates"], "from_a", (60.0, 0.0, 0.0))
DRAINED = Fault("drained", FAULT_TYPES["ZeroRemainingEnergyCapacityReport"], "from_a")
HARMFUL = {"AvoidCollision": HIT, "SufficientEnergy": DRAINED}


@pytest.fixture(params=TASKS)
def flown(request, tmp_path):
    robots, attributes, content = TASKS[request.param]
    text = MISSION.format(
        robots=robots,
        members="a b" if robots != ALONE else "a",
        area='    <area ID="samples" radius="50.0"/>\n' if request.param == "GatherSamples" else "",
        task=request.param,
        attributes=f" {attributes}" if attributes else "",
        content=content,
    )
    models = write_mission(tmp_path, "one_task", text)
    target = tmp_path / "generated" / "one_task"
    generate(models, target)
    return request.param, load_code(target)


def test_every_task_has_a_mission_here():
    assert {task.__name__ for task in KNOWN} == set(TASKS)


def test_without_faults_the_reference_behaviour_keeps_the_goal(flown):
    _, code = flown

    for seed in range(5):
        outcome = ReferenceEngine(code, seed).evaluate(())
        assert (outcome.believed, outcome.true) == ((0,), (0,)), seed


@pytest.mark.parametrize("flown", KNOWING, indirect=True)
def test_robots_that_turn_slowly_and_report_inexactly_keep_the_goal_too(flown):
    _, code = flown
    odd = {"turn_rate": 45.0, "position_noise": 1.0}
    robots = tuple(replace(robot, **odd) for robot in code.mission.robots)
    code = replace(code, mission=replace(code.mission, robots=robots))

    for seed in range(5):
        outcome = ReferenceEngine(code, seed).evaluate(())
        assert (outcome.believed, outcome.true) == ((0,), (0,)), seed


def test_a_false_report_makes_the_goal_believed_violated(flown):
    task, code = flown
    pool = FaultPool("one", (HARMFUL.get(task, STRAY),))
    specification = (TimedFault(pool.faults[0].id, 10, 200, pool.faults[0].values),)

    outcome = ReferenceEngine(code, 1).evaluate(specification, pool=pool)

    assert outcome.applied == (191,)
    assert outcome.believed[0] > 0
