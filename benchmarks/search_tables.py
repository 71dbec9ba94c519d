"""The tables of docs/search.md, from the folders that ``mrsfi compare`` left in ``runs/``.

Run ``python -m benchmarks.search_tables [RUNS]`` after the comparisons that the page lists; rows
whose folder is missing are left out.
"""

import csv
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

CASES = {
    "case A": "compare-uuv_sampling-a",
    "case B": "compare-uuv_sampling-b",
    "`drawn_pool` a": "compare-drawn_pool-a",
    "`tight_energy` a": "compare-tight_energy-a",
    "`tight_energy` b": "compare-tight_energy-b",
    "`tight_energy` c": "compare-tight_energy-c",
    "`tight_margins` a": "compare-tight_margins-a",
}
PAIRS = {
    "tuned pair": "compare-margins_4-energy-depths",
    "fresh pair": "compare-margins_7-energy-pressures",
}
ALGORITHMS = ("guided", "nsga2", "paper", "drift", "random")
TESTS = (
    "guided random",
    "guided drift",
    "guided paper",
    "paper random",
    "paper drift",
    "drift random",
)
OF_NSGA2 = ("guided nsga2", "nsga2 random", "nsga2 drift", "nsga2 paper")
ALL_GOALS = "evaluations until all goals are broken at once"
BEGINNINGS = ("random", "first_populations:both", "first_populations:from_chance", "guided")


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    """Return a table of a comparison."""
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def last_goal(folder: Path) -> str:
    """Return the measure of all goals broken at once."""
    found = {row["measure"] for row in rows(folder, "quartiles")}
    return max(
        (name for name in found if name.startswith("at_once_")), key=lambda name: int(name[8:])
    )


def number(text: str, measure: str) -> str:
    """Return a quartile as the page writes it."""
    value = float(text or "inf")  # empty: never reached
    if value == float("inf"):
        return "never"
    if measure == "hypervolume":
        return f"{value:.1e}" if 0.0 < value < 0.01 else f"{value:.3f}" if value < 1.0 else "1"
    return f"{value:,.1f}" if measure == "fitness" else f"{value:,.1f}".removesuffix(".0")


def quartiles(folder: Path, measure: str) -> Mapping[str, str]:
    """Return, for each algorithm, the median and quartiles of a measure."""
    found = {}
    for row in rows(folder, "quartiles"):
        if row["measure"] == measure:
            low, middle, high = (number(row[key], measure) for key in ("lower", "median", "upper"))
            found[row["algorithm"]] = f"{middle} [{low}, {high}]"
    return found


def tests(folder: Path, measure: str) -> Mapping[str, str]:
    """Return, for each pair of algorithms, A12, its magnitude and Holm's p-value of a measure."""
    found = {}
    for row in rows(folder, "tests"):
        if row["measure"] != measure:
            continue
        p = float(row["holm_p_value"])
        shown = f"{p:.3f}" if p >= 0.001 else f"{p:.1e}"
        a12, magnitude = float(row["a12"]), row["magnitude"]
        found[f"{row['first']} {row['second']}"] = f"{a12:.2f} {magnitude}, {shown}"
        found[f"{row['second']} {row['first']}"] = f"{1.0 - a12:.2f} {magnitude}, {shown}"
    return found


def print_table(
    title: str,
    columns: Sequence[str],
    folders: Mapping[str, Path],
    cells: Callable[[Path, str], Mapping[str, str]],
    measure: str,
) -> None:
    """Print a table in Markdown: a row for each folder that has one of the columns."""
    shown = [["", *(", ".join(f"`{name}`" for name in column.split()) for column in columns)]]
    for label, folder in folders.items():
        found = cells(folder, last_goal(folder) if measure == ALL_GOALS else measure)
        if any(column in found for column in columns):
            shown.append([label, *(found.get(column, "–") for column in columns)])
    lines = [f"| {' | '.join(cells)} |".replace("|  |", "| |") for cells in shown]
    lines.insert(1, "|" + "---|" * (1 + len(columns)))
    print(f"\n{title}: {measure}\n", *lines, sep="\n")


def main(runs: Path) -> None:
    """Print all tables."""
    ready = {path.parent.name: path.parent for path in runs.glob("*/tests.csv")}
    cases = {label: ready[name] for label, name in CASES.items() if name in ready}
    pairs = {label: ready[name] for label, name in PAIRS.items() if name in ready}
    for measure in ("fitness", "hypervolume", ALL_GOALS):
        print_table("cases", ALGORITHMS, cases, quartiles, measure)
        print_table("tests", TESTS, cases, tests, measure)
        print_table("nsga2", OF_NSGA2, cases, tests, measure)
    for measure in ("fitness", "hypervolume"):
        print_table("pairs", ALGORITHMS, pairs, quartiles, measure)
        print_table("tests", (*TESTS[:2], *OF_NSGA2[:3]), pairs, tests, measure)
    firsts = {name: ready[name] for name in sorted(ready) if name.startswith("first_populations")}
    print_table("beginnings", BEGINNINGS, firsts, quartiles, "fitness")
    of_firsts = [f"{first} {second}" for first, second in pairwise(BEGINNINGS)]
    print_table("tests", [*of_firsts, f"{BEGINNINGS[1]} {BEGINNINGS[3]}"], firsts, tests, "fitness")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "runs"))
