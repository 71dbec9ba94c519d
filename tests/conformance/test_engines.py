"""What every engine does, however it flies."""

import csv
import re
import tracemalloc
from dataclasses import asdict, replace
from io import StringIO
from itertools import product

import pytest

from m2t.generate import generate
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import EvaluationError, SpecificationError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.state import COLUMNS
from mrsfi_runtime.model.faults import Event, TimedFault, limits
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.observers import Events, SimulationLog, TraceTable, named_faults
from tests.integration.test_injector import EMBEDDED, flown
from tests.support.edited import edited
from tests.support.models.copies import MISSION, copy_models, edit
from tests.support.trace import TraceDigest, columns, traced
from tests.support.triggers import with_triggers
from tests.support.world import code_of, paper_code, specifications
from tests.tiers import night, slow

SEED = 5
OTHERS = (
    "tight_margins",
    "tight_energy",
    "undersea",
    "atlas_search",
    "atlas_crossing",
    "fleet_30",
    "depot",
)
ENGINES = {
    "reference": EngineSettings("reference"),
    "compiled": EngineSettings("compiled"),
    "rosbridge": EngineSettings("rosbridge"),
}
RATES, NOISES, RADII = (9.0, 30.0, 180.0), (2.0, 0.0, 0.5), (1.0, 8.5, 0.25)
GIVEN = (
    'turnRate="9.0" positionNoise="2.0"',
    'turnRate="30.0" radius="8.5"',
    'positionNoise="0.5" radius="0.25"',
)


@pytest.fixture(scope="module", params=ENGINES)
def engine(request):
    with open_engine(ENGINES[request.param], paper_code(150), SEED) as opened:
        yield opened


def test_every_bit_of_belief_and_truth_is_that_of_the_reference(engine):
    reference = ReferenceEngine(engine.code, SEED)

    for specification in ((), *specifications(engine.code, 5)):
        assert traced(engine, specification) == traced(reference, specification)


@pytest.mark.parametrize("name", ENGINES)
def test_a_goal_whose_check_a_team_wrote_has_no_margin(tmp_path, name):
    """Each engine flies it as the reference says, and measures the goals that are as generated."""
    body = "    return ci.mission.tick == 9\n"
    written = load_code(edited(tmp_path, "g2.check", body))
    code = replace(written, mission=replace(written.mission, duration=60))

    with open_engine(ENGINES[name], code, SEED) as opened:
        outcome = opened.evaluate(())

    assert outcome.true == (0, 1, 0, 60, 60, 60)
    assert [margin is not None for margin in outcome.margins] == [True, False, True] + [False] * 3
    assert outcome == ReferenceEngine(code, SEED).evaluate(())


def test_faults_that_wait_fly_as_on_the_reference(engine):
    """No goal is reached so soon; in whole flights below, some are."""
    code = with_triggers(engine.code)
    reference = ReferenceEngine(engine.code, SEED)
    happened = set()

    for specification in specifications(code, 8):
        told, expected = ([], []), ([], [])
        for each, tallies in ((engine, told), (reference, expected)):
            digest = TraceDigest()
            options = {"pool": code.pool, "observer": digest, "tallies": tallies[0]}
            tallies[1].extend((each.evaluate(specification, **options), digest.hexdigest()))
        assert told == expected
        for timed, tally in zip(specification, told[0], strict=True):
            if timed.trigger and tally.applied:
                happened.add(code.pool.triggers_by_id[timed.trigger].event)

    assert happened == {*Event} - {Event.REACHED}


def test_values_at_their_limits_lead_to_the_same_bits(engine):
    cases = [
        (fault.id, values)
        for fault in engine.code.pool
        for values in product(*(limits(parameter) for parameter in fault.kind.parameters))
        if values and [*values] == sorted(values)
    ]
    specification = [
        TimedFault(fault, 2 * tick, 2 * tick + 1, values)
        for tick, (fault, values) in enumerate(cases)
    ]

    assert len(cases) > 30
    assert 2 * len(cases) <= engine.code.mission.duration
    expected = traced(ReferenceEngine(engine.code, SEED), specification)
    assert traced(engine, specification) == expected


def test_one_engine_flies_in_the_weather_of_any_mission_seed(engine):
    specification = specifications(engine.code, 1)[0]
    seeds = (SEED, 1, 2, 1)

    alone = [engine.evaluate(specification, seed) for seed in seeds]
    together = list(
        zip(*(engine.evaluate_many([specification], seed) for seed in seeds), strict=True)
    )

    expected = [ReferenceEngine(engine.code, seed).evaluate(specification) for seed in seeds]
    assert alone == expected
    assert together == [tuple(expected)]
    assert engine.evaluate(specification) == expected[0] != expected[1]


@pytest.mark.parametrize(
    ("engine_name", "mission"),
    [
        ("compiled", "uuv_sampling"),
        *(pytest.param("compiled", name, marks=slow) for name in OTHERS[:2]),
        *(pytest.param("compiled", name, marks=night) for name in OTHERS[2:]),
        ("rosbridge", "tight_margins"),
    ],
)
def test_flights_of_every_mission_have_the_recordings_of_the_reference(engine_name, mission):
    plain = code_of(mission)
    code = with_triggers(plain)
    reference = ReferenceEngine(code, SEED)
    flown = [*specifications(plain, 2), *specifications(code, 2)]

    with open_engine(ENGINES[engine_name], code, SEED) as engine:
        for seed, specification in enumerate(flown):
            recording = engine.record(specification, seed)

            expected = reference.record(specification, seed)
            assert dict(columns(recording)) == dict(columns(expected))
            assert recording.tallies == expected.tallies


def test_a_recording_has_what_an_observer_sees(engine):
    specification = specifications(engine.code, 2)[1]
    recording = engine.record(specification)
    seen = []

    def compare(world, belief, verdicts):
        moment = recording[len(seen)]
        for side, state in (("world", world), ("belief", belief)):
            for name, fields in COLUMNS.items():
                expected = [
                    tuple(getattr(record, field) for field in fields)
                    for record in getattr(state, name)
                ]
                assert moment[side][name][[*fields]].tolist() == expected
            memories = [[*goal.memory] for goal in state.goals]
            assert moment[side]["goals"]["memory"].tolist() == memories
        judged = (*recording.dtype.names[2:],)
        assert {each: moment[each].tolist() for each in judged} == asdict(verdicts)
        seen.append((world.mission.tick, belief.mission.tick))

    engine.evaluate(specification, observer=compare)

    assert len(recording) == 150
    assert seen == [(tick, tick) for tick in range(150)]


@pytest.mark.parametrize("name", ["reference", "compiled"])
def test_a_recording_of_many_chunks_is_that_of_one(name, monkeypatch):
    code = paper_code(150)
    specification = specifications(code, 3)[2]
    with open_engine(ENGINES[name], code, SEED) as engine:
        (expected,) = engine.record(specification).moments()
        monkeypatch.setattr("mrsfi_runtime.engine.recording.CHUNK", 1)

        recording = engine.record(specification)

    chunks = [*recording.moments()]
    assert [*map(len, chunks)] == [8] * 18 + [6]
    assert b"".join(chunk.tobytes() for chunk in chunks) == expected.tobytes()
    assert recording["world"]["robots"]["x"].tolist() == expected["world"]["robots"]["x"].tolist()
    memory = recording["belief"]["goals"]["memory"]
    assert memory.tolist() == expected["belief"]["goals"]["memory"].tolist()
    for tick in (0, 7, 8, 143, 149, -1):
        assert recording[tick].tobytes() == expected[tick].tobytes()
        found = recording["belief"]["commands"][tick]
        assert found.tobytes() == expected["belief"]["commands"][tick].tobytes()


def test_a_long_recording_stays_out_of_memory():
    with open_engine(ENGINES["compiled"], paper_code(40_000), SEED) as engine:
        engine.evaluate(())
        tracemalloc.start()
        recording = engine.record(())
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()

    assert len(recording) == 40_000
    assert recording.dtype.itemsize * len(recording) > 4 * peak


def test_log_and_trace_say_from_which_tick_on_a_goal_is_missed(engine):
    mission = engine.code.mission
    log, trace = StringIO(), StringIO()
    observers = SimulationLog(mission, log, Events(mission, (), ())), TraceTable(mission, trace)

    outcome = engine.evaluate(
        specifications(engine.code, 3)[2],
        observer=lambda *tick: [observer(*tick) for observer in observers],
    )

    since = outcome.missed_since(150)
    assert None in since
    assert any(since)
    header, *rows = csv.reader(trace.getvalue().splitlines())
    ticks = log.getvalue().split("tick ")[1:]
    for goal, first in zip(mission.goal_ids, since, strict=True):
        column = header.index(f"{goal}.missed.true")
        flags = [row[column] for row in rows]
        event = f"  event {goal} failed: no -> yes\n"
        found = [number for number, text in enumerate(ticks) if event in text]
        assert flags == ["0" if first is None or tick < first else "1" for tick in range(150)]
        assert found == ([] if first is None else [first])


def logged(engine, specification):
    """Return the log of a flight, what its faults did, and its outcome."""
    mission, pool = engine.code.mission, engine.code.pool
    stream, tallies = StringIO(), []
    log = SimulationLog(
        mission, stream, Events(mission, named_faults(mission, pool, specification), tallies)
    )
    outcome = engine.evaluate(specification, observer=log, tallies=tallies)
    return stream.getvalue(), tallies, outcome


def test_the_log_of_a_flight_under_faults_is_that_of_the_reference(engine):
    reference = ReferenceEngine(engine.code, SEED)

    for specification in specifications(engine.code, 3):
        log, tallies, outcome = logged(engine, specification)

        assert (log, tallies, outcome) == logged(reference, specification)
        assert tuple(tally.changed for tally in tallies) == outcome.changed
        assert log.count(": has its first effect\n") == sum(map(bool, outcome.changed)) > 0
        assert log.count(": ends\n") == log.count(": starts (") == sum(map(bool, outcome.applied))
        assert "  believed " in log


def test_the_window_of_every_fault_has_as_many_ticks_as_it_was_active(engine):
    mission, pool = engine.code.mission, engine.code.pool

    for specification in specifications(engine.code, 5):
        applied = engine.evaluate(specification).applied

        for fault, n_ticks in zip(named_faults(mission, pool, specification), applied, strict=True):
            first, last = fault.window or (0, -1)
            assert last - first + 1 == n_ticks


def test_a_fault_that_ends_when_it_first_changes_something_changes_it_once_and_before_nothing():
    engine = ReferenceEngine(paper_code(150), SEED)
    found = []

    for specification in specifications(engine.code, 5):
        _, tallies, _ = logged(engine, specification)
        for number, (timed, tally) in enumerate(zip(specification, tallies, strict=True)):
            first = tally.first_changed
            for finish in (first - 1, first):
                if finish >= timed.start:
                    cut = [*specification]
                    cut[number] = timed._replace(finish=finish)
                    n_changed = engine.evaluate(tuple(cut)).changed[number]
                    found.append((finish - first, n_changed))

    assert {*found} == {(-1, 0), (0, 1)}


def test_conflicting_faults_are_refused_before_the_flight(engine):
    conflicting = (TimedFault("f27", 0, 9), TimedFault("f4", 5, 9, (1.0,)))

    for fly in (engine.evaluate, engine.record):
        with pytest.raises(SpecificationError, match="overlap"):
            fly(conflicting)


@pytest.mark.parametrize("name", ["reference", "rosbridge"])
def test_an_error_in_a_region_is_an_evaluation_error_and_the_next_flight_is_whole(name):
    code = paper_code(40)
    broken_at = [20]

    def react(ci):
        if ci.mission.tick in broken_at:
            message = "too deep"
            raise ArithmeticError(message)
        code.functions.react(ci)

    broken = replace(code, functions=code.functions._replace(react=react))
    with open_engine(ENGINES[name], broken, SEED) as engine:
        with pytest.raises(EvaluationError, match="stopped at tick 20: ArithmeticError: too deep"):
            engine.evaluate(())
        broken_at.clear()
        outcome = engine.evaluate(())

    assert outcome == ReferenceEngine(code, SEED).evaluate(())


@pytest.mark.parametrize("settings", ENGINES.values(), ids=ENGINES)
def test_closing_twice_does_no_harm(settings):
    engine = open_engine(settings, paper_code(1), SEED)

    engine.close()
    engine.close()


@pytest.fixture(scope="module")
def code(tmp_path_factory):
    folder = tmp_path_factory.mktemp("realism")
    models = copy_models(folder, "uuv_sampling")
    edit(models / MISSION, 'duration="1000"', 'duration="200"')
    for robot, given in zip(("LEN", "JEN", "KAL"), GIVEN, strict=True):
        edit(models / MISSION, f'name="{robot}"', f'name="{robot}" {given}')
    for goal, required in (("g2", 2), ("g3", 1), ("g4", 0)):
        edit(models / MISSION, f'ID="{goal}"', f'ID="{goal}" requiredMembers="{required}"')
    edit(models / MISSION, '"mission:AvoidCollision"', '"mission:AvoidCollision" clearance="3.5"')
    for goal, grace in (("g1", 1), ("g3", 0), ("g5", 40), ("g6", 199)):
        edit(models / MISSION, f'ID="{goal}"', f'ID="{goal}" grace="{grace}"')
    generate(models, folder / "generated" / "uuv_sampling")
    return load_code(folder / "generated" / "uuv_sampling")


def flights(code):
    return ((), *specifications(code, 4))


def test_generated_code_has_what_the_model_gives_and_no_more(code):
    robots = code.mission.robots
    text = (code.directory / "mission_loader.py").read_text(encoding="utf-8")

    assert tuple(robot.turn_rate for robot in robots) == RATES
    assert tuple(robot.position_noise for robot in robots) == NOISES
    assert tuple(robot.radius for robot in robots) == RADII
    counts = [text.count(f"{name}=") for name in ("turn_rate", "position_noise", "clearance")]
    assert counts == [2, 2, 1]
    assert re.findall(r"\bradius=(8\.5|0\.25|1\.0)\b", text) == ["8.5", "0.25"]
    assert re.findall(r"required_members=(\d)", text) == ["2", "1"]
    assert re.findall(r"grace=(\d+)", text) == ["1", "40", "199"]


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
