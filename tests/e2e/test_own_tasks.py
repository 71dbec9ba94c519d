"""A goal task of a team's own, from the command line: what is left to write is named everywhere."""

import pytest

from tests.support.cli import mrsfi
from tests.support.models.loiter import fill, write_loiter

EMPTY = "region 'near.check': is empty; expected the body of check_near"
ENGINES = ("reference", "compiled", "rosbridge")
CASE = '[search]\nalgorithm = "random"\n'


@pytest.fixture
def project(tmp_path, own_metamodels):
    write_loiter(tmp_path, own_metamodels)
    return tmp_path


def test_generate_writes_the_files_and_names_what_is_left_to_write(project):
    done = mrsfi("generate", "own_task", cwd=project, expected=4)

    path = "generated/own_task/collective_intelligence.py"
    assert (project / path).is_file()
    assert f"written    {path}\n" in done.stdout
    assert f"{path}:" in done.stderr
    assert EMPTY in done.stderr

    fill(project / "generated" / "own_task")
    mrsfi("generate", "own_task", cwd=project)
    mrsfi("validate", "own_task", cwd=project)
    flown = mrsfi("simulate", "own_task", "--no-faults", cwd=project).stdout
    assert ["near", "Loiter"] in [line.split()[:2] for line in flown.splitlines()]


def test_no_command_flies_what_is_not_written(project):
    mrsfi("generate", "own_task", cwd=project, expected=4)
    (project / "models" / "own_task" / "case_a.toml").write_text(CASE)
    engines = [("simulate", "--no-faults", "--engine", name) for name in ENGINES]

    validated = mrsfi("validate", "own_task", cwd=project, expected=6).stdout

    assert "own_task/collective_intelligence.py:" in validated
    assert f"error: {EMPTY}" in validated
    assert "near.progress" not in validated
    for command, *options in (("evolve",), *engines):
        assert EMPTY in mrsfi(command, "own_task", *options, cwd=project, expected=6).stderr
    assert not (project / "runs").exists()
