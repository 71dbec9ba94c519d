"""A way to break a goal as people look at it: in words, and its flight in time and in space."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from mrsfi_runtime.analysis.drawing import Drawing, draw_here
from mrsfi_runtime.analysis.page.content import Record, flown_of
from mrsfi_runtime.analysis.report import Illustration, to_draw, write_rows, writing
from mrsfi_runtime.analysis.story import Story, places_table, story_of, timeline_table
from mrsfi_runtime.analysis.weaknesses import broken_by
from mrsfi_runtime.causes.ways import Way
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.folder import CampaignFolder


@dataclass(frozen=True, slots=True)
class Shown:
    """A way to break a goal, in words and in pictures.

    Attributes
    ----------
    title
        The goal.
    sentences
        By what it is broken, in how many forms, who sees it, and from what on, if that is known;
        then what each of the faults did until it broke.
    figures
        Pictures of the flight in time and in space; each is an SVG as well, by the same name.
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
    illustrations = [*_illustrated(way.number, story)]
    drawings = to_draw(layout, illustrations)
    files = [stem.with_suffix(suffix) for suffix in (".png", ".svg") for _, stem in drawings]
    recorded = layout.database.stat().st_mtime_ns
    if any(not file.exists() or file.stat().st_mtime_ns <= recorded for file in files):
        with writing(layout.path, "figures"):
            for folder in (layout.tables, layout.figures):
                folder.mkdir(exist_ok=True)
            write_rows(layout.tables, illustrations)
            draw_here(drawings)()
    return Shown(way, flown.title, (broken_by(way), *sentences), files[: len(drawings)])


def _illustrated(number: int, story: Story) -> Iterator[Illustration]:
    """Yield the figures of a flight that breaks a goal."""
    for what, caption, function, table in (
        ("timeline", "faults, and violations of goals, in time", "flight_timeline", timeline_table),
        ("map", "where robots were, and were believed to be", "flight_map", places_table),
    ):
        drawing = Drawing(function, (story,), "mission_plots")
        name = f"weakness_{number:02d}_{what}"
        yield Illustration(name, f"{story.title}: {caption}", drawing, table(story))
