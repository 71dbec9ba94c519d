"""The topics and services of the lock-step itself; they are the same in every mission.

The collective intelligence (CI) sends ``SETUP`` before it resets the simulation, and ``GO``
after the commands that precede a tick's motion: all of them before tick 0, later those that
changed. The simulation answers with the messages of the tick, and ``TICK`` last. Both say how
many messages went before, and ``TICK`` also how many commands the simulation obeyed: a server
that keeps order within a topic only may deliver ``GO`` before the commands that it follows.
"""

from typing import NamedTuple, TypeVar

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import Payload, Service, Topic

SETUP = Topic("/mission/setup", "std_msgs/Int64MultiArray")
"""CI to simulation: the run that the next reset begins, a ``Setup``."""

GO = Topic("/mission/go", "std_msgs/Int64MultiArray")
"""CI to simulation: fly a tick, a ``Go``."""

TICK = Topic("/mission/tick", "std_msgs/Int64MultiArray")
"""Simulation to CI: a tick was flown and told, a ``Tick``."""

GO_BUNDLE = Topic("/mission/go/bundle", "std_msgs/String")
"""CI to simulation: ``GO`` and all that goes before it, in one message."""

TICK_BUNDLE = Topic("/mission/tick/bundle", "std_msgs/String")
"""Simulation to CI: ``TICK`` and all that goes before it, in one message."""

CLOCK = Topic("/clock", "rosgraph_msgs/Clock")
"""Simulation to all: one tick is one second."""

FAILURE = Topic("/mission/failure", "std_msgs/String")
"""Simulation to CI: why it cannot go on."""

RESET = Service("/mission/reset", "std_srvs/Trigger")
"""Back to before tick 0, with the newest setup; answers ``run <run>``.

A simulation of other rules of the world answers with ``REFUSAL`` first, and fails when it is
asked no more.
"""

REFUSAL = "semantics"
"""How the answer begins that no repetition changes; the simulation's version follows."""

STOP = Service("/mission/stop", "std_srvs/Trigger")
"""Ends the run."""


RUNS_OF_A_SESSION = 1_000_000
"""A run has the number session × this + its place in the session, from 1 on.

The session is drawn at random: no two collective intelligences, and no simulation that an
earlier one left behind, take each other's messages for their own.
"""


class Setup(NamedTuple):
    """Numbers of ``SETUP``."""

    run: int
    seed: int
    semantics: int


class Go(NamedTuple):
    """Numbers of ``GO``; ``n_commands`` were sent in this tick before it."""

    run: int
    tick: int
    n_commands: int


class Tick(NamedTuple):
    """Numbers of ``TICK``.

    ``n_messages`` were sent in this tick before it; ``n_commands`` were obeyed since the reset.
    """

    run: int
    tick: int
    n_messages: int
    n_commands: int


Numbers = TypeVar("Numbers", Setup, Go, Tick)


def numbers(topic: Topic, payload: Payload, kind: type[Numbers]) -> Numbers:
    """Return the numbers of a message of the lock-step.

    It is a ``ProtocolError`` if they are not as many integers as they should be.
    """
    found = payload.get("data")
    if (
        not isinstance(found, list)
        or len(found) != len(kind._fields)
        or not all(type(value) is int for value in found)
    ):
        raise ProtocolError(
            f"{topic.name} carried {found!r}; expected {len(kind._fields)} integers: "
            f"{', '.join(kind._fields)} (docs/bus.md)"
        )
    return kind(*found)
