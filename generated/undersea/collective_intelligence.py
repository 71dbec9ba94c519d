# Generated from mission undersea by collective_intelligence.py.j2.
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

SURVEY = 0
R2 = 1
R1_TEMPERATURES = 2
R1_PRESSURES = 3
R1_DEPTHS = 4
NAUTILUS = 0  # nautilus
SENSOR1 = 0
SENSOR2 = 1
SENSOR3 = 2


# protected region helpers on begin
# protected region helpers end


@kernel
def progress_survey(ci: State) -> None:
    """Note what goal survey (Track) has to remember, once a tick before its check.

    Members: nautilus.
    """
    # protected region survey.progress on begin
    goal_tasks.track.progress(ci, SURVEY)
    # protected region survey.progress end


@kernel
def check_survey(ci: State) -> bool:
    """Return whether goal survey (Track) is violated now.

    Members: nautilus.
    """
    # protected region survey.check on begin
    return goal_tasks.track.violated(ci, SURVEY)
    # protected region survey.check end


@kernel
def react_survey(ci: State) -> None:
    """Command the members of goal survey (Track).

    Members: nautilus.
    """
    # protected region survey.react on begin
    goal_tasks.track.react(ci, SURVEY)
    # protected region survey.react end


@kernel
def check_r2(ci: State) -> bool:
    """Return whether goal r2 (SufficientEnergy) is violated now.

    Members: nautilus.
    """
    # protected region r2.check on begin
    return goal_tasks.sufficient_energy.violated(ci, R2)
    # protected region r2.check end


@kernel
def react_r2(ci: State) -> None:
    """Command the members of goal r2 (SufficientEnergy).

    Members: nautilus.
    """
    # protected region r2.react on begin
    goal_tasks.sufficient_energy.react(ci, R2)
    # protected region r2.react end


@kernel
def progress_r1_temperatures(ci: State) -> None:
    """Note what goal r1_temperatures (GatherSamples) has to remember, once a tick before its check.

    Members: nautilus.
    """
    # protected region r1_temperatures.progress on begin
    goal_tasks.gather_samples.progress(ci, R1_TEMPERATURES)
    # protected region r1_temperatures.progress end


@kernel
def check_r1_temperatures(ci: State) -> bool:
    """Return whether goal r1_temperatures (GatherSamples) is violated now.

    Members: nautilus.
    """
    # protected region r1_temperatures.check on begin
    return goal_tasks.gather_samples.violated(ci, R1_TEMPERATURES)
    # protected region r1_temperatures.check end


@kernel
def react_r1_temperatures(ci: State) -> None:
    """Command the members of goal r1_temperatures (GatherSamples).

    Members: nautilus.
    """
    # protected region r1_temperatures.react on begin
    goal_tasks.gather_samples.react(ci, R1_TEMPERATURES)
    # protected region r1_temperatures.react end


@kernel
def progress_r1_pressures(ci: State) -> None:
    """Note what goal r1_pressures (GatherSamples) has to remember, once a tick before its check.

    Members: nautilus.
    """
    # protected region r1_pressures.progress on begin
    goal_tasks.gather_samples.progress(ci, R1_PRESSURES)
    # protected region r1_pressures.progress end


@kernel
def check_r1_pressures(ci: State) -> bool:
    """Return whether goal r1_pressures (GatherSamples) is violated now.

    Members: nautilus.
    """
    # protected region r1_pressures.check on begin
    return goal_tasks.gather_samples.violated(ci, R1_PRESSURES)
    # protected region r1_pressures.check end


@kernel
def react_r1_pressures(ci: State) -> None:
    """Command the members of goal r1_pressures (GatherSamples).

    Members: nautilus.
    """
    # protected region r1_pressures.react on begin
    goal_tasks.gather_samples.react(ci, R1_PRESSURES)
    # protected region r1_pressures.react end


@kernel
def progress_r1_depths(ci: State) -> None:
    """Note what goal r1_depths (GatherSamples) has to remember, once a tick before its check.

    Members: nautilus.
    """
    # protected region r1_depths.progress on begin
    goal_tasks.gather_samples.progress(ci, R1_DEPTHS)
    # protected region r1_depths.progress end


@kernel
def check_r1_depths(ci: State) -> bool:
    """Return whether goal r1_depths (GatherSamples) is violated now.

    Members: nautilus.
    """
    # protected region r1_depths.check on begin
    return goal_tasks.gather_samples.violated(ci, R1_DEPTHS)
    # protected region r1_depths.check end


@kernel
def react_r1_depths(ci: State) -> None:
    """Command the members of goal r1_depths (GatherSamples).

    Members: nautilus.
    """
    # protected region r1_depths.react on begin
    goal_tasks.gather_samples.react(ci, R1_DEPTHS)
    # protected region r1_depths.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_survey(view)
    progress_r1_temperatures(view)
    progress_r1_pressures(view)
    progress_r1_depths(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[SURVEY] = 1 if check_survey(view) else 0
    violated[R2] = 1 if check_r2(view) else 0
    violated[R1_TEMPERATURES] = 1 if check_r1_temperatures(view) else 0
    violated[R1_PRESSURES] = 1 if check_r1_pressures(view) else 0
    violated[R1_DEPTHS] = 1 if check_r1_depths(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_survey(ci)
    react_r2(ci)
    react_r1_temperatures(ci)
    react_r1_pressures(ci)
    react_r1_depths(ci)
