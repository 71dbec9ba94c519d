"""Our own simulation as somebody else's: ``python planted_world.py WHAT URL``.

It serves the small mission with planted causes in the working folder. ``WHAT`` is something that it
does wrong, or how far robot b begins from its place, flight after flight, as an expression.
"""

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain, count, repeat
from pathlib import Path
from time import sleep

sys.path[:0] = [str(Path(__file__).parents[2])]

from mrsfi_runtime import api  # noqa: E402 - it needs the path
from mrsfi_runtime.cli.main import main  # noqa: E402 - it needs the path
from mrsfi_runtime.cosimulation.bus_lockstep import SimulationHost  # noqa: E402 - it needs the path
from tests.support.rendezvous import NAME  # noqa: E402 - it needs the path
from tests.support.rosbridge import process  # noqa: E402 - it needs the path

SAME, OTHER, CHANCY = "repeat(0.0)", "repeat(1.0)", "count()"
"""Begins as in our own world, or in another one that repeats itself, or in one that does not."""

CHANCY_LATER = "chain(repeat(0.0, 4), count())"
"""Begins alike in the flights that look for repetition, and in the first of the search."""

NEARER, NEVER, SLOW = "repeat(-60.0)", "repeat(700.0)", "(sleep(0.5) or 0.0 for _ in count())"
"""Those of a world in which it has time to spare, of one in which it never gets there, and of one
that takes its time to begin anew."""

THERE = "repeat(-200.0)"
"""Begins so near that it arrives before the faults of two weaknesses begin."""

_NAMES = {"chain": chain, "count": count, "repeat": repeat, "sleep": sleep}
TICK = 40
_initial, _init = api.initial_state, SimulationHost.__init__
_fly, _reset = SimulationHost._fly, SimulationHost._on_reset


def die(_):
    """Say why, and end."""
    sys.stdout.write("lost its way\n")
    sys.stdout.flush()
    os._exit(3)


def die_once(_):
    """End in the first process only."""
    mark = Path("died")
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)


def lie(host):
    """Announce a message more than there is."""
    host._topics.n_sent += 1


MID_FLIGHT = {
    "dies": die,
    "dies once": die_once,
    "hangs": lambda _: os.kill(os.getpid(), signal.SIGSTOP),
    "lies": lie,
}
LATE = "is late in each tick that is a multiple of "


def serve(what: str, url: str) -> int:
    """Serve until ended."""
    known = {*MID_FLIGHT, "is slow"}
    drift = iter(repeat(0.0) if what in known or what.startswith(LATE) else eval(what, _NAMES))

    def begin(mission, seed):
        state = _initial(mission, seed)
        state.robots[1].x += next(drift)
        return state

    def fly(host):
        if host._topics.tick == TICK and what in MID_FLIGHT:
            MID_FLIGHT[what](host)
        _fly(host)

    def reset(host, request):
        sleep(3.0 if what == "is slow" else 0.0)
        answer = _reset(host, request)
        if answer["success"]:  # else it is asked again
            with Path("flights").open("a", encoding="ascii") as flights:
                flights.write(f"{os.getpid()}\n")
        return answer

    def initialise(host, *arguments):
        _init(host, *arguments)
        if what.startswith(LATE):
            tell, every = host._tick, int(what.removeprefix(LATE))
            host._tick = lambda told: tell(
                {"data": [*told["data"], int(told["data"][1] % every == 0)]}
            )

    SimulationHost.__init__, SimulationHost._fly, SimulationHost._on_reset = initialise, fly, reset
    api.initial_state = begin
    return main(["simulate", NAME, "--engine", "rosbridge", "--side", "simulation", "--url", url])


@contextmanager
def external_world(url: str, cwd: Path, kind: str = SAME) -> Iterator[None]:
    """Serve the simulation at a server beside the body."""
    with process(kind, url, cwd=cwd, program=(sys.executable, __file__)) as running:
        assert running.stderr is not None
        assert f"serves at {url}" in running.stderr.readline()
        yield


if __name__ == "__main__":
    sys.exit(serve(*sys.argv[1:]))
