"""A mission whose causes are there by construction: robots that must be at a point by a deadline.

Robots a and b begin 200 units from the point, and fly 4 a tick: they are there at tick 50, and have
until tick 70. Goals g1 and g2 are about one of them each, g3 about both. A goal that is missed at
the deadline is violated until its robots arrive, or to the end, at tick 119.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from shutil import copy

from m2t.generate import generate
from tests.support.tree import ROOT

NAME = "rendezvous"
_XMI = 'xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI"'
_ROBOT = """
  <robots ID="{0}" name="{0}" speed="4.0">
    <position x="{1}"/>
    <batteries ID="{0}_battery" name="" totalEnergy="100000.0"/>
    <motionSources ID="{0}_drive" name="" energyPerDistanceUnit="1.0"/>
  </robots>"""
_GOAL = """
  <goals ID="{0}" name="" members="{1}">
    <task xsi:type="mission:Visit" tolerance="3.0" deadline="70">
      <coordinates x="0.0" y="0.0"/>
    </task>{2}
  </goals>"""
_MESSAGE = """
    <messages ID="report" sender="a" receiver="base">
      <body name="POSITION" type="Coordinates"/>
    </messages>"""
MISSION = f"""<?xml version="1.0" encoding="ASCII"?>
<mission:Mission {_XMI} xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="rendezvous" duration="120">
  <missionArea ID="whole" radius="1000.0"><center/></missionArea>\
{_ROBOT.format("a", -200.0)}{_ROBOT.format("b", 200.0)}
  <servers ID="base" name=""/>\
{_GOAL.format("g1", "a", _MESSAGE)}{_GOAL.format("g2", "b", "")}{_GOAL.format("g3", "a b", "")}
</mission:Mission>
"""
FAULTS = f"""<?xml version="1.0" encoding="ASCII"?>
<faults:FaultSpecification {_XMI} xmlns:faults="http://mrsfi.org/faults/1.0" ID="pool">
  <faults ID="stop_a" name=""><stopRobot><affectedRobot href="mission.xmi#a"/></stopRobot></faults>
  <faults ID="stop_b" name=""><stopRobot><affectedRobot href="mission.xmi#b"/></stopRobot></faults>
  <faults ID="lie_a" name=""><fixedRobotCoordinates NEW_X="0.0" NEW_Y="0.0" NEW_Z="0.0">
    <affectedMessage href="mission.xmi#report"/></fixedRobotCoordinates></faults>
</faults:FaultSpecification>
"""
DEADLINE, DURATION = 70, 120


def write_rendezvous(place: Path) -> Path:
    """Write models and generated code of the mission into a folder; return that of the code."""
    models, generated = place / "models" / NAME, place / "generated" / NAME
    models.mkdir(parents=True)
    (models / "mission.xmi").write_text(MISSION, encoding="ascii")
    (models / "faults.xmi").write_text(FAULTS, encoding="ascii")
    generate(models, generated)
    return generated


SOLE = (("stop_b", 60, 65), ("stop_a", 10, 119))
"""The second does it alone."""

TOGETHER = (("stop_a", 10, 22), ("stop_b", 10, 22), ("stop_a", 30, 42))
"""The first and the third make robot a too late, and only together."""

EITHER = (("stop_a", 10, 119), ("stop_b", 20, 119))
"""Goal g3 fails under either, g1 and g2 under one each."""

HIDDEN = (("stop_a", 10, 119), ("lie_a", 60, 119, (0.0, 0.0, 0.0)), ("stop_b", 10, 119))
"""The second hides from the collective intelligence what the first does."""

PLANTED = (SOLE, TOGETHER, EITHER, HIDDEN)


def harmless(n: int) -> list[tuple[tuple[str, int, int], ...]]:
    """Return specifications that violate nothing: they stop a robot that is there already."""
    return [(("stop_b", 75 + k // 20, 95 + k % 20),) for k in range(n)]


N_SEARCHED = 130
"""Evaluations of the search that finds all that is planted, and enough that may be flown after."""


def searched(place: Path) -> tuple[str, ...]:
    """Return what searches what is planted, among what is harmless."""
    return write_planted(place, [*PLANTED, *harmless(N_SEARCHED - len(PLANTED))])


def write_planted(
    place: Path, specifications: Sequence[object], **settings: object
) -> tuple[str, ...]:
    """Write a campaign file whose search asks for specifications; return what evolves them."""
    copy(ROOT / "tests" / "support" / "planted_search.py", place)
    (place / "planted.json").write_text(json.dumps(specifications), encoding="utf-8")
    chosen = {"algorithm": "planted_search:Planted", **settings}
    lines = ["[search]", *(f"{key} = {json.dumps(value)}" for key, value in chosen.items())]
    (place / "planted.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return ("evolve", NAME, "--case", "planted.toml", "--engine", "reference")
