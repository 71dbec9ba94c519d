"""Synthetic campaigns: evaluations of the paper's mission as a search would leave them."""

import sqlite3
import weakref
from collections.abc import Iterable, Sequence
from pathlib import Path
from random import Random

from mrsfi_runtime.analysis.fronts import Columns
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.model.mission import Area, Coordinates, Outcome
from mrsfi_runtime.record import database
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import (
    CampaignStore,
    Evaluation,
    FailedEvaluation,
    Generation,
    Measure,
)
from tests.support.search import PAPER_FAULTS

_IN_MEMORY = Path("in memory", "campaign.sqlite")
SETTINGS = CampaignSettings(seed=7)


def area(identifier: str, x: float, y: float, radius: float) -> Area:
    """Return a disc."""
    return Area(identifier, Coordinates(x, y), radius)


def outcome(believed: Sequence[int], n_faults: int = 0) -> Outcome:
    """Return an outcome whose other counts follow from the believed ones."""
    none = tuple(0 for _ in believed)
    return Outcome(
        believed=tuple(believed),
        true=tuple(n // 2 for n in believed),
        phantom=tuple(n - n // 2 for n in believed),
        masked=none,
        missed=tuple(n // 4 for n in believed),
        samples=none,
        applied=(1,) * n_faults,
        changed=(1,) * n_faults,
        digest=f"{sum(believed):064x}",
    )


def evaluation(
    index: int,
    believed: Sequence[int],
    *,
    generation: int = 0,
    specification: Specification | None = None,
    fitness: float | None = None,
) -> Evaluation:
    """Return an evaluation; by default of a specification that no other index has."""
    flown = specification
    if flown is None:
        flown = (TimedFault("f8", index, index + 10, (float(index),)),)
    return Evaluation(
        index=index,
        generation=generation,
        specification=flown,
        outcome=outcome(believed, len(flown)),
        fitness=(float(sum(believed)) if fitness is None else fitness,),
        fault_ticks=sum(timed.finish - timed.start + 1 for timed in flown),
    )


def random_specification(random: Random, n_faults: int = 20) -> Specification:
    """Return faults of the pool with windows and values, the message faults favoured."""
    timed = []
    for _ in range(n_faults):
        number = min(random.randrange(30), random.randrange(30))
        start = random.randrange(900)
        finish = random.randrange(start, 1000)
        values = tuple(random.uniform(-500, 500) for _ in PAPER_FAULTS[number].values)
        timed.append(TimedFault(f"f{number + 1}", start, finish, values))
    return tuple(timed)


def generations_of_evaluations(
    n_generations: int, n_individuals: int, seed: int = 1
) -> list[list[Evaluation]]:
    """Return evaluations per generation, whose violations grow from generation to generation."""
    random = Random(seed)
    index = 0
    result = []
    for generation in range(n_generations):
        members = []
        for _ in range(n_individuals):
            skill = (generation + 5) / (n_generations + 5)
            share = random.random()
            believed = (
                int(700 * skill * share * random.random()),
                int(100 * random.random()),
                int(900 * skill * (1 - share * share) * random.random()),
                *(int(600 * skill * random.random()) for _ in range(3)),
            )
            members.append(
                evaluation(
                    index,
                    believed,
                    generation=generation,
                    specification=random_specification(random),
                )
            )
            index += 1
        result.append(members)
    return result


def statistics(members: Iterable[Evaluation]) -> dict[str, float]:
    """Return a generation's statistics."""
    fitness = [member.fitness[0] for member in members]
    mean = sum(fitness) / len(fitness)
    return {
        "n_evaluations": len(fitness),
        "mean": mean,
        "std": (sum((f - mean) ** 2 for f in fitness) / len(fitness)) ** 0.5,
        "min": min(fitness),
        "max": max(fitness),
    }


def store_of(
    evaluations: Iterable[Evaluation] = (),
    settings: CampaignSettings = SETTINGS,
    kind: type[CampaignStore] = CampaignStore,
) -> CampaignStore:
    """Return the store of a campaign that is in no file; it is closed with its last user."""
    connection = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
    meta = {
        "settings": database.canonical(settings.as_json()),
        "manifest": database.canonical(Manifest().as_json()),
    }
    database.fill(_IN_MEMORY, connection, meta)
    store = kind(_IN_MEMORY, connection)
    weakref.finalize(store, connection.close)
    store.append(evaluations)
    return store


def content(
    store: CampaignStore,
) -> tuple[list[Evaluation], tuple[FailedEvaluation, ...], list[Generation]]:
    """Return all that a search has recorded."""
    return [*store.evaluations()], store.failures(), [*store.generations()]


def columns_of(
    evaluations: Iterable[Evaluation], measure: Measure, goals: Sequence[str] = ()
) -> Columns:
    """Return what a report asks of evaluations."""
    with store_of(evaluations) as store:
        return Columns.read(store, measure, goals)


def write_campaign(
    folder: Path,
    *,
    n_generations: int = 12,
    n_individuals: int = 10,
    settings: CampaignSettings | None = None,
    seed: int = 1,
) -> Path:
    """Write a synthetic campaign and return its folder."""
    chosen = CampaignSettings(seed=seed) if settings is None else settings
    with CampaignStore.create(folder, chosen, Manifest()) as store:
        for index, members in enumerate(
            generations_of_evaluations(n_generations, n_individuals, seed)
        ):
            store.append(members)
            population = tuple(member.index for member in members)
            store.append(generations=[Generation(index, statistics(members), population, "[1,2]")])
    return folder
