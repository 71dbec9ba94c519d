"""What a campaign finds out by itself about the causes of its most critical evaluations."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from mrsfi_runtime.causes.cause import Cause, find_cause
from mrsfi_runtime.causes.cause_set import KEEP
from mrsfi_runtime.causes.chain import Chain, First
from mrsfi_runtime.causes.counts import BudgetSpentError, EvaluateIn, Flights
from mrsfi_runtime.causes.sentence import sentence
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.errors import EvaluationError, WorkerLost
from mrsfi_runtime.model.faults import numbered
from mrsfi_runtime.record.campaign import CampaignStore, Evaluation
from mrsfi_runtime.record.causes import RecordedCause
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.named_faults import NamedFault, named_faults


def record_causes(
    store: CampaignStore,
    measure: Measure,
    best: Sequence[Evaluation],
    evaluate_many: EvaluateIn,
    engine: Engine,
    on_found: Callable[[RecordedCause], None],
) -> None:
    """Find out the causes of evaluations that are not recorded yet, one after the other.

    All of them take at most as many flights as the search did: whatever is left when one begins
    is what it may take, and the first one for which that is too little is the last.

    Parameters
    ----------
    store
        The campaign, whose search has ended.
    measure
        What is counted.
    best
        Its evaluations, the most critical first.
    evaluate_many
        Flies their faults.
    engine
        Records flights that have to be looked at.
    on_found
        Told what was found out now.

    Raises
    ------
    RecordError
        If the record cannot be written.
    WorkerLost, TransportError
        If somebody who flies is gone; nothing is stored about what was being looked at.
    """
    mission_seeds = store.settings.mission_seeds
    left = store.n_evaluations * len(mission_seeds)
    known = {each.index: each for each in store.causes()}
    for evaluation in best:
        cause = known.get(evaluation.index)
        if cause is None:
            flights = Flights(evaluate_many, measure, mission_seeds, left)
            cause = _found(flights, engine, evaluation)
            store.append_cause(cause)
            on_found(cause)
        left -= cause.n_flown
        if cause.reason == _SPENT:
            return


_SPENT = "it would take more flights than the search did"
_NOTHING = "it violates no goal that is counted"
NO_FAULT = "without any of its faults, the violations are there as well"


def _found(flights: Flights, engine: Engine, evaluation: Evaluation) -> RecordedCause:
    def because(reason: str) -> RecordedCause:
        return RecordedCause(evaluation.index, flights.n_flown.total(), reason)

    try:
        cause = find_cause(flights, engine, evaluation.specification, KEEP)
    except BudgetSpentError:
        return because(_SPENT)
    except WorkerLost:
        raise
    except EvaluationError as error:
        return because(str(error))
    if cause is None:
        return because(_NOTHING)
    if not cause.places:
        return because(NO_FAULT)
    names = numbered(timed.fault for timed in evaluation.specification)
    mission, pool = engine.code.mission, engine.code.pool
    faults = named_faults(mission, pool, evaluation.specification, names)
    return recorded(evaluation.index, cause, faults)


def recorded(index: int, cause: Cause, faults: Sequence[NamedFault]) -> RecordedCause:
    """Return what is kept and shown of the cause of an evaluation.

    Parameters
    ----------
    index
        The evaluation.
    cause
        Why it violates goals.
    faults
        All its faults.
    """
    return RecordedCause(
        index=index,
        n_flown=sum(cause.n_flown.values()),
        places=cause.places,
        leading=cause.leading,
        outcome=cause.outcome,
        sentences=sentences(cause, faults),
        chains=tuple(map(chain_as_json, cause.chains)),
        firmness=tuple(
            column._asdict() | asdict(firm)
            for column, firm in zip(cause.columns, cause.firmness, strict=True)
        ),
    )


def sentences(cause: Cause, faults: Sequence[NamedFault]) -> tuple[str, ...]:
    """Return for each fault of a cause set what it did, in words.

    Parameters
    ----------
    faults
        All faults of the specification.
    """
    return tuple(
        sentence(faults[place], chain)
        for place, chain in zip(cause.places, cause.chains, strict=True)
    )


def chain_as_json(chain: Chain) -> dict[str, Any]:
    """Return a chain as plain values."""
    firsts = {"belief": chain.belief, "command": chain.command, "truth": chain.truth}
    return {
        **{
            name: None if first is None else _first_as_json(first) for name, first in firsts.items()
        },
        "verdicts": {
            each.goal: {
                name: None if verdict is None else verdict._asdict()
                for name, verdict in zip(each._fields[1:], each[1:], strict=True)
            }
            for each in chain.verdicts
        },
    }


def _first_as_json(first: First) -> dict[str, Any]:
    changes = [change._asdict() | {"size": change.size} for change in first.changes]
    return {"tick": first.tick, "changes": changes}
