"""Which robots are near a place: looked up in a grid where they are many, one by one where few.

The grid has no edges: cells are numbered without end and share a fixed number of buckets, so
that it serves robots wherever they are believed to be.
"""

from mrsfi_runtime.kernel.compiling import kernel
from mrsfi_runtime.kernel.state import GoalState, LookupState, State

FEW = 24
"""Members up to which a goal's robots are looked at one by one."""

WIDEST = 4
"""Cells a side of the widest square that is looked up; beyond it all members are looked at."""

FAR = 2.0**30
"""Number of the outermost cell; whatever is farther out counts as inside it."""


def n_buckets(n_members: int) -> int:
    """Return how many buckets a goal's grid has: a power of two, or 0 where there is no grid.

    There are two to four for each robot, so that most robots are alone in theirs.
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
def chart(view: State, goal: GoalState, size: float) -> None:
    """Sort a goal's members into the grid, where they are many.

    Parameters
    ----------
    view, goal
        State and one of its AvoidCollision goals.
    size
        Side of a cell, > 0.

    Notes
    -----
    Counting sort: ``LookupState.heads`` first counts the robots of each bucket, then tells where
    each bucket ends in ``charted``, and last, where it begins.
    """
    if goal.n_members <= FEW:
        return
    lookup = view.lookup
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
        charted.x = view.robots[charted.robot].x
        charted.y = view.robots[charted.robot].y


@kernel
def bucket_of(lookup: LookupState, column: int, row: int) -> int:
    """Return the bucket of a cell."""
    return (column + row * lookup.stride) & (lookup.n_buckets - 1)


@kernel
def gather(view: State, goal: GoalState, index: int, reach: float) -> int:
    """Collect the other members that are nearer than ``reach`` along both axes.

    Parameters
    ----------
    view
        State whose members ``chart`` has sorted, and which have not moved since.
    goal
        The goal.
    index
        Index of the robot whose neighbours are wanted.
    reach
        Distance.

    Returns
    -------
    int
        Their number; their indices stand first in ``State.lookup.nearby``.
    """
    lookup = view.lookup
    x = view.robots[index].x
    y = view.robots[index].y
    if goal.n_members > FEW:
        per_unit = lookup.cells_per_unit
        left = cell(x - reach, per_unit)
        right = cell(x + reach, per_unit)
        low = cell(y - reach, per_unit)
        high = cell(y + reach, per_unit)
        if max(right - left, high - low) < WIDEST:
            return gather_cells(view, index, reach, left, right, low, high)
    n = 0
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        other = view.members[m].robot
        robot = view.robots[other]
        if other != index and is_near(robot.x - x, robot.y - y, reach):
            lookup.nearby[n] = other
            n += 1
    return n


@kernel
def gather_cells(
    view: State, index: int, reach: float, left: int, right: int, low: int, high: int
) -> int:
    """Collect the robots of a rectangle of cells that are near another; as ``gather``."""
    lookup = view.lookup
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
    """Collect the robots of some buckets behind those found before; return how many there are.

    Notes
    -----
    All are written down, and what is not near is written over: compiled, that is faster than
    a branch that nobody can predict.
    """
    lookup = view.lookup
    x = view.robots[index].x
    y = view.robots[index].y
    n = n_before
    for k in range(lookup.heads[begin], lookup.heads[end + 1]):
        other = lookup.charted[k]
        lookup.nearby[n] = other.robot
        n += is_near(other.x - x, other.y - y, reach) & (other.robot != index)
    return n


@kernel
def is_near(dx: float, dy: float, reach: float) -> bool:
    """Return whether two points are nearer than ``reach`` along both axes."""
    return max(abs(dx), abs(dy)) < reach
