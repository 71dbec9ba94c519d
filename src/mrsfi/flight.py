"""One flight, tick by tick, as arrays."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Part, Recorder, Recording
from mrsfi_runtime.errors import expected
from mrsfi_runtime.kernel.initial import initial_state
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import COUNTED, Outcome

Numbers: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, slots=True, repr=False)
class Flight:
    """What happened under one fault specification.

    Lengths, speeds and energies are in the model's units. What the collective intelligence believes
    is what reached it, with what faults made of that. Robots and goals stand in model order.

    Attributes
    ----------
    mission
        What flew.
    specification
        Under what.
    seed
        Mission seed.
    outcome
        What was counted, and a digest of it all.
    recording
        Every tick, as ``mrsfi_runtime.engine.recording`` lays it out: all that is below, and more.
    """

    mission: Mission
    specification: Specification
    seed: int
    outcome: Outcome
    recording: Recording

    def __repr__(self) -> str:
        counts = ", ".join(f"{goal} {ticks}" for goal, ticks in self.violations("true").items())
        return f"<Flight of {self.mission.name}, seed {self.seed}, truly violated: {counts}>"

    @property
    def robots(self) -> tuple[str, ...]:
        """IDs of the robots, the second axis of positions, speeds and energies."""
        return tuple(robot.id for robot in self.mission.robots)

    @property
    def goals(self) -> tuple[str, ...]:
        """IDs of the goals, the second axis of verdicts."""
        return self.mission.goal_ids

    @property
    def true_positions(self) -> Numbers:
        """Where robots were, shape ``(n_ticks, n_robots, 3)``."""
        return _positions(self.recording["world"])

    @property
    def believed_positions(self) -> Numbers:
        """Where they were believed to be, shape ``(n_ticks, n_robots, 3)``."""
        return _positions(self.recording["belief"])

    @property
    def true_speeds(self) -> Numbers:
        """How fast robots were, per tick, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["world"], "speed")

    @property
    def believed_speeds(self) -> Numbers:
        """How fast they were believed to be, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["belief"], "speed")

    @property
    def true_energies(self) -> Numbers:
        """Energy that was left to robots, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["world"], "energy")

    @property
    def believed_energies(self) -> Numbers:
        """Energy that was believed to be left, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["belief"], "energy")

    @property
    def truly_violated(self) -> NDArray[np.bool_]:
        """Whether goals were violated in truth, shape ``(n_ticks, n_goals)``."""
        return np.asarray(self.recording["is_true"], np.bool_)

    @property
    def believed_violated(self) -> NDArray[np.bool_]:
        """Whether they were believed to be, shape ``(n_ticks, n_goals)``."""
        return np.asarray(self.recording["is_believed"], np.bool_)

    def violations(self, kind: str = "believed") -> dict[str, int]:
        """Return at how many ticks each goal was violated, by its ID.

        Parameters
        ----------
        kind
            ``believed``, ``true``, ``phantom`` (believed, not true), ``masked`` (true, not
            believed) or ``missed`` (from when on it was certain that its purpose is not met).
        """
        if kind not in COUNTED:
            raise ValueError(f"found kind '{kind}'; {expected(kind, COUNTED)}")
        return dict(zip(self.goals, getattr(self.outcome, kind), strict=True))


def fly(engine: Engine, pool: FaultPool, specification: Specification, seed: int) -> Flight:
    """Fly once on an engine, and record every tick."""
    mission = engine.code.mission
    recorder = Recorder(initial_state(mission, seed))
    outcome = engine.evaluate(specification, seed, pool=pool, observer=recorder)
    return Flight(mission, specification, seed, outcome, recorder.recording())


def _positions(states: Part) -> Numbers:
    return np.stack([_of_robots(states, axis) for axis in "xyz"], axis=-1)


def _of_robots(states: Part, column: str) -> Numbers:
    return np.asarray(states["robots"][column], np.float64)
