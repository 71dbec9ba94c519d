"""What 10,000 evaluations leave behind: size of the record, and seconds of the report's queries.

Run ``python -m benchmarks.record`` from the project's root after ``make install``, or with
``--quick`` for 1,000. The paper's mission is searched at random on the compiled engine.

Ends with 1 if a query takes a second or more.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.measuring import Aims, seconds
from mrsfi_runtime.analysis.fronts import Columns
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.record.engine_settings import COMPILED, EngineSettings, Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure
from mrsfi_runtime.search.run import run_campaign

MISSION = Path("generated") / "uuv_sampling"
AIM = 1.0
"""Seconds that each query is to stay below."""
N_ROUNDS = 3
"""The quickest counts."""


def write(folder: Path, n_evaluations: int) -> float:
    """Record a random search, and return its seconds."""
    settings = CampaignSettings(algorithm="random", evaluations=n_evaluations, population=100)
    code = load_code(MISSION)
    with (
        CampaignStore.create(folder, settings, Manifest()) as store,
        open_engine(EngineSettings(COMPILED), load_code(MISSION), settings.mission_seed) as pool,
    ):
        evaluate = pool.evaluate_many
        return seconds(lambda: run_campaign(settings, code.mission, code.pool, evaluate, store))


def queries(store: CampaignStore, mission: Mission) -> Mapping[str, Callable[[], Any]]:
    """Return what is asked of a record, mostly by a report; each reads all that it is about."""
    last = store.n_evaluations - 1
    measure = Measure.of(store.settings, mission)
    return {
        "all evaluations": lambda: tuple(store.evaluations()),
        "what a report asks of all evaluations": lambda: Columns.read(store, measure),
        "what a table lists of all evaluations": lambda: tuple(store.flown(1)),
        "all generations": lambda: tuple(store.generations()),
        "all failures": store.failures,
        "the digest over all evaluations": store.digest,
        "one evaluation": lambda: store.evaluation(last),
        "number of evaluations": lambda: store.n_evaluations,
        "number of generations": lambda: store.n_generations,
    }


def main() -> int:
    """Print size and queries; return 1 if one takes too long."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="1,000 evaluations")
    n_evaluations = 1_000 if parser.parse_args().quick else 10_000
    aims = Aims()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "run"
        taken = write(folder, n_evaluations)
        size = CampaignFolder(folder).database.stat().st_size
        print(
            f"{n_evaluations:,} evaluations with their record: {taken:.1f} s; "
            f"{size / 1e6:.1f} MB, {size / n_evaluations:,.0f} bytes an evaluation"
        )
        with CampaignStore.open(folder) as store:
            for what, query in queries(store, load_code(MISSION).mission).items():
                aims.below(what, min(seconds(query) for _ in range(N_ROUNDS)), AIM, "s")
    return aims.exit_code()


if __name__ == "__main__":
    sys.exit(main())
