"""The studies of operators and settings, with their raw runs in benchmarks/results.

``python -m benchmarks.studies operators FOLDER`` searches six missions with restricted and freed
operators, in a folder that is new or to go on; ``parameters FOLDER`` takes the runs from the folder
of a ``mrsfi compare --sweep``. Both write a CSV. ``tables`` prints what these say.
"""

import csv
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.stats import wilcoxon

import mrsfi
from mrsfi_runtime.analysis.tables import Table, as_csv, to_markdown
from mrsfi_runtime.study.comparison import PAPERS, RunResult, Variant, compare_ranks, holm

KEPT = Path("benchmarks/results")
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


def kept_runs(name: str) -> list[dict[str, str]]:
    """Return the runs of a study."""
    with (KEPT / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def print_table(title: str, columns: Iterable[str], rows: Iterable[tuple[Any, ...]]) -> None:
    """Print a table in Markdown."""
    print(f"\n{title}\n", to_markdown(Table(title, tuple(columns), [*rows])), sep="\n")


Settings = Mapping[tuple[str, ...], Sequence[float]]
"""The best fitness of each setting of a sweep, by seed; the seeds are the same for all."""


def parameter_tables() -> None:
    """Print medians by value, whether values differ from the paper's, and each setting."""
    runs = kept_runs("parameters")
    keys = tuple(list(runs[0])[: list(runs[0]).index("seed")])
    by_setting: dict[tuple[str, ...], list[float]] = {}
    for run in runs:
        by_setting.setdefault(itemgetter(*keys)(run), []).append(float(run["fitness"]))
    n_short = sum(int(run["evaluations"]) < N_EVALUATIONS for run in runs)
    print(f"{len(runs)} runs; {n_short} of them ended before {N_EVALUATIONS} evaluations")
    base = by_setting.pop(tuple(str(PAPERS[key]) for key in keys))
    rows = []
    for place, key in enumerate(keys):
        values = {setting[place]: list[float]() for setting in by_setting}
        for setting, found in by_setting.items():
            values[setting[place]] += found
        rows += [(key, value, len(found), median(found)) for value, found in values.items()]
    print_table("best fitness by value", ("setting", "value", "runs", "median"), rows)
    print_blocked(keys, by_setting)
    tests = {setting: compare_ranks(found, base) for setting, found in by_setting.items()}
    adjusted = holm([each.p_value for each in tests.values()])
    tested = [
        (*setting, median(by_setting[setting]), each.a12, each.p_value, p)
        for (setting, each), p in zip(tests.items(), adjusted, strict=True)
    ]
    columns = (*keys, "median", "A12", "p", "p (Holm)")
    title = f"settings against the paper's ({len(base)} seeds, median {median(base):.1f})"
    print_table(title, columns, sorted(tested, key=itemgetter(-3), reverse=True))


def print_blocked(keys: Sequence[str], by_setting: Settings) -> None:
    """Print how each value does against the one nearest to the paper's, blocked.

    A block is a seed and the values of the other settings. The differences of one seed are
    averaged over its blocks, because these begin with the same populations; Wilcoxon's signed-rank
    test is of one such number a seed. "better" is the share of blocks, ties half.
    """
    rows, p_values = [], []
    for place, key in enumerate(keys):
        values = [*dict.fromkeys(setting[place] for setting in by_setting)]
        papers = min(values, key=lambda value: abs(float(value) - float(PAPERS[key])))
        for value in filter(papers.__ne__, values):
            blocks = np.array([
                np.subtract(found, by_setting[*setting[:place], papers, *setting[place + 1 :]])
                for setting, found in by_setting.items()
                if setting[place] == value
            ])  # fmt: skip
            share = np.mean((blocks > 0) + (blocks == 0) / 2)
            by_seed = blocks.mean(axis=0)
            p_values.append(wilcoxon(by_seed).pvalue)
            rows.append((key, value, papers, blocks.size, share, median(by_seed), p_values[-1]))
    found = [(*row, p) for row, p in zip(rows, holm(p_values), strict=True)]
    columns = ("setting", "value", "against", "blocks", "better", "difference", "p", "p (Holm)")
    print_table("values against the paper's, blocked by seed and setting", columns, found)


def operator_tables() -> None:
    """Print, for each mission and measure, medians and tests of freed operators."""
    kept = kept_runs("operators")
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
        print_table(measure, columns, rows)


if __name__ == "__main__":
    if sys.argv[1] == "tables":
        operator_tables()
        parameter_tables()
    else:
        {"operators": operators, "parameters": parameters}[sys.argv[1]](Path(sys.argv[2]))
