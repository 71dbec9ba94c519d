"""Synthetic campaigns: a mission, its pool, and evaluations as a search would leave them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random

from mrsfi_runtime.api import AvoidCollision, GatherSamples, StayWithinMissionArea, SufficientEnergy
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Area, Coordinates, Goal, Mission, Obstacle, Robot, Sensor
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.campaign import CampaignStore, Evaluation, Generation
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from tests.support.fault_types import FAULT_TYPES

STARTS = {"LEN": (250.0, -250.0), "JEN": (-250.0, 250.0), "KAL": (250.0, 250.0)}
OBSTACLES = (
    (0, 500, 50),
    (500, 500, 40),
    (500, 0, 45),
    (500, -500, 25),
    (0, -500, 30),
    (-500, -500, 28),
    (-500, 0, 45),
    (-500, 500, 15),
)

SETTINGS = CampaignSettings(seed=7)


def area(identifier: str, x: float, y: float, radius: float) -> Area:
    """Return a disc."""
    return Area(identifier, Coordinates(x, y), radius)


def mission() -> Mission:
    """Return a mission with the places and goals of the paper's."""
    robots = tuple(
        Robot(
            f"r{i}",
            name,
            Coordinates(x, y),
            4.0,
            (Sensor(f"s{i}", f"s{i}", "DEPTH", 2.0, 5),),
        )
        for i, (name, (x, y)) in enumerate(STARTS.items(), start=1)
    )
    obstacles = tuple(
        Obstacle(f"o{i}", area(f"b{i}", x, y, radius))
        for i, (x, y, radius) in enumerate(OBSTACLES, start=1)
    )
    members = tuple(robot.id for robot in robots)
    gather = tuple(
        Goal(
            f"g{i + 3}",
            "GatherSamples",
            (f"r{i}",),
            GatherSamples(250, f"s{i}"),
            area(f"a{i}", *STARTS[robots[i - 1].name], 150),
        )
        for i in (1, 2, 3)
    )
    return Mission(
        name="waters",
        duration=1000,
        area=area("a0", 0, 0, 2000),
        robots=robots,
        servers=(),
        obstacles=obstacles,
        goals=(
            Goal("g1", "AvoidCollision", members, AvoidCollision(members)),
            Goal("g2", "StayWithinMissionArea", members, StayWithinMissionArea()),
            Goal("g3", "SufficientEnergy", members, SufficientEnergy()),
            *gather,
        ),
    )


def pool() -> FaultPool:
    """Return a pool with one fault of each type, ``f1`` to ``f30``."""
    return FaultPool(
        "fs",
        tuple(
            Fault(f"f{i}", kind, "m1", tuple(0.0 for _ in kind.parameters), name=f"f{i}")
            for i, kind in enumerate(FAULT_TYPES.values(), start=1)
        ),
    )


@dataclass(frozen=True)
class Code:
    """What a report needs to know about the code that a campaign flew."""

    mission: Mission
    pool: FaultPool


def outcome(believed: Sequence[int], n_faults: int = 0) -> Outcome:
    """Return an outcome whose other counts follow from the believed ones."""
    none = tuple(0 for _ in believed)
    return Outcome(
        believed=tuple(believed),
        true=tuple(n // 2 for n in believed),
        phantom=tuple(n - n // 2 for n in believed),
        masked=none,
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
        flown = (TimedFault("f1", index, index + 10, (float(index),)),)
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
    types = list(FAULT_TYPES.values())
    timed = []
    for _ in range(n_faults):
        number = min(random.randrange(30), random.randrange(30))
        start = random.randrange(900)
        finish = random.randrange(start, 1000)
        values = tuple(random.uniform(-500, 500) for _ in types[number].parameters)
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
