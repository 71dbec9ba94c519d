# Generated from mission atlas_search by collective_intelligence.py.j2.
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
STAYINREGION = 1
SWEEP_FRANK = 2
SWEEP_HENRY = 3
SWEEP_ELLA = 4
SWEEP_GILDA = 5
OBJECT1 = 6
OBJECT3 = 7
OBJECT2 = 8
FRANK = 0  # frank
HENRY = 1  # henry
ELLA = 2  # ella
GILDA = 3  # gilda
FRANK_GPS = 0
HENRY_GPS = 1
ELLA_GPS = 2
GILDA_GPS = 3


# protected region helpers on begin
# protected region helpers end


@kernel
def check_mutualavoidance(ci: State) -> bool:
    """Return whether goal mutualavoidance (AvoidCollision) is violated now.

    Members: frank, henry, ella, gilda.
    """
    # protected region mutualavoidance.check on begin
    return goal_tasks.avoid_collision.violated(ci, MUTUALAVOIDANCE)
    # protected region mutualavoidance.check end


@kernel
def react_mutualavoidance(ci: State) -> None:
    """Command the members of goal mutualavoidance (AvoidCollision).

    Members: frank, henry, ella, gilda.
    """
    # protected region mutualavoidance.react on begin
    goal_tasks.avoid_collision.react(ci, MUTUALAVOIDANCE)
    # protected region mutualavoidance.react end


@kernel
def check_stayinregion(ci: State) -> bool:
    """Return whether goal stayinregion (StayWithinMissionArea) is violated now.

    Members: frank, henry, ella, gilda.
    """
    # protected region stayinregion.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, STAYINREGION)
    # protected region stayinregion.check end


@kernel
def react_stayinregion(ci: State) -> None:
    """Command the members of goal stayinregion (StayWithinMissionArea).

    Members: frank, henry, ella, gilda.
    """
    # protected region stayinregion.react on begin
    goal_tasks.stay_within_mission_area.react(ci, STAYINREGION)
    # protected region stayinregion.react end


@kernel
def progress_sweep_frank(ci: State) -> None:
    """Note what goal sweep_frank (Track) has to remember, once a tick before its check.

    Members: frank.
    """
    # protected region sweep_frank.progress on begin
    goal_tasks.track.progress(ci, SWEEP_FRANK)
    # protected region sweep_frank.progress end


@kernel
def check_sweep_frank(ci: State) -> bool:
    """Return whether goal sweep_frank (Track) is violated now.

    Members: frank.
    """
    # protected region sweep_frank.check on begin
    return goal_tasks.track.violated(ci, SWEEP_FRANK)
    # protected region sweep_frank.check end


@kernel
def react_sweep_frank(ci: State) -> None:
    """Command the members of goal sweep_frank (Track).

    Members: frank.
    """
    # protected region sweep_frank.react on begin
    goal_tasks.track.react(ci, SWEEP_FRANK)
    # protected region sweep_frank.react end


@kernel
def progress_sweep_henry(ci: State) -> None:
    """Note what goal sweep_henry (Track) has to remember, once a tick before its check.

    Members: henry.
    """
    # protected region sweep_henry.progress on begin
    goal_tasks.track.progress(ci, SWEEP_HENRY)
    # protected region sweep_henry.progress end


@kernel
def check_sweep_henry(ci: State) -> bool:
    """Return whether goal sweep_henry (Track) is violated now.

    Members: henry.
    """
    # protected region sweep_henry.check on begin
    return goal_tasks.track.violated(ci, SWEEP_HENRY)
    # protected region sweep_henry.check end


@kernel
def react_sweep_henry(ci: State) -> None:
    """Command the members of goal sweep_henry (Track).

    Members: henry.
    """
    # protected region sweep_henry.react on begin
    goal_tasks.track.react(ci, SWEEP_HENRY)
    # protected region sweep_henry.react end


@kernel
def progress_sweep_ella(ci: State) -> None:
    """Note what goal sweep_ella (Track) has to remember, once a tick before its check.

    Members: ella.
    """
    # protected region sweep_ella.progress on begin
    goal_tasks.track.progress(ci, SWEEP_ELLA)
    # protected region sweep_ella.progress end


@kernel
def check_sweep_ella(ci: State) -> bool:
    """Return whether goal sweep_ella (Track) is violated now.

    Members: ella.
    """
    # protected region sweep_ella.check on begin
    return goal_tasks.track.violated(ci, SWEEP_ELLA)
    # protected region sweep_ella.check end


@kernel
def react_sweep_ella(ci: State) -> None:
    """Command the members of goal sweep_ella (Track).

    Members: ella.
    """
    # protected region sweep_ella.react on begin
    goal_tasks.track.react(ci, SWEEP_ELLA)
    # protected region sweep_ella.react end


@kernel
def progress_sweep_gilda(ci: State) -> None:
    """Note what goal sweep_gilda (Track) has to remember, once a tick before its check.

    Members: gilda.
    """
    # protected region sweep_gilda.progress on begin
    goal_tasks.track.progress(ci, SWEEP_GILDA)
    # protected region sweep_gilda.progress end


@kernel
def check_sweep_gilda(ci: State) -> bool:
    """Return whether goal sweep_gilda (Track) is violated now.

    Members: gilda.
    """
    # protected region sweep_gilda.check on begin
    return goal_tasks.track.violated(ci, SWEEP_GILDA)
    # protected region sweep_gilda.check end


@kernel
def react_sweep_gilda(ci: State) -> None:
    """Command the members of goal sweep_gilda (Track).

    Members: gilda.
    """
    # protected region sweep_gilda.react on begin
    goal_tasks.track.react(ci, SWEEP_GILDA)
    # protected region sweep_gilda.react end


@kernel
def progress_object1(ci: State) -> None:
    """Note what goal object1 (Visit) has to remember, once a tick before its check.

    Members: frank, henry.
    """
    # protected region object1.progress on begin
    goal_tasks.visit.progress(ci, OBJECT1)
    # protected region object1.progress end


@kernel
def check_object1(ci: State) -> bool:
    """Return whether goal object1 (Visit) is violated now.

    Members: frank, henry.
    """
    # protected region object1.check on begin
    return goal_tasks.visit.violated(ci, OBJECT1)
    # protected region object1.check end


@kernel
def react_object1(ci: State) -> None:
    """Command the members of goal object1 (Visit).

    Members: frank, henry.
    """
    # protected region object1.react on begin
    goal_tasks.visit.react(ci, OBJECT1)
    # protected region object1.react end


@kernel
def progress_object3(ci: State) -> None:
    """Note what goal object3 (Visit) has to remember, once a tick before its check.

    Members: ella, henry.
    """
    # protected region object3.progress on begin
    goal_tasks.visit.progress(ci, OBJECT3)
    # protected region object3.progress end


@kernel
def check_object3(ci: State) -> bool:
    """Return whether goal object3 (Visit) is violated now.

    Members: ella, henry.
    """
    # protected region object3.check on begin
    return goal_tasks.visit.violated(ci, OBJECT3)
    # protected region object3.check end


@kernel
def react_object3(ci: State) -> None:
    """Command the members of goal object3 (Visit).

    Members: ella, henry.
    """
    # protected region object3.react on begin
    goal_tasks.visit.react(ci, OBJECT3)
    # protected region object3.react end


@kernel
def progress_object2(ci: State) -> None:
    """Note what goal object2 (Visit) has to remember, once a tick before its check.

    Members: gilda, ella, frank.
    """
    # protected region object2.progress on begin
    goal_tasks.visit.progress(ci, OBJECT2)
    # protected region object2.progress end


@kernel
def check_object2(ci: State) -> bool:
    """Return whether goal object2 (Visit) is violated now.

    Members: gilda, ella, frank.
    """
    # protected region object2.check on begin
    return goal_tasks.visit.violated(ci, OBJECT2)
    # protected region object2.check end


@kernel
def react_object2(ci: State) -> None:
    """Command the members of goal object2 (Visit).

    Members: gilda, ella, frank.
    """
    # protected region object2.react on begin
    goal_tasks.visit.react(ci, OBJECT2)
    # protected region object2.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_sweep_frank(view)
    progress_sweep_henry(view)
    progress_sweep_ella(view)
    progress_sweep_gilda(view)
    progress_object1(view)
    progress_object3(view)
    progress_object2(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[MUTUALAVOIDANCE] = 1 if check_mutualavoidance(view) else 0
    violated[STAYINREGION] = 1 if check_stayinregion(view) else 0
    violated[SWEEP_FRANK] = 1 if check_sweep_frank(view) else 0
    violated[SWEEP_HENRY] = 1 if check_sweep_henry(view) else 0
    violated[SWEEP_ELLA] = 1 if check_sweep_ella(view) else 0
    violated[SWEEP_GILDA] = 1 if check_sweep_gilda(view) else 0
    violated[OBJECT1] = 1 if check_object1(view) else 0
    violated[OBJECT3] = 1 if check_object3(view) else 0
    violated[OBJECT2] = 1 if check_object2(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_mutualavoidance(ci)
    react_stayinregion(ci)
    react_sweep_frank(ci)
    react_sweep_henry(ci)
    react_sweep_ella(ci)
    react_sweep_gilda(ci)
    react_object1(ci)
    react_object3(ci)
    react_object2(ci)
