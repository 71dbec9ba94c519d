import os

import pytest

from mrsfi_runtime.analysis.drawing_process import Drawing, DrawingProcess, draw_here
from tests.support.search import paper_mission
from tests.tiers import slow


@slow
def test_another_process_draws_the_same_bytes(tmp_path):
    drawing = Drawing("mission_map", (paper_mission(),), "mission_plots")
    draw_here([(drawing, tmp_path / "here")])()

    with DrawingProcess() as drawing_process:
        drawing_process.draw([(drawing, tmp_path / "there")])()

    for suffix in (".png", ".svg"):
        here, there = (tmp_path / f"{name}{suffix}" for name in ("here", "there"))
        assert here.read_bytes() == there.read_bytes()


@slow
def test_what_saving_met_is_raised_here(tmp_path):
    drawings = [
        (Drawing("mission_map", (paper_mission(),), "mission_plots"), tmp_path / "missing" / "map")
    ]

    with DrawingProcess() as drawing_process, pytest.raises(FileNotFoundError, match="missing"):
        drawing_process.draw(drawings)()


def test_what_cannot_be_drawn_anywhere_is_raised_here(tmp_path, capfd):
    with DrawingProcess() as drawing_process, pytest.raises(AttributeError, match="no_such_figure"):
        drawing_process.draw([(Drawing("no_such_figure", ()), tmp_path / "figure")])()

    assert "no_such_figure" in capfd.readouterr().err


def test_a_studio_that_is_killed_leaves_the_drawing_to_this_process(tmp_path):
    drawing = Drawing("mission_map", (paper_mission(),), "mission_plots")
    draw_here([(drawing, tmp_path / "here")])()

    with DrawingProcess() as drawing_process:
        drawing_process._process.kill()
        drawing_process._process.wait()
        drawing_process.draw([(drawing, tmp_path / "there")])()

    assert (tmp_path / "there.svg").read_bytes() == (tmp_path / "here.svg").read_bytes()


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_a_studio_that_never_draws_ends_with_its_block(error):
    drawing_process = DrawingProcess()

    try:
        with drawing_process:
            if error is not None:
                raise error
    except KeyboardInterrupt:
        pass

    assert drawing_process._process.returncode is not None


@slow
def test_what_was_drawn_ahead_is_the_same(tmp_path):
    drawing = Drawing("mission_map", (paper_mission(),), "mission_plots")
    draw_here([(drawing, tmp_path / "here")])()

    with DrawingProcess(drawing) as drawing_process:
        drawing_process.draw([(drawing, tmp_path / "there")])()

    assert (tmp_path / "there.svg").read_bytes() == (tmp_path / "here.svg").read_bytes()


def test_ctrl_c_never_reaches_it_not_even_while_it_starts():
    with DrawingProcess() as drawing:
        assert os.getsid(drawing._process.pid) != os.getsid(0)
