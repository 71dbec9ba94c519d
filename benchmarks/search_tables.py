"""The tables of benchmarks/results/searches.md, from what ``mrsfi compare`` left in ``runs/``.

Run ``python -m benchmarks.search_tables [RUNS]`` after the comparisons that the page lists.
"""

import csv
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

ALL_GOALS = "evaluations until all goals are broken at once"


def rows(folder: Path, name: str, measure: str) -> list[dict[str, str]]:
    """Return what a table of a comparison has of a measure."""
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        found = list(csv.DictReader(file))
    if measure == ALL_GOALS:
        counts = [row["measure"][8:] for row in found if row["measure"].startswith("at_once_")]
        measure = f"at_once_{max(map(int, counts), default=0)}"
    return [row for row in found if row["measure"] == measure]


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
    for row in rows(folder, "quartiles", measure):
        low, middle, high = (number(row[key], measure) for key in ("lower", "median", "upper"))
        found[row["algorithm"]] = f"{middle} [{low}, {high}]"
    return found


def tests(folder: Path, measure: str) -> Mapping[str, str]:
    """Return, for each pair of algorithms, A12, its magnitude and Holm's p-value of a measure."""
    found = {}
    for row in rows(folder, "tests", measure):
        p = float(row["holm_p_value"])
        shown = f"{p:.3f}" if p >= 0.001 else f"{p:.1e}"
        cell = f"{float(row['a12']):.2f} {row['magnitude']}, {shown}"
        found[f"{row['first']}, {row['second']}"] = cell
    return found


def print_table(
    folders: Mapping[str, Path], cells: Callable[[Path, str], Mapping[str, str]], measure: str
) -> None:
    """Print a table in Markdown."""
    found = {name: cells(folder, measure) for name, folder in folders.items()}
    columns = dict.fromkeys(column for row in found.values() for column in row)
    lines = [["", *columns], ["---"] * (1 + len(columns))]
    lines += [[name, *(row.get(each, "–") for each in columns)] for name, row in found.items()]
    print(f"\n{measure}\n", *(f"| {' | '.join(line)} |" for line in lines), sep="\n")


def main(runs: Path) -> None:
    """Print all tables."""
    folders = {path.parent.name: path.parent for path in sorted(runs.glob("*/tests.csv"))}
    for measure in ("fitness", "hypervolume", ALL_GOALS):
        print_table(folders, quartiles, measure)
        print_table(folders, tests, measure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "runs"))
