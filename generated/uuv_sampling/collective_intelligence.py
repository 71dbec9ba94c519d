# Generated from mission uuv_sampling by collective_intelligence.py.j2.
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

G1 = 0
G2 = 1
G3 = 2
G4 = 3
G5 = 4
G6 = 5
R1 = 0  # LEN
R2 = 1  # JEN
R3 = 2  # KAL
S1 = 0
S2 = 1
S3 = 2
S4 = 3
S5 = 4
S6 = 5
O1 = 0
O2 = 1
O3 = 2
O4 = 3
O5 = 4
O6 = 5
O7 = 6
O8 = 7


# protected region helpers on begin
# protected region helpers end


@kernel
def check_g1(ci: State) -> bool:
    """Return whether goal g1 (AvoidCollision) is violated now.

    Members: r2, r3, r1.
    """
    # protected region g1.check on begin
    return goal_tasks.avoid_collision.violated(ci, G1)
    # protected region g1.check end


@kernel
def react_g1(ci: State) -> None:
    """Command the members of goal g1 (AvoidCollision).

    Members: r2, r3, r1.
    """
    # protected region g1.react on begin
    goal_tasks.avoid_collision.react(ci, G1)
    # protected region g1.react end


@kernel
def check_g2(ci: State) -> bool:
    """Return whether goal g2 (StayWithinMissionArea) is violated now.

    Members: r2, r3, r1.
    """
    # protected region g2.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, G2)
    # protected region g2.check end


@kernel
def react_g2(ci: State) -> None:
    """Command the members of goal g2 (StayWithinMissionArea).

    Members: r2, r3, r1.
    """
    # protected region g2.react on begin
    goal_tasks.stay_within_mission_area.react(ci, G2)
    # protected region g2.react end


@kernel
def check_g3(ci: State) -> bool:
    """Return whether goal g3 (SufficientEnergy) is violated now.

    Members: r2, r3, r1.
    """
    # protected region g3.check on begin
    return goal_tasks.sufficient_energy.violated(ci, G3)
    # protected region g3.check end


@kernel
def react_g3(ci: State) -> None:
    """Command the members of goal g3 (SufficientEnergy).

    Members: r2, r3, r1.
    """
    # protected region g3.react on begin
    goal_tasks.sufficient_energy.react(ci, G3)
    # protected region g3.react end


@kernel
def progress_g4(ci: State) -> None:
    """Note what goal g4 (GatherSamples) has to remember, once a tick before its check.

    Members: r2.
    """
    # protected region g4.progress on begin
    goal_tasks.gather_samples.progress(ci, G4)
    # protected region g4.progress end


@kernel
def check_g4(ci: State) -> bool:
    """Return whether goal g4 (GatherSamples) is violated now.

    Members: r2.
    """
    # protected region g4.check on begin
    return goal_tasks.gather_samples.violated(ci, G4)
    # protected region g4.check end


@kernel
def react_g4(ci: State) -> None:
    """Command the members of goal g4 (GatherSamples).

    Members: r2.
    """
    # protected region g4.react on begin
    goal_tasks.gather_samples.react(ci, G4)
    # protected region g4.react end


@kernel
def progress_g5(ci: State) -> None:
    """Note what goal g5 (GatherSamples) has to remember, once a tick before its check.

    Members: r3.
    """
    # protected region g5.progress on begin
    goal_tasks.gather_samples.progress(ci, G5)
    # protected region g5.progress end


@kernel
def check_g5(ci: State) -> bool:
    """Return whether goal g5 (GatherSamples) is violated now.

    Members: r3.
    """
    # protected region g5.check on begin
    return goal_tasks.gather_samples.violated(ci, G5)
    # protected region g5.check end


@kernel
def react_g5(ci: State) -> None:
    """Command the members of goal g5 (GatherSamples).

    Members: r3.
    """
    # protected region g5.react on begin
    goal_tasks.gather_samples.react(ci, G5)
    # protected region g5.react end


@kernel
def progress_g6(ci: State) -> None:
    """Note what goal g6 (GatherSamples) has to remember, once a tick before its check.

    Members: r1.
    """
    # protected region g6.progress on begin
    goal_tasks.gather_samples.progress(ci, G6)
    # protected region g6.progress end


@kernel
def check_g6(ci: State) -> bool:
    """Return whether goal g6 (GatherSamples) is violated now.

    Members: r1.
    """
    # protected region g6.check on begin
    return goal_tasks.gather_samples.violated(ci, G6)
    # protected region g6.check end


@kernel
def react_g6(ci: State) -> None:
    """Command the members of goal g6 (GatherSamples).

    Members: r1.
    """
    # protected region g6.react on begin
    goal_tasks.gather_samples.react(ci, G6)
    # protected region g6.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_g4(view)
    progress_g5(view)
    progress_g6(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[G1] = 1 if check_g1(view) else 0
    violated[G2] = 1 if check_g2(view) else 0
    violated[G3] = 1 if check_g3(view) else 0
    violated[G4] = 1 if check_g4(view) else 0
    violated[G5] = 1 if check_g5(view) else 0
    violated[G6] = 1 if check_g6(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_g1(ci)
    react_g2(ci)
    react_g3(ci)
    react_g4(ci)
    react_g5(ci)
    react_g6(ci)
