"""Tables that ``mrsfi compare`` prints."""

from math import isinf

from rich.table import Table
from rich.text import Text

from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.study.comparison import Comparison
from mrsfi_runtime.study.run_results import MOST_OBJECTIVES


def quartile_table(comparison: Comparison) -> Table:
    """Return the quartiles of every measure, one line for each measure and algorithm."""
    table = plain_table(("measure", "algorithm"), ("lower quartile", "median", "upper quartile"))
    for criterion in comparison.criteria:
        for number, name in enumerate(comparison.algorithms):
            found = comparison.quartiles[criterion.name][name]
            table.add_row(
                Text(criterion.name if number == 0 else ""),
                Text(name),
                *(number_text(value) for value in (found.lower, found.median, found.upper)),
            )
    return table


def rank_test_table(comparison: Comparison) -> Table:
    """Return the tests of two algorithms, but for measures on which no two algorithms differ."""
    table = plain_table(("measure", "first", "second"), ("U", "p", "p (Holm)", "A12", "magnitude"))
    before = ""
    telling = {test.measure for test in comparison.tests if test.ranks.a12 != 0.5}
    for test in comparison.tests:
        if test.measure not in telling:
            continue
        table.add_row(
            Text(test.measure if test.measure != before else ""),
            Text(test.first),
            Text(test.second),
            f"{test.ranks.u:g}",
            probability(test.ranks.p_value),
            probability(test.holm_p_value),
            f"{test.ranks.a12:.3f}",
            test.ranks.magnitude,
        )
        before = test.measure
    return table


def legend(comparison: Comparison) -> list[str]:
    """Return what the names of measures mean, line by line."""
    names = [criterion.name for criterion in comparison.criteria]
    lines = ["fitness      best of a run"]
    if "hypervolume" in names:
        lines.append(
            "hypervolume  share of the possible, beyond the reference point of -1 violations"
        )
    else:
        lines.append(f"hypervolume  not computed: needs 2 to {MOST_OBJECTIVES} goals")
    if "at_once_1" in names:
        lines.append("at_once_k    evaluations until one specification broke k goals")
        lines.append("together_k   evaluations until all so far broke k goals between them")
    return lines


def number_text(value: float) -> str:
    """Return a measured number in four or more digits, and ``never`` for infinity."""
    if isinf(value):
        return "never"
    return f"{value:.6g}" if abs(value) >= 1 else f"{value:.4g}"


def probability(value: float) -> str:
    """Return a p-value in three digits."""
    return f"{value:.3f}" if value >= 0.001 else f"{value:.1e}"
