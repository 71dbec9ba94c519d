"""One flight, tick by tick, as arrays.

``fly`` records a flight; ``Flight`` gives the recording as arrays, frames of pandas and pictures.
All arrays begin with the axis of ticks; robots and goals stand in model order.
"""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mrsfi_runtime.analysis.story import Story, story_of
from mrsfi_runtime.analysis.tables import Table, goal_table, to_html
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Part, Recorder, Recording
from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.kernel.flight import initial_state
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import COUNTED, Mission, Outcome
from mrsfi_runtime.record.observers import named_faults

if TYPE_CHECKING:
    from pandas import DataFrame

    from mrsfi_runtime.kernel.injections import FaultTally

Numbers: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, slots=True, repr=False)
class Flight:
    """One flight with one fault specification.

    Lengths, speeds and energies are in the model's units. The collective intelligence believes what
    it received, as changed by faults. Robots and goals are in model order.

    Attributes
    ----------
    mission
        The mission that was flown.
    specification, pool
        The timed faults, and the pool that they are from.
    seed
        Mission seed.
    outcome
        The counted violations, and a digest of the flight.
    recording
        Every tick, as ``mrsfi_runtime.engine.recording`` lays it out: all that is below, and more.
    """

    mission: Mission
    specification: Specification
    pool: FaultPool
    seed: int
    outcome: Outcome
    recording: Recording

    def __repr__(self) -> str:
        counts = ", ".join(f"{goal} {ticks}" for goal, ticks in self.violations("true").items())
        return f"<Flight of {self.mission.name}, seed {self.seed}, truly violated: {counts}>"

    def _repr_html_(self) -> str:
        title = f"{self.mission.name}, mission seed {self.seed}"
        title += f", under {len(self.specification)} faults"
        return to_html(goal_table(title, self.mission, self.outcome))

    def to_frame(self) -> "DataFrame":
        """Return a pandas frame: a row for each tick and robot, with true and believed values."""
        ticks = np.arange(len(self.true_speeds))
        columns = {"tick": np.repeat(ticks, len(self.robots))}
        columns["robot"] = np.tile(np.array(self.robots, object), len(ticks))
        for side in ("true", "believed"):
            places = getattr(self, f"{side}_positions")
            columns |= {f"{side}_{axis}": places[..., k].ravel() for k, axis in enumerate("xyz")}
            for name, plural in (("speed", "speeds"), ("energy", "energies")):
                columns[f"{side}_{name}"] = getattr(self, f"{side}_{plural}").ravel()
        return _pandas().DataFrame(columns)

    def plot(self, what: str = "map") -> Any:
        """Draw it, as in a report, and return the axes; their ``figure`` is the picture.

        Parameters
        ----------
        what
            ``map``, the true and believed paths of robots, or ``timeline``, the ticks at which
            faults were active and goals violated.
        """
        from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - brings matplotlib

        kinds = {"map": plots.flight_map, "timeline": plots.flight_timeline}
        if what not in kinds:
            raise UsageError(f"what: found {what!r}; {expected(what, kinds)}")
        return kinds[what](self._story()).axes[0]

    def write_gif(self, path: Path | str) -> None:
        """Write it as an animated picture, for a pull request or slides."""
        from mrsfi_runtime.analysis.plots import flight_gif  # noqa: PLC0415 - likewise

        with whole_file(Path(path)) as file:
            file.write(flight_gif(self._story()))

    def _story(self) -> Story:
        faults = named_faults(self.mission, self.pool, self.specification)
        title = f"Mission {self.mission.name}, mission seed {self.seed}"
        return story_of(title, self.mission, faults, self.recording)

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
        """True positions of robots, shape ``(n_ticks, n_robots, 3)``."""
        return _positions(self.recording["world"])

    @property
    def believed_positions(self) -> Numbers:
        """Believed positions of robots, shape ``(n_ticks, n_robots, 3)``."""
        return _positions(self.recording["belief"])

    @property
    def true_speeds(self) -> Numbers:
        """True speeds of robots, per tick, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["world"], "speed")

    @property
    def believed_speeds(self) -> Numbers:
        """Believed speeds of robots, per tick, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["belief"], "speed")

    @property
    def true_energies(self) -> Numbers:
        """Energy left to robots, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["world"], "energy")

    @property
    def believed_energies(self) -> Numbers:
        """Energy believed to be left, shape ``(n_ticks, n_robots)``."""
        return _of_robots(self.recording["belief"], "energy")

    @property
    def truly_violated(self) -> NDArray[np.bool_]:
        """Whether goals were truly violated, shape ``(n_ticks, n_goals)``."""
        return np.asarray(self.recording["is_true"], np.bool_)

    @property
    def believed_violated(self) -> NDArray[np.bool_]:
        """Whether goals were believed violated, shape ``(n_ticks, n_goals)``."""
        return np.asarray(self.recording["is_believed"], np.bool_)

    def violations(self, kind: str = "believed") -> dict[str, int]:
        """Return the number of ticks at which each goal was violated, by its ID.

        Parameters
        ----------
        kind
            ``believed``, ``true``, ``phantom`` (believed, not true), ``masked`` (true, not
            believed) or ``missed`` (the goal can no longer be met).
        """
        if kind not in COUNTED:
            raise ValueError(f"found kind '{kind}'; {expected(kind, COUNTED)}")
        return dict(zip(self.goals, getattr(self.outcome, kind), strict=True))


def fly(engine: Engine, pool: FaultPool, specification: Specification, seed: int) -> Flight:
    """Fly once on an engine, and record every tick."""
    mission = engine.code.mission
    recorder = Recorder(initial_state(mission, seed))
    tallies: list[FaultTally] = []
    outcome = engine.evaluate(specification, seed, pool=pool, observer=recorder, tallies=tallies)
    return Flight(mission, specification, pool, seed, outcome, recorder.recording(tallies))


def frame(table: Table) -> "DataFrame":
    """Return a table as a frame of pandas."""
    return _pandas().DataFrame(list(table.rows), columns=list(table.columns))


def _pandas() -> Any:
    try:
        return import_module("pandas")
    except ModuleNotFoundError as error:
        raise UsageError("pandas is not installed; install it: pip install pandas") from error


def _positions(states: Part) -> Numbers:
    return np.stack([_of_robots(states, axis) for axis in "xyz"], axis=-1)


def _of_robots(states: Part, column: str) -> Numbers:
    return np.asarray(states["robots"][column], np.float64)
