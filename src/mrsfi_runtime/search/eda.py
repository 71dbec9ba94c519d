"""A model of good fault specifications, to be drawn from and learned: which faults, and when.

References
----------
Larrañaga and Lozano, *Estimation of Distribution Algorithms*, 2002: univariate models.
"""

from collections.abc import Sequence
from random import Random
from statistics import fmean, pstdev

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.individuals import Individual
from mrsfi_runtime.search.space import SearchSpace

_RATE = 0.3  # of learning: the share of what is new
_ELITE = 0.25  # share of a generation that is learned from
_LEAST_SPREAD = 0.02  # of a Gaussian, as a share of its range, so that no model freezes
_LEAST_CHANCE = 0.1  # of a fault, as a share of what it would have if all were alike

_Gauss = tuple[float, float]


class FaultModel:
    """For every pool fault how often it occurs, and Gaussians of start, finish and values."""

    def __init__(self, space: SearchSpace, n_faults: int, rng: Random) -> None:
        self._space = space
        self._n_faults = n_faults
        self._rng = rng
        self._chances = dict.fromkeys(space.candidates, 1.0)
        last = float(space.duration - 1)
        self._ranges = {
            fault: ((0.0, last), (0.0, last), *candidate.bounds)
            for fault, candidate in space.candidates.items()
        }
        self._gaussians: dict[str, list[_Gauss]] = {
            fault: [((low + high) / 2, (high - low) / 2) for low, high in ranges]
            for fault, ranges in self._ranges.items()
        }

    def generate(self) -> Specification:
        """Draw a specification: faults by their chance, as long as one is free."""
        placed: list[TimedFault] = []
        candidates = dict(self._chances)
        while candidates and len(placed) < self._n_faults:
            (fault,) = self._rng.choices(tuple(candidates), tuple(candidates.values()))
            timed = self._timed(fault, placed)
            if timed is None:
                del candidates[fault]
            else:
                placed.append(timed)
        return self._space.ordered(placed)

    def _timed(self, fault: str, placed: Sequence[TimedFault]) -> TimedFault | None:
        drawn = [
            min(high, max(low, self._rng.gauss(*gaussian)))
            for gaussian, (low, high) in zip(
                self._gaussians[fault], self._ranges[fault], strict=True
            )
        ]
        start, finish = sorted(map(round, drawn[:2]))
        overlaps = [
            (max(start, first), min(finish, last))
            for first, last in self._space.free_windows(fault, placed)
            if first <= finish and start <= last
        ]
        if not overlaps:
            return None
        start, finish = max(overlaps, key=lambda window: window[1] - window[0])
        values = self._space.candidates[fault].changed(
            drawn[2:],
            lambda value, _low, _high, is_whole: float(round(value)) if is_whole else value,
        )
        trigger = self._space.candidates[fault].drawn_trigger(self._rng)
        return TimedFault(fault, start, finish, values, trigger)

    def update(self, population: Sequence[Individual]) -> None:
        """Learn from how the best of a generation differ from all.

        From the difference, because faults that are placed early cut the windows of later ones: a
        model of the best alone would take that for success and make all windows short.
        """
        ranked = sorted(population, key=lambda individual: individual.score.fitness, reverse=True)
        elite = ranked[: max(1, round(_ELITE * len(ranked)))]
        n_elite = sum(map(len, elite))
        for fault, gaussians in self._gaussians.items():
            among_all, among_best = _rows(fault, ranked), _rows(fault, elite)
            share = len(among_best) * len(self._chances) / n_elite
            chance = (1.0 - _RATE) * self._chances[fault] + _RATE * share
            self._chances[fault] = max(_LEAST_CHANCE, chance)
            if among_best:
                best, every = zip(*among_best, strict=True), zip(*among_all, strict=True)
                moved = map(_moved, gaussians, best, every, self._ranges[fault])
                self._gaussians[fault] = [*moved]


def _rows(fault: str, individuals: Sequence[Individual]) -> list[tuple[float, ...]]:
    return [
        (timed.start, timed.finish, *timed.values)
        for individual in individuals
        for timed in individual
        if timed.fault == fault
    ]


def _moved(
    old: _Gauss, best: Sequence[float], every: Sequence[float], bounds: tuple[float, float]
) -> _Gauss:
    (middle, spread), (low, high) = old, bounds
    middle += _RATE * (fmean(best) - fmean(every))
    ratio = pstdev(best) / pstdev(every) if pstdev(every) > 0.0 else 1.0
    spread *= 1.0 + _RATE * (min(1.0, ratio) - 1.0)
    return min(high, max(low, middle)), max(_LEAST_SPREAD * (high - low), spread)
