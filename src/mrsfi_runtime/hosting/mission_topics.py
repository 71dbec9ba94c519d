"""The topics and services of the lock-step itself; they are the same in every mission.

The collective intelligence (CI) sends ``SETUP`` before it resets the simulation, and ``GO``
after the commands that precede a tick's motion: all of them before tick 0, later those that
changed. The simulation answers with the messages of the tick, and ``TICK`` last. Both say how
many messages went before.
"""

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.transport.topics import Payload, Service, Topic

SETUP = Topic("/mission/setup", "std_msgs/Int64MultiArray")
"""CI to simulation: ``[run, seed]`` of the run that the next reset begins."""

GO = Topic("/mission/go", "std_msgs/Int64MultiArray")
"""CI to simulation: ``[run, tick, number of commands before this message]``."""

TICK = Topic("/mission/tick", "std_msgs/Int64MultiArray")
"""Simulation to CI: ``[run, tick, number of messages before this one in the tick]``."""

GO_BUNDLE = Topic("/mission/go/bundle", "std_msgs/String")
"""CI to simulation: ``GO`` and all that goes before it, in one message."""

TICK_BUNDLE = Topic("/mission/tick/bundle", "std_msgs/String")
"""Simulation to CI: ``TICK`` and all that goes before it, in one message."""

CLOCK = Topic("/clock", "rosgraph_msgs/Clock")
"""Simulation to all: one tick is one second."""

FAILURE = Topic("/mission/failure", "std_msgs/String")
"""Simulation to CI: why it cannot go on."""

RESET = Service("/mission/reset", "std_srvs/Trigger")
"""Back to before tick 0, with the newest setup; answers ``run <run>``."""

STOP = Service("/mission/stop", "std_srvs/Trigger")
"""Ends the run."""


def numbers(topic: Topic, payload: Payload, n: int) -> list[int]:
    """Return the numbers that a message of the lock-step carries.

    Raises
    ------
    ProtocolError
        If they are not ``n`` integers.
    """
    found = payload.get("data")
    if (
        not isinstance(found, list)
        or len(found) != n
        or not all(type(value) is int for value in found)
    ):
        message = f"{topic.name} carried {found!r}; expected {n} integers"
        raise ProtocolError(message)
    return found
