"""A flight as a picture that moves, and its map in print."""

from dataclasses import replace
from io import BytesIO
from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation
from PIL import Image

from mrsfi_runtime.analysis.plots import flight_gif, flight_map
from mrsfi_runtime.analysis.story import story_of
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.record.observers import named_faults
from tests.integration.analysis.test_page import HOSTILE
from tests.support.world import paper_code, specifications

DOLLARS = "$\\frac{1}{$ & {}"


def story(code):
    (specification,) = specifications(code, 1)
    faults = named_faults(code.mission, code.pool, specification)
    return story_of("flown", code.mission, faults, ReferenceEngine(code, 1).record(specification))


def test_hostile_names_are_drawn_as_they_stand():
    found = story(paper_code(60))
    names = [DOLLARS, *HOSTILE]
    goals = tuple(
        replace(goal, id=text) for goal, text in zip(found.mission.goals, names, strict=False)
    )
    faults = [replace(each, name=names[k % 6]) for k, each in enumerate(found.faults)]
    hostile = replace(
        found, title=DOLLARS, mission=replace(found.mission, goals=goals), faults=faults
    )

    with Image.open(BytesIO(flight_gif(hostile))) as picture:
        assert picture.n_frames == 60


def test_a_map_has_at_most_twelve_labels_and_none_lies_on_another():
    figure = flight_map(story(paper_code(300)))

    labels = [each for each in figure.axes[0].texts if isinstance(each, Annotation)]
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [each.get_window_extent(renderer) for each in labels if each.get_visible()]
    assert 0 < len(labels) <= 12
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert {"LEN", "JEN", "KAL"} <= {each.get_text() for each in labels if each.get_visible()}
