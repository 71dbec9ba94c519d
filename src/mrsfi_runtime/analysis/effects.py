"""Effect audit: every fault of a pool alone, what it changed, and what became of each goal."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.forecast import energy_reserve, sample_reserve
from mrsfi_runtime.kernel.geometry import distance
from mrsfi_runtime.kernel.goal_tasks.avoid_collision import AvoidCollision
from mrsfi_runtime.kernel.goal_tasks.gather_samples import GatherSamples
from mrsfi_runtime.kernel.goal_tasks.sufficient_energy import SufficientEnergy
from mrsfi_runtime.kernel.goal_tasks.table import TASKS
from mrsfi_runtime.kernel.state import GoalState, State
from mrsfi_runtime.model.fault_types import Field
from mrsfi_runtime.model.faults import Fault, TimedFault
from mrsfi_runtime.model.mission import ROBOT_RADIUS, Mission, Obstacle, Robot, Sensor
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.targets import Target, touched

_AVOID_COLLISION = TASKS.index(AvoidCollision)
_SUFFICIENT_ENERGY = TASKS.index(SufficientEnergy)
_GATHER_SAMPLES = TASKS.index(GatherSamples)


@dataclass(slots=True)
class Reserves:
    """Observer of how near each kind of goal came to be believed violated.

    Attributes
    ----------
    energy
        Least believed energy beyond the forecast need, in energy units.
    samples
        Least believed forecast of samples beyond a target not yet reached.
    gap
        Least believed gap between the discs of AvoidCollision goals, in distance units.
    """

    energy: float = float("inf")
    samples: float = float("inf")
    gap: float = float("inf")

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Look at one tick."""
        del world, verdicts
        for goal in belief.goals:
            members = range(goal.first_member, goal.first_member + goal.n_members)
            if goal.task == _SUFFICIENT_ENERGY:
                for m in members:
                    reserve = energy_reserve(belief, belief.members[m].robot)
                    self.energy = min(self.energy, reserve)
            elif goal.task == _GATHER_SAMPLES and goal.count < goal.target:
                self.samples = min(self.samples, sample_reserve(belief, goal))
            elif goal.task == _AVOID_COLLISION:
                self.gap = min([self.gap, *_gaps(belief, goal)])


def _gaps(belief: State, goal: GoalState) -> Iterator[float]:
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        robot = belief.robots[belief.members[m].robot]
        for other in range(m + 1, goal.first_member + goal.n_members):
            second = belief.robots[belief.members[other].robot]
            yield distance(robot.x, robot.y, second.x, second.y) - 2.0 * ROBOT_RADIUS
        for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
            hazard = belief.obstacles[belief.hazards[h]]
            gap = distance(robot.x, robot.y, hazard.x, hazard.y)
            yield gap - hazard.radius - ROBOT_RADIUS


@dataclass(frozen=True, slots=True)
class AuditRow:
    """What one fault did alone.

    Attributes
    ----------
    fault
        The fault.
    touched
        Properties it touches, in words.
    outcome
        What the flight found; ``applied`` and ``changed`` have one entry.
    reason
        Why no goal changed; empty where one did.
    """

    fault: Fault
    touched: tuple[str, ...]
    outcome: Outcome
    reason: str = ""


def audit(engine: Engine, start: int, finish: int) -> tuple[AuditRow, ...]:
    """Fly every fault of the mission's pool alone over one window, with the pool's values.

    Parameters
    ----------
    engine
        Evaluates; its mission must fly without violations for the reasons to make sense.
    start, finish
        Window of every fault, in ticks.
    """
    mission = engine.code.mission
    rows = []
    for fault in engine.code.pool:
        reserves = Reserves()
        timed = TimedFault(fault.id, start, finish, fault.values)
        outcome = engine.evaluate((timed,), observer=reserves)
        targets = touched(mission, fault)
        has_effect = any((*outcome.believed, *outcome.true, *(outcome.missed or ())))
        reason = "" if has_effect else _reason(targets, outcome, reserves)
        words = tuple(describe(mission, target) for target in targets)
        rows.append(AuditRow(fault, words, outcome, reason))
    return tuple(rows)


def describe(mission: Mission, target: Target) -> str:
    """Return a target in words, for example ``r3 energy`` or ``s4 count``."""
    affected, index = target
    owners: Sequence[Robot | Sensor | Obstacle] = mission.robots
    if affected in (Field.COUNT, Field.RATE, Field.COST, Field.ACTIVATION):
        owners = mission.sensors
    elif affected is Field.OBSTACLE:
        owners = mission.obstacles
    return f"{owners[index].id} {affected.name.lower()}"


def _reason(targets: Sequence[Target], outcome: Outcome, reserves: Reserves) -> str:
    """Say why a fault changed no goal, from what was measured."""
    if not targets:
        return "its message does not carry the property"
    if not any(outcome.changed):
        return "the forged command is what the CI orders anyway"
    affected = {target[0] for target in targets}
    energy = {Field.SPEED, Field.ENERGY, Field.RATE, Field.COST, Field.ACTIVATION}
    reasons = (
        (energy, f"energy reserve stayed at {reserves.energy:.0f} or more"),
        (
            {Field.COUNT, Field.RATE},
            f"sample forecast stayed {reserves.samples:.0f} or more above target",
        ),
        (
            {Field.POSITION, Field.OBSTACLE},
            f"believed gap stayed at {reserves.gap:.0f} or more",
        ),
    )
    found = (words for fields, words in reasons if affected & fields)
    return "; ".join(found) or "the goals allow for it"
