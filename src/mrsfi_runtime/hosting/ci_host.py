"""The collective intelligence's side of a mission.

References
----------
Source paper, section III-G and Figure 4.
"""

from collections.abc import Sequence

from mrsfi_runtime.errors import ProtocolError
from mrsfi_runtime.hosting.sides import Check, Reaction, SimInterface
from mrsfi_runtime.kernel.effects import Orders, issue
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import CommandState, State, SwitchState
from mrsfi_runtime.kernel.tick import perceive
from mrsfi_runtime.model.mission import Mission


class CiHost:
    """Runs the goal functions of a mission on belief, and injects faults.

    Attributes
    ----------
    belief
        Local state of the collective intelligence.
    plan
        Faults of the run.
    sent
        What the simulation was last told.
    """

    def __init__(
        self,
        mission: Mission,
        interface: SimInterface,
        checks: Sequence[Check],
        reactions: Sequence[Reaction],
        plan: Plan,
        seed: int,
    ) -> None:
        self.belief = initial_state(mission, seed)
        self.plan = plan
        self._interface = interface
        self._checks = tuple(checks)
        self._reactions = tuple(reactions)
        self._inbox = initial_state(mission, seed)
        self._orders = _orders(self.belief)
        self.sent = _orders(self.belief)
        interface.reset()

    def begin(self, *, tells_all: bool = False) -> None:
        """Send the commands that act from the very first motion.

        Parameters
        ----------
        tells_all
            Whether to send all of them, to a simulation that may not know the first headings;
            otherwise the forged ones alone.
        """
        self._send(0, tells_all=tells_all)

    def step(self, tick: int) -> list[bool]:
        """Read the messages of a tick, check every goal, and command the robots.

        Returns
        -------
        list[bool]
            For each goal in model order, whether it is believed violated.

        Raises
        ------
        ProtocolError
            If a message of the simulation is missing or cannot be read.
        """
        belief = self.belief
        try:
            self._interface.read(self._inbox)
        except (KeyError, TypeError, ValueError) as error:
            message = f"the simulation's messages cannot be read: {type(error).__name__}: {error}"
            raise ProtocolError(message) from error
        perceive(belief, self._inbox, self.plan, tick)
        violated = [bool(check(belief)) for check in self._checks]
        for react in self._reactions:
            react(belief)
        self._send(tick + 1)
        return violated

    def _send(self, tick: int, *, tells_all: bool = False) -> None:
        """Send what differs from what was sent before, or all."""
        orders, sent, interface = self._orders, self.sent, self._interface
        issue(self.belief, orders, self.plan, tick)
        for index, order in enumerate(orders.commands):
            last = sent.commands[index]
            is_turned = order.heading_x != last.heading_x or order.heading_y != last.heading_y
            if tells_all or is_turned:
                last.heading_x, last.heading_y = order.heading_x, order.heading_y
                interface.set_heading[index](order.heading_x, order.heading_y)
            if tells_all or order.speed != last.speed:
                last.speed = order.speed
                interface.set_speed[index](order.speed)
        for index, switch in enumerate(orders.switches):
            if tells_all or switch.active != sent.switches[index].active:
                sent.switches[index].active = switch.active
                interface.set_active[index](switch.active == 1)


def _orders(state: State) -> Orders:
    """Return the orders that a simulation obeys before anything was sent."""
    return Orders(
        [
            CommandState(command.heading_x, command.heading_y, command.speed, 0, 0)
            for command in state.commands
        ],
        [SwitchState(switch.active, 0) for switch in state.switches],
    )
