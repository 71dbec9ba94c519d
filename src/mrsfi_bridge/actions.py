"""Actions: goals on their way to providers, feedback and results on their way back.

References
----------
https://github.com/RobotWebTools/rosbridge_suite/blob/ros2/ROSBRIDGE_PROTOCOL.md
"""

from collections.abc import Callable, Hashable
from typing import Any, TypeAlias

from mrsfi_bridge.errors import ProtocolError
from mrsfi_bridge.services import Services
from mrsfi_bridge.settings import ServiceType

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""How a goal ended; of ``action_msgs/GoalStatus``. Whatever else a provider says is the last."""

Answer: TypeAlias = Callable[[dict[str, Any]], None]
"""Takes what comes back of a goal: the fields of an operation, its result last."""


class Actions(Services):
    """Services that may take as long as they like, tell how far they are, and can be cancelled.

    What asks a provider is given ``None`` in place of the goal that it is to give up.
    """

    noun = "action"
    _id = "send_action_goal"

    def send_goal(
        self, caller: Hashable, name: str, type_name: str, goal: Any, answer: Answer
    ) -> str:
        """Pass a goal to its provider; as ``call``. It fails if the action is of another type."""

        def reply(is_ok: bool, told: Any) -> None:
            failed = {"values": told, "status": ABORTED, "result": False}
            answer({"op": "action_result", **(told if is_ok else failed)})

        known = self.services.get(name)
        if known is not None and type_name.replace("/action/", "/") != known.type.name:
            reply(False, f"action '{name}' is of type {known.type.name}, not {type_name:.80}")
            return ""
        return self.call(caller, name, goal, reply)

    def cancel(self, goal_id: str) -> None:
        """Ask a provider to give up a goal; its result says what came of that."""
        call = self._calls.get(goal_id)
        if call is None:
            raise ProtocolError("no such goal of yours is under way")
        self.services[call.service].ask(goal_id, None)

    def feed_back(self, owner: Hashable, goal_id: Any, values: Any) -> None:
        """Tell a caller how far a goal is.

        It is a ``ProtocolError`` if no such goal is under way, or what is told does not fit.
        """
        call = self._asked(owner, goal_id)
        if call.type.feedback is not None:
            told = call.type.feedback.convert(values)
            call.reply(True, {"op": "action_feedback", "values": told})

    def finish(
        self, owner: Hashable, goal_id: Any, values: Any, status: int, *, is_ok: bool
    ) -> None:
        """Tell a caller the result of a goal; as ``respond``.

        A goal that failed has a result, too, as with the genuine server: an empty one.
        """
        call = self._asked(owner, goal_id)
        try:
            result = call.type.response.convert(values if is_ok else {})
        except ProtocolError as error:
            reason = f"result of action {call.service}: {error}"
            self.refuse(owner, goal_id, reason)
            raise ProtocolError(reason) from error
        self._forget(goal_id)
        ended = status if is_ok and status in (SUCCEEDED, CANCELED) else ABORTED
        call.reply(True, {"values": result, "status": ended, "result": True})

    def _typed(self, type_name: str) -> ServiceType:
        return self._types.action(type_name)

    def _timer(self, _call_id: str, _timeout_s: float) -> None:
        return None
