# Generated from mission tight_margins by collective_intelligence.py.j2.
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
DEPTHS = 3
PRESSURES = 4
BUOY = 5
MOOR = 6
P1 = 0  # ANN
P2 = 1  # BEA
P3 = 2  # CAY
P1_GPS = 0
P1_DEPTH = 1
P2_GPS = 2
P2_PRESSURE = 3
P3_GPS = 4
P3_TEMPERATURE = 5
ROCK = 0


# protected region helpers on begin
# protected region helpers end


@kernel
def check_clear(ci: State) -> bool:
    """Return whether goal clear (AvoidCollision) is violated now.

    Members: p1, p2, p3.
    """
    # protected region clear.check on begin
    return goal_tasks.avoid_collision.violated(ci, CLEAR)
    # protected region clear.check end


@kernel
def react_clear(ci: State) -> None:
    """Command the members of goal clear (AvoidCollision).

    Members: p1, p2, p3.
    """
    # protected region clear.react on begin
    goal_tasks.avoid_collision.react(ci, CLEAR)
    # protected region clear.react end


@kernel
def check_within(ci: State) -> bool:
    """Return whether goal within (StayWithinMissionArea) is violated now.

    Members: p1, p2, p3.
    """
    # protected region within.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, WITHIN)
    # protected region within.check end


@kernel
def react_within(ci: State) -> None:
    """Command the members of goal within (StayWithinMissionArea).

    Members: p1, p2, p3.
    """
    # protected region within.react on begin
    goal_tasks.stay_within_mission_area.react(ci, WITHIN)
    # protected region within.react end


@kernel
def check_energy(ci: State) -> bool:
    """Return whether goal energy (SufficientEnergy) is violated now.

    Members: p1, p2.
    """
    # protected region energy.check on begin
    return goal_tasks.sufficient_energy.violated(ci, ENERGY)
    # protected region energy.check end


@kernel
def react_energy(ci: State) -> None:
    """Command the members of goal energy (SufficientEnergy).

    Members: p1, p2.
    """
    # protected region energy.react on begin
    # Hurry: up to half as fast again, as long as two per cent of the energy stay in reserve.
    left = max(forecast.ticks_left(ci), 1)
    for index in (P1, P2):
        robot = ci.robots[index]
        spare = 0.98 * robot.energy / left - forecast.sensor_power(ci, index)
        affordable = max(spare / robot.energy_per_distance, 0.0)
        wanted = min(1.5 * robot.nominal_speed, affordable)
        commands.set_speed(ci, index, ci.commands[index].sent_speed + wanted - robot.speed)
    # protected region energy.react end


@kernel
def progress_depths(ci: State) -> None:
    """Note what goal depths (GatherSamples) has to remember, once a tick before its check.

    Members: p1.
    """
    # protected region depths.progress on begin
    goal_tasks.gather_samples.progress(ci, DEPTHS)
    # protected region depths.progress end


@kernel
def check_depths(ci: State) -> bool:
    """Return whether goal depths (GatherSamples) is violated now.

    Members: p1.
    """
    # protected region depths.check on begin
    return goal_tasks.gather_samples.violated(ci, DEPTHS)
    # protected region depths.check end


@kernel
def react_depths(ci: State) -> None:
    """Command the members of goal depths (GatherSamples).

    Members: p1.
    """
    # protected region depths.react on begin
    goal_tasks.gather_samples.react(ci, DEPTHS)
    # protected region depths.react end


@kernel
def progress_pressures(ci: State) -> None:
    """Note what goal pressures (GatherSamples) has to remember, once a tick before its check.

    Members: p2.
    """
    # protected region pressures.progress on begin
    goal_tasks.gather_samples.progress(ci, PRESSURES)
    # protected region pressures.progress end


@kernel
def check_pressures(ci: State) -> bool:
    """Return whether goal pressures (GatherSamples) is violated now.

    Members: p2.
    """
    # protected region pressures.check on begin
    return goal_tasks.gather_samples.violated(ci, PRESSURES)
    # protected region pressures.check end


@kernel
def react_pressures(ci: State) -> None:
    """Command the members of goal pressures (GatherSamples).

    Members: p2.
    """
    # protected region pressures.react on begin
    goal_tasks.gather_samples.react(ci, PRESSURES)
    # protected region pressures.react end


@kernel
def progress_buoy(ci: State) -> None:
    """Note what goal buoy (Visit) has to remember, once a tick before its check.

    Members: p3.
    """
    # protected region buoy.progress on begin
    goal_tasks.visit.progress(ci, BUOY)
    # protected region buoy.progress end


@kernel
def check_buoy(ci: State) -> bool:
    """Return whether goal buoy (Visit) is violated now.

    Members: p3.
    """
    # protected region buoy.check on begin
    return goal_tasks.visit.violated(ci, BUOY)
    # protected region buoy.check end


@kernel
def react_buoy(ci: State) -> None:
    """Command the members of goal buoy (Visit).

    Members: p3.
    """
    # protected region buoy.react on begin
    goal_tasks.visit.react(ci, BUOY)
    # protected region buoy.react end


@kernel
def progress_moor(ci: State) -> None:
    """Note what goal moor (Stay) has to remember, once a tick before its check.

    Members: p3.
    """
    # protected region moor.progress on begin
    goal_tasks.stay.progress(ci, MOOR)
    # protected region moor.progress end


@kernel
def check_moor(ci: State) -> bool:
    """Return whether goal moor (Stay) is violated now.

    Members: p3.
    """
    # protected region moor.check on begin
    return goal_tasks.stay.violated(ci, MOOR)
    # protected region moor.check end


@kernel
def react_moor(ci: State) -> None:
    """Command the members of goal moor (Stay).

    Members: p3.
    """
    # protected region moor.react on begin
    goal_tasks.stay.react(ci, MOOR)
    # protected region moor.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_depths(view)
    progress_pressures(view)
    progress_buoy(view)
    progress_moor(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[CLEAR] = 1 if check_clear(view) else 0
    violated[WITHIN] = 1 if check_within(view) else 0
    violated[ENERGY] = 1 if check_energy(view) else 0
    violated[DEPTHS] = 1 if check_depths(view) else 0
    violated[PRESSURES] = 1 if check_pressures(view) else 0
    violated[BUOY] = 1 if check_buoy(view) else 0
    violated[MOOR] = 1 if check_moor(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_clear(ci)
    react_within(ci)
    react_energy(ci)
    react_depths(ci)
    react_pressures(ci)
    react_buoy(ci)
    react_moor(ci)
