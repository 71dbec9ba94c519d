"""The node ``standin_node`` that notes what it has received and commanded in each tick.

Each line of ``noted.jsonl`` in the working folder is a tick, in the shape of a recorded belief.
"""

import json
from dataclasses import asdict
from pathlib import Path

from tests.support import standin_node

NOTES = "noted.jsonl"
LISTS = ("robots", "sensors", "obstacles", "commands", "switches")


class NotingNode(standin_node.StandIn):
    """The stand-in; its answer to a tick ends a line."""

    def __init__(self, *arguments) -> None:
        super().__init__(*arguments)
        answer = self.answer

        def note(message) -> None:
            tick = {name: [*map(asdict, getattr(self.ci, name))] for name in LISTS}
            with Path(NOTES).open("a", encoding="ascii") as notes:
                notes.write(f"{json.dumps(tick)}\n")
            answer(message)

        self.answer = note


if __name__ == "__main__":
    standin_node.StandIn = NotingNode
    standin_node.main()
