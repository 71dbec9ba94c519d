"""Draw a mission (figure 5 of the paper), and a flight in space and in time.

``mission_map`` draws the mission, ``flight_map``, ``flight_gif`` and ``flight_timeline`` a flight;
the helpers that they share follow. Style and rendering are those of ``plots``.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from textwrap import fill
from typing import Any, TypeAlias

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch, Polygon, Rectangle
from matplotlib.text import Annotation

from mrsfi_runtime.analysis import plots
from mrsfi_runtime.analysis.plots import BELIEVED, BLUE, GRID, INK, PAPER, ROCK, SERIES, SOFT, TRUE
from mrsfi_runtime.analysis.story import Story, window_around, windows, working_window
from mrsfi_runtime.files import temporary_files_writable
from mrsfi_runtime.model.fault_types import Range
from mrsfi_runtime.model.mission import Coordinates, Goal, Mission, Offsets

Place: TypeAlias = tuple[float, float]

Label: TypeAlias = tuple[str, Place, float, Mapping[str, Any]]
"""Words, the place that they name, how many points they are above it, and their style."""

_MANY_OBSTACLES = 40  # above this number, obstacles have no labels
_MANY_LABELS = 200  # above this number, the map of a mission has none
_MOST_LABELS = 12  # on the map of a flight
_WAITING, _ACTIVE = 0.15, 0.75  # opacity of the windows of faults
_N_FRAMES = 100
_TRAJECTORY: Mapping[str, Any] = {"lw": 1.4, "ls": (0, (4, 2)), "marker": ".", "ms": 7}


def mission_map(mission: Mission) -> Figure:
    """Draw the working area of a mission beside its whole mission area (figure 5)."""
    with plots.drawing((11.0, 7.4)) as figure:
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
        far.xaxis.set_major_locator(plots.whole_numbers(4))
        far.yaxis.set_major_locator(plots.whole_numbers(4))

        key = figure.add_subplot(grid[1, 1])
        key.set_axis_off()
        key.legend(handles=_map_legend(mission, colours), loc="upper left", borderaxespad=0)
    _parted(figure, shown)
    return figure


def flight_map(story: Story) -> Figure:
    """Draw true positions of robots, and believed ones at the ticks at which they differ."""
    wrong = (story.true != story.believed).any(axis=-1)
    is_many = bool(wrong.sum() > plots.MANY_POINTS)
    mission, colours = story.mission, _colours(story.mission)
    with plots.drawing((8.2, 8.6)) as figure:
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
        plots.legend_below(figure, ncols=4, handles=keys)
    _parted(figure, labels)
    return figure


def flight_gif(story: Story) -> bytes:
    """Return an animation as GIF: true positions (filled) and believed positions (rings)."""
    with plots.drawing((8.2, 8.2)) as figure:
        axes = figure.add_subplot()
        _draw_mission(axes, story.mission, _colours(story.mission))
        window, unit = window_around(story.mission, story.true), story.mission.distance_unit
        _set_window(axes, window, fill(story.title, 70), unit)
    n_ticks, colours = len(story.true), [*_colours(story.mission).values()]
    (x, y), (believed_x, believed_y) = story.true[0].T, story.believed[0].T
    ticks = np.unique(np.linspace(0, n_ticks - 1, _N_FRAMES).astype(int))
    trail = 20 * max(1, n_ticks // _N_FRAMES)  # length of a robot's trail, in ticks
    with temporary_files_writable(), TemporaryDirectory() as folder, rc_context(plots.STYLE):
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
    with plots.drawing((10.4, 1.9 + 0.36 * len(names))) as figure:
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
        plots.name_rows(axes, names)
        keys: list[Line2D | Patch] = [
            Patch(fc=INK, alpha=_ACTIVE, label="fault active"),
            Patch(fc=BELIEVED, label="violated in belief"),
            Patch(fc=TRUE, label="violated in truth"),
            _key("|", "goal fails", ms=12, mew=2.2, color=INK),
        ]
        if any(fault.trigger for fault in faults):
            keys.insert(1, Patch(fc=INK, alpha=_WAITING, label="may be triggered"))
        plots.legend_below(figure, handles=keys)
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
    for goal in _with_paths(mission):
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


def _with_paths(mission: Mission) -> list[Goal]:
    return [goal for goal in mission.goals if goal.terms.path]


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
            for _ in _with_paths(mission)[:1]
        ),
        Patch(fc=ROCK, ec=INK, label="obstacle"),
        Patch(fc="#f1f6fa", ec=BLUE, label=f"mission area, radius {radius}"),
        Patch(fill=False, ec=INK, label="working area (left)"),
    ]
