"""Seeds are spread over make test, make test-all and the night; quick rooms start nothing."""

import os
import socket
import subprocess
from contextlib import suppress
from multiprocessing import get_context

import pytest

from tests.tiers import night, seeds, slow


def test_first_seeds_are_plain_the_next_slow_and_all_others_of_the_night():
    assert seeds("abcd", 1, 2) == [
        "a",
        pytest.param("b", marks=slow),
        pytest.param("c", marks=slow),
        pytest.param("d", marks=night),
    ]


@pytest.mark.parametrize(
    "forbidden",
    [
        lambda: subprocess.run(["true"], check=True),
        lambda: get_context("spawn").Process(target=print).start(),
        lambda: os.fork() or os._exit(0),
        socket.socket,
    ],
)
def test_a_process_and_a_socket_fail_a_test_here_also_where_errors_are_caught(forbidden):
    with pytest.raises(pytest.fail.Exception, match="a test of tests/unit "), suppress(Exception):
        forbidden()
