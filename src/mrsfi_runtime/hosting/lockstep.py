"""The lock-step that joins the two sides of a mission in one process.

References
----------
Source paper, Figure 4. Its three unsynchronised threads (section V-D b) are one loop here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from mrsfi_runtime.hosting.ci_host import CiHost
from mrsfi_runtime.hosting.sides import Check, Simulation
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.kernel.tasks import progress

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


def fly(
    simulation: Simulation,
    ci: CiHost,
    checks: Sequence[Check],
    duration: int,
    observer: Observer | None = None,
) -> Violations:
    """Fly a mission to its end and count violations once per goal and tick.

    Parameters
    ----------
    simulation, ci
        The two sides, both before their first tick.
    checks
        Goal predicates, run on the true state after every tick.
    duration
        Number of ticks.
    observer
        Sees every tick; must not change what it sees.
    """
    world = simulation.world
    n_goals = len(checks)
    counts = Violations([0] * n_goals, [0] * n_goals, [0] * n_goals, [0] * n_goals)
    ci.begin()
    for tick in range(duration):
        simulation.step(tick)
        progress(world)
        true = [bool(check(world)) for check in checks]
        believed = ci.step(tick)
        if any(believed) or any(true):
            _count(counts, believed, true)
        if observer is not None:
            observer(world, ci.belief, true, believed)
    simulation.stop()
    return counts


def _count(counts: Violations, believed: Sequence[bool], true: Sequence[bool]) -> None:
    for goal, (is_believed, is_true) in enumerate(zip(believed, true, strict=True)):
        counts.believed[goal] += is_believed
        counts.true[goal] += is_true
        counts.phantom[goal] += is_believed and not is_true
        counts.masked[goal] += is_true and not is_believed
