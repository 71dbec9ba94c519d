"""The guard of the quick rooms: what a test of theirs may not do ends it, whoever catches it."""

import os
import socket
import sqlite3
import subprocess
import sys
from contextlib import suppress
from multiprocessing import get_context

import numba
import pytest
from matplotlib.figure import Figure

from tests.guard import ForbiddenError, guard

FORBIDDEN = {
    "a command": lambda: subprocess.run([sys.executable, "--version"], check=True),
    "a process": lambda: get_context("spawn").Process(target=print).start(),
    "a fork": lambda: os.fork() or os._exit(0),
    "a socket": socket.socket,
    "compilation": lambda: numba.njit(lambda x: x + 1)(1),
    "a figure": Figure,
}


@pytest.mark.parametrize("room", ["unit", "disk"])
@pytest.mark.parametrize("does", FORBIDDEN.values(), ids=FORBIDDEN)
def test_what_is_slow_or_foreign_is_refused_in_a_quick_room(room, does):
    with pytest.raises(ForbiddenError, match=f"a test of tests/{room} "), guard(room):
        does()


def test_files_are_written_in_the_room_for_them_only(tmp_path):
    with guard("disk"):
        (tmp_path / "allowed").write_text("")
        sqlite3.connect(tmp_path / "allowed.sqlite").close()

    with pytest.raises(ForbiddenError, match="writes file"), guard("unit"):
        (tmp_path / "refused").write_text("")
    with pytest.raises(ForbiddenError, match="opens database"), guard("unit"):
        sqlite3.connect(tmp_path / "refused.sqlite")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["allowed", "allowed.sqlite"]


def test_what_was_refused_and_caught_fails_all_the_same():
    with (
        pytest.raises(pytest.fail.Exception, match="opens a socket"),
        guard("unit"),
        suppress(ForbiddenError),
    ):
        socket.socket()


def test_another_room_may_do_anything():
    with guard("integration"):
        socket.socket().close()
