"""The flights whose digests are committed, and how they are recorded.

Run ``python -m tests.golden.flights`` to record them anew, on purpose only: a changed digest
means that a mission now flies differently.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from random import Random

from mrsfi_runtime.engine.flights import Engine, ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.search.space import SearchSpace, random_specification
from tests.golden.frozen import FrozenTrace, outcome_digest
from tests.support.tree import ROOT

FLIGHTS = ROOT / "tests" / "golden" / "flights.json"
EFFECTS = ROOT / "tests" / "golden" / "effects.json"
MISSIONS = ("uuv_sampling", "tight_margins")
N_FLIGHTS = 4
WINDOWS = {"uuv_sampling": (100, 900), "tight_margins": (60, 180), "tight_energy": (60, 340)}
"""Missions, and the window in which each fault of their pools flies alone."""


def flights() -> dict[str, dict[str, object]]:
    """Fly each mission without faults and under random specifications of fixed seeds."""
    record = {}
    for mission in MISSIONS:
        code = load_code(ROOT / "generated" / mission)
        space = SearchSpace.of(code.mission, code.pool)
        for seed in range(N_FLIGHTS):
            trace = FrozenTrace()
            specification = random_specification(space, 20, Random(seed)) if seed else ()
            outcome = frozen_outcome(ReferenceEngine(code, seed), specification, trace)
            record[f"{mission}, seed {seed}"] = {
                "n_faults": len(specification),
                "believed": list(outcome.believed),
                "true": list(outcome.true),
                "outcome": outcome.digest,
                "trace": trace.hexdigest(),
            }
    return record


def frozen_outcome(
    engine: Engine, specification: Specification, trace: FrozenTrace | None = None
) -> Outcome:
    """Evaluate a specification, with its digest in the frozen encoding."""
    last: list[State] = []

    def watch(world: State, belief: State, verdicts: Verdicts) -> None:
        last[:] = world, belief
        if trace is not None:
            trace(world, belief, verdicts)

    outcome = engine.evaluate(specification, observer=watch)
    return replace(outcome, digest=outcome_digest(outcome, *last))


def effects() -> Iterator[tuple[str, str]]:
    """Fly every fault of each pool alone; yield mission and fault, and the outcome's digest."""
    for mission, (start, finish) in WINDOWS.items():
        code = load_code(ROOT / "generated" / mission)
        engine = ReferenceEngine(code, 1)
        for fault in code.pool:
            alone = (TimedFault(fault.id, start, finish, fault.values),)
            yield f"{mission}, {fault.id}", frozen_outcome(engine, alone).digest


if __name__ == "__main__":
    for path, record in ((FLIGHTS, flights()), (EFFECTS, dict(effects()))):
        path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
