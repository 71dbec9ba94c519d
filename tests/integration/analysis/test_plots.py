import re
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from matplotlib.figure import Figure

from mrsfi_runtime.analysis import plots
from mrsfi_runtime.analysis.fronts import Front, FrontPoint, Ratio
from mrsfi_runtime.analysis.tables import GenerationFitness, Trend, find_patterns
from tests.support.campaigns import random_specification
from tests.support.drawing import require_inside, save, texts
from tests.support.search import paper_mission, pool_of
from tests.tiers import slow

TREND = Trend(
    tuple(GenerationFitness(i, 10.0 * i, 5.0, 10.0 * i + 9, 0.0) for i in range(6)), 10.0, 0.0
)
FRONT = Front(("g1", "g3"), tuple(FrontPoint(i, (10 * i, 90 - i * i)) for i in range(5)))
CLOUD = [(i % 40, i % 17) for i in range(100)]
PICK = plots.Pick(Ratio(("g3", "g1"), (2.0, 1.0)), FRONT.points[4], FRONT.goals)


def types_figure() -> Figure:
    from random import Random

    top = [random_specification(Random(i)) for i in range(3)]
    return plots.fault_types(
        find_patterns(top, {"f1": 3, "f20": 1}, pool_of()),
        "Fault types in the 3 most critical specifications",
    )


FIGURES: dict[str, Callable[[], Figure]] = {
    "map": lambda: plots.mission_map(paper_mission()),
    "mean": lambda: plots.mean_fitness(TREND, "fitness (ticks)"),
    "best": lambda: plots.best_fitness(TREND, "fitness (ticks)"),
    "by_generation": lambda: plots.generation_fronts(
        {0: FRONT, 7: Front(FRONT.goals, FRONT.points[:1])}
    ),
    "front": lambda: plots.whole_front(FRONT, CLOUD, PICK),
    "types": types_figure,
    "history": lambda: plots.found_weaknesses(
        "Weaknesses of <b>$x", ["a-1\n2026-11-28\n3f2a1c9d", "a-2"], {"g1": [3, 0], "g2": [1, 2]}
    ),
}


@pytest.fixture(scope="module", params=FIGURES)
def drawn(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> "Drawn":
    """Name, figure and files of each kind of figure."""
    figure = FIGURES[request.param]()
    return request.param, figure, save(figure, tmp_path_factory.mktemp("drawn") / "figure")


Drawn = tuple[str, Figure, tuple[Path, Path]]


def test_a_figure_says_what_it_shows(drawn, approved):
    _, _, (_, svg) = drawn

    approved([text for text in texts(svg) if re.search("[a-z]{2}", text)])


def test_the_same_input_gives_the_same_bytes_without_dates(drawn, tmp_path):
    name, _, first = drawn

    second = save(FIGURES[name](), tmp_path / "second")

    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert not re.search(rb"dc:date|Matplotlib v", first[1].read_bytes())


def test_nothing_leaves_the_picture(drawn):
    _, figure, _ = drawn

    require_inside(figure)


def test_a_png_has_the_size_of_its_figure(tmp_path):
    png, _ = save(plots.best_fitness(TREND, "fitness"), tmp_path / "best")

    content = png.read_bytes()

    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", content[16:24]) == (1260, 720)


def test_a_dollar_in_a_name_is_a_dollar(tmp_path):
    waters = paper_mission()
    robot = replace(waters.robots[0], name="a$x^2$<&")

    _, svg = save(
        plots.mission_map(replace(waters, robots=(robot, *waters.robots[1:]))),
        tmp_path / "map",
    )

    assert "a$x^2$<&" in texts(svg)


def test_the_map_is_true_to_scale():
    figure = plots.mission_map(paper_mission())

    assert [axes.get_aspect() for axes in figure.axes[:2]] == [1.0, 1.0]
    near, far = figure.axes[:2]
    assert far.get_xlim() == (-2160.0, 2160.0)
    assert near.get_xlim()[0] > -700


@slow
def test_one_generation_and_one_point_can_be_drawn(tmp_path):
    trend = Trend(TREND.generations[:1], 0.0, 0.0)
    zero = Front(("g1", "g3"), (FrontPoint(0, (0, 0)),))

    for name, figure in {
        "mean": plots.mean_fitness(trend, "fitness"),
        "best": plots.best_fitness(trend, "fitness"),
        "by_generation": plots.generation_fronts({0: zero}),
        "front": plots.whole_front(zero, [(0, 0)], None),
        "types": plots.fault_types(find_patterns([()], {}, pool_of()), "Fault types in 1"),
    }.items():
        png, svg = save(figure, tmp_path / name)
        assert png.stat().st_size > 0
        assert texts(svg)


def test_a_large_cloud_stays_a_small_file(tmp_path):
    cloud = [(i % 101, i // 101) for i in range(9_000)]

    _, svg = save(plots.whole_front(FRONT, cloud, None), tmp_path / "front")

    assert svg.stat().st_size < 400_000


@pytest.mark.parametrize(
    ("draw", "label"),
    [
        (plots.mean_fitness, "mean of one in 3 generations"),
        (plots.best_fitness, "best of 3 generations"),
    ],
)
def test_of_many_generations_a_point_stands_for_several(draw, label, tmp_path):
    rows = tuple(GenerationFitness(i, i % 9, 1.0, i % 9 + 1, i % 9 - 1) for i in range(5_000))

    _, svg = save(draw(Trend(rows, 0.0, 0.0), "fitness"), tmp_path / "long")

    assert label in texts(svg)
    n_points = len(list(ET.fromstring(svg.read_bytes()).iter("{http://www.w3.org/2000/svg}use")))
    assert n_points < 2_000


def test_a_legend_says_how_many_points_are_not_drawn(tmp_path):
    _, svg = save(plots.whole_front(FRONT, CLOUD, None, 7), tmp_path / "front")

    assert "evaluated (7 points not drawn)" in texts(svg)


@pytest.mark.parametrize(
    ("violations", "expected"),
    [
        ((40, 74), ", which is 1.85:1"),
        ((0, 90), ", which is 90:0"),
        ((90, 0), ", which is 0:1"),
    ],
)
def test_a_pick_says_its_ratio(violations, expected):
    pick = plots.Pick(PICK.ratio, FrontPoint(0, violations), FRONT.goals)

    assert pick.offered_in_words == expected


def test_figures_and_pages_have_the_same_colours_for_believed_and_true():
    css = (Path(plots.__file__).parent / "assets" / "page.css").read_text("utf-8")

    assert f"--believed: {plots.BELIEVED}; --true: {plots.TRUE};" in css
