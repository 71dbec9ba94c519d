"""Measures from within, in the tree whose Python runs it: flights, evaluations, searches.

``benchmarks.beside`` runs it in two trees, with ``benchmarks`` of the same tree: it keeps to what
old commits have as well. Milliseconds of processors are printed, as JSON.
"""

import json
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.fleets import fleet
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import run_campaign
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import random_specification

MISSION = "uuv_sampling"
LEAST_SECONDS = 1.0
"""Evaluations are repeated for so long; the quickest counts."""
N_ROBOTS, N_TICKS = 1_000, 1_000


class Timed:
    """A function, and the seconds of processors that its calls took."""

    def __init__(self, function: Callable[..., object]) -> None:
        self._function = function
        self.seconds = 0.0

    def __call__(self, *arguments: object) -> None:
        """Call the function."""
        start = time.process_time()
        self._function(*arguments)
        self.seconds += time.process_time() - start


def evaluation(code: MissionCode, n: int) -> dict[str, float]:
    """Return what an evaluation takes, and the compiled flight in it, the least of some rounds."""
    space = SearchSpace.of(code.mission, code.pool)
    specifications = [random_specification(space, 20, Random(seed)) for seed in range(n)]
    taken: list[tuple[float, float]] = []
    with CompiledEngine(code, 1) as engine:
        vars(engine)["_is_checked"] = True  # the reference would fly a fleet for a minute
        list(engine.evaluate_many(specifications[:2]))
        flown = Timed(vars(engine)["_fly_many"])
        vars(engine)["_fly_many"] = flown
        end = time.perf_counter() + LEAST_SECONDS
        while time.perf_counter() < end or not taken:
            flown.seconds = 0.0
            start = time.process_time()
            list(engine.evaluate_many(specifications))
            taken.append((flown.seconds, time.process_time() - start))
    flights, evaluations = (1000 * min(each) / n for each in zip(*taken, strict=True))
    return {"flight": flights, "evaluation": evaluations}


def search(code: MissionCode) -> float:
    """Return what 909 evaluations of a search of case a take, with their record, compiled before.

    The paper's search has about as many; how many exactly differs from commit to commit.
    """
    is_new = find_spec("mrsfi_runtime.record.settings") is not None
    room = "mrsfi_runtime.record" if is_new else "mrsfi_runtime.search"
    campaign = import_module(f"{room}.settings").CampaignSettings
    settings = campaign.load(Path("models") / MISSION / "case_a.toml")
    recorded: tuple[Any, ...] = (settings.as_json(), {})
    if is_new:
        recorded = settings, import_module("mrsfi_runtime.record.manifest").Manifest()
    with (
        tempfile.TemporaryDirectory() as name,
        CampaignStore.create(Path(name) / "run", *recorded) as store,
        CompiledEngine(code, settings.mission_seed) as engine,
    ):
        list(engine.evaluate_many([()]))  # compared with the reference
        start = time.process_time()
        run_campaign(settings, code.mission, code.pool, engine.evaluate_many, store)
        return 909_000 * (time.process_time() - start) / store.n_evaluations


def paper() -> dict[str, float]:
    """Return what the paper's mission takes."""
    code = load_code(Path("generated") / MISSION)
    return {**evaluation(code, 200), "search of 909": search(code)}


def robots(folder: Path) -> dict[str, float]:
    """Return what a fleet takes; it is generated in a folder the first time."""
    generated = folder / "generated"
    code = load_code(generated) if generated.is_dir() else fleet(folder, N_ROBOTS, N_TICKS)
    return {f"{N_ROBOTS:,} robots: {what}": ms for what, ms in evaluation(code, 2).items()}


if __name__ == "__main__":
    folders = sys.argv[1:]
    print(json.dumps(robots(Path(folders[0])) if folders else paper()))
