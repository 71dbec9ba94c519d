"""Draw the figures of the paper, of missions and of flights, in one style.

Figures are plain objects, never the global state of pyplot. The same input gives the same bytes:
the files contain no dates, random identifiers or version numbers. ``rendered`` makes files of a
figure. Then each function draws one kind: first numbers of campaigns (figures 6 to 12); from
``mission_map`` on a mission (figure 5), and a flight in space and in time. What figures share comes
last.

References
----------
Source paper, section V, figures 5 to 12.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from itertools import accumulate, combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill
from typing import Any, TypeAlias

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import FigureCanvasPdf
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon, Rectangle
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator

from mrsfi_runtime.analysis.fronts import Front, FrontPoint, Harm, Pick
from mrsfi_runtime.analysis.story import Story, window_around, windows, working_window
from mrsfi_runtime.analysis.tables import Trend, TypePattern, every
from mrsfi_runtime.causes.mildest import Tried
from mrsfi_runtime.errors import counted
from mrsfi_runtime.files import temporary_files_writable
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Coordinates, Mission, Offsets
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
_MANY_OBSTACLES = 40  # above this number, obstacles have no labels
_MANY_LABELS = 200  # above this number, the map of a mission has none
_MOST_LABELS = 12  # on the map of a flight
_WAITING, _ACTIVE = 0.15, 0.75  # opacity of the windows of faults
_N_FRAMES = 100
_TRAJECTORY: Mapping[str, Any] = {"lw": 1.4, "ls": (0, (4, 2)), "marker": ".", "ms": 7}

Place: TypeAlias = tuple[float, float]

Label: TypeAlias = tuple[str, Place, float, Mapping[str, Any]]
"""Words, the place that they name, how many points they are above it, and their style."""


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
        means, stds = np.array([(row.mean, row.std) for row in rows]).T
        axes.fill_between(
            xs, means - stds, means + stds, color=BLUE, alpha=0.16, lw=0, label="± 1 std"
        )
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
        places, below = range(len(labels)), np.zeros(len(labels), int)
        for place, (goal, ns) in enumerate(goals.items()):
            axes.bar(places, ns, 0.6, below, color=SERIES[place % len(SERIES)], label=goal)
            below = below + ns
        axes.set_xticks(places, labels)
        axes.yaxis.set_major_locator(whole_numbers())
        axes.grid(visible=False, axis="x")
        legend_below(figure)
    return figure


def mission_map(mission: Mission) -> Figure:
    """Draw the working area of a mission beside its whole mission area (figure 5)."""
    with drawing((11.0, 7.4)) as figure:
        grid = figure.add_gridspec(2, 2, width_ratios=(2.3, 1), height_ratios=(1, 1.1))
        colours = _colours(mission)
        near = figure.add_subplot(grid[:, 0])
        labels = _draw_mission(near, mission, colours)
        shown = _labelled(near, labels if len(labels) <= _MANY_LABELS else ())
        x, y, half = working_window(mission)
        title = f"Mission {mission.name}: working area"
        _set_window(near, (x, y, half), title, mission.distance_unit)

        far = figure.add_subplot(grid[0, 1])
        _draw_mission(far, mission, colours, is_small=True)
        centre, radius = mission.area.center, mission.area.radius
        corner, width = (x - half, y - half), 2 * half
        far.add_patch(Rectangle(corner, width, width, fill=False, ec=INK, lw=1.2))
        _set_window(far, (centre.x, centre.y, radius * 1.08), "", "")
        far.set(anchor="NW", xlabel="", ylabel="")
        far.grid(visible=False)
        far.set_title("Whole mission area", fontsize=11)
        far.xaxis.set_major_locator(whole_numbers(4))
        far.yaxis.set_major_locator(whole_numbers(4))

        key = figure.add_subplot(grid[1, 1])
        key.set_axis_off()
        key.legend(handles=_map_legend(mission, colours), loc="upper left", borderaxespad=0)
    _parted(figure, shown)
    return figure


def flight_map(story: Story) -> Figure:
    """Draw true positions of robots, and believed ones at the ticks at which they differ."""
    wrong = (story.true != story.believed).any(axis=-1)
    is_many = bool(wrong.sum() > MANY_POINTS)
    mission, colours = story.mission, _colours(story.mission)
    with drawing((8.2, 8.6)) as figure:
        axes = figure.add_subplot()
        labels = _foremost(_labelled(axes, _draw_mission(axes, mission, colours)), story)
        *centre, half = window = window_around(mission, story.true)
        _set_window(axes, window, story.title, mission.distance_unit)
        is_outside = (abs(story.believed - centre) > half).any(axis=-1)
        for k, robot in enumerate(mission.robots):
            colour = colours[robot.id]
            axes.plot(*story.true[:, k].T, color=colour, lw=1.6, zorder=2.4)
            spots = story.believed[wrong[:, k], k]
            style: dict[str, Any] = {"color": colour, "alpha": 0.45, "lw": 0, "zorder": 1.8}
            axes.scatter(spots[:, 0], spots[:, 1], 5, rasterized=is_many, **style)
            x, y = story.true[-1, k]
            _draw(axes, (x, y), robot.radius, fc=colour, ec=INK, lw=0.9, zorder=2.5)
            axes.scatter([x], [y], s=42, color=colour, ec=INK, lw=0.9, zorder=3.1)
        keys: list[Line2D | Patch] = [
            Line2D([], [], color=colours[robot.id], lw=2.0, label=f"{robot.id}, true")
            for robot in mission.robots[:12]  # a longer legend would be unreadable
        ]
        keys += [
            _key(".", "believed, if wrong", color=SOFT),
            _key("^", "start", color=SOFT),
            _key("o", "end", color=SOFT, mec=INK),
        ]
        if story.collisions:
            met = np.array([story.true[each.window[0], each.robot] for each in story.collisions])
            x, y = met.T
            axes.scatter(x, y, s=60, color=INK, marker="x", lw=2, zorder=3.2)
            keys.append(_key("x", "collision", mew=2, color=INK))
        n_outside = int((wrong & is_outside).sum())
        if n_outside:
            keys.append(_key("", f"believed outside the figure: {n_outside} robot-ticks"))
        legend_below(figure, ncols=4, handles=keys)
    _parted(figure, labels)
    return figure


def flight_gif(story: Story) -> bytes:
    """Return an animation as GIF: true positions (filled) and believed positions (rings)."""
    with drawing((8.2, 8.2)) as figure:
        axes = figure.add_subplot()
        _draw_mission(axes, story.mission, _colours(story.mission))
        window, unit = window_around(story.mission, story.true), story.mission.distance_unit
        _set_window(axes, window, fill(story.title, 70), unit)
    n_ticks, colours = len(story.true), [*_colours(story.mission).values()]
    (x, y), (believed_x, believed_y) = story.true[0].T, story.believed[0].T
    ticks = np.unique(np.linspace(0, n_ticks - 1, _N_FRAMES).astype(int))
    trail = 20 * max(1, n_ticks // _N_FRAMES)  # length of a robot's trail, in ticks
    with temporary_files_writable(), TemporaryDirectory() as folder, rc_context(STYLE):
        trails = [axes.plot([], [], color=colour, lw=1.6, zorder=2.4)[0] for colour in colours]
        believed = axes.scatter(believed_x, believed_y, s=70, fc="none", ec=colours, zorder=2.6)
        true = axes.scatter(x, y, s=42, color=colours, zorder=3.1)
        sized = zip(story.mission.robots, colours, strict=True)
        discs = [Circle((0, 0), robot.radius, color=c, zorder=2.5) for robot, c in sized]
        for disc in discs:
            axes.add_patch(disc)
        caption = axes.text(0.01, 0.01, "", transform=axes.transAxes, zorder=4)
        path = Path(folder) / "flight.gif"
        FigureCanvasAgg(figure)
        writer = PillowWriter(fps=12)
        with writer.saving(figure, path, dpi=72):
            for tick in ticks.tolist():
                for k, line in enumerate(trails):
                    line.set_data(*story.true[max(0, tick - trail) : tick + 1, k].T)
                    discs[k].set_center(story.true[tick, k])
                true.set_offsets(story.true[tick])
                believed.set_offsets(story.believed[tick])
                caption.set_text(_caption(story, tick))
                writer.grab_frame()
        return path.read_bytes()


def _caption(story: Story, tick: int) -> str:
    now = [so for *so, first, last in windows(story) if first <= tick <= last]
    active = [name for kind, name, _ in now if kind == "fault"]
    broken = [name for kind, name, what in now if (kind, what) == ("goal", "truly violated")]
    parts = [f"tick {tick}"]
    parts += [f"{', '.join(active)} active"] if active else []
    parts += [f"{', '.join(broken)} truly violated"] if broken else []
    return "   ".join(parts)


def flight_timeline(story: Story) -> Figure:
    """Draw when faults were active and goals were violated, on one axis of ticks."""
    faults = [fault for fault in story.faults if fault.window or fault.trigger]
    names = [f"{fault.name} {fault.fault.type}" for fault in faults]
    names += [goal.id for goal in story.mission.goals]
    with drawing((10.4, 1.9 + 0.36 * len(names))) as figure:
        axes = figure.add_subplot()
        for row, fault in enumerate(faults):
            drawn = [(fault.timed[1:3], _WAITING)] if fault.trigger else []
            drawn += [(fault.window, _ACTIVE)] if fault.window else []
            for (first, last), alpha in drawn:
                axes.barh(row, last - first + 1, left=first, height=0.62, color=INK, alpha=alpha)
        for row, goal in enumerate(story.goals, len(faults)):
            for windows, place, colour in ((goal.believed, -0.2, BELIEVED), (goal.true, 0.2, TRUE)):
                bars = [(first, last - first + 1) for first, last in windows]
                axes.broken_barh(bars, (row + place - 0.19, 0.38), color=colour, lw=0)
            if goal.missed is not None:
                axes.plot([goal.missed] * 2, [row - 0.42, row + 0.42], color=INK, lw=2.2)
        axes.set(xlim=(0, story.mission.duration), title=story.title)
        time = story.mission.time_unit
        axes.set_xlabel(f"time ({time})" if time else "tick")
        axes.axhline(len(faults) - 0.5, color=GRID, lw=1.4)
        name_rows(axes, names)
        keys: list[Line2D | Patch] = [
            Patch(fc=INK, alpha=_ACTIVE, label="fault active"),
            Patch(fc=BELIEVED, label="violated in belief"),
            Patch(fc=TRUE, label="violated in truth"),
            _key("|", "goal fails", ms=12, mew=2.2, color=INK),
        ]
        if any(fault.trigger for fault in faults):
            keys.insert(1, Patch(fc=INK, alpha=_WAITING, label="may be triggered"))
        legend_below(figure, handles=keys)
    return figure


def _colours(mission: Mission) -> dict[str, str]:
    return {robot.id: SERIES[index % len(SERIES)] for index, robot in enumerate(mission.robots)}


def _set_window(axes: Axes, window: tuple[float, float, float], title: str, unit: str) -> None:
    x, y, half = window
    axes.set(xlim=(x - half, x + half), ylim=(y - half, y + half), aspect="equal", anchor="N")
    unit = unit or "distance units"
    axes.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=title)


def _parted(figure: Figure, labels: Sequence[Annotation]) -> None:
    """Move overlapping labels apart, up and down, in at most 60 steps; hide those that remain."""
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    points = 72.0 / figure.dpi
    for _ in range(60):
        boxes = [(label, label.get_window_extent(renderer)) for label in labels]
        pairs = (pair for pair in combinations(boxes, 2) if pair[0][1].overlaps(pair[1][1]))
        first = next(pairs, None)
        if first is None:
            return
        upper, lower = sorted(first, key=lambda each: -(each[1].y0 + each[1].y1))
        by = (lower[1].y1 - upper[1].y0) / 2 * points + 0.5
        for (label, _), shift in ((upper, by), (lower, -by)):
            x, y = label.get_position()
            label.set_position((x, y + shift))
    for one, other in combinations(labels, 2):
        near = [label.get_window_extent(renderer) for label in (one, other)]
        if one.get_visible() and near[0].overlaps(near[1]):
            other.set_visible(False)


def _foremost(labels: Sequence[Annotation], story: Story) -> list[Annotation]:
    """Keep a readable number of labels: of robots that faults affect, other robots, goals."""
    struck = story.struck
    n_robots = len(story.mission.robots)
    robots = sorted(range(n_robots), key=lambda robot: robot not in struck)
    ranked = [*(labels[robot - n_robots] for robot in robots), *labels[:-n_robots]]
    for label in ranked[_MOST_LABELS:]:
        label.remove()
    return ranked[:_MOST_LABELS]


def _draw_mission(
    axes: Axes, mission: Mission, colours: Mapping[str, str], *, is_small: bool = False
) -> list[Label]:
    """Draw areas, paths, obstacles and starts; return their labels, in this order."""
    area, labels = mission.area, list[Label]()
    _draw(axes, _of(area.center), area.radius, fc="#f1f6fa", ec=BLUE, lw=1.4, zorder=0)
    for disc in mission.goal_discs:
        colour = colours.get(disc.goal.members[0], SOFT)
        area, (x, y) = disc.area, _of(disc.area.center)
        _draw(axes, (x, y), area.radius, area.offsets, fc=colour, alpha=0.14, lw=0, zorder=1)
        _draw(axes, (x, y), area.radius, area.offsets, fc="none", ec=colour, lw=1.2, zorder=1.1)
        high = max((dy for _, dy in area.offsets), default=area.radius)
        labels.append((f"{disc.label} {disc.goal.name}", (x, y + high), 5, {"color": colour}))
    for goal in (each for each in mission.goals if each.terms.path):
        path = [_of(point) for point in goal.terms.path]
        colour = colours.get(goal.members[0], SOFT)
        axes.plot(*zip(*path, strict=True), color=colour, **_TRAJECTORY, zorder=1.5)
        for point in goal.terms.trajectory[:1]:
            labels.append((f"{goal.id} {goal.name}", _of(point), 7, {"color": colour}))
    for obstacle in mission.obstacles:
        area, (x, y) = obstacle.area, _of(obstacle.area.center)
        _draw(axes, (x, y), area.radius, area.offsets, fc=ROCK, ec=INK, lw=0.8, zorder=2)
        if len(mission.obstacles) <= _MANY_OBSTACLES:
            low = min((dy for _, dy in area.offsets), default=-area.radius)
            labels.append((obstacle.id, (x, y + low), -13, {"color": SOFT}))
    size, edge = (14, 0.2) if is_small else (95, 0.8)
    for robot in mission.robots:
        style: dict[str, Any] = {"fc": colours[robot.id], "ec": PAPER, "lw": edge, "zorder": 2.5}
        spot = _of(robot.position)
        _draw(axes, spot, robot.radius, **style)
        labels.append((robot.name or robot.id, spot, -18, {"weight": "bold", "zorder": 4}))
    xs, ys = zip(*(_of(robot.position) for robot in mission.robots), strict=True)
    style = {"marker": "^", "color": [*colours.values()], "ec": PAPER}
    axes.scatter(xs, ys, s=size, lw=edge, zorder=3, **style)
    return labels


def _labelled(axes: Axes, labels: Iterable[Label]) -> list[Annotation]:
    return [
        axes.annotate(words, spot, (0, above), textcoords="offset points", ha="center", **style)
        for words, spot, above, style in labels
    ]


def _draw(axes: Axes, spot: Place, radius: float, offsets: Offsets = (), **style: Any) -> None:
    """Draw a disc, or a polygon, without looking for limits: the window has them."""
    corners = [(spot[0] + dx, spot[1] + dy) for dx, dy in offsets]
    axes.add_artist(Polygon(corners, **style) if corners else Circle(spot, radius, **style))


def _of(point: Coordinates) -> Place:
    return point.x, point.y


def _key(marker: str, words: str, **style: Any) -> Line2D:
    return Line2D([], [], ls="none", marker=marker, label=words, **style)


def _map_legend(mission: Mission, colours: Mapping[str, str]) -> list[Line2D | Patch]:
    radius, n = mission.units.quantity(mission.area.radius, Range.X, 6), len(mission.robots)
    return [
        *(
            _key("^", f"start of {each.name or each.id} ({each.id})", ms=9, color=colours[each.id])
            for each in mission.robots[: n if n <= _MANY_OBSTACLES else _MOST_LABELS]
        ),
        *[_key("^", f"starts of {n} robots in all", ms=9, color=SOFT)][: n > _MANY_OBSTACLES],
        Patch(fc="#e4e9ed", ec=SOFT, label="goal area, in its robot's colour"),
        *(
            Line2D([], [], color=SOFT, label="trajectory or route of a goal", **_TRAJECTORY)
            for _ in [goal for goal in mission.goals if goal.terms.path][:1]
        ),
        Patch(fc=ROCK, ec=INK, label="obstacle"),
        Patch(fc="#f1f6fa", ec=BLUE, label=f"mission area, radius {radius}"),
        Patch(fill=False, ec=INK, label="working area (left)"),
    ]


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
