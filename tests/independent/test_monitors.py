"""Monitors judge flights as a recount in plain Python does, and thresholds decide to the digit."""

import math
from dataclasses import replace

import pytest

from mrsfi_runtime.causes.consequences import STAGES
from mrsfi_runtime.causes.monitors import Case, Watch, verdict_ticks
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.monitors import MONITORS
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.independent.monitors import detection, first_alarms, measures, thresholds
from tests.support.world import code_of, specification

N_FIT, N_FAULTY = 4, 12


@pytest.fixture(scope="module", params=["tight_margins", "depot"])
def engine(request):
    with open_engine(EngineSettings(name="reference"), code_of(request.param, 200), 1) as engine:
        yield engine


@pytest.fixture(scope="module")
def fit(engine):
    """Flights without faults, and the thresholds that they give."""
    flights = [(seed, engine.record((), seed)) for seed in range(1, N_FIT + 1)]
    return flights, Watch.fitted(engine.code.mission, MONITORS, flights)


def by_element(found):
    return {(name, element): value for name, row in found.items() for element, value in row.items()}


def test_a_recount_has_the_same_thresholds_alarms_and_detection(engine, fit):
    mission, (flights, watch) = engine.code.mission, fit
    recounted = thresholds([measures(mission, flight, seed) for seed, flight in flights])
    n_alarms, stages = 0, set()

    for seed in range(N_FAULTY):
        flight = engine.record(specification(engine.code, seed, 3))
        since = min(each.first_changed for each in flight.tallies if each.changed)
        raised = watch.alarms(1, flight, max(0, since))
        again = first_alarms(measures(mission, flight, 1), recounted, since)
        assert by_element(raised) == again, seed
        n_alarms += len(again)
        for place, broken in enumerate(flight["broken"][-1]):
            if broken:
                case = Case(None, (), 1.0, *verdict_ticks(flight, place), raised)
                for names in ([], ["position frozen"], [*raised]):
                    ticks = [tick for (name, _), tick in again.items() if name in names]
                    found = STAGES[case.stage(names)]
                    assert found == detection(flight, place, ticks), (seed, place, names)
                    stages.add(found)

    assert by_element(watch.thresholds) == pytest.approx(recounted)
    assert n_alarms > N_FAULTY
    assert len(stages) > 1


def test_flights_that_fit_thresholds_raise_no_alarm(engine, fit):
    flights, watch = fit

    assert [watch.alarms(*each) for each in flights] == [{}] * N_FIT


@pytest.mark.parametrize(("tick", "stage"), [(9, 0), (10, 0), (11, 1), (19, 1), (20, 2)])
def test_stages_change_when_a_goal_is_broken_and_when_it_fails(tick, stage):
    believed = Case(None, (), 1.0, 10, 20.0, tick, {})
    raised = Case(None, (), 1.0, 10, 20.0, math.inf, {"map": {"rock": tick, "reef": 30}})

    assert believed.stage([]) == raised.stage(["map"]) == stage
    assert STAGES[raised.stage(["position frozen"])] == "never"


@pytest.fixture(scope="module")
def tight():
    with open_engine(EngineSettings(name="reference"), code_of("tight_margins"), 1) as engine:
        yield engine


def limited(engine, name, **limits):
    """Return monitors that are fitted to one flight, one of them with other thresholds."""
    watch = Watch.fitted(engine.code.mission, MONITORS, [(1, engine.record(()))])
    return replace(watch, thresholds=watch.thresholds | {name: limits})


@pytest.mark.parametrize(("size", "tick"), [(1.999, None), (2.0, None), (2.001, 100)])
def test_an_error_above_a_threshold_raises_an_alarm_at_its_first_tick(tight, size, tick):
    watch = limited(tight, "map", rock=2.0)
    center = tight.code.mission.obstacles[0].area.center

    flight = tight.record((TimedFault("f9", 100, 120, (center.x - size, center.y, 0.0)),))

    raised = watch.alarms(1, flight).get("map", {})
    assert raised == ({} if tick is None else {"rock": tick})


@pytest.mark.parametrize(("n_ticks", "tick"), [(5, None), (6, None), (7, 106)])
def test_a_position_that_stays_for_more_ticks_than_a_threshold_raises_an_alarm(
    tight, n_ticks, tick
):
    """At the first tick of the fault the position still changes."""
    watch = limited(tight, "position frozen", p1=5.0, p2=5.0, p3=5.0)

    flight = tight.record((TimedFault("f11", 100, 99 + n_ticks, (50.0, 50.0, 0.0)),))

    raised = watch.alarms(1, flight).get("position frozen", {})
    assert raised == ({} if tick is None else {"p1": tick})


@pytest.mark.parametrize(("energy", "tick"), [(1_000_000.0, 0), (None, None)])
def test_an_energy_that_is_false_from_the_first_tick_on_raises_an_alarm_at_it(tight, energy, tick):
    """The model's energy is what was heard before."""
    watch = Watch.fitted(tight.code.mission, MONITORS, [(1, tight.record(()))])
    faults = (TimedFault("f10", 0, tight.code.mission.duration - 1, (energy,)),) if energy else ()

    raised = watch.alarms(1, tight.record(faults)).get("energy balance", {})

    assert raised == ({} if tick is None else {"p1": tick})
