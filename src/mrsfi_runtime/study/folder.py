"""The folder of a comparison: a campaign for each run, tables, figures and a summary.

``ComparisonFolder.write`` replaces the files of an earlier comparison and keeps the runs. The
figures have the style of ``analysis/plots.py``; a sweep has other figures than a comparison of
algorithms. In tables, an empty cell means that a run never reached a number of goals.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import astuple
from itertools import combinations
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any, Self

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter

from mrsfi_runtime.analysis import plots
from mrsfi_runtime.analysis.plots import AGES, INK, PAPER, SERIES, SOFT
from mrsfi_runtime.analysis.tables import Cell, Table, as_csv
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.files import write_atomically
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.study.comparison import Comparison, Criterion, Sweep, Value, finite, quartiles

_COLUMNS = 3  # of panels; each pair of settings of a sweep has a panel


def illustrate(comparison: Comparison) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a comparison or a sweep with their names."""
    if comparison.sweep is not None:
        if len(comparison.sweep.values) > 1:
            yield "heat_maps", heat_maps(comparison, comparison.sweep)
        yield "interactions", interactions(comparison, comparison.sweep)
        return
    yield "results", results(comparison)
    yield "course", course(comparison)
    if any(criterion.name.startswith("at_once") for criterion in comparison.criteria):
        yield "goals", goals(comparison)


def results(comparison: Comparison) -> Figure:
    """Draw best fitness and hypervolume of each run, with median and quartiles."""
    titles = {"fitness": "Best fitness", "hypervolume": "Hypervolume"}
    shown = [m for m in comparison.criteria if m.name in titles]
    with plots.drawing((5.2 * len(shown), 1.7 + 0.55 * len(comparison.algorithms))) as figure:
        for number, criterion in enumerate(shown):
            axes = figure.add_subplot(1, len(shown), number + 1, title=titles[criterion.name])
            _draw_runs(axes, comparison, criterion)
            labels = [] if number else comparison.algorithms
            axes.set_yticks(range(len(comparison.algorithms)), labels=labels)
        plots.legend_below(figure, handles=axes.get_legend_handles_labels()[0][:2])
    return figure


def _draw_runs(axes: Axes, comparison: Comparison, criterion: Criterion) -> None:
    for row, name in enumerate(comparison.algorithms):
        runs = comparison.of(name)
        values = [criterion.value(run) for run in runs]
        found = comparison.quartiles[criterion.name][name]
        spread = [row + 0.3 * ((7 * number % 11) / 10 - 0.5) for number in range(len(runs))]
        axes.hlines(row, found.lower, found.upper, color=INK, lw=5, alpha=0.3, label="quartiles")
        axes.scatter([found.median], [row], marker="|", s=320, color=INK, lw=2.5, label="median")
        axes.scatter(values, spread, s=16, color=_colour(row), alpha=0.75, lw=0, zorder=3)
    axes.set_ylim(len(comparison.algorithms) - 0.4, -0.6)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0, labelcolor=INK)


def course(comparison: Comparison) -> Figure:
    """Draw the best fitness so far over the evaluations: median and quartiles of the runs."""
    n_evaluations = max(run.n_evaluations for run in comparison.runs)
    step = max(1, n_evaluations // 200)
    places = [*range(1, n_evaluations, step), n_evaluations]
    with plots.drawing((8.4, 4.8)) as figure:
        axes = figure.add_subplot(xlabel="evaluations", ylabel="best fitness so far")
        axes.set_title("Best fitness so far: median and quartiles of the runs")
        axes.xaxis.set_major_locator(plots.whole_numbers())
        axes.margins(x=0.02)
        for row, name in enumerate(comparison.algorithms):
            runs = comparison.of(name)
            found = [quartiles([run.best_after(place) for run in runs]) for place in places]
            lower, upper = [at.lower for at in found], [at.upper for at in found]
            axes.fill_between(places, lower, upper, color=_colour(row), alpha=0.16, lw=0)
            medians = [at.median for at in found]
            axes.plot(places, medians, color=_colour(row), lw=1.8, label=name)
        plots.legend_below(figure)
    return figure


def goals(comparison: Comparison) -> Figure:
    """Draw after how many evaluations one specification broke k goals, on a log scale.

    An infinite quartile stands at the upper edge, above the last evaluation.
    """
    shown = [m for m in comparison.criteria if m.name.startswith("at_once")]
    edge = 2.0 * max(run.n_evaluations for run in comparison.runs)
    with plots.drawing((8.4, 4.8)) as figure:
        axes = figure.add_subplot(
            title="Evaluations to break several goals by one specification",
            xlabel="goals broken at once",
            ylabel="evaluations (top: never)",
            yscale="log",
        )
        n_algorithms = len(comparison.algorithms)
        for row, name in enumerate(comparison.algorithms):
            shift = 0.5 * ((row + 0.5) / n_algorithms - 0.5)
            places = [number + shift for number in range(1, len(shown) + 1)]
            found = [comparison.quartiles[criterion.name][name] for criterion in shown]
            lower, medians, upper = (
                [min(getattr(at, part), edge) for at in found]
                for part in ("lower", "median", "upper")
            )
            axes.vlines(places, lower, upper, color=_colour(row), lw=4, alpha=0.3)
            drawn: dict[str, Any] = {"color": _colour(row), "label": name}
            axes.scatter(places, medians, s=40, ec=PAPER, lw=0.7, zorder=3, **drawn)
        axes.set_ylim(0.8, edge * 1.15)
        axes.xaxis.set_major_locator(plots.whole_numbers())
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        plots.legend_below(figure)
    return figure


def heat_maps(comparison: Comparison, sweep: Sweep) -> Figure:
    """Draw the median of best fitness over each pair of settings, with all values of others."""
    pairs = [*combinations(sweep.values, 2)]
    medians = {
        pair: [
            [_median(comparison, {pair[0]: x, pair[1]: y}) for x in sweep.values[pair[0]]]
            for y in sweep.values[pair[1]]
        ]
        for pair in pairs
    }
    every = [value for rows in medians.values() for row in rows for value in row]
    colours = LinearSegmentedColormap.from_list("low to high", AGES)
    scale: dict[str, Any] = {"vmin": min(every), "vmax": max(every), "cmap": colours}
    with plots.drawing(_size(len(pairs))) as figure:
        for axes, pair in zip(_panels(figure, len(pairs)), pairs, strict=True):
            drawn = axes.pcolormesh(medians[pair], edgecolors=PAPER, lw=1.5, **scale)
            for y, row in enumerate(medians[pair]):
                for x, value in enumerate(row):
                    is_dark = 2 * value > min(every) + max(every)
                    colour = PAPER if is_dark else INK
                    axes.text(x + 0.5, y + 0.5, f"{value:.5g}", ha="center", color=colour)
            for key, set_ticks in zip(pair, (axes.set_xticks, axes.set_yticks), strict=True):
                values = sweep.values[key]
                set_ticks([place + 0.5 for place in range(len(values))], labels=map(str, values))
            axes.set(xlabel=pair[0], ylabel=pair[1])
            axes.grid(visible=False)
        figure.colorbar(drawn, ax=figure.axes, label="median of best fitness")
    return figure


def interactions(comparison: Comparison, sweep: Sweep) -> Figure:
    """Draw the median of best fitness over a setting, with a line for each value of another.

    Parallel lines mean that the two do not interact. The dashed line is the paper's setup.
    """
    keys = tuple(sweep.values)
    pairs: list[tuple[str, ...]] = [*combinations(keys, 2)] or [keys]
    papers = comparison.quartiles["fitness"][sweep.papers].median
    with plots.drawing(_size(len(pairs))) as figure:
        for axes, (x, *others) in zip(_panels(figure, len(pairs)), pairs, strict=True):
            lines = [{key: value} for key in others for value in sweep.values[key]] or [{}]
            for row, fixed in enumerate(lines):
                found = [_median(comparison, {x: value, **fixed}) for value in sweep.values[x]]
                label = ", ".join(f"{key} {value}" for key, value in fixed.items())
                drawn: dict[str, Any] = {"color": _colour(row), "label": label or "median"}
                axes.plot(sweep.values[x], found, marker="o", ms=4, lw=1.6, **drawn)
            axes.axhline(papers, color=SOFT, lw=1.1, ls=(0, (5, 3)), label="the paper's")
            axes.set(xlabel=x, ylabel="median of best fitness")
            axes.set_xticks(sweep.values[x])
            axes.legend(fontsize=8.5)
    return figure


def _median(comparison: Comparison, values: Mapping[str, Value]) -> float:
    return quartiles(comparison.with_values(values)).median


def _size(n_panels: int) -> tuple[float, float]:
    return 0.8 + 4.6 * min(n_panels, _COLUMNS), 4.2 * -(-n_panels // _COLUMNS)


def _panels(figure: Figure, n_panels: int) -> Iterator[Axes]:
    shape = -(-n_panels // _COLUMNS), min(n_panels, _COLUMNS)
    for number in range(1, n_panels + 1):
        yield figure.add_subplot(*shape, number)


def _colour(row: int) -> str:
    return SERIES[row % len(SERIES)]


class ComparisonFolder(CampaignFolder):
    """Layout of the folder; lock and figures stand where a campaign has them."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.runs = path / "runs"
        self.summary = path / "comparison.json"

    @classmethod
    def reserve(cls, path: Path) -> Self:
        """Take the folder of a comparison, or make a new folder."""
        folder = cls(path)
        is_begun = folder.runs.is_dir() and folder.lock.is_file()
        return folder if is_begun else super().reserve(path)

    def run(self, algorithm: str, seed: int) -> CampaignFolder:
        """Return the folder of a run."""
        return CampaignFolder(self.runs / f"{algorithm}-{seed}")

    def write(self, comparison: Comparison, content: Mapping[str, Any]) -> None:
        """Write tables, figures and summary; earlier ones are replaced."""
        text = f"{json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)}\n"
        try:
            tables = {"runs": _runs, "quartiles": _quartiles, "tests": _tests}
            if comparison.sweep is not None:
                tables["settings"] = setting_table
            for name, table in tables.items():
                write_atomically(self.path / f"{name}.csv", as_csv(table(comparison).lines))
            self.figures.mkdir(exist_ok=True)
            for name, figure in illustrate(comparison):
                for suffix, drawn in plots.rendered(figure).items():
                    write_atomically(self.figures / f"{name}{suffix}", drawn)
            write_atomically(self.summary, text.encode())
        except OSError as error:
            raise RecordError(
                f"{self.path}: cannot be written: {error.strerror or error}; expected a folder "
                "that can be, on a disk with some room; runs that are finished stay"
            ) from error


def _runs(comparison: Comparison) -> Table:
    """Return one row for each run with all measures; a cell is empty for infinity."""
    fixed, criteria = ("algorithm", "seed", "n_evaluations", "n_failures"), comparison.criteria
    rows = (
        (*attrgetter(*fixed)(run), *(finite(each.value(run)) for each in criteria), run.digest)
        for run in comparison.runs
    )
    columns = (*fixed, *(criterion.name for criterion in criteria), "digest")
    return Table("Runs", columns, rows)


def _quartiles(comparison: Comparison) -> Table:
    rows = (
        (measure, name, len(comparison.of(name)), *map(finite, astuple(found)))
        for measure, by_algorithm in comparison.quartiles.items()
        for name, found in by_algorithm.items()
    )
    columns = ("measure", "algorithm", "n_runs", "lower", "median", "upper")
    return Table("Quartiles", columns, rows)


def _tests(comparison: Comparison) -> Table:
    names = ("measure", "first", "second", "u", "p_value", "holm_p_value", "method", "a12")
    columns = (*names, "magnitude")
    rows = [itemgetter(*columns)(test.as_json()) for test in comparison.tests]
    return Table("Tests", columns, rows)


def setting_table(comparison: Comparison) -> Table:
    """Return the setups of a sweep, each compared with the paper's by best fitness."""
    assert comparison.sweep is not None
    tests = {test.first: test for test in comparison.tests if test.measure == "fitness"}

    def row(name: str, values: Mapping[str, Value]) -> tuple[Cell, ...]:
        median = comparison.quartiles["fitness"][name].median
        cells = (*values.values(), len(comparison.of(name)), median)
        if name not in tests:
            return (*cells, None, None, None, "the paper's")
        found = tests[name]
        return (*cells, found.ranks.a12, found.holm_p_value, found.ranks.magnitude, found.verdict)

    results = ("n_runs", "median", "a12", "holm_p_value", "magnitude", "verdict")
    rows = [row(name, values) for name, values in comparison.sweep.settings().items()]
    return Table("Settings", (*comparison.sweep.values, *results), rows, ("magnitude", "verdict"))
