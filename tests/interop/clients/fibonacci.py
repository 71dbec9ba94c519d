"""An action server behind a rosbridge server of ROS 2, as its demo node is one: Fibonacci numbers.

Run ``python fibonacci.py URL``. One line says that it may be asked; then one JSON object a line
says of each goal its order, with which status it ended, and how often there was feedback. It ends
with the connection.
"""

import json
import sys
from dataclasses import dataclass, field
from time import monotonic
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

ACTION, TYPE = "/fibonacci", "example_interfaces/action/Fibonacci"
STEP_S = 0.5
SUCCEEDED, CANCELED = 4, 5


@dataclass(slots=True)
class Goal:
    """A goal under way; the next number is ``due`` at a moment of the monotonic clock."""

    order: int
    due: float = field(default_factory=lambda: monotonic() + STEP_S)
    sequence: list[int] = field(default_factory=lambda: [0, 1])

    def step(self) -> bool:
        """Add a number; return whether it was the last."""
        self.sequence.append(sum(self.sequence[-2:]))
        self.due += STEP_S
        return len(self.sequence) > self.order


class Fibonacci:
    """Counts for all goals at once, one step of each at its time."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._goals: dict[str, Goal] = {}

    def advertise(self) -> None:
        """Have goals come here, and return once that is so."""
        self._send("advertise_action", "advert", type=TYPE)
        self._send("call_service", "answered after it", service="/rosapi/action_servers")
        answer = json.loads(self._connection.recv(timeout=10.0))
        assert answer["values"] == {"action_servers": [ACTION]}

    def work(self) -> None:
        """Do what is due, or wait for what comes first: its time, or an operation."""
        now = monotonic()
        for goal_id, goal in tuple(self._goals.items()):
            if goal.due <= now:
                self._step(goal_id, goal)
        wait_s = min((goal.due for goal in self._goals.values()), default=now + 60.0) - now
        try:
            self._take(json.loads(self._connection.recv(timeout=max(0.0, wait_s))))
        except TimeoutError:
            return

    def _step(self, goal_id: str, goal: Goal) -> None:
        is_last = goal.step()
        self._send("action_feedback", goal_id, values={"sequence": goal.sequence})
        if is_last:
            self._end(goal_id, SUCCEEDED)

    def _take(self, operation: dict[str, Any]) -> None:
        if operation["op"] == "send_action_goal":
            self._goals[operation["id"]] = Goal(operation["args"]["order"])
        else:
            assert operation["op"] == "cancel_action_goal", operation
            self._end(operation["id"], CANCELED)

    def _end(self, goal_id: str, status: int) -> None:
        goal = self._goals.pop(goal_id)
        values = {"sequence": goal.sequence}
        self._send("action_result", goal_id, values=values, status=status, result=True)
        told = {"order": goal.order, "status": status, "n_feedback": len(goal.sequence) - 2}
        say(json.dumps(told))

    def _send(self, op: str, goal_id: str, **fields: Any) -> None:
        told = {"op": op, "id": goal_id, "action": ACTION, **fields}
        self._connection.send(json.dumps(told))


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    """Serve until the connection ends."""
    with connect(sys.argv[1]) as connection:
        server = Fibonacci(connection)
        server.advertise()
        say("advertised")
        try:
            while True:
                server.work()
        except ConnectionClosed:
            return


if __name__ == "__main__":
    main()
