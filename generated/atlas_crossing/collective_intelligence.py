# Generated from mission atlas_crossing by collective_intelligence.py.j2.
# Edit inside protected regions only.
"""The collective intelligence: what each goal checks and does, in model order."""

from mrsfi_runtime.api import (
    State,
    commands,
    forecast,
    geometry,
    goal_tasks,
    guidance,
    kernel,
    randomness,
)

# protected region imports on begin
# protected region imports end

MUTUALAVOIDANCE = 0
WITHIN = 1
RETURNONLOWENERGY = 2
GILDA_SWEEP1 = 3
GILDA_SWEEP2 = 4
HENRY_SWEEP1 = 5
HENRY_SWEEP2 = 6
GILDA = 0  # gilda
HENRY = 1  # henry
GILDA_GPS = 0
HENRY_GPS = 1
OB_0 = 0
OB_1 = 1
OB_2 = 2
OB_3 = 3
OB_4 = 4


# protected region helpers on begin
# protected region helpers end


@kernel
def check_mutualavoidance(ci: State) -> bool:
    """Return whether goal mutualavoidance (AvoidCollision) is violated now.

    Members: gilda, henry.
    """
    # protected region mutualavoidance.check on begin
    return goal_tasks.avoid_collision.violated(ci, MUTUALAVOIDANCE)
    # protected region mutualavoidance.check end


@kernel
def react_mutualavoidance(ci: State) -> None:
    """Command the members of goal mutualavoidance (AvoidCollision).

    Members: gilda, henry.
    """
    # protected region mutualavoidance.react on begin
    goal_tasks.avoid_collision.react(ci, MUTUALAVOIDANCE)
    # protected region mutualavoidance.react end


@kernel
def check_within(ci: State) -> bool:
    """Return whether goal within (StayWithinMissionArea) is violated now.

    Members: gilda, henry.
    """
    # protected region within.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, WITHIN)
    # protected region within.check end


@kernel
def react_within(ci: State) -> None:
    """Command the members of goal within (StayWithinMissionArea).

    Members: gilda, henry.
    """
    # protected region within.react on begin
    goal_tasks.stay_within_mission_area.react(ci, WITHIN)
    # protected region within.react end


@kernel
def check_returnonlowenergy(ci: State) -> bool:
    """Return whether goal returnonlowenergy (SufficientEnergy) is violated now.

    Members: gilda, henry.
    """
    # protected region returnonlowenergy.check on begin
    return goal_tasks.sufficient_energy.violated(ci, RETURNONLOWENERGY)
    # protected region returnonlowenergy.check end


@kernel
def react_returnonlowenergy(ci: State) -> None:
    """Command the members of goal returnonlowenergy (SufficientEnergy).

    Members: gilda, henry.
    """
    # protected region returnonlowenergy.react on begin
    goal_tasks.sufficient_energy.react(ci, RETURNONLOWENERGY)
    # protected region returnonlowenergy.react end


@kernel
def progress_gilda_sweep1(ci: State) -> None:
    """Note what goal gilda_sweep1 (Track) has to remember, once a tick before its check.

    Members: gilda.
    """
    # protected region gilda_sweep1.progress on begin
    goal_tasks.track.progress(ci, GILDA_SWEEP1)
    # protected region gilda_sweep1.progress end


@kernel
def check_gilda_sweep1(ci: State) -> bool:
    """Return whether goal gilda_sweep1 (Track) is violated now.

    Members: gilda.
    """
    # protected region gilda_sweep1.check on begin
    return goal_tasks.track.violated(ci, GILDA_SWEEP1)
    # protected region gilda_sweep1.check end


@kernel
def react_gilda_sweep1(ci: State) -> None:
    """Command the members of goal gilda_sweep1 (Track).

    Members: gilda.
    """
    # protected region gilda_sweep1.react on begin
    goal_tasks.track.react(ci, GILDA_SWEEP1)
    # protected region gilda_sweep1.react end


@kernel
def progress_gilda_sweep2(ci: State) -> None:
    """Note what goal gilda_sweep2 (Track) has to remember, once a tick before its check.

    Members: gilda.
    """
    # protected region gilda_sweep2.progress on begin
    goal_tasks.track.progress(ci, GILDA_SWEEP2)
    # protected region gilda_sweep2.progress end


@kernel
def check_gilda_sweep2(ci: State) -> bool:
    """Return whether goal gilda_sweep2 (Track) is violated now.

    Members: gilda.
    """
    # protected region gilda_sweep2.check on begin
    return goal_tasks.track.violated(ci, GILDA_SWEEP2)
    # protected region gilda_sweep2.check end


@kernel
def react_gilda_sweep2(ci: State) -> None:
    """Command the members of goal gilda_sweep2 (Track).

    Members: gilda.
    """
    # protected region gilda_sweep2.react on begin
    goal_tasks.track.react(ci, GILDA_SWEEP2)
    # protected region gilda_sweep2.react end


@kernel
def progress_henry_sweep1(ci: State) -> None:
    """Note what goal henry_sweep1 (Track) has to remember, once a tick before its check.

    Members: henry.
    """
    # protected region henry_sweep1.progress on begin
    goal_tasks.track.progress(ci, HENRY_SWEEP1)
    # protected region henry_sweep1.progress end


@kernel
def check_henry_sweep1(ci: State) -> bool:
    """Return whether goal henry_sweep1 (Track) is violated now.

    Members: henry.
    """
    # protected region henry_sweep1.check on begin
    return goal_tasks.track.violated(ci, HENRY_SWEEP1)
    # protected region henry_sweep1.check end


@kernel
def react_henry_sweep1(ci: State) -> None:
    """Command the members of goal henry_sweep1 (Track).

    Members: henry.
    """
    # protected region henry_sweep1.react on begin
    goal_tasks.track.react(ci, HENRY_SWEEP1)
    # protected region henry_sweep1.react end


@kernel
def progress_henry_sweep2(ci: State) -> None:
    """Note what goal henry_sweep2 (Track) has to remember, once a tick before its check.

    Members: henry.
    """
    # protected region henry_sweep2.progress on begin
    goal_tasks.track.progress(ci, HENRY_SWEEP2)
    # protected region henry_sweep2.progress end


@kernel
def check_henry_sweep2(ci: State) -> bool:
    """Return whether goal henry_sweep2 (Track) is violated now.

    Members: henry.
    """
    # protected region henry_sweep2.check on begin
    return goal_tasks.track.violated(ci, HENRY_SWEEP2)
    # protected region henry_sweep2.check end


@kernel
def react_henry_sweep2(ci: State) -> None:
    """Command the members of goal henry_sweep2 (Track).

    Members: henry.
    """
    # protected region henry_sweep2.react on begin
    goal_tasks.track.react(ci, HENRY_SWEEP2)
    # protected region henry_sweep2.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_gilda_sweep1(view)
    progress_gilda_sweep2(view)
    progress_henry_sweep1(view)
    progress_henry_sweep2(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[MUTUALAVOIDANCE] = 1 if check_mutualavoidance(view) else 0
    violated[WITHIN] = 1 if check_within(view) else 0
    violated[RETURNONLOWENERGY] = 1 if check_returnonlowenergy(view) else 0
    violated[GILDA_SWEEP1] = 1 if check_gilda_sweep1(view) else 0
    violated[GILDA_SWEEP2] = 1 if check_gilda_sweep2(view) else 0
    violated[HENRY_SWEEP1] = 1 if check_henry_sweep1(view) else 0
    violated[HENRY_SWEEP2] = 1 if check_henry_sweep2(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_mutualavoidance(ci)
    react_within(ci)
    react_returnonlowenergy(ci)
    react_gilda_sweep1(ci)
    react_gilda_sweep2(ci)
    react_henry_sweep1(ci)
    react_henry_sweep2(ci)
