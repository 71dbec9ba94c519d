"""Robots that turn slowly and misjudge where they are: the same bits however they fly."""

import pytest

from m2t.generate import generate
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.integration.test_injector import EMBEDDED, flown
from tests.support.models.copies import MISSION, copy_models, edit
from tests.support.trace import columns, traced
from tests.support.world import specifications

SEED = 5
RATES, NOISES = (9.0, 30.0, 180.0), (2.0, 0.0, 0.5)
GIVEN = ('turnRate="9.0" positionNoise="2.0"', 'turnRate="30.0"', 'positionNoise="0.5"')


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    folder = tmp_path_factory.mktemp("realism")
    models = copy_models(folder, "uuv_sampling")
    edit(models / MISSION, 'duration="1000"', 'duration="200"')
    for robot, given in zip(("LEN", "JEN", "KAL"), GIVEN, strict=True):
        edit(models / MISSION, f'name="{robot}"', f'name="{robot}" {given}')
    generate(models, folder / "generated" / "uuv_sampling")
    return load_code(folder / "generated" / "uuv_sampling")


def flights(code):
    return ((), *specifications(code, 4))


def test_generated_code_has_what_the_model_gives_and_no_more(code):
    robots = code.mission.robots
    text = (code.directory / "mission_loader.py").read_text(encoding="utf-8")

    assert tuple(robot.turn_rate for robot in robots) == RATES
    assert tuple(robot.position_noise for robot in robots) == NOISES
    assert (text.count("turn_rate="), text.count("position_noise=")) == (2, 2)


@pytest.mark.parametrize(
    "settings",
    [EngineSettings("compiled"), EngineSettings("rosbridge", timeout=20.0)],
    ids=["compiled", "rosbridge"],
)
def test_every_bit_is_that_of_the_reference(code, settings):
    reference = ReferenceEngine(code, SEED)

    with open_engine(settings, code, SEED) as engine:
        for specification in flights(code):
            assert traced(engine, specification) == traced(reference, specification)
        recording = dict(columns(engine.record(specification)))
        assert recording == dict(columns(reference.record(specification)))


def test_a_node_that_answers_flies_likewise(code):
    specification = (TimedFault("f11", 20, 60, code.pool["f11"].values), TimedFault("f26", 80, 99))

    (outcome,) = flown(EMBEDDED, 1, [specification], code=code)

    assert outcome == ReferenceEngine(code, 1).evaluate(specification)
