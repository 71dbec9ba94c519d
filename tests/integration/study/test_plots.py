import re
from dataclasses import asdict

import pytest

from mrsfi_runtime.study import folder as study_plots
from mrsfi_runtime.study.comparison import Comparison, RunResult, Sweep, compare
from tests.support.comparisons import run_result
from tests.support.drawing import require_inside, save, texts


def run(algorithm: str, seed: int, best: float, volume: float | None = 0.2) -> RunResult:
    return run_result(
        algorithm,
        seed,
        n_evaluations=400,
        improvements=((1, best / 3), (40 * seed, best)),
        at_once=(1, 20 * seed, 300 if best > 800 else None, None),
        together=(1, 2, 3, None),
        hypervolume=volume,
    )


def compared(volume: float | None = 0.2) -> Comparison:
    names = ("guided", "paper", "random")
    return compare(
        names,
        [
            run(name, seed, 1200.0 - 300 * place + 20 * seed, volume)
            for place, name in enumerate(names)
            for seed in (1, 2, 3, 4, 5)
        ],
    )


@pytest.mark.parametrize("name", ["results", "course", "goals"])
def test_a_figure_says_what_it_shows_and_nothing_leaves_it(name, tmp_path, approved):
    figure = dict(study_plots.illustrate(compared()))[name]

    _, svg = save(figure, tmp_path / name)

    approved([text for text in texts(svg) if re.search("[a-z]{2}", text)])
    require_inside(figure)


def test_algorithms_are_named_beside_the_first_of_the_results():
    figure = dict(study_plots.illustrate(compared()))["results"]

    labels = [[label.get_text() for label in axes.get_yticklabels()] for axes in figure.axes]
    assert labels == [["guided", "paper", "random"], ["", "", ""]]


def test_each_run_is_a_dot_at_its_value_in_the_row_of_its_algorithm():
    comparison = compared()
    figure = dict(study_plots.illustrate(comparison))["results"]

    drawn = [dots.get_offsets() for dots in figure.axes[0].collections]
    clouds = [offsets for offsets in drawn if len(offsets) == len(comparison.seeds)]
    assert [offsets[:, 0].tolist() for offsets in clouds] == [
        [run.best_fitness for run in comparison.of(name)] for name in comparison.algorithms
    ]
    for row, offsets in enumerate(clouds):
        assert len({*offsets[:, 1]}) == len(comparison.seeds)
        assert abs(offsets[:, 1] - row).max() < 0.2


def test_the_course_of_a_short_search_has_a_place_for_each_evaluation():
    runs = [
        run_result(
            name, seed, n_evaluations=5, improvements=((1, 2.0), (3, 4.0 + seed)), hypervolume=None
        )
        for name in ("paper", "random")
        for seed in (1, 2, 3)
    ]

    figure = dict(study_plots.illustrate(compare(("paper", "random"), runs)))["course"]

    medians = [line.get_xydata().tolist() for line in figure.axes[0].lines]
    assert medians == [[[1, 2], [2, 2], [3, 6], [4, 6], [5, 6]]] * 2


def swept(text: str) -> Comparison:
    sweep = Sweep.parse(text)
    names = tuple(sweep.settings())
    runs = [
        run(name, seed, 900.0 + 40 * place + seed)
        for place, name in enumerate(names)
        for seed in (1, 2, 3)
    ]
    return compare(names, runs, sweep)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            "crossover=0.3:0.9:3,mutation=0.1,0.2,population=10,40",
            {
                "heat_maps": {"crossover", "population", "40", "median of best fitness"},
                "interactions": {"mutation 0.1", "population 40", "the paper's"},
            },
        ),
        (
            "crossover=0.7,mutation=0.7",
            {"heat_maps": {"902"}, "interactions": {"mutation 0.7"}},
        ),
        ("faults=5,20", {"interactions": {"median", "faults", "the paper's"}}),
    ],
)
def test_a_sweep_draws_every_two_settings(text, words, tmp_path):
    figures = dict(study_plots.illustrate(swept(text)))

    assert figures.keys() == words.keys()
    for name, figure in figures.items():
        _, svg = save(figure, tmp_path / name)
        assert words[name] <= {*texts(svg)}
        require_inside(figure)


def test_without_a_hypervolume_the_fitness_stands_alone():
    figure = study_plots.results(compared(volume=None))

    assert [axes.get_title(loc="left") for axes in figure.axes] == ["Best fitness"]


def test_where_no_run_broke_a_goal_no_goals_are_drawn():
    calm = run("paper", 1, 0.0)
    nothing = RunResult(**{**asdict(calm), "at_once": (None,), "together": (None,)})

    names = [name for name, _ in study_plots.illustrate(compare(("paper",), [nothing]))]

    assert names == ["results", "course"]
