"""The lock-step that joins the two sides of a mission.

References
----------
Source paper, Figure 4. Its three unsynchronised threads (section V-D b) are one loop here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from mrsfi_runtime.hosting.ci_host import CiHost
from mrsfi_runtime.hosting.sides import Check, SimInterface, Simulation
from mrsfi_runtime.kernel.goal_tasks.progress import progress
from mrsfi_runtime.kernel.state import State

Observer: TypeAlias = Callable[[State, State, Sequence[bool], Sequence[bool]], None]
"""Called at the end of every tick with the true state, the belief, and for each goal whether
it is truly violated and whether it is believed so."""


@dataclass(slots=True)
class Violations:
    """Ticks at which each goal was violated, each of shape ``(n_goals,)``."""

    believed: list[int]
    true: list[int]
    phantom: list[int]
    masked: list[int]


class Flight:
    """One run: lets the collective intelligence take its steps, and judges every tick.

    Attributes
    ----------
    world
        The true state, moved by others.
    ci
        The collective intelligence's side.
    violations
        What was counted until now, once per goal and tick.

    Parameters
    ----------
    world, ci
        Both before their first tick.
    checks
        Goal predicates, run on the true state after every tick.
    observer
        Sees every tick; must not change what it sees.
    """

    def __init__(
        self,
        world: State,
        ci: CiHost,
        checks: Sequence[Check],
        observer: Observer | None = None,
    ) -> None:
        n_goals = len(checks)
        self.world = world
        self.ci = ci
        self.violations = Violations([0] * n_goals, [0] * n_goals, [0] * n_goals, [0] * n_goals)
        self._checks = tuple(checks)
        self._observer = observer

    def step(self, tick: int) -> None:
        """Judge a tick that the simulation has flown, and let the CI answer it."""
        world = self.world
        progress(world)
        true = [bool(check(world)) for check in self._checks]
        believed = self.ci.step(tick)
        if any(believed) or any(true):
            _count(self.violations, believed, true)
        if self._observer is not None:
            self._observer(world, self.ci.belief, true, believed)


Boarding: TypeAlias = Callable[[SimInterface, State], Flight]
"""Makes a flight before its first tick, of an interface and a true state that others move."""


def fly(simulation: Simulation, flight: Flight, duration: int) -> None:
    """Fly a mission to its end in one thread.

    Parameters
    ----------
    simulation
        Owns the true state of the flight; before its first tick.
    flight
        Counts violations.
    duration
        Number of ticks.
    """
    flight.ci.begin()
    for tick in range(duration):
        simulation.step(tick)
        flight.step(tick)
    simulation.stop()


def _count(counts: Violations, believed: Sequence[bool], true: Sequence[bool]) -> None:
    for goal, (is_believed, is_true) in enumerate(zip(believed, true, strict=True)):
        counts.believed[goal] += is_believed
        counts.true[goal] += is_true
        counts.phantom[goal] += is_believed and not is_true
        counts.masked[goal] += is_true and not is_believed
