from pathlib import Path
from time import monotonic

import pytest

from tests.support.cli import mrsfi, workspace
from tests.support.cluster import require_dask
from tests.support.interrupted import MISSION

EVOLVE = ("evolve", MISSION, "--engine", "reference", "--population", "8", "--seed", "3")
PATIENCE = 120.0  # seconds after which a command counts as hanging


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with models and generated code of the small mission."""
    require_dask()
    return workspace(tmp_path_factory.mktemp("place"), MISSION)


def test_an_address_where_nobody_answers_ends_with_8_soon(place):
    begin = monotonic()

    done = mrsfi(*EVOLVE, "--dask", "tcp://127.0.0.1:1", cwd=place, expected=8)

    assert "--dask tcp://127.0.0.1:1: no scheduler answers" in done.stderr.splitlines()[-1]
    assert monotonic() - begin < PATIENCE / 2


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--dask", "somewhere"), "--dask: found 'somewhere'; expected tcp://HOST:PORT"),
        (("--dask", "tcp://h:1", "--workers", "2"), "--workers 2: not possible with --dask tcp:"),
        (("--dask", "local", "--engine", "rosbridge"), "not possible with --engine rosbridge"),
    ],
)
@pytest.mark.parametrize("command", ["evolve", "compare"])
def test_options_that_make_no_sense_end_with_2_and_leave_nothing(place, command, options, expected):
    before = sorted(place.rglob("*"))

    error = mrsfi(command, MISSION, *options, cwd=place, expected=2).stderr

    assert expected in error
    assert sorted(place.rglob("*")) == before
