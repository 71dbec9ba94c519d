"""A way to break a goal as people look at it: in words, and its flight in time and in space."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from mrsfi_runtime.analysis.drawing import Drawing, draw_here
from mrsfi_runtime.analysis.illustrations import Illustration
from mrsfi_runtime.analysis.page.content import flown_of
from mrsfi_runtime.analysis.report import write_figures, writing
from mrsfi_runtime.analysis.story import places_table, story_of, timeline_table
from mrsfi_runtime.analysis.weaknesses import broken_by
from mrsfi_runtime.causes.ways import Way
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.folder import CampaignFolder


class Shown(NamedTuple):
    """A way to break a goal, in words and in pictures.

    ``sentences`` say by what the goal is broken, in how many forms, who sees it, and from what on,
    if that is known; then what each of the faults did until it broke. ``figures`` are PNG of the
    flight in time and in space; each is there as SVG, too.
    """

    way: Way
    title: str
    sentences: Sequence[str]
    figures: Sequence[Path]


def look_at(
    layout: CampaignFolder, mission: Mission, pool: FaultPool, way: Way, record: Record
) -> Shown:
    """Fly a way to break a goal, and draw what is missing, or older than the campaign's record."""
    flown, sentences = flown_of(mission, pool, way, record)
    story = story_of(flown.title, mission, flown.faults, flown.recording)
    illustrations = [
        Illustration(
            f"weakness_{way.number:02d}_{what}",
            Drawing(f"flight_{what}", (story,), "mission_plots"),
            table(story),
        )
        for what, table in (("timeline", timeline_table), ("map", places_table))
    ]
    names = [each.name for each in illustrations]
    files = [layout.figures / f"{name}{kind}" for kind in (".png", ".svg") for name in names]
    recorded = layout.database.stat().st_mtime_ns
    if any(not file.exists() or file.stat().st_mtime_ns <= recorded for file in files):
        with writing(layout.path, "figures"):
            for folder in (layout.tables, layout.figures):
                folder.mkdir(exist_ok=True)
            write_figures(layout, illustrations, draw_here)()
    return Shown(way, flown.title, (broken_by(way), *sentences), files[: len(names)])
