"""Chains of first differences, held to ticks worked out by hand and to whole traces."""

import csv
from io import StringIO

import pytest

from mrsfi_runtime.causes.chain import FirstVerdict, chains, sentence
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.observers import TraceTable, named_faults
from tests.support.world import code_of, paper_code, specification
from tests.tiers import seeds


def linked(code, drawn):
    """Return the chain of each fault of a specification."""
    return chains(ReferenceEngine(code, 1).record, code.mission, drawn)


def trace(code, drawn):
    text = StringIO()
    ReferenceEngine(code, 1).evaluate(drawn, observer=TraceTable(code.mission, text))
    return [*csv.DictReader(StringIO(text.getvalue()))]


def pool_fault(code, type_name):
    return next(fault for fault in code.pool if fault.type == type_name)


def alone(type_name, start, finish, duration=200):
    code = paper_code(duration)
    fault = pool_fault(code, type_name)
    timed = TimedFault(fault.id, start, finish, fault.values)
    (chain,) = linked(code, (timed,))
    return code, fault, timed, chain


def named(code, timed, name):
    (fault,) = named_faults(code.mission, code.pool, (timed,), [name])
    return fault


def test_a_forged_speed_is_sent_a_tick_before_the_robot_stands_and_the_ci_sees_it():
    _, fault, _, chain = alone("StopRobot", 100, 150)

    assert (chain.command.tick, chain.truth.tick, chain.belief.tick) == (99, 100, 100)
    (sent,) = chain.command.changes
    assert (sent.owner, sent.quantity, sent.found) == (fault.target, "speed", (0.0,))
    assert sent.size == sent.otherwise[0] > 0.0
    position = chain.truth.changes[0]
    assert (position.owner, position.quantity) == (fault.target, "position")
    assert position.size == pytest.approx(sent.size)  # a tick's way


def test_a_falsified_position_is_believed_at_once_and_moves_robots_a_tick_later():
    code, fault, _, chain = alone("FixedRobotCoordinates", 60, 90)
    sender = code.mission.message_goal[fault.target][0].sender

    assert (chain.belief.tick, chain.command.tick, chain.truth.tick) == (60, 60, 61)
    believed = chain.belief.changes[0]
    assert (believed.owner, believed.quantity) == (sender, "position")
    assert believed.found == fault.values
    assert believed.otherwise != believed.found


def test_a_fault_that_touches_nothing_in_its_window_makes_no_difference(approved):
    code, _, timed, chain = alone("StopRobot", 300, 310)

    assert (chain.belief, chain.command, chain.truth, chain.verdicts) == (None, None, None, ())
    approved(sentence(code.mission, named(code, timed, "x.1"), chain))


def test_a_chain_begins_where_the_rest_of_the_specification_leaves_off():
    code = paper_code(200)
    stop = pool_fault(code, "StopRobot")
    early, late = (TimedFault(stop.id, start, start + 20) for start in (40, 120))

    first, second = linked(code, (early, late))

    assert (first.command.tick, second.command.tick) == (39, 119)


CASES = seeds([(name, seed) for seed in range(4) for name in ("tight_margins", "tight_energy")])


@pytest.mark.parametrize("case", CASES, ids=str)
def test_chains_are_the_first_differences_of_two_traces(case):
    code = code_of(case[0])
    drawn = specification(code, case[1], 3)
    whole = trace(code, drawn)
    goals = code.mission.goal_ids

    for place, chain in enumerate(linked(code, drawn)):
        rest = trace(code, tuple(each for k, each in enumerate(drawn) if k != place))
        verdicts = {each.goal: each for each in chain.verdicts}
        for goal in goals:
            found = verdicts.get(goal)
            for name, side in (("violated", "believed"), ("violated", "true"), ("missed", "true")):
                kind = "missed" if name == "missed" else side
                expected = _first(whole, rest, [f"{goal}.{name}.{side}"])
                verdict = None if found is None else getattr(found, kind)
                if expected is None:
                    assert verdict is None
                else:
                    is_so = whole[expected][f"{goal}.{name}.{side}"] == "1"
                    assert verdict == FirstVerdict(expected, is_so)
        for first, side in ((chain.truth, "true"), (chain.belief, "believed")):
            columns = [
                name
                for name in whole[0]
                if name.endswith(f".{side}") and name.split(".")[0] not in goals
            ]
            expected = _first(whole, rest, columns)
            shown = first is not None and any(
                change.quantity != "progress" and change.owner not in code.mission.obstacle_index
                for change in first.changes
            )
            if shown:
                assert first.tick == expected
            else:  # nothing differs, or first what has no column
                assert expected is None or (first is not None and first.tick < expected)


def _first(whole, rest, columns):
    ticks = (
        tick
        for tick, (one, other) in enumerate(zip(whole, rest, strict=True))
        if any(one[name] != other[name] for name in columns)
    )
    return next(ticks, None)
