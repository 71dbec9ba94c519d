"""What one search found, in the numbers by which searches are compared."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import numpy as np
from moocore import hypervolume
from numpy.typing import NDArray

from mrsfi_runtime.analysis.columns import Columns
from mrsfi_runtime.analysis.fronts import find_front, is_more
from mrsfi_runtime.analysis.story import first
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.encoding import object_from_text
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.store import CampaignStore

MOST_OBJECTIVES = 7
"""Of a hypervolume that is computed; its cost grows exponentially with their number."""


@dataclass(frozen=True, slots=True)
class RunResult:
    """What one algorithm found with one seed.

    ``improvements`` are numbers of evaluations at which a fitness above all before was found, and
    that. ``at_once`` has for k = 1, 2, … the number of evaluations until one specification broke k
    goals, ``None`` if none did, shape ``(n_goals,)``; ``together`` the same for one or another of
    those so far. ``hypervolume`` is the share of the possible that the front reaches, 0 … 1, see
    ``front_volume``; ``front_size`` counts its different vectors. ``seconds`` are wall time.
    ``digest`` is over all evaluations, as in the report of the same search by itself.
    """

    algorithm: str
    seed: int
    n_evaluations: int
    n_failures: int
    improvements: tuple[tuple[int, float], ...]
    at_once: tuple[int | None, ...]
    together: tuple[int | None, ...]
    hypervolume: float | None
    front_size: int
    seconds: float
    digest: str

    @property
    def best_fitness(self) -> float:
        """Highest fitness of all evaluations; 0 without any."""
        return self.improvements[-1][1] if self.improvements else 0.0

    def best_after(self, n_evaluations: int) -> float:
        """Return the highest fitness of the first so many evaluations."""
        return max(
            (value for place, value in self.improvements if place <= n_evaluations), default=0.0
        )

    def as_json(self) -> dict[str, Any]:
        """Return the result as values of JSON."""
        return asdict(self)

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Return the result that ``as_json`` described, from its JSON text."""
        return cls(**{key: _frozen(value) for key, value in object_from_text(text).items()})


def _frozen(value: Any) -> Any:
    return tuple(map(_frozen, value)) if isinstance(value, list) else value


def measure_run(store: CampaignStore, mission: Mission, seconds: float) -> RunResult:
    """Return what a search found, in the first mission seed."""
    settings = store.settings
    measure = replace(Measure.of(settings, mission), n_seeds=1)
    columns = Columns.read(store, measure, measure.goals)
    is_broken = columns.violations > 0
    is_improved = np.flatnonzero(is_more(columns.fitness))
    best = [mission.duration] * len(measure.chosen)
    points = find_front(measure, columns, measure.chosen).points
    front = [point.violations for point in points]
    if measure.minimised is not None:
        most = settings.faults * (mission.duration if measure.minimised == "fault_ticks" else 1)
        best.append(most - 1)
        front = [(*point.violations, most - point.cost) for point in points]
    return RunResult(
        algorithm=settings.algorithm,
        seed=settings.seed,
        n_evaluations=len(columns),
        n_failures=store.n_failures,
        improvements=tuple((k + 1, columns.fitness[k].item()) for k in is_improved.tolist()),
        at_once=_reached(is_broken.sum(axis=1), len(mission.goals)),
        together=_reached(np.logical_or.accumulate(is_broken).sum(axis=1), len(mission.goals)),
        hypervolume=front_volume(front, best),
        front_size=len(front),
        seconds=seconds,
        digest=store.digest(),
    )


def _reached(n_broken: NDArray[Any], n_goals: int) -> tuple[int | None, ...]:
    """Return at which place, from 1, 1, 2, … goals were broken, ``None`` where they never were."""
    firsts = [first(n_broken >= n) for n in range(1, n_goals + 1)]
    return tuple(None if place is None else place + 1 for place in firsts)


def front_volume(front: Sequence[tuple[float, ...]], best: Sequence[int]) -> float | None:
    """Return the hypervolume of a front, as a share of the possible.

    Points are whole numbers from 0 on, more is better: violations, or how many fewer faults, or
    ticks of faults, than a specification may have; ``best`` is the best possible one. The reference
    point is ``(-1, …, -1)``: so a front whose points violate one goal alone counts, and the volume
    is the number of whole vectors that the front reaches or exceeds, over the number of all.
    ``None`` with fewer than two objectives, or more than ``MOST_OBJECTIVES``.
    """
    if not 2 <= len(best) <= MOST_OBJECTIVES:
        return None
    if not front:
        return 0.0
    shares = [
        [(value + 1) / (most + 1) for value, most in zip(point, best, strict=True)]
        for point in front
    ]
    return float(hypervolume(shares, ref=[0.0] * len(best), maximise=True))
