"""What is true is read from a flight without faults, for each kind of fixed value."""

import pytest

from mrsfi_runtime.causes.mildest import Deviation
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.search.space import SearchSpace
from tests.support.world import paper_code

CODE = paper_code(duration=60)


@pytest.fixture(scope="module")
def deviation():
    with open_engine(EngineSettings(), CODE, 1) as engine:
        return Deviation(SearchSpace.of(CODE.mission, CODE.pool), engine.record(()))


def harmless(deviation, fault, start=0):
    own = CODE.pool[fault].values
    return deviation.harmless(TimedFault(fault, start, 59, own))


def test_an_obstacle_is_truly_where_the_model_has_it(deviation):
    (centre,) = (o.area.center for o in CODE.mission.obstacles if o.id == "o5")

    assert harmless(deviation, "f9")[:2] == (centre.x, centre.y)


def test_a_robot_is_where_it_is_when_the_window_begins(deviation):
    places = []
    with open_engine(EngineSettings(), CODE, 1) as engine:
        engine.evaluate((), observer=lambda world, *_: places.append(_place(world.robots[2])))

    assert [harmless(deviation, "f11", tick) for tick in (0, 30, 59)] == [
        places[tick] for tick in (0, 30, 59)
    ]
    assert places[0] != places[59]


def _place(robot):
    return robot.x, robot.y, robot.z


def test_energy_falls_rates_and_costs_stay_and_differences_are_nothing(deviation):
    nominal = {sensor.id: sensor for sensor in CODE.mission.sensors}

    assert harmless(deviation, "f10", 59) < harmless(deviation, "f10")
    assert harmless(deviation, "f12")[0] in {s.samples_per_second for s in nominal.values()}
    assert harmless(deviation, "f13")[0] in {s.energy_per_sample for s in nominal.values()}
    assert harmless(deviation, "f4") == harmless(deviation, "f8") == (0.0,)


def test_as_far_off_in_a_shorter_window_is_another_place(deviation):
    timed = TimedFault("f11", 0, 59, (500.0, 500.0, 1.0))

    late = deviation.milder(timed, before=1 / 3)

    assert (late.start, late.finish) == (39, 59)
    assert late.values != timed.values
    assert deviation.share(late) == pytest.approx(deviation.share(timed), abs=1e-4)
    assert deviation.share(deviation.milder(timed, off=0.0)) == 0.0
