"""A robot's greatest speed: what the model says reaches the code, what it omits stays so."""

import pytest

from m2t.generate import diff, generate
from m2t.load import load_mission_folder
from m2t.saving import save
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


@pytest.mark.parametrize("given", [NOMINAL, BOUNDED])
def test_saving_keeps_it_as_it_is(models, given):
    edit(models / MISSION, NOMINAL, given)
    before = (models / MISSION).read_bytes()
    loaded = load_mission_folder(models)

    assert save(loaded) == ()

    jen = loaded.mission.robots[1]
    assert jen.eIsSet("maxSpeed") == (given == BOUNDED)
    assert (models / MISSION).read_bytes() == before


def test_a_script_gives_it_and_takes_it_back(models):
    before = (models / MISSION).read_text(encoding="ascii")
    loaded = load_mission_folder(models)
    jen = loaded.mission.robots[1]

    jen.maxSpeed = 4.5
    save(loaded)
    bounded = (models / MISSION).read_text(encoding="ascii")
    jen.maxSpeed = None
    save(loaded)

    assert bounded == before.replace(NOMINAL, BOUNDED)
    assert (models / MISSION).read_text(encoding="ascii") == before
