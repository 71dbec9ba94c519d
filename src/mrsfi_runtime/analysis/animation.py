"""A flight as an animated GIF, for a pull request or slides: one round of some seconds."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import PillowWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg

from mrsfi_runtime.analysis.mission_plots import mission_axes
from mrsfi_runtime.analysis.plots import SERIES, STYLE
from mrsfi_runtime.analysis.story import Story, windows

_N_FRAMES = 100
_PER_SECOND = 12
_DPI = 72
_TRAIL = 20  # frames of a robot's way that are seen behind it


def flight_gif(story: Story) -> bytes:
    """Return where robots were (filled) and were believed to be (rings), as a GIF."""
    figure, axes = mission_axes(story)
    n_ticks, n_robots, _ = story.true.shape
    colours = [SERIES[k % len(SERIES)] for k in range(n_robots)]
    (x, y), (believed_x, believed_y) = story.true[0].T, story.believed[0].T
    ticks = np.unique(np.linspace(0, n_ticks - 1, _N_FRAMES).astype(int))
    trail = _TRAIL * max(1, n_ticks // _N_FRAMES)
    with TemporaryDirectory() as folder, rc_context(STYLE):
        trails = [axes.plot([], [], color=colour, lw=1.6, zorder=2.4)[0] for colour in colours]
        believed = axes.scatter(believed_x, believed_y, s=70, fc="none", ec=colours, zorder=2.6)
        true = axes.scatter(x, y, s=42, color=colours, zorder=3.1)
        told = axes.text(0.01, 0.01, "", transform=axes.transAxes, zorder=4)
        path = Path(folder) / "flight.gif"
        FigureCanvasAgg(figure)
        writer = PillowWriter(fps=_PER_SECOND)
        with writer.saving(figure, path, _DPI):
            for tick in ticks.tolist():
                for k, line in enumerate(trails):
                    line.set_data(*story.true[max(0, tick - trail) : tick + 1, k].T)
                true.set_offsets(story.true[tick])
                believed.set_offsets(story.believed[tick])
                told.set_text(_said(story, tick))
                writer.grab_frame()
        return path.read_bytes()


def _said(story: Story, tick: int) -> str:
    """Return what is so at a tick: faults at work, and goals that are violated."""
    now = [so for *so, first, last in windows(story) if first <= tick <= last]
    active = [name for kind, name, _ in now if kind == "fault"]
    broken = [name for kind, name, what in now if (kind, what) == ("goal", "truly violated")]
    parts = [f"tick {tick}"]
    parts += [f"{', '.join(active)} at work"] if active else []
    parts += [f"{', '.join(broken)} truly violated"] if broken else []
    return "   ".join(parts)
