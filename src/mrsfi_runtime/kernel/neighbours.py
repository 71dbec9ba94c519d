"""Find the robots and obstacles near a robot.

Up to ``FEW`` robots are compared one by one. For more robots, a hashed grid is used: it has no
edge, and its cells share a fixed number of buckets, so it works wherever robots are believed to be.
Sorting robots into the grid also lists their neighbours, with a margin; grid and lists stay valid
until robots have moved farther than that margin.

Obstacles are looked up in a map of their model positions. It divides the square around the mission
area into cells. Each cell lists the obstacles within reach of it, nearest first; cells at the edge
also cover all points beyond. The few obstacles believed elsewhere are compared one by one.

Invariant: every query returns the result of comparing all pairs. Begin with ``chart`` and
``gather`` for robots, ``mapped`` and ``cell_at`` for obstacles.
"""

from functools import lru_cache
from operator import attrgetter

from mrsfi_runtime.kernel.guidance import pace
from mrsfi_runtime.kernel.state import GoalState, LookupState, MappedState, MapState, State, kernel
from mrsfi_runtime.model.mission import Area, Obstacle

FEW = 24  # members up to which a goal's robots are compared one by one

WIDEST = 4
"""Cells per side of the widest square that is searched; beyond it all members are compared."""

FAR = 2.0**30  # number of the outermost cell; whatever is farther out counts as inside it
TICKS = 6  # ticks for which the fastest robot may move before robots are sorted anew
LISTED = 16  # capacity of the neighbour lists, in neighbours per member on average

STRAYS = 8
"""Robots that may leave their cell, such as those that faults displace, before a new sort."""

SURE = 1.0 + 1e-9  # factor that exceeds every rounding error of a distance


def n_buckets(n_members: int) -> int:
    """Return how many buckets a goal's grid has: a power of two, or 0 where there is no grid.

    There are two to four buckets per robot, so that most robots are alone in theirs.
    """
    return 0 if n_members <= FEW else 2 << (n_members - 1).bit_length()


def stride(buckets: int) -> int:
    """Return by how many buckets two rows of cells are apart.

    It is odd, so that a column of cells spreads over all buckets, about the square root of
    their number, so that a square does, and such that no two cells of a square of ``WIDEST``
    share one: no robot is found twice.
    """
    return (1 << (buckets.bit_length() // 2)) + 7


@kernel
def cell(value: float, per_unit: float) -> int:
    """Return in which column or row of cells a coordinate lies; number 0 is twice as wide."""
    return int(min(max(value * per_unit, -FAR), FAR))


@kernel
def chart(view: State, goal: GoalState, reach: float) -> None:
    """Prepare the grid for a goal's members, if they are more than ``FEW``.

    ``reach`` is the most frequent search distance, > 0. Grid and lists have a margin, and stay
    valid until more than ``STRAYS`` robots have moved farther than it. This is checked by their
    positions, so any cause of motion counts. If goals alternate, no goal is searched twice in a
    row, and lists are not made because they would not pay.
    """
    if goal.n_members <= FEW:
        return
    lookup = view.lookup
    is_same = lookup.first_member == goal.first_member
    if not is_same or reach > lookup.reach or not is_charted(view, goal):
        lookup.first_member = goal.first_member
        lookup.reach = max(reach, lookup.asked) if is_same else reach
        slack = TICKS * fastest(view, goal) if is_same else 0.0
        sort(view, goal, 2.0 * (lookup.reach + slack))
        if is_same:
            list_neighbours(view, goal, (lookup.reach + 2.0 * slack) * SURE)
        lookup.slack = slack
    lookup.asked = reach


@kernel
def fastest(view: State, goal: GoalState) -> float:
    """Return the distance that any member may move in a tick, by its command and nominal speed."""
    most = 0.0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        most = max(most, pace(view, view.members[m].robot))
    return most


@kernel
def is_charted(view: State, goal: GoalState) -> bool:
    """Return whether at most ``STRAYS`` members have moved farther than the slack since sorting."""
    lookup = view.lookup
    n = 0
    for k in range(goal.n_members):
        spot = lookup.charted[k]
        robot = view.robots[spot.robot]
        if max(abs(robot.x - spot.x), abs(robot.y - spot.y)) > lookup.slack:
            if n == STRAYS:
                return False
            lookup.strays[n] = spot.robot
            n += 1
    lookup.n_strays = n
    return True


@kernel
def sort(view: State, goal: GoalState, size: float) -> None:
    """Sort a goal's members into cells of a size, by counting.

    ``LookupState.heads`` first counts the robots of each bucket, then holds where each bucket
    ends in ``charted``, and finally where it begins.
    """
    lookup = view.lookup
    lookup.slack = 0.0
    lookup.n_strays = 0
    lookup.is_listed = 0
    per_unit = 1.0 / size
    lookup.cells_per_unit = per_unit
    for bucket in range(lookup.n_buckets + 1):
        lookup.heads[bucket] = 0
    for k in range(goal.n_members):
        robot = view.robots[view.members[goal.first_member + k].robot]
        bucket = bucket_of(lookup, cell(robot.x, per_unit), cell(robot.y, per_unit))
        lookup.buckets[k] = bucket
        lookup.heads[bucket] += 1
    end = 0
    for bucket in range(lookup.n_buckets + 1):
        end += lookup.heads[bucket]
        lookup.heads[bucket] = end
    for k in range(goal.n_members):
        bucket = lookup.buckets[k]
        lookup.heads[bucket] -= 1
        charted = lookup.charted[lookup.heads[bucket]]
        charted.robot = view.members[goal.first_member + k].robot
        charted.x, charted.y = view.robots[charted.robot].x, view.robots[charted.robot].y


@kernel
def list_neighbours(view: State, goal: GoalState, reach: float) -> None:
    """List the neighbours of each member, unless they exceed the capacity of the lists."""
    lookup = view.lookup
    end = 0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        index = view.members[m].robot
        n = gather_charted(view, index, reach)
        if n < 0 or end + n > len(lookup.listed):
            return
        lookup.first_listed[index] = end
        lookup.n_listed[index] = n
        for k in range(n):
            lookup.listed[end + k] = lookup.nearby[k]
        end += n
    lookup.is_listed = 1


@kernel
def bucket_of(lookup: LookupState, column: int, row: int) -> int:
    """Return the bucket of a cell."""
    return (column + row * lookup.stride) & (lookup.n_buckets - 1)


@kernel
def gather(view: State, goal: GoalState, index: int, reach: float) -> int:
    """Collect the other members nearer than ``reach`` along both axes, and return their number.

    ``chart`` must have sorted the members after their last motion. Their indices are written to
    the start of ``State.lookup.nearby``.
    """
    n = -1
    if goal.n_members > FEW:
        lookup = view.lookup
        if lookup.is_listed == 1 and reach <= lookup.reach and not is_stray(lookup, index):
            n = gather_listed(view, index, reach)
        else:
            n = gather_charted(view, index, reach)
        if n >= 0 and lookup.n_strays > 0:
            n = gather_strays(view, index, reach, n)
    return gather_members(view, goal, index, reach) if n < 0 else n


@kernel
def gather_members(view: State, goal: GoalState, index: int, reach: float) -> int:
    """Collect neighbours by comparing all members; otherwise as ``gather``."""
    lookup = view.lookup
    x, y = view.robots[index].x, view.robots[index].y
    n = 0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        other = view.members[m].robot
        robot = view.robots[other]
        if other != index and is_near(robot.x - x, robot.y - y, reach):
            lookup.nearby[n] = other
            n += 1
    return n


@kernel
def is_stray(lookup: LookupState, index: int) -> bool:
    """Return whether a robot is a stray: farther than the slack from where it was sorted."""
    for k in range(lookup.n_strays):
        if lookup.strays[k] == index:
            return True
    return False


@kernel
def gather_strays(view: State, index: int, reach: float, n_before: int) -> int:
    """Collect nearby strays that are not yet in ``nearby``; otherwise as ``gather_buckets``."""
    lookup = view.lookup
    own = view.robots[index]
    n = n_before
    for k in range(lookup.n_strays):
        other = lookup.strays[k]
        robot = view.robots[other]
        if other != index and is_near(robot.x - own.x, robot.y - own.y, reach):
            lookup.nearby[n] = other  # a sentinel that ends the search
            place = 0
            while lookup.nearby[place] != other:
                place += 1
            n = max(n, place + 1)
    return n


@kernel
def gather_listed(view: State, index: int, reach: float) -> int:
    """Collect neighbours from the lists; otherwise as ``gather_buckets``."""
    lookup = view.lookup
    x, y = view.robots[index].x, view.robots[index].y
    first = lookup.first_listed[index]
    n = 0
    for k in range(first, first + lookup.n_listed[index]):
        other = lookup.listed[k]
        robot = view.robots[other]
        lookup.nearby[n] = other
        n += is_near(robot.x - x, robot.y - y, reach)
    return n


@kernel
def gather_charted(view: State, index: int, reach: float) -> int:
    """Collect neighbours from the cells around a robot; return -1 if there are too many cells."""
    lookup = view.lookup
    x, y = view.robots[index].x, view.robots[index].y
    wide = (reach + lookup.slack) * SURE
    per_unit = lookup.cells_per_unit
    left = cell(x - wide, per_unit)
    right = cell(x + wide, per_unit)
    low = cell(y - wide, per_unit)
    high = cell(y + wide, per_unit)
    if max(right - left, high - low) >= WIDEST:
        return -1
    last = lookup.n_buckets - 1
    n = 0
    for row in range(low, high + 1):
        begin = bucket_of(lookup, left, row)
        end = bucket_of(lookup, right, row)
        if begin > end:  # the row goes on in the first bucket
            n = gather_buckets(view, index, reach, begin, last, n)
            begin = 0
        n = gather_buckets(view, index, reach, begin, end, n)
    return n


@kernel
def gather_buckets(
    view: State, index: int, reach: float, begin: int, end: int, n_before: int
) -> int:
    """Append the nearby robots of a range of buckets to ``nearby``; return the new number.

    Every robot is written, and the next one overwrites it if it is not near: in compiled code
    this is faster than an unpredictable branch.
    """
    lookup = view.lookup
    x, y = view.robots[index].x, view.robots[index].y
    n = n_before
    for k in range(lookup.heads[begin], lookup.heads[end + 1]):
        other = lookup.charted[k].robot
        robot = view.robots[other]
        lookup.nearby[n] = other
        n += is_near(robot.x - x, robot.y - y, reach) & (other != index)
    return n


@kernel
def is_near(dx: float, dy: float, reach: float) -> bool:
    """Return whether two points are nearer than ``reach`` along both axes."""
    return max(abs(dx), abs(dy)) < reach


SIDE = 32  # cells along a side of the map

SLACK = 0.001
"""Enlargement of each cell, in cells, so that no rounding error hides an obstacle."""


@kernel
def column(map_: MapState, offset: float) -> int:
    """Return the column (or row) of a point at an offset from the map's left (or lower) edge."""
    return int(min(max(offset * map_.cells_per_unit, 0.0), SIDE - 1.0))


@kernel
def cell_at(view: State, x: float, y: float) -> int:
    """Return the index of the map cell of a point; cells are numbered row by row along x."""
    map_ = view.map
    return SIDE * column(map_, y - map_.y) + column(map_, x - map_.x)


@kernel
def is_listed(view: State, goal: GoalState, index: int) -> bool:
    """Return whether an obstacle is among those of a goal, which mostly are all, in order."""
    if index < goal.n_hazards and view.hazards[goal.first_hazard + index] == index:
        return True
    for h in range(goal.first_hazard, goal.first_hazard + goal.n_hazards):
        if view.hazards[h] == index:
            return True
    return False


@kernel
def is_displaced(view: State, index: int) -> bool:
    """Return whether the believed position of an obstacle differs from the model's."""
    obstacle = view.obstacles[index]
    return obstacle.x != obstacle.model_x or obstacle.y != obstacle.model_y


def mapped(
    area: Area, obstacles: tuple[Obstacle, ...], reach: float
) -> tuple[MapState, tuple[int, ...], tuple[MappedState, ...]]:
    """Return ``State.map``, ``.cells`` and ``.mapped``; for ``reach`` see ``MapState``."""
    x, y = float(area.center.x) - area.radius, float(area.center.y) - area.radius
    map_ = MapState(x, y, SIDE / max(2.0 * area.radius, 1.0), reach, 0)
    discs = tuple(obstacle.area for obstacle in obstacles)
    return map_, *_drawn(x, y, map_.cells_per_unit, reach, discs)


@lru_cache(maxsize=16)
def _drawn(
    x: float, y: float, cells_per_unit: float, reach: float, discs: tuple[Area, ...]
) -> tuple[tuple[int, ...], tuple[MappedState, ...]]:
    """Return ``State.cells`` and ``State.mapped``, which all states of a mission share."""
    found: list[list[MappedState]] = [[] for _ in range(SIDE * SIDE)]
    for index, disc in enumerate(discs):
        across = _gaps(disc.center.x - x, cells_per_unit, reach + disc.radius)
        along = _gaps(disc.center.y - y, cells_per_unit, reach + disc.radius)
        for row, low in along:
            for column_, near in across:
                gap = max(low, near) - disc.radius
                found[SIDE * row + column_].append(MappedState(index, gap))
    cells = [0]
    shown: list[MappedState] = []
    for each in found:
        shown.extend(sorted(each, key=attrgetter("gap")))
        cells.append(len(shown))
    return tuple(cells), tuple(shown)


def _gaps(offset: float, cells_per_unit: float, limit: float) -> list[tuple[int, float]]:
    """Return the columns (or rows) nearer than a limit to a point, each with its distance."""
    place = offset * cells_per_unit
    gaps = [max(n - SLACK - place, place - n - 1 - SLACK, 0.0) for n in range(SIDE)]
    gaps[0] = max(place - 1 - SLACK, 0.0)
    gaps[-1] = max(SIDE - 1 - SLACK - place, 0.0)
    return [(n, gap / cells_per_unit) for n, gap in enumerate(gaps) if gap < limit * cells_per_unit]
