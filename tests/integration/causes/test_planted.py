"""Causes that are there by construction, in the mission of ``tests/support/rendezvous.py``."""

from dataclasses import replace

import pytest

from mrsfi_runtime.causes.cause_set import Flights
from mrsfi_runtime.causes.chain import FirstVerdict
from mrsfi_runtime.causes.explanation import explain
from mrsfi_runtime.cli.campaign_results import Shown, print_explanation
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.observers import named_faults
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure
from tests.support.rendezvous import DEADLINE, write_rendezvous


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    generated = write_rendezvous(tmp_path_factory.mktemp("planted"))
    return ReferenceEngine(load_code(generated), 1)


def explained(engine, *faults):
    """Return why these faults break goals, and what each of them is to each goal."""
    measure = Measure.of(CampaignSettings(), engine.code.mission)
    flights = Flights(engine.evaluate_many, measure, (1,))
    found = explain(flights, engine, tuple(TimedFault(*fault) for fault in faults), 0.95)
    return found, {goal.goal: goal.labels for goal in found.goals}


def believed(found):
    return {
        column.goal: count
        for column, count in zip(found.cause.columns, found.cause.counts, strict=True)
        if column.kind == "believed"
    }


def test_without_faults_both_are_there_in_time(engine):
    assert engine.evaluate(()).true == (0, 0, 0)


def test_one_fault_alone(engine):
    found, labels = explained(engine, ("stop_b", 60, 65), ("stop_a", 10, 119, ()))

    assert believed(found) == {"g1": 50, "g2": 0, "g3": 50}
    assert found.cause.places == (1,)
    assert labels == {
        "g1": ("bystander", "sole"),
        "g2": ("bystander", "bystander"),
        "g3": ("bystander", "sole"),
    }
    (chain,) = found.cause.chains
    assert (chain.command.tick, chain.truth.tick, chain.belief.tick) == (9, 10, 10)
    assert chain.command.changes[0].size == 4.0
    at_deadline = FirstVerdict(DEADLINE, is_so=True)
    assert [each.goal for each in chain.verdicts] == ["g1", "g3"]
    assert {(each.believed, each.true, each.missed) for each in chain.verdicts} == {
        (at_deadline,) * 3
    }
    assert {(firm.median, firm.n_violated) for firm in found.cause.robustness} == {(50, 20), (0, 0)}


def test_two_faults_only_together(engine):
    """Each costs 13 of the 20 ticks that there are to spare, both cost 26."""
    found, labels = explained(engine, ("stop_a", 10, 22), ("stop_b", 10, 22), ("stop_a", 30, 42))

    assert 0 < believed(found)["g1"] < 20
    assert found.cause.places == (0, 2)
    assert labels["g1"] == ("joint", "bystander", "joint")
    assert not any(found.alone[0])
    assert not any(found.left_out[2])
    (first, second) = (of_fault for of_fault in found.attribution.shares)
    assert first == second
    assert [chain.command.tick for chain in found.cause.chains] == [9, 29]


def test_either_of_two_faults(engine):
    found, labels = explained(engine, ("stop_a", 0, 119), ("stop_b", 0, 119))

    assert labels["g3"] == ("sole", "redundant")
    assert labels["g1"] == ("sole", "bystander")
    assert labels["g2"] == ("bystander", "sole")
    assert found.cause.places == (0, 1)


def test_a_fault_that_hides_what_another_does(engine):
    """A robot that was once believed to be there is not missed by those who believed it."""
    found, labels = explained(
        engine, ("stop_a", 10, 119), ("lie_a", 60, 60, (0.0, 0.0, 0.0)), ("stop_b", 0, 119)
    )

    assert believed(found) == {"g1": 0, "g2": 50, "g3": 50}
    assert found.cause.outcome.true == (50, 50, 50)
    assert labels["g1"] == ("sole", "masking", "bystander")
    assert labels["g2"] == ("bystander", "bystander", "sole")
    assert found.cause.places == (0, 2)
    assert found.left_out[1][0] == 50


def test_what_is_violated_without_any_fault_has_no_cause(engine, capsys):
    code = replace(engine.code, mission=_with_an_earlier_deadline(engine.code.mission))
    measure = Measure.of(CampaignSettings(), code.mission)
    late = ReferenceEngine(code, 1)
    flights = Flights(late.evaluate_many, measure, (1,))

    drawn = (TimedFault("stop_b", 100, 110),)
    named = named_faults(code.mission, code.pool, drawn, ["h1"])
    found = explain(flights, late, drawn, 0.95)
    print_explanation(Shown(code, measure, "x.xmi", named, 0.95, {}), found)

    assert found.cause.places == found.cause.chains == ()
    assert found.cause.fault_free == found.cause.counts != (0,) * 6
    said = capsys.readouterr().out
    assert (
        "x.xmi: 1 fault, none of which is the cause: without faults, 95 % of every goal's" in said
    )
    assert "Bystanders to every goal: h1\n" in said
    assert "Role of each fault" not in said


def _with_an_earlier_deadline(mission):
    goals = [replace(goal, task=replace(goal.task, deadline=40)) for goal in mission.goals]
    return replace(mission, goals=tuple(goals))
