"""The simplest form of a cause set: shorter windows and plainer values that do almost the same."""

from collections.abc import Callable, Iterator

from mrsfi_runtime.causes.cause_set import floor
from mrsfi_runtime.causes.counts import Flights
from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission

KEEP = 0.99
"""Share that the simplest form keeps of each count of the cause set."""

_DIGITS = (1, 2, 3)  # of a round number, the fewest first


def simplest(
    flights: Flights, mission: Mission, pool: FaultPool, specification: Specification
) -> Specification:
    """Return a cause set with shorter windows and plainer values that keeps its counts.

    Fault by fault, what can go is cut from the start of the window, then from its finish, in steps
    that begin with half of it; then each value becomes the first of the pool's own, a bound, and
    the number itself in one, two or three digits with which enough is kept.
    """
    columns = range(len(flights.columns))
    least = floor(flights.counts(specification), KEEP, columns)
    found = [*specification]
    for place, timed in enumerate(specification):

        def is_kept(tried: TimedFault, place: int = place) -> bool:
            counts = flights.counts((*found[:place], tried, *found[place + 1 :]))
            return all(counts[k] >= count for k, count in least.items())

        found[place] = _cut(timed, mission.duration, is_kept)
        found[place] = _plain(found[place], mission, pool[timed.fault], is_kept)
    return tuple(found)


def _cut(timed: TimedFault, duration: int, is_kept: Callable[[TimedFault], bool]) -> TimedFault:
    """Return a fault with a window cut from both ends, as far as enough is kept."""
    timed = timed._replace(finish=max(timed.start, min(timed.finish, duration - 1)))
    for first, last in ((1, 0), (0, 1)):
        step = (timed.finish - timed.start + 1) // 2
        while step:
            tried = timed._replace(
                start=timed.start + first * step, finish=timed.finish - last * step
            )
            if tried.start <= tried.finish and is_kept(tried):
                timed = tried
            else:
                step //= 2
    return timed


def _plain(
    timed: TimedFault, mission: Mission, fault: Fault, is_kept: Callable[[TimedFault], bool]
) -> TimedFault:
    """Return a fault with the plainest values with which enough is kept."""
    bounds = value_bounds(mission, fault)
    for k, (low, high) in enumerate(bounds):
        for value in _plainer(timed.values[k], fault.values[k], low, high):
            values = (*timed.values[:k], value, *timed.values[k + 1 :])
            tried = timed._replace(values=values)
            if value == timed.values[k] or is_kept(tried):
                timed = tried
                break
    return timed


def _plainer(value: float, own: float, low: float, high: float) -> Iterator[float]:
    """Yield values within bounds, the plainest first."""
    yield from (own, low, high)
    for digits in _DIGITS:
        rounded = float(f"{value:.{digits}g}")
        if low <= rounded <= high:
            yield rounded
