"""Values of a fault's parameters that mean something in its mission.

Most values between two bounds are like their neighbours. What stands out are the ends, and,
among places, where robots begin, goals are pursued and obstacles stand: a believed position
inside an obstacle is a point that chance hardly ever hits.
"""

from collections.abc import Iterable, Iterator

from mrsfi_runtime.kernel.goal_tasks.visit import Visit
from mrsfi_runtime.model.bounds import value_bounds
from mrsfi_runtime.model.faults import Fault
from mrsfi_runtime.model.mission import Coordinates, Mission

_OUTSIDE = 1.2  # mission radii: surely outside, within the default bounds


def landmarks(mission: Mission, fault: Fault) -> tuple[tuple[float, ...], ...]:
    """Return the landmarks of a pool fault, each once, its own values first.

    Returns
    -------
    tuple[tuple[float, ...], ...]
        Shape ``(n_landmarks, n_parameters)``, all within ``value_bounds``.
    """
    bounds = value_bounds(mission, fault)
    found = _places(mission, fault) if fault.kind.is_place else _ends(fault, bounds)
    return tuple(
        dict.fromkeys(
            values
            for values in (fault.values, *found)
            if all(low <= value <= high for value, (low, high) in zip(values, bounds, strict=True))
        )
    )


def _ends(fault: Fault, bounds: Iterable[tuple[float, float]]) -> Iterator[tuple[float, ...]]:
    """Yield the pool's values with one of them at an end of its bounds."""
    for place, (low, high) in enumerate(bounds):
        for end in (low, high):
            yield (*fault.values[:place], end, *fault.values[place + 1 :])


def _places(mission: Mission, fault: Fault) -> Iterator[tuple[float, ...]]:
    own_height = fault.values[2:]
    for point in _points(mission):
        yield (float(point.x), float(point.y), *own_height)


def _points(mission: Mission) -> Iterator[Coordinates]:
    center, far = mission.area.center, _OUTSIDE * mission.area.radius
    for robot in mission.robots:
        yield robot.position
    for obstacle in mission.obstacles:
        yield obstacle.area.center
    for goal in mission.goals:
        if goal.area is not None:
            yield goal.area.center
        if isinstance(goal.task, Visit):
            yield goal.task.coordinates
    yield center
    for x, y in ((far, 0.0), (-far, 0.0), (0.0, far), (0.0, -far)):
        yield Coordinates(center.x + x, center.y + y)
