"""The paper's mission and fault pool, and a stand-in evaluation."""

from collections.abc import Sequence
from dataclasses import replace
from random import Random

from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.search.space import SearchSpace, random_specification
from tests.support.world import paper_code

_PAPER = paper_code()
PAPER_FAULTS = _PAPER.pool.faults


def paper_mission(duration: int = 1000) -> Mission:
    return replace(_PAPER.mission, name="uuv_sampling", duration=duration)


def pool_of(*fault_ids: str) -> FaultPool:
    """Return the paper's pool, or only some of its faults in the order given."""
    faults = {fault.id: fault for fault in PAPER_FAULTS}
    return FaultPool("fs", tuple(faults[f] for f in fault_ids) if fault_ids else PAPER_FAULTS)


def paper_space(duration: int = 1000, *fault_ids: str) -> SearchSpace:
    return SearchSpace.of(paper_mission(duration), pool_of(*fault_ids))


def random_pair(space: SearchSpace, n_faults: int, rng: Random) -> tuple[Specification, ...]:
    return (random_specification(space, n_faults, rng), random_specification(space, n_faults, rng))


def outcome_of(*believed: int) -> Outcome:
    zeros = (0,) * len(believed)
    return Outcome(believed, believed, zeros, zeros, zeros, zeros, (), (), "")


def stand_in_outcome(specification: Specification) -> Outcome:
    """Return violations that are a plain function of a specification: long windows are bad."""
    believed = [0] * 6
    for timed in specification:
        number = int(timed.fault[1:])
        believed[number % 6] += timed.finish - timed.start + 1
    return outcome_of(*(min(1000, violations) for violations in believed))


def evaluate_stand_in(specifications: Sequence[Specification]) -> list[Outcome]:
    return [stand_in_outcome(specification) for specification in specifications]
