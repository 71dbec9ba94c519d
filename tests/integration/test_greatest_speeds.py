"""A robot's greatest speed: what the model says reaches the code, what it omits stays so."""

from m2t.generate import diff, generate
from mrsfi_runtime.generated_code import load_code
from tests.support.models.copies import MISSION, edit

NOMINAL, BOUNDED = 'name="JEN" speed="4.0"', 'name="JEN" speed="4.0" maxSpeed="4.5"'


def test_the_code_has_the_greatest_speed_of_the_robot_that_names_one(models, tmp_path):
    target = tmp_path / "generated" / "uuv_sampling"
    generate(models, target)
    edit(models / MISSION, NOMINAL, BOUNDED)

    changed = diff(models, target)
    generate(models, target)

    lines = [line for line in changed.splitlines() if line.startswith(("+ ", "- "))]
    assert lines == ["+                max_speed=4.5,"]
    robots = load_code(target).mission.robots
    assert [robot.max_speed for robot in robots] == [None, 4.5, None]
    assert [robot.fastest for robot in robots] == [10.0, 4.5, 8.0]


def test_a_robot_that_never_moves_is_not_one_without_a_greatest_speed(models, tmp_path):
    target = tmp_path / "generated" / "uuv_sampling"
    edit(models / MISSION, NOMINAL, 'name="JEN" speed="0.0" maxSpeed="0.0"')

    generate(models, target)

    assert [robot.max_speed for robot in load_code(target).mission.robots] == [None, 0.0, None]
