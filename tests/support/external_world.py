"""An external simulation of the small mission with planted causes, at a server.

To its other side it is somebody else's; behind the topics is our own world, or one beside it.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.support.rendezvous import NAME
from tests.support.rosbridge import process

SAME, OTHER, CHANCY = "repeat(0.0)", "repeat(1.0)", "count()"
"""How far robot b begins from its place, flight after flight: as in our own world, or in another
one that repeats itself, or in one that does not."""

_PROGRAM = """
import sys
from itertools import count, repeat
from mrsfi_runtime import api
from mrsfi_runtime.cli.main import main

initial_state, drift = api.initial_state, {}

def drifted(mission, seed):
    state = initial_state(mission, seed)
    state.robots[1].x += next(drift)
    return state

api.initial_state = drifted
sys.exit(main(sys.argv[1:]))
"""


@contextmanager
def external_world(url: str, cwd: Path, kind: str = SAME) -> Iterator[None]:
    """Serve a simulation at a server beside the body."""
    words = ("simulate", NAME, "--engine", "rosbridge", "--side", "simulation", "--url", url)
    program = (sys.executable, "-c", _PROGRAM.format(kind))
    with process(*words, cwd=cwd, program=program) as running:
        assert running.stderr is not None
        assert f"serves at {url}" in running.stderr.readline()
        yield
