# Generated from mission tight_energy by collective_intelligence.py.j2.
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

CLEAR = 0
WITHIN = 1
ENERGY = 2
TEMPERATURES = 3
DEPTHS = 4
ROUNDS = 5
E1 = 0  # ADA
E2 = 1  # BOB
E3 = 2  # CEM
E1_GPS_POSITION = 0
E1_TEMPERATURE = 1
E2_GPS_POSITION = 2
E2_DEPTH = 3
E3_GPS_POSITION = 4
E3_PRESSURE = 5
REEF = 0
WRECK = 1


# protected region helpers on begin
# protected region helpers end


@kernel
def check_clear(ci: State) -> bool:
    """Return whether goal clear (AvoidCollision) is violated now.

    Members: e1, e2, e3.
    """
    # protected region clear.check on begin
    return goal_tasks.avoid_collision.violated(ci, CLEAR)
    # protected region clear.check end


@kernel
def react_clear(ci: State) -> None:
    """Command the members of goal clear (AvoidCollision).

    Members: e1, e2, e3.
    """
    # protected region clear.react on begin
    goal_tasks.avoid_collision.react(ci, CLEAR)
    # protected region clear.react end


@kernel
def check_within(ci: State) -> bool:
    """Return whether goal within (StayWithinMissionArea) is violated now.

    Members: e1, e2, e3.
    """
    # protected region within.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, WITHIN)
    # protected region within.check end


@kernel
def react_within(ci: State) -> None:
    """Command the members of goal within (StayWithinMissionArea).

    Members: e1, e2, e3.
    """
    # protected region within.react on begin
    goal_tasks.stay_within_mission_area.react(ci, WITHIN)
    # protected region within.react end


@kernel
def check_energy(ci: State) -> bool:
    """Return whether goal energy (SufficientEnergy) is violated now.

    Members: e1, e2, e3.
    """
    # protected region energy.check on begin
    return goal_tasks.sufficient_energy.violated(ci, ENERGY)
    # protected region energy.check end


@kernel
def react_energy(ci: State) -> None:
    """Command the members of goal energy (SufficientEnergy).

    Members: e1, e2, e3.
    """
    # protected region energy.react on begin
    goal_tasks.sufficient_energy.react(ci, ENERGY)
    # protected region energy.react end


@kernel
def progress_temperatures(ci: State) -> None:
    """Note what goal temperatures (GatherSamples) has to remember, once a tick before its check.

    Members: e1.
    """
    # protected region temperatures.progress on begin
    goal_tasks.gather_samples.progress(ci, TEMPERATURES)
    # protected region temperatures.progress end


@kernel
def check_temperatures(ci: State) -> bool:
    """Return whether goal temperatures (GatherSamples) is violated now.

    Members: e1.
    """
    # protected region temperatures.check on begin
    return goal_tasks.gather_samples.violated(ci, TEMPERATURES)
    # protected region temperatures.check end


@kernel
def react_temperatures(ci: State) -> None:
    """Command the members of goal temperatures (GatherSamples).

    Members: e1.
    """
    # protected region temperatures.react on begin
    goal_tasks.gather_samples.react(ci, TEMPERATURES)
    # protected region temperatures.react end


@kernel
def progress_depths(ci: State) -> None:
    """Note what goal depths (GatherSamples) has to remember, once a tick before its check.

    Members: e2.
    """
    # protected region depths.progress on begin
    goal_tasks.gather_samples.progress(ci, DEPTHS)
    # protected region depths.progress end


@kernel
def check_depths(ci: State) -> bool:
    """Return whether goal depths (GatherSamples) is violated now.

    Members: e2.
    """
    # protected region depths.check on begin
    return goal_tasks.gather_samples.violated(ci, DEPTHS)
    # protected region depths.check end


@kernel
def react_depths(ci: State) -> None:
    """Command the members of goal depths (GatherSamples).

    Members: e2.
    """
    # protected region depths.react on begin
    goal_tasks.gather_samples.react(ci, DEPTHS)
    # protected region depths.react end


@kernel
def progress_rounds(ci: State) -> None:
    """Note what goal rounds (Patrol) has to remember, once a tick before its check.

    Members: e3.
    """
    # protected region rounds.progress on begin
    goal_tasks.patrol.progress(ci, ROUNDS)
    # protected region rounds.progress end


@kernel
def check_rounds(ci: State) -> bool:
    """Return whether goal rounds (Patrol) is violated now.

    Members: e3.
    """
    # protected region rounds.check on begin
    return goal_tasks.patrol.violated(ci, ROUNDS)
    # protected region rounds.check end


@kernel
def react_rounds(ci: State) -> None:
    """Command the members of goal rounds (Patrol).

    Members: e3.
    """
    # protected region rounds.react on begin
    goal_tasks.patrol.react(ci, ROUNDS)
    # protected region rounds.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_temperatures(view)
    progress_depths(view)
    progress_rounds(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[CLEAR] = 1 if check_clear(view) else 0
    violated[WITHIN] = 1 if check_within(view) else 0
    violated[ENERGY] = 1 if check_energy(view) else 0
    violated[TEMPERATURES] = 1 if check_temperatures(view) else 0
    violated[DEPTHS] = 1 if check_depths(view) else 0
    violated[ROUNDS] = 1 if check_rounds(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_clear(ci)
    react_within(ci)
    react_energy(ci)
    react_temperatures(ci)
    react_depths(ci)
    react_rounds(ci)
