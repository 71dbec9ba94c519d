import os
import pickle
import sys
import threading

import pytest

from mrsfi_runtime.analysis.summary import Drawing, DrawingProcess, draw_here
from mrsfi_runtime.analysis.tables import GenerationFitness, Trend
from tests.support.search import paper_mission
from tests.tiers import slow

TREND = Trend((GenerationFitness(0, 10.0, 5.0, 19.0, 0.0),), 0.0, 10.0)
MAP = Drawing("mission_map", (paper_mission(),), "mission_plots")


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """The map as this process draws it, by suffix."""
    stem = tmp_path_factory.mktemp("here") / "map"
    draw_here([(MAP, stem)])()
    return files(stem)


def files(stem):
    return {suffix: stem.with_suffix(suffix).read_bytes() for suffix in (".png", ".svg")}


@slow
def test_another_process_draws_the_same_bytes(here, tmp_path):
    stems = [tmp_path / str(number) for number in range(3)]

    with DrawingProcess() as process:
        first = process.draw([(MAP, stem) for stem in stems[:2]])
        second = process.draw([(MAP, stems[2])])
        second()
        first()

    assert [files(stem) for stem in stems] == [here] * 3


class Watched:
    """The label of an axis that notes which threads pickle it."""

    def __init__(self):
        self.pickled_by = []

    def __reduce__(self):
        self.pickled_by.append(threading.get_ident())
        return str, ()


def test_what_is_drawn_is_pickled_by_who_asks_for_it_so_that_it_may_change_meanwhile(tmp_path):
    watched = Watched()

    with DrawingProcess() as process:
        process.draw([(Drawing("mean_fitness", (TREND, watched)), tmp_path / "figure")])

    assert watched.pickled_by == [threading.get_ident()]


@slow
def test_what_saving_met_is_raised_here(tmp_path):
    drawings = [(MAP, tmp_path / "missing" / "map")]

    with DrawingProcess() as process, pytest.raises(FileNotFoundError, match="missing"):
        process.draw(drawings)()


def test_what_cannot_be_drawn_anywhere_is_raised_here(tmp_path, capfd):
    with DrawingProcess() as process, pytest.raises(AttributeError, match="no_such_figure"):
        process.draw([(Drawing("no_such_figure", ()), tmp_path / "figure")])()

    assert "no_such_figure" in capfd.readouterr().err


@pytest.mark.parametrize(
    "program",
    [
        "raise SystemExit(1)",
        "import pickle, sys; sys.stdout.buffer.write(pickle.dumps({'.png': b'x' * 9999})[:99])",
        None,
    ],
)
def test_a_process_that_fails_leaves_the_drawing_to_this_one(program, here, tmp_path, monkeypatch):
    python = tmp_path / "python"
    if program is not None:
        python.write_text(f"#!{sys.executable}\n{program}\n", encoding="utf-8")
        python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))

    with DrawingProcess() as process:
        process.draw([(MAP, tmp_path / "there")])()

    assert files(tmp_path / "there") == here


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_what_nobody_waits_for_ends_with_its_block(error):
    process = DrawingProcess()

    try:
        with process:
            process._begin(MAP).result()
            if error is not None:
                raise error
    except KeyboardInterrupt:
        pass

    assert process._process.returncode is not None


def test_ctrl_c_never_reaches_it_not_even_while_it_starts():
    with DrawingProcess() as process:
        assert os.getsid(process._process.pid) != os.getsid(0)


def test_a_process_whose_answer_nobody_hears_ends_in_silence(capfd):
    with DrawingProcess() as process:
        program = process._process
        program.stdout.close()
        pickle.dump(MAP, program.stdin)
        program.stdin.flush()

        assert program.wait(60) == 0
    assert capfd.readouterr().err == ""


def test_a_process_ends_when_nobody_can_ask_it_anymore():
    with DrawingProcess() as process:
        process._process.stdin.close()

        assert process._process.wait(60) == 0
