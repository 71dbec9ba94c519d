"""Models to generate from: copies of the paper's mission, and missions of other shapes."""

import shutil
import subprocess
import sys
from pathlib import Path

from tests.support.tree import ROOT

MODELS = ROOT / "models" / "uuv_sampling"
GENERATED = ROOT / "generated" / "uuv_sampling"
FILES = (
    "mission_loader.py",
    "fault_loader.py",
    "fault_effects.py",
    "topics.py",
    "sim_interface.py",
    "simulation.py",
    "collective_intelligence.py",
)

_HEAD = """<?xml version="1.0" encoding="ASCII"?>
<mission:Mission xmi:version="2.0" xmlns:xmi="http://www.omg.org/XMI" \
xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" \
xmlns:mission="http://mrsfi.org/mission/1.0" name="tests" duration="100">
  <missionArea ID="a0" radius="500.0"/>
"""

ALL_TASKS = f"""{_HEAD}  <robots ID="Scout-1" name="first scout" speed="2.5">
    <intProperties name="hull number" value="7"/>
    <stringProperties name="skipper" value="none"/>
    <doubleProperties name="draught" value="1.5"/>
    <sensors ID="scout_gps" name="GPS" type="GPS_POSITION" energyPerSample="1.0" \
samplesPerSecond="1"/>
    <batteries ID="b1" name="battery" totalEnergy="1.0E12"/>
    <motionSources ID="ms1" name="drive" energyPerDistanceUnit="0.25"/>
  </robots>
  <robots ID="Scout-2" name="O'Hara" speed="2.0">
    <position x="50.0" y="1.0E-5"/>
    <batteries ID="b2" name="battery" totalEnergy="100000.0"/>
  </robots>
  <servers ID="sv1" name="server">
    <stringProperties name="place" value="{{{{ ashore }}}}"/>
  </servers>
  <obstacles ID="o1">
    <area ID="a1" radius="5.0">
      <center x="200.0" y="200.0"/>
    </area>
  </obstacles>
  <goals ID="collision" name="c" members="Scout-1 Scout-2" dependentGoals="area">
    <task xsi:type="mission:AvoidCollision" robots="Scout-1 Scout-2" obstacles="o1"/>
    <messages ID="m1" sender="Scout-1" receiver="sv1">
      <body name="POSITION" type="Coordinates"/>
      <body name="SPEED" type="Int"/>
    </messages>
  </goals>
  <goals ID="area" name="s" members="Scout-1">
    <task xsi:type="mission:StayWithinMissionArea"/>
  </goals>
  <goals ID="energy" name="e" members="Scout-2">
    <task xsi:type="mission:SufficientEnergy"/>
  </goals>
  <goals ID="samples" name="g" members="Scout-1">
    <area ID="a2" radius="100.0"/>
    <task xsi:type="mission:GatherSamples" targetSampleNumber="3" sensor="scout_gps"/>
  </goals>
  <goals ID="patrol" name="p" members="Scout-1">
    <task xsi:type="mission:Patrol" period="50">
      <area ID="a3" radius="20.0"/>
    </task>
  </goals>
  <goals ID="visit" name="v" members="Scout-1">
    <task xsi:type="mission:Visit" deadline="90">
      <coordinates x="10.0"/>
    </task>
  </goals>
  <goals ID="track" name="t" members="Scout-1">
    <task xsi:type="mission:Track" tolerance="500.0">
      <trajectory/>
      <trajectory x="10.0"/>
    </task>
  </goals>
  <goals ID="stay" name="st" members="Scout-1">
    <task xsi:type="mission:Stay">
      <area ID="a4" radius="400.0"/>
    </task>
  </goals>
  <goals ID="distance" name="f" members="Scout-1 Scout-2">
    <task xsi:type="mission:FixedDistanceBetweenRobots" fixedDistance="50.0" tolerance="5.0"/>
  </goals>
</mission:Mission>
"""
"""All nine tasks, properties of every type, a robot without sensors, IDs in need of translation."""

BARE = f"""{_HEAD}  <robots ID="r1" name="alone" speed="1.0">
    <batteries ID="b1" name="battery" totalEnergy="100000.0"/>
  </robots>
  <goals ID="g1" name="stay" members="r1">
    <task xsi:type="mission:StayWithinMissionArea"/>
  </goals>
</mission:Mission>
"""
"""As little as a mission may hold: one robot, one goal, no sensor, no obstacle, no server."""


def copy_models(folder: Path) -> Path:
    """Return a copy of the paper's mission folder under its own name."""
    return Path(shutil.copytree(MODELS, folder / "models" / "uuv_sampling"))


def write_mission(folder: Path, name: str, mission: str) -> Path:
    """Return a mission folder with this mission and no faults."""
    models = folder / "models" / name
    models.mkdir(parents=True)
    (models / "mission.xmi").write_text(mission)
    return models


def edit(path: Path, old: str, new: str) -> None:
    """Replace a text that stands in a file exactly once."""
    text = path.read_text()
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {path}"
    path.write_text(text.replace(old, new))


def contents(folder: Path) -> dict[str, str]:
    """Return the texts of all files of a folder by name."""
    return {path.name: path.read_text() for path in sorted(folder.iterdir()) if path.is_file()}


def run_module(module: str, *arguments: str | Path, **environment: str) -> str:
    """Run a Python module in the project's root and return what it printed."""
    done = subprocess.run(
        [sys.executable, "-m", module, *map(str, arguments)],
        cwd=ROOT,
        env=environment or None,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
