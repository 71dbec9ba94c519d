"""The studies of docs/studies.md, with their raw runs in docs/studies.

``python -m benchmarks.studies operators FOLDER`` searches six missions with restricted and freed
operators, in a folder that is new or to go on; ``parameters FOLDER`` takes the runs from the folder
of a ``mrsfi compare --sweep``. Both write a CSV. ``tables`` prints what these say.
"""

import csv
import subprocess
import sys
from collections.abc import Iterable, Mapping
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from statistics import median

import mrsfi
from mrsfi_runtime.analysis.table import Table, as_csv, to_markdown
from mrsfi_runtime.study.comparison import RunResult, compare_ranks, holm
from mrsfi_runtime.study.variants import Variant

KEPT = Path("docs/studies")
N_SEEDS, N_EVALUATIONS = 20, 909
SETTINGS = {
    "restricted": ("exchange", "redraw"),
    "free": ("free", "free"),
    "transform": ("free", "transform"),
}
VARIANTS = [
    Variant(name, {"crossover_operator": crossover, "mutation_operator": mutation})
    for name, (crossover, mutation) in SETTINGS.items()
]
COLUMNS = ("seed", "evaluations", "fitness", "hypervolume", "at_once", "together", "digest")
MISSIONS = {
    "uuv_sampling a": ("uuv_sampling", "a"),
    "uuv_sampling b": ("uuv_sampling", "b"),
    "tight_energy a": ("tight_energy", "a"),
    "tight_margins a": ("tight_margins", "a"),
    "harbour": ("harbour", "defaults.toml"),
    "warehouse": ("warehouse", "defaults.toml"),
}


def row(run: RunResult) -> tuple[object, ...]:
    """Return what is kept of a run; goals broken by one specification, and by all together."""
    n_broken = (sum(place is not None for place in each) for each in (run.at_once, run.together))
    return (run.seed, run.n_evaluations, run.best_fitness, run.hypervolume, *n_broken, run.digest)


def missions(folder: Path) -> Mapping[str, tuple[mrsfi.Mission, str]]:
    """Return the missions by name, each with its campaign file; make those that are not shipped."""
    (folder / "defaults.toml").write_text("[search]\n", encoding="utf-8")
    if not (folder / "models").is_dir():
        subprocess.run([sys.executable, "examples/warehouse/warehouse.py", folder], check=True)
    harbour = mrsfi.load("tests/independent/harbour", folder / "generated" / "harbour")
    harbour.generate()
    made = {
        "harbour": harbour,
        "warehouse": mrsfi.load(folder / "models/warehouse", folder / "generated/warehouse"),
    }
    return {
        title: (made.get(name) or mrsfi.load(name), str(folder / case) if name in made else case)
        for title, (name, case) in MISSIONS.items()
    }


def operators(folder: Path) -> None:
    """Search all missions with all settings, and keep the runs."""
    folder.mkdir(parents=True, exist_ok=True)
    rows: list[tuple[object, ...]] = []
    for title, (mission, case) in missions(folder).items():
        out = folder / title.replace(" ", "-")
        found = mission.compare(VARIANTS, N_SEEDS, N_EVALUATIONS, case=case, out=out, workers=1)
        rows += [(title, run.algorithm, *row(run)) for run in found.runs]
        keep("operators", ("mission", "setting", *COLUMNS), rows)


def keep(name: str, columns: Iterable[str], rows: Iterable[tuple[object, ...]]) -> None:
    """Write the runs of a study."""
    KEPT.mkdir(exist_ok=True)
    (KEPT / f"{name}.csv").write_bytes(as_csv([tuple(columns), *rows]))  # type: ignore[list-item]


def parameters(folder: Path) -> None:
    """Keep the runs of a sweep."""
    with (folder / "runs.csv").open(encoding="utf-8", newline="") as file:
        runs = list(csv.DictReader(file))
    keys = [part.partition("=")[0] for part in runs[0]["algorithm"].split(",")]
    rows = [
        (
            *(part.partition("=")[2] for part in run["algorithm"].split(",")),
            *itemgetter("seed", "n_evaluations", "fitness", "hypervolume", "digest")(run),
        )
        for run in runs
    ]
    keep("parameters", (*keys, "seed", "evaluations", "fitness", "hypervolume", "digest"), rows)


def tables() -> None:
    """Print, for each mission and measure, medians and tests of freed operators."""
    with (KEPT / "operators.csv").open(encoding="utf-8", newline="") as file:
        kept = list(csv.DictReader(file))
    for measure in ("fitness", "at_once", "together"):
        cells, ranks = [], []
        for mission, runs in groupby(kept, itemgetter("mission")):
            values: dict[str, list[float]] = {name: [] for name in SETTINGS}
            for run in runs:
                values[run["setting"]].append(float(run[measure] or "nan"))
            for name in list(SETTINGS)[1:]:
                cells.append((mission, name, median(values["restricted"]), median(values[name])))
                ranks.append(compare_ranks(values[name], values["restricted"]))
        adjusted = holm([found.p_value for found in ranks])
        rows = [
            (*cell, f"{found.a12:.2f}", found.magnitude, f"{p:.2g}")
            for cell, found, p in zip(cells, ranks, adjusted, strict=True)
        ]
        columns = ("mission", "operators", "restricted", "median", "A12", "magnitude", "p (Holm)")
        print(f"\n{measure}\n", to_markdown(Table(measure, columns, rows)), sep="\n")


if __name__ == "__main__":
    if sys.argv[1] == "tables":
        tables()
    else:
        {"operators": operators, "parameters": parameters}[sys.argv[1]](Path(sys.argv[2]))
