"""Draw figures 6 to 12 of the paper, in the style of all figures.

Figures are plain objects, never the global state of pyplot. The same input gives the same bytes:
the files contain no dates, random identifiers or version numbers. ``rendered`` makes files of a
figure; each function after it draws one kind; the last ones are shared with ``mission_plots``.

References
----------
Source paper, section V, figures 6 to 12.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from itertools import accumulate
from operator import add
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mrsfi_runtime.analysis.fronts import Front, FrontPoint, Harm, Pick
from mrsfi_runtime.analysis.tables import Trend, TypePattern, every
from mrsfi_runtime.causes.mildest import Tried
from mrsfi_runtime.errors import counted
from mrsfi_runtime.record.store import Measure

INK, SOFT, GRID, PAPER = "#1f2933", "#66737f", "#e3e8ec", "#ffffff"
BLUE, ORANGE, GREEN, ROCK, SAND = "#1b6ca8", "#d9622b", "#2a8c6a", "#6b7681", "#a9b4bd"
BELIEVED, TRUE = ORANGE, BLUE  # those of assets/page.css
SERIES = (BLUE, ORANGE, GREEN, "#8a5aa8", "#b8902a", "#c2476f", "#3a8fb7", "#5b6b2f")
AGES = ("#b9d3e6", "#7fb0d2", "#4189b9", "#1b5e93", "#0b2f52")  # early to late generations

STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": SAND,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelsize": 11,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlepad": 12,
    "axes.titlesize": 13,
    "axes.titleweight": "bold",
    "figure.constrained_layout.h_pad": 0.12,
    "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.12,
    "figure.facecolor": PAPER,
    "font.family": ["DejaVu Sans"],
    "font.size": 10.5,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "legend.fontsize": 10,
    "legend.frameon": False,
    "path.simplify": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "mrsfi",
    "text.color": INK,
    "text.hinting": "none",  # invisible at this resolution, and takes a tenth of the time
    "text.parse_math": False,  # names may contain dollar signs
    "xtick.color": SOFT,
    "ytick.color": SOFT,
}

_CANVASES: dict[str, tuple[Any, int, Sequence[str]]] = {
    ".png": (FigureCanvasAgg, 150, ("Software",)),
    ".svg": (FigureCanvasSVG, 150, ("Date", "Creator")),
    ".pdf": (FigureCanvasPdf, 100, ("CreationDate", "Creator", "Producer")),
}
"""By suffix: the canvas that draws a figure, dots per inch, and the metadata to leave out."""

MANY_POINTS = 4000  # above this number, the cloud of an SVG is a bitmap
_MOST_GENERATIONS = 2000  # above this number, one point stands for several


def rendered(figure: Figure, suffixes: Iterable[str] = (".png", ".svg")) -> dict[str, bytes]:
    """Return the files of a figure by their suffixes, always the same bytes."""
    files = {}
    with rc_context(STYLE):  # ``savefig`` would draw twice: once for the layout
        for suffix in suffixes:
            canvas, figure.dpi, unsaid = _CANVASES[suffix]
            content = BytesIO()
            write = getattr(canvas(figure), f"print_{suffix[1:]}")
            write(content, metadata=dict.fromkeys(unsaid))
            files[suffix] = content.getvalue()
    return files


def mean_fitness(trend: Trend, label: str) -> Figure:
    """Draw mean fitness of all generations, or one in several, and its trend (figures 6, 8)."""
    with drawing((8.4, 4.8)) as figure:
        axes = _fitness_axes(figure, "Mean fitness of each generation", label)
        step = every(len(trend.generations), _MOST_GENERATIONS)
        rows = trend.generations[::step]
        xs = [row.generation for row in rows]
        means = [row.mean for row in rows]
        low = [row.mean - row.std for row in rows]
        high = [row.mean + row.std for row in rows]
        axes.fill_between(xs, low, high, color=BLUE, alpha=0.16, lw=0, label="± 1 std")
        drawn = "mean" if step == 1 else f"mean of one in {step} generations"
        axes.plot(xs, means, color=BLUE, marker="o", ms=4, lw=1.8, label=drawn)
        line = [trend.intercept + trend.slope * x for x in xs]
        words = f"trend: {trend.slope:+.3g} per generation"
        axes.plot(xs, line, color=ORANGE, ls=(0, (5, 3)), lw=1.5, label=words)
        legend_below(figure)
    return figure


def best_fitness(trend: Trend, label: str) -> Figure:
    """Draw the best fitness of each generation, or of several, and so far (figures 7, 9)."""
    with drawing((8.4, 4.8)) as figure:
        axes = _fitness_axes(figure, "Best fitness of each generation", label)
        step = every(len(trend.generations), _MOST_GENERATIONS)
        firsts = range(0, len(trend.generations), step)
        some = [trend.generations[first : first + step] for first in firsts]
        xs = [rows[0].generation for rows in some]
        best = [max(row.best for row in rows) for rows in some]
        so_far = list(accumulate(best, max))
        axes.step(xs, so_far, where="post", color=SAND, lw=1.8, label="best so far")
        drawn = "best of the generation" if step == 1 else f"best of {step} generations"
        axes.plot(xs, best, color=BLUE, marker="o", ms=4, lw=1.8, label=drawn)
        legend_below(figure)
    return figure


def generation_fronts(fronts: Mapping[int, Front]) -> Figure:
    """Draw the fronts of some generations' populations over two goals (figure 10)."""
    with drawing((7.6, 6.0)) as figure:
        front = next(iter(fronts.values()))
        axes = _goal_axes(figure, "Pareto points of some generations", front)
        for index, (generation, front) in enumerate(fronts.items()):
            colour = AGES[round(index * (len(AGES) - 1) / max(len(fronts) - 1, 1))]
            words = f"generation {generation} ({counted(len(front.points), 'points')})"
            _draw_front(axes, front, words, colour, size=48, marker="osD^v"[index % 5])
        legend_below(figure, ncols=3)
    return figure


def whole_front(
    front: Front, cloud: Sequence[tuple[float, ...]], pick: Pick | None, n_left_out: int = 0
) -> Figure:
    """Draw the front of a campaign over the cloud of all its evaluations (figure 11)."""
    with drawing((7.6, 6.0)) as figure:
        axes = _goal_axes(figure, "Non-dominated specifications of the campaign", front)
        points = sorted(set(cloud))
        label = f"evaluated ({n_left_out} points not drawn)" if n_left_out else "evaluated"
        style: dict[str, Any] = {"s": 14, "color": SAND, "alpha": 0.6, "lw": 0, "label": label}
        xs, ys = [x for x, _ in points], [y for _, y in points]
        axes.scatter(xs, ys, rasterized=len(points) > MANY_POINTS, **style)
        _draw_front(axes, front, f"non-dominated ({len(front.points)})", BLUE, size=52)
        if pick is not None and pick.point is not None:
            _draw_pick(axes, pick, pick.point)
        legend_below(figure, ncols=3)
    return figure


def harm_front(harm: Sequence[Harm], measure: Measure) -> Figure:
    """Draw the most violations, and the most violated goals, against the minimised cost."""
    with drawing((7.6, 6.0)) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
        costs = [each.cost for each in harm]
        for axes, colour, label, most in (
            (above, BLUE, f"{measure} (ticks)", [each.violations for each in harm]),
            (below, ORANGE, "goals violated", [each.n_violated for each in harm]),
        ):
            axes.step(costs, most, where="post", color=colour, lw=1.2, alpha=0.75)
            axes.scatter(costs, most, s=52, color=colour, ec=PAPER, lw=0.7, zorder=3)
            axes.set(ylabel=label, ylim=(0, max(1, *most) * 1.1))
            axes.yaxis.set_major_locator(whole_numbers())
        above.set_title(f"Most harm for each limit on {measure.minimised}")
        below.set_xlabel(f"limit on {measure.minimised} of a specification")
        below.xaxis.set_major_locator(whole_numbers())
    return figure


def fault_types(patterns: Sequence[TypePattern], title: str) -> Figure:
    """Draw how often each fault type occurs, beside its base share (figure 12)."""
    with drawing((9.4, 1.9 + 0.27 * max(len(patterns), 4))) as figure:
        axes = figure.add_subplot()
        names = [pattern.type for pattern in patterns]
        counts = [pattern.n_occurrences for pattern in patterns]
        places = range(len(names))
        keys: list[Any] = [
            axes.barh(places, counts, height=0.66, color="#6fa8d0", label="occurrences")
        ]
        for marker, colour, size, words, share in (
            ("|", ORANGE, 190, "expected from share in pool", "pool_expected"),
            ("D", INK, 20, "expected from share in campaign", "campaign_expected"),
        ):
            values = [getattr(pattern, share) for pattern in patterns]
            style: dict[str, Any] = {"marker": marker, "color": colour, "lw": 2.2, "zorder": 3}
            keys.append(axes.scatter(values, places, size, label=words, **style))
        expected = [share for p in patterns for share in (p.pool_expected, p.campaign_expected)]
        reach = max([1.0, *counts, *expected])
        across = axes.get_yaxis_transform()
        for count, place in zip(counts, places, strict=True):
            axes.text(1.01, place, str(count), transform=across, va="center", color=INK)
        axes.set(xlim=(0, reach * 1.04), xlabel="occurrences (timed faults)", title=title)
        name_rows(axes, names)
        legend_below(figure, handles=keys)
    return figure


def tried_map(title: str, tried: Sequence[Tried]) -> Figure:
    """Draw which values and windows of faults suffice to break a goal."""
    with drawing((7.2, 4.8)) as figure:
        axes = figure.add_subplot(title=title, xlabel="active ticks")
        axes.set_ylabel("deviation of values, % of their range")
        for is_broken, colour, words in ((False, SAND, "not enough"), (True, ORANGE, "enough")):
            points = [each for each in tried if each.is_broken is is_broken]
            xs, ys = [each.ticks for each in points], [100 * each.off for each in points]
            axes.scatter(xs, ys, marker="s", color=colour, label=f"{words} ({len(points)})")
        legend_below(figure)
    return figure


def found_weaknesses(
    title: str, labels: Sequence[str], goals: Mapping[str, Sequence[int]]
) -> Figure:
    """Draw how many weaknesses of each goal were found by each campaign of a mission."""
    with drawing((3.0 + 1.5 * len(labels), 4.8)) as figure:
        axes = figure.add_subplot(title=title, ylabel="weaknesses found")
        places, below = range(len(labels)), [0] * len(labels)
        for place, (goal, ns) in enumerate(goals.items()):
            axes.bar(places, ns, 0.6, below, color=SERIES[place % len(SERIES)], label=goal)
            below = [*map(add, below, ns)]
        axes.set_xticks(places, labels)
        axes.yaxis.set_major_locator(whole_numbers())
        axes.grid(visible=False, axis="x")
        legend_below(figure)
    return figure


@contextmanager
def drawing(size: tuple[float, float]) -> Iterator[Figure]:
    """Yield an empty figure in our style, and fix its layout for every file format."""
    with rc_context(STYLE):
        figure = Figure(figsize=size)
        yield figure
        layout = figure.get_layout_engine()
        assert layout is not None
        layout.execute(figure)
        figure.set_layout_engine("none")


def _fitness_axes(figure: Figure, title: str, label: str) -> Axes:
    axes = figure.add_subplot(title=title, xlabel="generation", ylabel=label)
    axes.xaxis.set_major_locator(whole_numbers())
    axes.margins(x=0.02)
    return axes


def _goal_axes(figure: Figure, title: str, front: Front) -> Axes:
    x, y = (f"{goal}: {front.counts} (ticks)" for goal in front.goals)
    axes = figure.add_subplot(title=title, xlabel=x, ylabel=y)
    axes.xaxis.set_major_locator(whole_numbers())
    axes.yaxis.set_major_locator(whole_numbers())
    return axes


def legend_below(figure: Figure, *, ncols: int = 4, **keys: Any) -> None:
    """Put the legend of a figure below its axes."""
    figure.legend(loc="outside lower left", ncols=ncols, borderpad=0.2, columnspacing=1.6, **keys)


def whole_numbers(n_ticks: int = 8) -> MaxNLocator:
    """Return a locator that marks whole numbers on an axis."""
    return MaxNLocator(n_ticks, integer=True, steps=[1, 2, 5, 10])


def name_rows(axes: Axes, names: Sequence[str]) -> None:
    """Name rows of bars, the first at the top, along an axis of whole numbers."""
    axes.set(ylim=(len(names) - 0.4, -0.6), yticks=range(len(names)), yticklabels=names)
    axes.xaxis.set_major_locator(whole_numbers())
    axes.tick_params(axis="y", length=0, labelcolor=INK)
    axes.grid(visible=False, axis="y")


def _draw_front(
    axes: Axes, front: Front, words: str, colour: str, *, size: int, marker: str = "o"
) -> None:
    xs, ys = zip(*sorted(point.violations for point in front.points), strict=True)
    border = [0, *xs, xs[-1]], [ys[0], *ys, 0]
    axes.step(*border, where="pre", color=colour, lw=1.2, alpha=0.75, zorder=2)
    style: dict[str, Any] = {"s": size, "color": colour, "marker": marker, "label": words}
    axes.scatter(xs, ys, ec=PAPER, lw=0.7, zorder=3, **style)


def _draw_pick(axes: Axes, pick: Pick, point: FrontPoint) -> None:
    ratio = pick.ratio
    parts = [ratio.parts[ratio.goals.index(goal)] for goal in pick.goals]
    x, y = point.violations
    scale = min(end / part for end, part in zip((x, y), parts, strict=True) if part)
    ends = [[0, part * scale] for part in parts]
    axes.plot(*ends, color=ORANGE, ls=(0, (5, 3)), lw=1.3, zorder=2, label=str(ratio))
    words = f"nearest to it: evaluation {point.evaluation}{pick.offered_in_words}"
    axes.scatter([x], [y], s=150, fc="none", ec=ORANGE, lw=2.2, label=words, zorder=4)
