"""A robot more in the model is a row more in the generated code, not a page."""

from pathlib import Path

from m2t.generate import diff, generate
from tests.support.models.copies import copy_models, edit

ROBOT = """  <robots ID="r4" name="MEL" speed="4.0">
    <position x="-250.0" y="-250.0" z="1.0"/>
    <sensors ID="s7" name="GPS sensor of MEL" type="GPS_POSITION" samplesPerSecond="5"/>
    <sensors ID="s8" name="Depth sensor of MEL" type="DEPTH" samplesPerSecond="5"/>
    <batteries ID="b7" name="Battery of MEL" totalEnergy="50000.0"/>
    <motionSources ID="ms4" name="Thruster of MEL" energyPerDistanceUnit="5.0"/>
  </robots>
"""
ROWS = [
    '+    RobotTopics(robot="r4"),',
    '+    SensorTopics(robot="r4", sensor="s7"),',
    '+    SensorTopics(robot="r4", sensor="s8"),',
]


def changed_lines(difference: str) -> dict[str, list[str]]:
    """Return the lines that a unified difference adds and removes, by file."""
    found: dict[str, list[str]] = {}
    for part in difference.split("--- a/")[1:]:
        name, _, lines = part.partition("\n")
        found[name] = [line for line in lines.splitlines()[1:] if line.startswith(("+", "-"))]
    return found


def add_robot(models: Path) -> None:
    """Add a robot that no goal mentions to the paper's mission."""
    edit(models / "mission.xmi", '  <servers ID="sv1"', f'{ROBOT}  <servers ID="sv1"')


def test_a_robot_with_two_sensors_adds_rows_only(tmp_path):
    models, target = copy_models(tmp_path, "uuv_sampling"), tmp_path / "generated" / "uuv_sampling"
    generate(models, target)
    add_robot(models)

    changed = changed_lines(diff(models, target))

    assert changed["topics.py"] == ROWS
    assert changed.keys() <= {"topics.py", "mission_loader.py", "collective_intelligence.py"}
    assert all(line.startswith("+") for lines in changed.values() for line in lines)
