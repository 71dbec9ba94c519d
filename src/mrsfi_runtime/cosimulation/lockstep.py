"""Flights on plain objects: the kernel's tick, between an interface and a true state.

References
----------
Source paper, section III-G and Figure 4.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

from mrsfi_runtime.cosimulation.sides import SimInterface
from mrsfi_runtime.errors import MrsfiError
from mrsfi_runtime.kernel.effects import Orders, issue
from mrsfi_runtime.kernel.flight import (
    MissionFunctions,
    Verdicts,
    hear,
    initial_state,
    no_verdicts,
    reply,
)
from mrsfi_runtime.kernel.injections import Plan
from mrsfi_runtime.kernel.state import State, SwitchState
from mrsfi_runtime.model.mission import Mission

Observer: TypeAlias = Callable[[State, State, Verdicts], None]
"""Called at the end of every tick with the true state, the belief, and the verdicts until now."""


class Flight:
    """One run: the collective intelligence takes its steps, and every tick is judged.

    ``world`` is the true state, moved by others; it is also the belief until the run begins.
    ``plan`` are the faults.
    ``sent`` is what the simulation was last told, ``verdicts`` what was counted until now, once
    per goal and tick. ``observer`` sees every tick; it must not change what it sees, which the
    next tick will.
    """

    def __init__(
        self,
        functions: MissionFunctions,
        mission: Mission,
        seed: int,
        interface: SimInterface,
        plan: Plan,
        observer: Observer | None = None,
    ) -> None:
        self.world = self.belief = initial_state(mission, seed)
        self.sent = _orders(self.belief)
        self.verdicts = no_verdicts(len(mission.goals))
        self._functions = functions
        self.plan = plan
        self._interface = interface
        self._inbox = initial_state(mission, seed)
        self._orders = _orders(self.belief)
        self._observer = observer

    def begin(self, world: State, *, tells_all: bool = False) -> None:
        """Send the commands that act from the very first motion on.

        The forged ones alone; all, to a simulation that may not know the first headings.
        """
        self.world = world
        self._interface.reset()
        issue(self.belief, self._orders, self.plan, 0)
        self._send(tells_all=tells_all)

    def step(self, tick: int) -> None:
        """Judge a tick that the simulation has flown, and let the CI answer it."""
        self.hear(tick)
        self.react()
        self.reply(tick)

    def hear(self, tick: int) -> None:
        """Judge a tick that the simulation has flown, and turn its messages into belief."""
        self._interface.read(self._inbox)
        hear(
            self._functions,
            self.world,
            self.belief,
            self._inbox,
            self.plan,
            self.verdicts,
            tick,
        )

    def react(self) -> None:
        """Let the generated goals command their members."""
        self._functions.react(self.belief)

    def reply(self, tick: int) -> None:
        """Send the commands of a tick, and count what was violated in it."""
        reply(self.world, self.belief, self._orders, self.plan, self.verdicts, tick)
        self._send()
        if self._observer is not None:
            self._observer(self.world, self.belief, self.verdicts)

    def _send(self, *, tells_all: bool = False) -> None:
        """Send what differs from what was sent before, or all."""
        orders, sent, interface = self._orders, self.sent, self._interface
        for index, order in enumerate(orders.commands):
            last = sent.commands[index]
            is_turned = order.heading_x != last.heading_x or order.heading_y != last.heading_y
            if tells_all or is_turned:
                last.heading_x, last.heading_y = order.heading_x, order.heading_y
                interface.robots[index].set_heading(order.heading_x, order.heading_y)
            if tells_all or order.speed != last.speed:
                last.speed = order.speed
                interface.robots[index].set_speed(order.speed)
        for index, switch in enumerate(orders.switches):
            if tells_all or switch.active != sent.switches[index].active:
                sent.switches[index].active = switch.active
                interface.sensors[index].set_active(switch.active == 1)


class Mind:
    """Who answers what a flight heard, with commands in its belief: the generated reactions.

    A region may think as long as it wants.
    """

    def begin(self, flight: Flight, run: int, seed: int) -> None:
        """Get ready for a flight."""

    def soon(self, function: Callable[[], None]) -> None:
        """Call a function in the thread in which answers come."""
        function()

    def answer(self, flight: Flight, tick: int, then: Callable[[], None]) -> bool:  # noqa: ARG002
        """Answer a tick; return whether that is done, or else call a function then."""
        flight.react()
        return True

    def overdue(self, silence: float) -> MrsfiError | None:  # noqa: ARG002
        """Return what is wrong after so many seconds without an answer, if anything is."""
        return None

    def end(self) -> None:
        """Leave a flight."""


def _orders(state: State) -> Orders:
    """Return the orders that a simulation obeys before anything was sent."""
    return Orders(
        [replace(command) for command in state.commands],
        [SwitchState(switch.active, 0) for switch in state.switches],
    )
