import os
import pickle
import sys

import pytest

from mrsfi_runtime.analysis.drawing import Drawing, DrawingProcesses, draw_here
from tests.support.search import paper_mission
from tests.tiers import slow

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
@pytest.mark.turn(1)
def test_other_processes_draw_the_same_bytes(here, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    stems = [tmp_path / str(number) for number in range(12)]

    with DrawingProcesses() as processes:
        first = processes.draw([(MAP, stem) for stem in stems[:11]])
        second = processes.draw([(MAP, stems[11])])
        second()
        first()

    assert [files(stem) for stem in stems] == [here] * 12
    assert len(processes._processes) == 2


@slow
def test_few_figures_are_not_worth_a_second_process(here, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    stems = [tmp_path / str(number) for number in range(4)]

    with DrawingProcesses() as processes:
        processes.draw([(MAP, stem) for stem in stems])()

    assert [files(stem) for stem in stems] == [here] * 4
    assert len(processes._processes) == 1


@slow
def test_what_saving_met_is_raised_here(tmp_path):
    drawings = [(MAP, tmp_path / "missing" / "map")]

    with DrawingProcesses() as processes, pytest.raises(FileNotFoundError, match="missing"):
        processes.draw(drawings)()


def test_what_cannot_be_drawn_anywhere_is_raised_here(tmp_path, capfd):
    with DrawingProcesses() as processes, pytest.raises(AttributeError, match="no_such_figure"):
        processes.draw([(Drawing("no_such_figure", ()), tmp_path / "figure")])()

    assert "no_such_figure" in capfd.readouterr().err


@pytest.mark.parametrize(
    "program",
    [
        "raise SystemExit(1)",
        "import pickle, sys; sys.stdout.buffer.write(pickle.dumps({'.png': b'x' * 9999})[:99])",
        None,
    ],
)
def test_processes_that_fail_leave_the_drawing_to_this_one(program, here, tmp_path, monkeypatch):
    python = tmp_path / "python"
    if program is not None:
        python.write_text(f"#!{sys.executable}\n{program}\n", encoding="utf-8")
        python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))

    with DrawingProcesses() as processes:
        processes.draw([(MAP, tmp_path / "there")])()

    assert files(tmp_path / "there") == here


def test_nobody_waits_for_a_process_whose_begin_is_interrupted(monkeypatch):
    def interrupted():
        raise KeyboardInterrupt

    processes = DrawingProcesses(MAP)
    monkeypatch.setattr(processes, "_started", interrupted)

    with pytest.raises(KeyboardInterrupt), processes:
        pass

    assert processes._begun == []


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_what_nobody_waits_for_ends_with_its_block(error):
    processes = DrawingProcesses(MAP)

    try:
        with processes:
            processes._ready[0][1].result()
            if error is not None:
                raise error
    except KeyboardInterrupt:
        pass

    assert [process.returncode is None for process in processes._processes] == [False]


@slow
def test_what_was_drawn_ahead_is_the_same_and_drawn_once(here, tmp_path, monkeypatch):
    with DrawingProcesses(MAP) as processes:
        processes._ready[0][1].result()
        monkeypatch.setattr(processes, "_begin", None)
        processes.draw([(MAP, tmp_path / "there")])()

    assert files(tmp_path / "there") == here


def test_ctrl_c_never_reaches_them_not_even_while_they_start():
    with DrawingProcesses() as processes:
        process = processes._started()

        assert os.getsid(process.pid) != os.getsid(0)


def test_a_process_whose_answer_nobody_hears_ends_in_silence(capfd):
    with DrawingProcesses() as processes:
        process = processes._started()
        process.stdout.close()
        pickle.dump(MAP, process.stdin)
        process.stdin.flush()

        assert process.wait(60) == 0
    assert capfd.readouterr().err == ""


def test_a_process_ends_when_nobody_can_ask_it_anymore():
    with DrawingProcesses() as processes:
        process = processes._started()
        process.stdin.close()

        assert process.wait(60) == 0
