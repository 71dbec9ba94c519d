"""Figures of a campaign.

Figures drawn by a process of their own, which gets ready while this one searches.

matplotlib takes as long to import, and to draw three figures, as a whole search of compiled
evaluations.

Which figures there are numbers for in a campaign, and what these numbers are.

References
----------
Source paper, section V, figures 5 to 12.
"""

import gc
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple, Self, TypeAlias

import numpy as np

from mrsfi_runtime.analysis.fronts import Columns, Front, Pick, find_front, thinned
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.tables import (
    Table,
    front_table,
    harm_table,
    map_table,
    pattern_table,
)
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure to come: the module of ``analysis`` and its function that draw it, and what from."""

    function: str
    arguments: tuple[Any, ...]
    module: str = "plots"


Drawings: TypeAlias = Sequence[tuple[Drawing, Path]]
"""Drawings with the path of each one's files, without suffix."""

FigureFiles: TypeAlias = Mapping[str, bytes]
"""What the files of a figure hold, by suffix."""

Draw: TypeAlias = Callable[[Drawings], Callable[[], None]]
"""Takes figures to be drawn and saved; what it returns waits until all are, or draws them."""


def draw_here(drawings: Drawings) -> Callable[[], None]:
    """Let figures be drawn by this process."""

    def finish() -> None:
        for drawing, stem in drawings:
            _save(drawn(drawing), stem)

    return finish


def _save(files: FigureFiles, stem: Path) -> None:
    for suffix, content in files.items():
        stem.with_suffix(suffix).write_bytes(content)


def drawn(drawing: Drawing, suffixes: Sequence[str] = (".png", ".svg")) -> FigureFiles:
    """Draw a figure in this process, for files of some suffixes."""
    from mrsfi_runtime.analysis.plots import rendered  # noqa: PLC0415 - matplotlib takes its time

    module = import_module(f"{__package__}.{drawing.module}")
    return rendered(getattr(module, drawing.function)(*drawing.arguments), suffixes)


class DrawingProcess:
    """A process that draws, first what is ``ahead``; it ends with the ``with`` block."""

    def __init__(self, *ahead: Drawing) -> None:
        self._ahead = ahead
        self._process: subprocess.Popen[bytes] | None = None
        self._thread = ThreadPoolExecutor(1)

    def __enter__(self) -> Self:
        with suppress(OSError):
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                start_new_session=True,  # Ctrl-C reaches this process only, which ends that one
            )
        self._ready = [(drawing, self._begin(drawing)) for drawing in self._ahead]
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)
        if self._process is not None:
            if error is not None:
                self._process.kill()
            self._thread.shutdown()
            with suppress(BrokenPipeError), self._process:  # closes its pipes and waits for it
                pass

    def draw(self, drawings: Drawings) -> Callable[[], None]:
        """Begin to draw; what is returned saves all figures, and waits for those that are missing.

        It raises the ``OSError`` that saving met, and draws here what the process has not drawn.
        """
        begun = [(drawing, self._found(drawing), stem) for drawing, stem in drawings]

        def finish() -> None:
            for drawing, files, stem in begun:
                _save(files.result() or drawn(drawing), stem)

        return finish

    def _found(self, drawing: Drawing) -> Future[FigureFiles | None]:
        ready = (files for known, files in self._ready if known == drawing)
        return next(ready, None) or self._begin(drawing)

    def _begin(self, drawing: Drawing) -> Future[FigureFiles | None]:
        # Pickled here: what a mission has looked up grows in this thread meanwhile.
        return self._thread.submit(self._drawn_there, pickle.dumps(drawing))

    def _drawn_there(self, drawing: bytes) -> FigureFiles | None:
        """Return a figure that the process has drawn; ``None`` if there is none, or it failed."""
        process = self._process
        with suppress(OSError, EOFError, pickle.UnpicklingError):
            if process and process.stdin and process.stdout:
                process.stdin.write(drawing)
                process.stdin.flush()
                files: FigureFiles = pickle.load(process.stdout)
                return files
        return None


def main() -> None:
    """Draw what standard input says, as long as it says anything, and answer with each figure."""
    if hasattr(os, "nice"):
        os.nice(10)  # what is searched meanwhile comes first
    gc.disable()  # it takes a tenth of the time, for the 2 MB that some figures leave
    try:
        while True:
            files = drawn(pickle.load(sys.stdin.buffer))
            pickle.dump(files, sys.stdout.buffer)
            sys.stdout.buffer.flush()
    except EOFError:
        return
    except BrokenPipeError:  # nor is anybody to be told of it when Python ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    main()


N_GENERATION_FRONTS = 5


class Illustration(NamedTuple):
    """A figure and the numbers behind it, with its caption as title, by the stem of their files."""

    name: str
    drawing: Drawing
    table: Table


def illustrate(summary: Summary, columns: Columns, store: CampaignStore) -> Iterator[Illustration]:
    """Yield the figures that a campaign has numbers for, in the order of the paper.

    A campaign on chosen goals gets figures 8 and 9 in place of 6 and 7, which differ in the
    fitness only; figures 10 and 11 show the first two goals of its front, whatever is minimised
    beside them.
    """
    table = map_table("Mission map", summary.mission)
    yield Illustration("figure_05_mission_map", map_drawing(summary.mission), table)
    if summary.trend.generations:
        yield from _fitness(summary)
    if summary.harm:
        drawing = Drawing("harm_front", (summary.harm, summary.measure))
        yield Illustration("figure_harm", drawing, harm_table(summary.harm, summary.measure))
    if summary.front is not None and summary.front.points and len(summary.front.goals) >= 2:
        yield from _fronts(summary, summary.front.goals[:2], columns, store)
    for name, found, where, patterns in (
        ("fault_types", summary.top, "most critical specifications", summary.patterns),
        ("weaknesses", summary.ways, "least sets that break a goal", summary.guilty),
    ):
        if found:
            table = pattern_table(f"Fault types in the {len(found)} {where}", patterns)
            drawing = Drawing("fault_types", (patterns, table.title))
            yield Illustration(f"figure_12_{name}", drawing, table)


def map_drawing(mission: Mission) -> Drawing:
    """Return the figure of a mission, which needs no evaluation."""
    return Drawing("mission_map", (mission,), "mission_plots")


def fitness_label(settings: CampaignSettings, measure: Measure) -> str:
    """Return what the fitness of a campaign measures, for an axis."""
    name = settings.fitness
    goals = " + ".join(settings.goals) or "the chosen goals"
    known = {
        "weighted": f"0.3 · {measure.words} + 0.7 · goals",
        "weighted_normalised": f"0.3 · {measure.words} + 0.7 · goals, as shares",
        "focused": f"{measure.words} of {goals}, ticks",
    }
    return f"fitness ({known.get(name, name)}{measure.means})"


def _fitness(summary: Summary) -> Iterator[Illustration]:
    first = 8 if summary.settings.fitness == "focused" else 6
    label = fitness_label(summary.settings, summary.measure)
    for number, (what, *spread) in enumerate((("mean", "std"), ("best",)), first):
        names = (what, *spread)
        rows = [
            (row.generation, *(getattr(row, name) for name in names))
            for row in summary.trend.generations
        ]
        title = f"{what.capitalize()} fitness of each generation"
        yield Illustration(
            f"figure_{number:02d}_{what}_fitness",
            Drawing(f"{what}_fitness", (summary.trend, label)),
            Table(title, ("generation", *names), rows),
        )


def _fronts(
    summary: Summary, goals: Sequence[str], columns: Columns, store: CampaignStore
) -> Iterator[Illustration]:
    measure = replace(summary.measure, minimised=None)
    over = f"over the {measure.words} of {' and '.join(goals)}{measure.means}"
    by_generation = _generation_fronts(measure, columns, store, goals)
    if by_generation:
        rows = [
            (generation, *row)
            for generation, front in by_generation.items()
            for row in front_table(front).rows
        ]
        title = f"Pareto points of some generations {over}"
        yield Illustration(
            "figure_10_front_by_generation",
            Drawing("generation_fronts", (by_generation,)),
            Table(title, ("generation", "evaluation", *goals), rows),
        )
    front = find_front(measure, columns, goals)
    cloud, n_left_out = thinned(columns.of(goals))
    drawn = f"; {len(cloud)} of {len(cloud) + n_left_out} points are drawn" if n_left_out else ""
    title = f"All non-dominated specifications {over}{drawn}"
    yield Illustration(
        "figure_11_front",
        Drawing("whole_front", (front, cloud, _shown_pick(summary, front), n_left_out)),
        replace(front_table(front), title=title),
    )


def _generation_fronts(
    measure: Measure, columns: Columns, store: CampaignStore, goals: Sequence[str]
) -> dict[int, Front]:
    populated = store.populated()
    evenly = np.linspace(0, len(populated) - 1, N_GENERATION_FRONTS).astype(int).tolist()
    fronts = {}
    for place in dict.fromkeys(evenly) if populated else ():
        generation = store.generation(populated[place])
        assert generation is not None
        rows = columns.distinct_among(generation.population)
        fronts[generation.index] = find_front(measure, columns, goals, rows)
    return fronts


def _shown_pick(summary: Summary, front: Front) -> Pick | None:
    pick = summary.pick
    if pick is None or pick.point is None or set(pick.ratio.goals) != set(front.goals):
        return None
    drawn = {point.evaluation: point for point in front.points}
    return Pick(pick.ratio, drawn.get(pick.point.evaluation), front.goals)
