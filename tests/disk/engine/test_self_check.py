"""Compiled flights are held to those of the reference engine, tick by tick, faults at work."""

from dataclasses import replace

import pytest

from mrsfi_runtime.engine.compiled.engine import require_same, trials
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.recording import Recording
from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import FaultPool, Gate
from tests.support.world import paper_code

SEED = 3


@pytest.mark.parametrize("duration", [1, 3, 1000])
def test_every_fault_of_the_pool_acts_at_once_or_in_turns_until_the_end(duration):
    code = paper_code()
    mission = replace(code.mission, duration=duration)
    gate = Gate(mission, code.pool)

    flown = trials(gate)

    for each in flown:
        assert gate.admitted(each) == each
        assert {timed.fault for timed in each if timed.start == 0} == {one.fault for one in each}
        assert max(timed.finish for timed in each) == duration - 1
    assert {timed.fault for each in flown for timed in each} == set(code.pool.by_id)
    assert len(flown) < 9


def test_without_faults_the_mission_flies_alone():
    code = paper_code()
    assert trials(Gate(code.mission, FaultPool("none", ()))) == [()]


@pytest.fixture
def reference():
    return ReferenceEngine(paper_code(40), SEED)


def recorded(reference, change=lambda _recording: None):
    """Return what records flights on the reference engine, but for a change."""

    def record(specification, n_ticks):
        (moments,) = reference.record(specification).moments()
        recording = Recording(moments.dtype)
        recording.append(moments[:n_ticks])
        change(recording)
        return recording

    return record


def one(reference):
    return trials(Gate(reference.code.mission, reference.code.pool))


def test_equal_flights_pass_over_as_many_ticks_as_there_is_time_for(reference):
    lengths = []
    record = recorded(reference, lambda recording: lengths.append(len(recording)))

    require_same(reference, record, one(reference), 10.0)
    require_same(reference, record, one(reference), 0.0)

    n = len(one(reference))
    assert lengths == [40] * n + [2] * n


def spoilt(*path, tick=9):
    def change(recording):
        where = recording[tick]
        for name in path[:-1]:
            where = where[name]
        where[path[-1]] += 1

    return change


@pytest.mark.parametrize(
    "change",
    [
        spoilt("is_true", 1),
        spoilt("believed", 0),
        spoilt("belief", "commands", "speed", 2),
        spoilt("world", "robots", "x", 1),
        spoilt("belief", "goals", "memory", (0, 3)),
    ],
)
def test_the_first_difference_is_named_with_tick_and_region(reference, change, refused):
    with refused(EvaluationError):
        require_same(reference, recorded(reference, change), one(reference), 10.0)


def test_flights_that_fail_compiled_are_not_compared_for_they_are_repeated(reference):
    require_same(reference, lambda *_: None, one(reference), 0.0)


def test_what_fails_on_the_reference_engine_alone_is_told_with_its_line(refused):
    code = paper_code(40)
    sound = ReferenceEngine(code, SEED)

    def check(ci, violated):
        code.functions.check(ci, violated)
        if ci.mission.tick == 12:
            raise ZeroDivisionError

    functions = code.functions._replace(check=check)
    failing = ReferenceEngine(replace(code, functions=functions), SEED)

    with refused(EvaluationError):
        require_same(failing, recorded(sound), one(sound), 10.0)
