"""A monitor has one meaning: on recorded flights, as code of a region, and as a formula."""

import warnings
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from mrsfi_runtime.causes.monitors import Heard, Watch, formulas, lifted
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.kernel.state import N_MEMORY
from mrsfi_runtime.model.fault_types import Range, plain_name
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.monitors import MONITORS, left, ordered
from mrsfi_runtime.record.engine_settings import EngineSettings
from tests.support.edited import COLLECTIVE, edited, indented, write_body
from tests.support.missing import skip
from tests.support.world import code_of, specifications
from tests.tiers import slow

HEARD = {
    "robots": "ci.heard[{}]",
    "sensors": "ci.heard[len(ci.robots) + {}]",
    "obstacles": "ci.heard[len(ci.robots) + len(ci.sensors) + {}]",
}


def watched(mission):
    """Return each monitor with each of its elements."""
    return [(each, k) for each in MONITORS for k in range(len(getattr(mission, each.elements)))]


def storing(mission):
    """Return lines of a region that store each measure in the memory of a goal."""
    lines = []
    slots = product(range(len(mission.goals)), range(N_MEMORY))
    for (g, m), (monitor, k) in zip(slots, watched(mission), strict=False):
        call = f"monitors.{monitor.measure.__name__}(ci, {k})"
        if monitor.unit is Range.TICKS:
            place = MONITORS.index(monitor) % N_MEMORY
            call = f"monitors.lasting({HEARD[monitor.elements].format(k)}, {place}, {call})"
        lines.append(f"ci.goals[{g}].memory[{m}] = {call}")
    assert len(lines) == len(watched(mission))
    return "\n".join([*lines, "monitors.remember(ci)"])


SILENT = tuple(
    TimedFault(fault, 20, 60, values)
    for fault, values in (("f10", (500.0,)), ("f11", (50.0, 50.0, 0.0)), ("f30", ()))
)
"""Robot p1 reports the same energy, position and speed."""


@pytest.mark.parametrize(
    ("engine", "n"),
    [
        ("reference", 30),
        *(pytest.param(name, 200, marks=slow) for name in ("reference", "compiled")),
    ],
)
def test_a_monitor_flown_as_code_of_a_region_has_the_measures_of_the_recorded_flight(
    engine, n, tmp_path
):
    mission = code_of("tight_margins", 120).mission
    body = indented(f"{storing(mission)}\ngoal_tasks.avoid_collision.react(ci, CLEAR)")
    folder = edited(tmp_path, "clear.react", body, "tight_margins")
    write_body(folder / COLLECTIVE, "imports", "from mrsfi_runtime.api import monitors\n")
    code = replace(load_code(folder), mission=mission)
    n_measured = dict.fromkeys((each.name for each in MONITORS), 0)

    with open_engine(EngineSettings(engine), code, 1) as flying:
        for drawn in (*specifications(code, n), SILENT):
            flight = flying.record(drawn)
            heard, memory = Heard(mission, 1, flight), flight["belief"]["goals"]["memory"]
            stored = iter(memory.reshape(len(memory), -1).T.tolist())
            for monitor in MONITORS:
                for measured, flown in zip(heard.measured(monitor), stored, strict=False):
                    assert flown == measured.astype(float).tolist(), (monitor.name, drawn)
                    n_measured[monitor.name] += bool(measured.any())

    assert min(n_measured.values()) > 0


def stl(formula, signals):
    """Return RTAMT's monitor of a formula; its import warns, and fails from Python 3.13 on."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            import rtamt
        except ImportError:
            skip("rtamt is not installed")
        monitor = rtamt.StlDiscreteTimeSpecification()
        for name in (*signals, "out"):
            monitor.declare_var(name, "float")
        monitor.spec = f"out = {formula}"
        monitor.parse()
    return monitor


def signals(mission, flight):
    """Return the signals of formulas as lists: the model's values, then those of each tick."""
    before, belief, found = initial_state(mission, 1), flight["belief"], {}
    for listed in ("robots", "sensors", "obstacles"):
        for k, element in enumerate(getattr(mission, listed)):
            state = getattr(before, listed)[k]
            for field in state.__slots__:
                values = [getattr(state, field), *belief[listed][field][:, k].tolist()]
                found[f"{plain_name(element.id)}_{field}"] = [*map(float, values)]
    for listed, elements in (("commands", mission.robots), ("switches", mission.sensors)):
        for k, element in enumerate(elements):
            state = getattr(before, listed)[k]
            for field in state.__slots__:
                values = [getattr(state, field), *belief[listed][field][:, k].tolist()]
                values = [values[0], *values[:-1]]  # the last command at each tick
                found[f"{plain_name(element.id)}_commanded_{field}"] = [*map(float, values)]
    for k, element in enumerate(mission.robots):
        heard, name = Heard(mission, 1, flight), plain_name(element.id)
        found[f"{name}_ordered"] = [0.0, *lifted(ordered, OVER_TICKS)(heard, k).tolist()]
        found[f"{name}_left"] = [found[f"{name}_energy"][0], *lifted(left, OVER_TICKS)(heard, k)]
    return found


OVER_TICKS = {"math": np, "min": np.minimum, "max": np.maximum}


@pytest.mark.parametrize("monitor", MONITORS, ids=[each.name for each in MONITORS])
def test_rtamt_reads_the_formula_of_a_monitor_as_it_is_meant(monitor):
    code = code_of("tight_margins", 100)
    n_alarms = 0

    with open_engine(EngineSettings("reference"), code, 1) as engine:
        watch = Watch.fitted(code.mission, [monitor], [(1, engine.record(()))])
        flights = [engine.record(each) for each in (*specifications(code, 4), SILENT)]
    for flight in flights:
        known = signals(code.mission, flight)
        measured = Heard(code.mission, 1, flight).measured(monitor)
        for (id, formula), measures in zip(
            formulas(watch, monitor.name).items(), measured, strict=True
        ):
            named = {name: known[name] for name in known if name in formula}
            rtamt, values = stl(formula, named), []
            for tick in range(len(flight) + 1):
                row = [(name, signal[tick]) for name, signal in named.items()]
                values.append(rtamt.update(tick, row))
            alarms = [each < 0.0 for each in values[1:]]
            limit = watch.thresholds[monitor.name][id]
            assert alarms == (measures > limit).tolist(), (id, formula)
            n_alarms += sum(alarms)

    assert n_alarms > 0
