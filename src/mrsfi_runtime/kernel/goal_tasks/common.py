"""What goal tasks share: counting members, margins, and who has been in a goal's area.

A goal is violated if fewer members than it requires keep to the rule of its task. ``too_many``
makes this check of a rule for one member, ``kth_best`` the value that decides it.

A margin is the distance from violation, in the unit of the goal's task; it is negative if the goal
is violated. Robot motion bounds how fast most margins change. ``patience`` uses this bound to tell
for how many ticks a margin need not be computed, as it cannot fall below the least so far. If no
member's value falls by more than a bound in a tick, neither does the ``kth_best``: the k members
that are best now all keep a value of at least the present k-th best minus the bound.

The same bound makes a goal *quiet* until the tick at which one of its members can break the rule,
or has to react to it: it is not checked before, unless a belief may be false (``is_quiet``). No
goal is quiet in flights of the reference engine, or where a team's code may change a state.

References
----------
Margins are the robustness of signal temporal logic (A. Donzé and O. Maler, "Robust Satisfaction of
Temporal Logic over Real-Valued Signals", FORMATS 2010), taken as the minimum over a flight.
"""

import math
from collections.abc import Callable
from typing import Final, TypeAlias

from mrsfi_runtime.kernel.geometry import depth_in_area, in_area, inside
from mrsfi_runtime.kernel.guidance import roam_in
from mrsfi_runtime.kernel.state import AreaState, GoalState, State, WakeState, kernel

NO_MARGIN: Final = math.inf
"""Margin of a goal while it is undefined, such as before a robot first enters its area."""

NEVER: Final = 1 << 40  # a tick that no mission reaches

CALM, AWAKE = 5, 16
"""Ticks for which a member is calm at least, or a goal quiet; and for which it is not, at least."""

MemberRule: TypeAlias = Callable[[State, GoalState, int], bool]
"""Return whether a member of a goal, by its index in ``State.members``, breaks a rule."""

MemberValue: TypeAlias = Callable[[State, GoalState, int], float]
"""Return a number of a member, which is greater the further it is from a violation."""


def too_many(breaks: MemberRule) -> Callable[[State, int], bool]:
    """Return the check whether so many members break a rule that fewer than required keep it."""

    @kernel
    def is_broken(view: State, g: int) -> bool:
        goal = view.goals[g]
        spare = goal.n_members - view.required[g]
        for m in range(goal.first_member, goal.first_member + goal.n_members):
            if breaks(view, goal, m):
                if spare == 0:
                    return True
                spare -= 1
        return False

    return is_broken


def kth_best(value: MemberValue) -> Callable[[State, int], float]:
    """Return the function for the greatest value that as many members as required have or exceed.

    If all are required, it is the least value. Each pass over the members finds the next greater
    value; equal ones follow by index.
    """

    @kernel
    def decisive(view: State, g: int) -> float:
        goal = view.goals[g]
        first = goal.first_member
        found, at = -NO_MARGIN, -1
        for _ in range(goal.n_members - view.required[g] + 1):
            least, place = NO_MARGIN, at
            for m in range(first, first + goal.n_members):
                own = value(view, goal, m)
                if own < least and (own > found or (own == found and m > at)):
                    least, place = own, m
            found, at = least, place
        return found

    return decisive


@kernel
def patience(left: float, least: float, speed: float) -> int:
    """Return after how many ticks a margin, now ``left``, can be below ``least``; at least 1.

    ``speed`` is the most that the margin falls in a tick.
    """
    spare = left - least
    if spare <= speed:
        return 1
    return NEVER if spare >= NEVER * speed else int(spare / speed)


@kernel
def is_quiet(view: State, g: int) -> bool:
    """Return whether a goal is quiet, unless a member has jumped in belief."""
    tick, goal = view.mission.tick, view.goals[g]
    if len(view.quiet) == 0 or view.quiet[g] <= tick:
        return False
    if view.map.displaced >= tick:
        for m in range(goal.first_member, goal.first_member + goal.n_members):
            robot = view.robots[view.members[m].robot]
            if jumps(view.wakes[view.members[m].robot], robot.x, robot.y):
                view.quiet[g] = -(tick + AWAKE)
                return False
    return True


@kernel
def jumps(wake: WakeState, x: float, y: float) -> bool:
    """Return whether a robot or an obstacle is farther from where it was than it can have moved."""
    return not inside(x, y, wake.x, wake.y, wake.reach)


@kernel
def needs_reaction(ci: State, g: int) -> bool:
    """Return whether something may have to react for a goal, which has been checked before."""
    return len(ci.quiet) == 0 or ci.quiet[g] <= ci.mission.tick


@kernel
def grace_of(view: State, g: int) -> int:
    """Return for how many ticks in a row the rule of a goal may be broken."""
    return view.grace[g].n_ticks if len(view.grace) > 0 else 0


@kernel
def next_area(view: State, m: int) -> AreaState:
    """Return the area, or point with tolerance, that a member is to be in next."""
    return view.areas[view.routes[m].first_area + view.members[m].waypoint]


@kernel
def note_presence(view: State, g: int) -> None:
    """Record which members are inside their next area, or within tolerance of their point.

    The next area of a member that is inside is the one after it in the route, or the first.
    """
    goal = view.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        member = view.members[m]
        robot = view.robots[member.robot]
        if in_area(view, next_area(view, m), robot.x, robot.y):
            member.since = view.mission.tick
            member.reached = 1
            after = member.waypoint + 1
            member.waypoint = after if after < view.routes[m].n_areas else 0


@kernel
def depth(view: State, m: int) -> float:
    """Return how far inside its next area, or within tolerance of its point, a member is."""
    robot = view.robots[view.members[m].robot]
    return depth_in_area(view, next_area(view, m), robot.x, robot.y)


@kernel
def roam_area(ci: State, g: int) -> None:
    """Let every member head for its next area from outside, and roam inside it."""
    goal = ci.goals[g]
    for m in range(goal.first_member, goal.first_member + goal.n_members):
        roam_in(ci, next_area(ci, m), ci.members[m].robot)
