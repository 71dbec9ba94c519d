"""Draws comparisons of searches, in the style of ``plots``."""

from collections.abc import Iterator

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter

from mrsfi_runtime.analysis.plots import INK, PAPER, SERIES, drawing, legend_below, whole_numbers
from mrsfi_runtime.study.comparison import Comparison, Criterion, quartiles

_N_PLACES = 200  # at which the course of a search is drawn


def illustrate(comparison: Comparison) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a comparison with their names."""
    yield "results", results(comparison)
    yield "course", course(comparison)
    if any(criterion.name.startswith("at_once") for criterion in comparison.criteria):
        yield "goals", goals(comparison)


def results(comparison: Comparison) -> Figure:
    """Draw every run's best fitness and hypervolume, with median and quartiles."""
    titles = {"fitness": "Best fitness", "hypervolume": "Hypervolume"}
    shown = [m for m in comparison.criteria if m.name in titles]
    with drawing((5.2 * len(shown), 1.7 + 0.55 * len(comparison.algorithms))) as figure:
        for number, criterion in enumerate(shown):
            axes = figure.add_subplot(1, len(shown), number + 1, title=titles[criterion.name])
            _draw_runs(axes, comparison, criterion)
            axes.set_yticks(
                range(len(comparison.algorithms)),
                labels=comparison.algorithms if not number else [],
            )
        legend_below(figure, handles=axes.get_legend_handles_labels()[0][:2])
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
    step = max(1, n_evaluations // _N_PLACES)
    places = [*range(1, n_evaluations, step), n_evaluations]
    with drawing((8.4, 4.8)) as figure:
        axes = figure.add_subplot(xlabel="evaluations", ylabel="best fitness so far")
        axes.set_title("Best fitness so far: median and quartiles of the runs")
        axes.xaxis.set_major_locator(whole_numbers())
        axes.margins(x=0.02)
        for row, name in enumerate(comparison.algorithms):
            runs = comparison.of(name)
            found = [quartiles([run.best_after(place) for run in runs]) for place in places]
            lower, upper = [at.lower for at in found], [at.upper for at in found]
            axes.fill_between(places, lower, upper, color=_colour(row), alpha=0.16, lw=0)
            medians = [at.median for at in found]
            axes.plot(places, medians, color=_colour(row), lw=1.8, label=name)
        legend_below(figure)
    return figure


def goals(comparison: Comparison) -> Figure:
    """Draw how many evaluations it took to break k goals by one specification, on a log scale.

    A quartile that was never reached stands at the upper edge, above the last evaluation.
    """
    shown = [m for m in comparison.criteria if m.name.startswith("at_once")]
    edge = 2.0 * max(run.n_evaluations for run in comparison.runs)
    with drawing((8.4, 4.8)) as figure:
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
            axes.scatter(
                places, medians, s=40, color=_colour(row), ec=PAPER, lw=0.7, label=name, zorder=3
            )
        axes.set_ylim(0.8, edge * 1.15)
        axes.xaxis.set_major_locator(whole_numbers())
        axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        legend_below(figure)
    return figure


def _colour(row: int) -> str:
    return SERIES[row % len(SERIES)]
