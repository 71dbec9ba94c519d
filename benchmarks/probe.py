"""Measures from within, in the tree whose Python runs it: flights, evaluations, searches.

``benchmarks.beside`` runs it in two trees, with ``benchmarks`` of the same tree: it keeps to what
old commits have as well. Milliseconds of processors are printed, as JSON.
"""

import json
import sys
import tempfile
import time
from functools import wraps
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from random import Random
from typing import Any

from benchmarks.fleets import fleet
from m2t.generate import generate
from mrsfi_runtime.engine.compiled import engine as compiled
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.search.space import SearchSpace

MISSION = "uuv_sampling"
LEAST_SECONDS = 1.0
"""Evaluations are repeated for so long; the quickest counts."""
N_ROBOTS, N_TICKS = 1_000, 1_000


def module(*names: str) -> Any:
    """Return the first of some modules that this commit has."""
    name = next(each for each in names if find_spec(f"mrsfi_runtime.{each}"))
    return import_module(f"mrsfi_runtime.{name}")


load_code = module("generated_code", "mission").load_code
random_specification = module("search.specifications", "search.space").random_specification


def evaluation(code: Any, n: int) -> dict[str, float]:
    """Return what an evaluation takes, and the compiled flight in it, the least of some rounds."""
    space = SearchSpace.of(code.mission, code.pool)
    specifications = [random_specification(space, 20, Random(seed)) for seed in range(n)]
    taken: list[tuple[float, float]] = []
    with CompiledEngine(code, 1) as engine:
        vars(engine)["_is_checked"] = True  # the reference would fly a fleet for a minute
        trusted = getattr(compiled, "_TRUSTED", None)  # what says the same since later
        if trusted is not None:
            trusted.add(vars(engine)["_mission"])
        list(engine.evaluate_many(specifications[:2]))
        fly, flown = vars(engine)["_fly_many"], [0.0]

        @wraps(fly)  # with what else the engine asks of it
        def timed(*arguments: object) -> None:
            start = time.process_time()
            fly(*arguments)
            flown[0] += time.process_time() - start

        vars(engine)["_fly_many"] = timed
        end = time.perf_counter() + LEAST_SECONDS
        while time.perf_counter() < end or not taken:
            flown[0] = 0.0
            start = time.process_time()
            list(engine.evaluate_many(specifications))
            taken.append((flown[0], time.process_time() - start))
    flights, evaluations = (1000 * min(each) / n for each in zip(*taken, strict=True))
    return {"flight": flights, "evaluation": evaluations}


def search(code: Any) -> float:
    """Return what 909 evaluations, about a search of case a, take with their record."""
    campaign = module("record.settings", "search.settings").CampaignSettings
    settings = campaign.load(Path("models") / MISSION / "case_a.toml")
    recorded: tuple[Any, ...] = (settings.as_json(), {})
    if find_spec("mrsfi_runtime.record.settings"):
        recorded = settings, module("record.manifest", "record.engine_settings").Manifest()
    store_class = module("record.store", "record.campaign").CampaignStore
    run_campaign = module("search.run", "search.campaign").run_campaign
    with (
        tempfile.TemporaryDirectory() as name,
        store_class.create(Path(name) / "run", *recorded) as store,
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


def mission(folder: Path, models: Path) -> dict[str, float]:
    """Return what a mission takes; it is generated in a folder each time."""
    generate(models, folder)
    return {f"{models.name}: {what}": ms for what, ms in evaluation(load_code(folder), 60).items()}


def robots(folder: Path) -> dict[str, float]:
    """Return what a fleet takes; it is generated in a folder the first time."""
    generated = folder / "generated"
    code = load_code(generated) if generated.is_dir() else fleet(folder, N_ROBOTS, N_TICKS)
    return {f"{N_ROBOTS:,} robots: {what}": ms for what, ms in evaluation(code, 2).items()}


if __name__ == "__main__":
    measure = (paper, robots, mission)[len(sys.argv) - 1]
    print(json.dumps(measure(*map(Path, sys.argv[1:]))))
