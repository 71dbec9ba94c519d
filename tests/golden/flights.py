"""The flights whose traces are committed, and how they are recorded.

Run ``python -m tests.golden.flights`` to record them anew, on purpose only: a changed digest
means that a mission now flies differently.
"""

import json
from random import Random

from mrsfi_runtime.engine.reference import ReferenceEngine
from mrsfi_runtime.mission import load_code
from mrsfi_runtime.record.trace import TraceDigest
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification
from tests.support.tree import ROOT

RECORD = ROOT / "tests" / "golden" / "flights.json"
MISSIONS = ("uuv_sampling", "tight_margins")
N_FLIGHTS = 4


def flights() -> dict[str, dict[str, object]]:
    """Fly each mission without faults and under random specifications of fixed seeds."""
    record = {}
    for mission in MISSIONS:
        code = load_code(ROOT / "generated" / mission)
        space = SearchSpace.of(code.mission, code.pool)
        for seed in range(N_FLIGHTS):
            digest = TraceDigest()
            specification = random_specification(space, 20, Random(seed)) if seed else ()
            outcome = ReferenceEngine(code, seed).evaluate(specification, observer=digest)
            record[f"{mission}, seed {seed}"] = {
                "n_faults": len(specification),
                "believed": list(outcome.believed),
                "true": list(outcome.true),
                "trace": digest.hexdigest(),
            }
    return record


if __name__ == "__main__":
    RECORD.write_text(json.dumps(flights(), indent=1) + "\n", encoding="utf-8")
