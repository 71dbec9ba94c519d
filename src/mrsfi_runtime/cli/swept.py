"""What ``mrsfi compare --sweep`` prints."""

from collections.abc import Iterator
from dataclasses import astuple, replace
from typing import TYPE_CHECKING

from mrsfi_runtime.analysis.tables import Cell, Table
from mrsfi_runtime.cli.terminal import print_table, print_words

if TYPE_CHECKING:
    from mrsfi_runtime.study.comparison import Comparison, Sweep


def print_sweep(comparison: "Comparison", sweep: "Sweep", n_evaluations: int) -> None:
    """Print the median of each value, and which settings are better or worse than the paper's."""
    from mrsfi_runtime.study.folder import setting_table

    title = (
        f"{len(comparison.algorithms)} settings, {len(comparison.seeds)} seeds, "
        f"{n_evaluations} evaluations a run: best fitness"
    )
    columns = ("setting", "value", "n_runs", "lower", "median", "upper")
    print_table(Table(title, columns, [*_value_rows(comparison, sweep)], ("setting",)))
    table = setting_table(comparison)
    place, verdict = table.columns.index("a12"), table.columns.index("verdict")
    differ = [row for row in table.rows if row[verdict] in ("better", "worse")]
    if differ:
        rows = sorted(differ, key=lambda row: -float(row[place] or 0.0))
        print_table(replace(table, title="Settings that differ from the paper's", rows=rows))
    n_better = sum(row[verdict] == "better" for row in differ)
    said = f"{n_better} better, {len(differ) - n_better} worse" if differ else "none differs"
    n_others = len(comparison.algorithms) - 1
    print_words((f"Of {n_others} settings beside the paper's, {sweep.papers}: {said}", "bold"))


def _value_rows(comparison: "Comparison", sweep: "Sweep") -> Iterator[tuple[Cell, ...]]:
    from mrsfi_runtime.study.comparison import quartiles

    for key, values in sweep.values.items():
        for number, value in enumerate(values):
            found = comparison.with_values({key: value})
            told = astuple(quartiles(found))
            yield ("" if number else key, str(value), len(found), *told)
