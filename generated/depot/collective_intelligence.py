# Generated from mission depot by collective_intelligence.py.j2.
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
HANDOVER = 2
ENERGY = 3
ROUND_ADA = 4
ROUND_BEN = 5
ROUND_CLEO = 6
TEMPERATURES = 7
STORE = 8
ADA = 0  # Ada
BEN = 1  # Ben
CLEO = 2  # Cleo
DAN = 3  # Dan
ADA_POSITIONING = 0
BEN_POSITIONING = 1
CLEO_POSITIONING = 2
DAN_POSITIONING = 3
DAN_THERMOMETER = 4
RACK_NORTH = 0
RACK_SOUTH = 1
DOCK_WALL = 2
PILLAR_WEST = 3
PILLAR_EAST = 4


# protected region helpers on begin
# protected region helpers end


@kernel
def check_clear(ci: State) -> bool:
    """Return whether goal clear (AvoidCollision) is violated now.

    Members: ada, ben, cleo, dan.
    """
    # protected region clear.check on begin
    return goal_tasks.avoid_collision.violated(ci, CLEAR)
    # protected region clear.check end


@kernel
def react_clear(ci: State) -> None:
    """Command the members of goal clear (AvoidCollision).

    Members: ada, ben, cleo, dan.
    """
    # protected region clear.react on begin
    goal_tasks.avoid_collision.react(ci, CLEAR)
    # protected region clear.react end


@kernel
def check_within(ci: State) -> bool:
    """Return whether goal within (StayWithinMissionArea) is violated now.

    Members: ada, ben, cleo, dan.
    """
    # protected region within.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, WITHIN)
    # protected region within.check end


@kernel
def react_within(ci: State) -> None:
    """Command the members of goal within (StayWithinMissionArea).

    Members: ada, ben, cleo, dan.
    """
    # protected region within.react on begin
    goal_tasks.stay_within_mission_area.react(ci, WITHIN)
    # protected region within.react end


@kernel
def progress_handover(ci: State) -> None:
    """Note what goal handover (Visit) has to remember, once a tick before its check.

    Members: cleo.
    """
    # protected region handover.progress on begin
    goal_tasks.visit.progress(ci, HANDOVER)
    # protected region handover.progress end


@kernel
def check_handover(ci: State) -> bool:
    """Return whether goal handover (Visit) is violated now.

    Members: cleo.
    """
    # protected region handover.check on begin
    return goal_tasks.visit.violated(ci, HANDOVER)
    # protected region handover.check end


@kernel
def react_handover(ci: State) -> None:
    """Command the members of goal handover (Visit).

    Members: cleo.
    """
    # protected region handover.react on begin
    goal_tasks.visit.react(ci, HANDOVER)
    # protected region handover.react end


@kernel
def check_energy(ci: State) -> bool:
    """Return whether goal energy (SufficientEnergy) is violated now.

    Members: ada, ben, cleo, dan.
    """
    # protected region energy.check on begin
    return goal_tasks.sufficient_energy.violated(ci, ENERGY)
    # protected region energy.check end


@kernel
def react_energy(ci: State) -> None:
    """Command the members of goal energy (SufficientEnergy).

    Members: ada, ben, cleo, dan.
    """
    # protected region energy.react on begin
    goal_tasks.sufficient_energy.react(ci, ENERGY)
    # protected region energy.react end


@kernel
def progress_round_ada(ci: State) -> None:
    """Note what goal round_ada (Patrol) has to remember, once a tick before its check.

    Members: ada.
    """
    # protected region round_ada.progress on begin
    goal_tasks.patrol.progress(ci, ROUND_ADA)
    # protected region round_ada.progress end


@kernel
def check_round_ada(ci: State) -> bool:
    """Return whether goal round_ada (Patrol) is violated now.

    Members: ada.
    """
    # protected region round_ada.check on begin
    return goal_tasks.patrol.violated(ci, ROUND_ADA)
    # protected region round_ada.check end


@kernel
def react_round_ada(ci: State) -> None:
    """Command the members of goal round_ada (Patrol).

    Members: ada.
    """
    # protected region round_ada.react on begin
    goal_tasks.patrol.react(ci, ROUND_ADA)
    # protected region round_ada.react end


@kernel
def progress_round_ben(ci: State) -> None:
    """Note what goal round_ben (Patrol) has to remember, once a tick before its check.

    Members: ben.
    """
    # protected region round_ben.progress on begin
    goal_tasks.patrol.progress(ci, ROUND_BEN)
    # protected region round_ben.progress end


@kernel
def check_round_ben(ci: State) -> bool:
    """Return whether goal round_ben (Patrol) is violated now.

    Members: ben.
    """
    # protected region round_ben.check on begin
    return goal_tasks.patrol.violated(ci, ROUND_BEN)
    # protected region round_ben.check end


@kernel
def react_round_ben(ci: State) -> None:
    """Command the members of goal round_ben (Patrol).

    Members: ben.
    """
    # protected region round_ben.react on begin
    goal_tasks.patrol.react(ci, ROUND_BEN)
    # protected region round_ben.react end


@kernel
def progress_round_cleo(ci: State) -> None:
    """Note what goal round_cleo (Patrol) has to remember, once a tick before its check.

    Members: cleo.
    """
    # protected region round_cleo.progress on begin
    goal_tasks.patrol.progress(ci, ROUND_CLEO)
    # protected region round_cleo.progress end


@kernel
def check_round_cleo(ci: State) -> bool:
    """Return whether goal round_cleo (Patrol) is violated now.

    Members: cleo.
    """
    # protected region round_cleo.check on begin
    return goal_tasks.patrol.violated(ci, ROUND_CLEO)
    # protected region round_cleo.check end


@kernel
def react_round_cleo(ci: State) -> None:
    """Command the members of goal round_cleo (Patrol).

    Members: cleo.
    """
    # protected region round_cleo.react on begin
    goal_tasks.patrol.react(ci, ROUND_CLEO)
    # protected region round_cleo.react end


@kernel
def progress_temperatures(ci: State) -> None:
    """Note what goal temperatures (GatherSamples) has to remember, once a tick before its check.

    Members: dan.
    """
    # protected region temperatures.progress on begin
    goal_tasks.gather_samples.progress(ci, TEMPERATURES)
    # protected region temperatures.progress end


@kernel
def check_temperatures(ci: State) -> bool:
    """Return whether goal temperatures (GatherSamples) is violated now.

    Members: dan.
    """
    # protected region temperatures.check on begin
    return goal_tasks.gather_samples.violated(ci, TEMPERATURES)
    # protected region temperatures.check end


@kernel
def react_temperatures(ci: State) -> None:
    """Command the members of goal temperatures (GatherSamples).

    Members: dan.
    """
    # protected region temperatures.react on begin
    goal_tasks.gather_samples.react(ci, TEMPERATURES)
    # protected region temperatures.react end


@kernel
def progress_store(ci: State) -> None:
    """Note what goal store (Stay) has to remember, once a tick before its check.

    Members: dan.
    """
    # protected region store.progress on begin
    goal_tasks.stay.progress(ci, STORE)
    # protected region store.progress end


@kernel
def check_store(ci: State) -> bool:
    """Return whether goal store (Stay) is violated now.

    Members: dan.
    """
    # protected region store.check on begin
    return goal_tasks.stay.violated(ci, STORE)
    # protected region store.check end


@kernel
def react_store(ci: State) -> None:
    """Command the members of goal store (Stay).

    Members: dan.
    """
    # protected region store.react on begin
    goal_tasks.stay.react(ci, STORE)
    # protected region store.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_handover(view)
    progress_round_ada(view)
    progress_round_ben(view)
    progress_round_cleo(view)
    progress_temperatures(view)
    progress_store(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[CLEAR] = 1 if check_clear(view) else 0
    violated[WITHIN] = 1 if check_within(view) else 0
    violated[HANDOVER] = 1 if check_handover(view) else 0
    violated[ENERGY] = 1 if check_energy(view) else 0
    violated[ROUND_ADA] = 1 if check_round_ada(view) else 0
    violated[ROUND_BEN] = 1 if check_round_ben(view) else 0
    violated[ROUND_CLEO] = 1 if check_round_cleo(view) else 0
    violated[TEMPERATURES] = 1 if check_temperatures(view) else 0
    violated[STORE] = 1 if check_store(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_clear(ci)
    react_within(ci)
    react_handover(ci)
    react_energy(ci)
    react_round_ada(ci)
    react_round_ben(ci)
    react_round_cleo(ci)
    react_temperatures(ci)
    react_store(ci)
