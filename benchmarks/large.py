"""What the report of a million evaluations takes: seconds, and peak memory.

Run ``python -m benchmarks.large`` from the project's root after ``make install``; with ``--beside
COPY``, a tree that ``benchmarks.beside`` installed, that commit reports the same record first. What
a search of a hundred thousand takes says ``benchmarks.beside many``.

Nobody flies a million times for it: the rows of the record are flights of random specifications,
in each of which a fault is swapped and counts are moved by a few ticks, so that all differ.

Ends with 1 if the report takes more memory than it should.
"""

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from random import Random

from benchmarks.measuring import MEBI, Aims, Run, drawn, run_in
from mrsfi.campaign_folders import manifest_of
from mrsfi.folders import campaign_file, find_mission
from mrsfi_runtime.engine.compiled.engine import CompiledEngine
from mrsfi_runtime.generated_code import MissionCode, load_code
from mrsfi_runtime.model.faults import fault_ticks
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.record.manifest import EngineRecord
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Generation
from mrsfi_runtime.search.fitness import Judge
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.steps import swapped

MISSION, CASE = "uuv_sampling", "b"
N_FLOWN = 2_000
MOST_TICKS = 20
"""By which a count is moved."""
AIM = 500.0
"""Mebibytes that the report is to stay below."""


def evaluations(code: MissionCode, settings: CampaignSettings) -> Iterator[Evaluation]:
    """Yield evaluations without end, hardly any two of the same specification."""
    space, judge, random = (
        SearchSpace.of(code.mission, code.pool),
        Judge(settings, code.mission),
        Random(1),
    )
    specifications = drawn(code, N_FLOWN, settings.faults)
    with CompiledEngine(code, 1) as engine:
        flown = [*zip(specifications, engine.evaluate_many(specifications), strict=True)]
    index = 0
    while True:
        for known, outcome in flown:
            assert isinstance(outcome, Outcome)
            specification = swapped(space, known, random)
            believed = tuple(
                min(code.mission.duration, count + random.randrange(MOST_TICKS))
                for count in outcome.believed
            )
            n_faults = len(specification)
            found = replace(
                outcome,
                believed=believed,
                applied=outcome.applied[:n_faults],
                changed=outcome.changed[:n_faults],
            )
            yield Evaluation(
                index,
                index // settings.population,
                specification,
                found,
                (judge.score(found).fitness,),
                fault_ticks(specification, code.mission.duration),
            )
            index += 1


def write(folder: Path, n_evaluations: int) -> None:
    """Write the folder of a campaign as its search would leave it."""
    folders = find_mission(MISSION, None)
    settings = CampaignSettings.load(campaign_file(folders, CASE), evaluations=n_evaluations)
    CampaignFolder.reserve(folder).fill(folders.models, folders.generated)
    found = islice(evaluations(load_code(folders.generated), settings), n_evaluations)
    random = Random(1)
    with CampaignStore.create(
        folder, settings, manifest_of(folders, CASE, EngineRecord())
    ) as store:
        while members := list(islice(found, 500 * settings.population)):
            store.append(members, (), generations(members, settings.population, random))


def generations(members: list[Evaluation], size: int, random: Random) -> Iterator[Generation]:
    """Yield the generations whose populations are evaluations in turn."""
    for first in range(0, len(members), size):
        population = members[first : first + size]
        fitness = [each.fitness[0] for each in population]
        mean = sum(fitness) / len(fitness)
        random.random()
        yield Generation(
            population[0].generation,
            {
                "n_evaluations": len(fitness),
                "mean": mean,
                "std": 0.0,
                "min": min(fitness),
                "max": max(fitness),
            },
            tuple(each.index for each in population),
            json.dumps(random.getstate()),
        )


def report(tree: Path, folder: Path) -> Run:
    """Run the report of a campaign by the mrsfi that is installed in a tree."""
    return run_in(tree, [str(tree / ".venv/bin/mrsfi"), "report", str(folder)], os.environ)


def main() -> int:
    """Print seconds and memory; return 1 if it takes too much memory."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--evaluations", type=int, default=1_000_000)
    parser.add_argument("--beside", metavar="COPY", type=Path, help="tree of another commit")
    arguments = parser.parse_args()
    aims = Aims()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "run"
        write(folder, arguments.evaluations)
        size = CampaignFolder(folder).database.stat().st_size
        print(f"record of {arguments.evaluations:,} evaluations: {size / MEBI:,.0f} MiB")
        for tree in [arguments.beside.absolute()] if arguments.beside else []:
            found = report(tree, folder)
            print(f"{tree}: {found.seconds:.1f} s, {found.peak / MEBI:.0f} MiB")
        found = report(Path.cwd(), folder)
        print(f"report: {found.seconds:.1f} s, of processors {found.processor:.1f} s")
        aims.below("its peak memory", found.peak / MEBI, AIM, "MiB")
    return aims.exit_code()


if __name__ == "__main__":
    sys.exit(main())
