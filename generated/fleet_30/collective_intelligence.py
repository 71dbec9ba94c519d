# Generated from mission fleet_30 by collective_intelligence.py.j2.
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
Q0_BUOY = 3
Q0_ROUNDS = 4
Q0_SAMPLES = 5
Q1_BUOY = 6
Q1_ROUNDS = 7
Q1_SAMPLES = 8
Q2_BUOY = 9
Q2_ROUNDS = 10
Q2_SAMPLES = 11
Q0R0 = 0  # 'robot 0 of squad 0'
Q0R1 = 1  # 'robot 1 of squad 0'
Q0R2 = 2  # 'robot 2 of squad 0'
Q0R3 = 3  # 'robot 3 of squad 0'
Q0R4 = 4  # 'robot 4 of squad 0'
Q0R5 = 5  # 'robot 5 of squad 0'
Q0R6 = 6  # 'robot 6 of squad 0'
Q0R7 = 7  # 'robot 7 of squad 0'
Q0R8 = 8  # 'robot 8 of squad 0'
Q0R9 = 9  # 'robot 9 of squad 0'
Q1R0 = 10  # 'robot 0 of squad 1'
Q1R1 = 11  # 'robot 1 of squad 1'
Q1R2 = 12  # 'robot 2 of squad 1'
Q1R3 = 13  # 'robot 3 of squad 1'
Q1R4 = 14  # 'robot 4 of squad 1'
Q1R5 = 15  # 'robot 5 of squad 1'
Q1R6 = 16  # 'robot 6 of squad 1'
Q1R7 = 17  # 'robot 7 of squad 1'
Q1R8 = 18  # 'robot 8 of squad 1'
Q1R9 = 19  # 'robot 9 of squad 1'
Q2R0 = 20  # 'robot 0 of squad 2'
Q2R1 = 21  # 'robot 1 of squad 2'
Q2R2 = 22  # 'robot 2 of squad 2'
Q2R3 = 23  # 'robot 3 of squad 2'
Q2R4 = 24  # 'robot 4 of squad 2'
Q2R5 = 25  # 'robot 5 of squad 2'
Q2R6 = 26  # 'robot 6 of squad 2'
Q2R7 = 27  # 'robot 7 of squad 2'
Q2R8 = 28  # 'robot 8 of squad 2'
Q2R9 = 29  # 'robot 9 of squad 2'
Q0R0_GPS_POSITION = 0
Q0R0_TEMPERATURE = 1
Q0R1_GPS_POSITION = 2
Q0R2_GPS_POSITION = 3
Q0R3_GPS_POSITION = 4
Q0R4_GPS_POSITION = 5
Q0R5_GPS_POSITION = 6
Q0R6_GPS_POSITION = 7
Q0R7_GPS_POSITION = 8
Q0R8_GPS_POSITION = 9
Q0R9_GPS_POSITION = 10
Q1R0_GPS_POSITION = 11
Q1R0_TEMPERATURE = 12
Q1R1_GPS_POSITION = 13
Q1R2_GPS_POSITION = 14
Q1R3_GPS_POSITION = 15
Q1R4_GPS_POSITION = 16
Q1R5_GPS_POSITION = 17
Q1R6_GPS_POSITION = 18
Q1R7_GPS_POSITION = 19
Q1R8_GPS_POSITION = 20
Q1R9_GPS_POSITION = 21
Q2R0_GPS_POSITION = 22
Q2R0_TEMPERATURE = 23
Q2R1_GPS_POSITION = 24
Q2R2_GPS_POSITION = 25
Q2R3_GPS_POSITION = 26
Q2R4_GPS_POSITION = 27
Q2R5_GPS_POSITION = 28
Q2R6_GPS_POSITION = 29
Q2R7_GPS_POSITION = 30
Q2R8_GPS_POSITION = 31
Q2R9_GPS_POSITION = 32
Q0_REEF = 0
Q1_REEF = 1
Q2_REEF = 2


# protected region helpers on begin
# protected region helpers end


@kernel
def check_clear(ci: State) -> bool:
    """Return whether goal clear (AvoidCollision) is violated now.

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region clear.check on begin
    return goal_tasks.avoid_collision.violated(ci, CLEAR)
    # protected region clear.check end


@kernel
def react_clear(ci: State) -> None:
    """Command the members of goal clear (AvoidCollision).

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region clear.react on begin
    goal_tasks.avoid_collision.react(ci, CLEAR)
    # protected region clear.react end


@kernel
def check_within(ci: State) -> bool:
    """Return whether goal within (StayWithinMissionArea) is violated now.

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region within.check on begin
    return goal_tasks.stay_within_mission_area.violated(ci, WITHIN)
    # protected region within.check end


@kernel
def react_within(ci: State) -> None:
    """Command the members of goal within (StayWithinMissionArea).

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region within.react on begin
    goal_tasks.stay_within_mission_area.react(ci, WITHIN)
    # protected region within.react end


@kernel
def check_energy(ci: State) -> bool:
    """Return whether goal energy (SufficientEnergy) is violated now.

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region energy.check on begin
    return goal_tasks.sufficient_energy.violated(ci, ENERGY)
    # protected region energy.check end


@kernel
def react_energy(ci: State) -> None:
    """Command the members of goal energy (SufficientEnergy).

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 22 more.
    """
    # protected region energy.react on begin
    goal_tasks.sufficient_energy.react(ci, ENERGY)
    # protected region energy.react end


@kernel
def progress_q0_buoy(ci: State) -> None:
    """Note what goal q0_buoy (Visit) has to remember, once a tick before its check.

    Members: q0r1.
    """
    # protected region q0_buoy.progress on begin
    goal_tasks.visit.progress(ci, Q0_BUOY)
    # protected region q0_buoy.progress end


@kernel
def check_q0_buoy(ci: State) -> bool:
    """Return whether goal q0_buoy (Visit) is violated now.

    Members: q0r1.
    """
    # protected region q0_buoy.check on begin
    return goal_tasks.visit.violated(ci, Q0_BUOY)
    # protected region q0_buoy.check end


@kernel
def react_q0_buoy(ci: State) -> None:
    """Command the members of goal q0_buoy (Visit).

    Members: q0r1.
    """
    # protected region q0_buoy.react on begin
    goal_tasks.visit.react(ci, Q0_BUOY)
    # protected region q0_buoy.react end


@kernel
def progress_q0_rounds(ci: State) -> None:
    """Note what goal q0_rounds (Patrol) has to remember, once a tick before its check.

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 2 more.
    """
    # protected region q0_rounds.progress on begin
    goal_tasks.patrol.progress(ci, Q0_ROUNDS)
    # protected region q0_rounds.progress end


@kernel
def check_q0_rounds(ci: State) -> bool:
    """Return whether goal q0_rounds (Patrol) is violated now.

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 2 more.
    """
    # protected region q0_rounds.check on begin
    return goal_tasks.patrol.violated(ci, Q0_ROUNDS)
    # protected region q0_rounds.check end


@kernel
def react_q0_rounds(ci: State) -> None:
    """Command the members of goal q0_rounds (Patrol).

    Members: q0r0, q0r1, q0r2, q0r3, q0r4, q0r5, q0r6, q0r7 and 2 more.
    """
    # protected region q0_rounds.react on begin
    goal_tasks.patrol.react(ci, Q0_ROUNDS)
    # protected region q0_rounds.react end


@kernel
def progress_q0_samples(ci: State) -> None:
    """Note what goal q0_samples (GatherSamples) has to remember, once a tick before its check.

    Members: q0r0.
    """
    # protected region q0_samples.progress on begin
    goal_tasks.gather_samples.progress(ci, Q0_SAMPLES)
    # protected region q0_samples.progress end


@kernel
def check_q0_samples(ci: State) -> bool:
    """Return whether goal q0_samples (GatherSamples) is violated now.

    Members: q0r0.
    """
    # protected region q0_samples.check on begin
    return goal_tasks.gather_samples.violated(ci, Q0_SAMPLES)
    # protected region q0_samples.check end


@kernel
def react_q0_samples(ci: State) -> None:
    """Command the members of goal q0_samples (GatherSamples).

    Members: q0r0.
    """
    # protected region q0_samples.react on begin
    goal_tasks.gather_samples.react(ci, Q0_SAMPLES)
    # protected region q0_samples.react end


@kernel
def progress_q1_buoy(ci: State) -> None:
    """Note what goal q1_buoy (Visit) has to remember, once a tick before its check.

    Members: q1r1.
    """
    # protected region q1_buoy.progress on begin
    goal_tasks.visit.progress(ci, Q1_BUOY)
    # protected region q1_buoy.progress end


@kernel
def check_q1_buoy(ci: State) -> bool:
    """Return whether goal q1_buoy (Visit) is violated now.

    Members: q1r1.
    """
    # protected region q1_buoy.check on begin
    return goal_tasks.visit.violated(ci, Q1_BUOY)
    # protected region q1_buoy.check end


@kernel
def react_q1_buoy(ci: State) -> None:
    """Command the members of goal q1_buoy (Visit).

    Members: q1r1.
    """
    # protected region q1_buoy.react on begin
    goal_tasks.visit.react(ci, Q1_BUOY)
    # protected region q1_buoy.react end


@kernel
def progress_q1_rounds(ci: State) -> None:
    """Note what goal q1_rounds (Patrol) has to remember, once a tick before its check.

    Members: q1r0, q1r1, q1r2, q1r3, q1r4, q1r5, q1r6, q1r7 and 2 more.
    """
    # protected region q1_rounds.progress on begin
    goal_tasks.patrol.progress(ci, Q1_ROUNDS)
    # protected region q1_rounds.progress end


@kernel
def check_q1_rounds(ci: State) -> bool:
    """Return whether goal q1_rounds (Patrol) is violated now.

    Members: q1r0, q1r1, q1r2, q1r3, q1r4, q1r5, q1r6, q1r7 and 2 more.
    """
    # protected region q1_rounds.check on begin
    return goal_tasks.patrol.violated(ci, Q1_ROUNDS)
    # protected region q1_rounds.check end


@kernel
def react_q1_rounds(ci: State) -> None:
    """Command the members of goal q1_rounds (Patrol).

    Members: q1r0, q1r1, q1r2, q1r3, q1r4, q1r5, q1r6, q1r7 and 2 more.
    """
    # protected region q1_rounds.react on begin
    goal_tasks.patrol.react(ci, Q1_ROUNDS)
    # protected region q1_rounds.react end


@kernel
def progress_q1_samples(ci: State) -> None:
    """Note what goal q1_samples (GatherSamples) has to remember, once a tick before its check.

    Members: q1r0.
    """
    # protected region q1_samples.progress on begin
    goal_tasks.gather_samples.progress(ci, Q1_SAMPLES)
    # protected region q1_samples.progress end


@kernel
def check_q1_samples(ci: State) -> bool:
    """Return whether goal q1_samples (GatherSamples) is violated now.

    Members: q1r0.
    """
    # protected region q1_samples.check on begin
    return goal_tasks.gather_samples.violated(ci, Q1_SAMPLES)
    # protected region q1_samples.check end


@kernel
def react_q1_samples(ci: State) -> None:
    """Command the members of goal q1_samples (GatherSamples).

    Members: q1r0.
    """
    # protected region q1_samples.react on begin
    goal_tasks.gather_samples.react(ci, Q1_SAMPLES)
    # protected region q1_samples.react end


@kernel
def progress_q2_buoy(ci: State) -> None:
    """Note what goal q2_buoy (Visit) has to remember, once a tick before its check.

    Members: q2r1.
    """
    # protected region q2_buoy.progress on begin
    goal_tasks.visit.progress(ci, Q2_BUOY)
    # protected region q2_buoy.progress end


@kernel
def check_q2_buoy(ci: State) -> bool:
    """Return whether goal q2_buoy (Visit) is violated now.

    Members: q2r1.
    """
    # protected region q2_buoy.check on begin
    return goal_tasks.visit.violated(ci, Q2_BUOY)
    # protected region q2_buoy.check end


@kernel
def react_q2_buoy(ci: State) -> None:
    """Command the members of goal q2_buoy (Visit).

    Members: q2r1.
    """
    # protected region q2_buoy.react on begin
    goal_tasks.visit.react(ci, Q2_BUOY)
    # protected region q2_buoy.react end


@kernel
def progress_q2_rounds(ci: State) -> None:
    """Note what goal q2_rounds (Patrol) has to remember, once a tick before its check.

    Members: q2r0, q2r1, q2r2, q2r3, q2r4, q2r5, q2r6, q2r7 and 2 more.
    """
    # protected region q2_rounds.progress on begin
    goal_tasks.patrol.progress(ci, Q2_ROUNDS)
    # protected region q2_rounds.progress end


@kernel
def check_q2_rounds(ci: State) -> bool:
    """Return whether goal q2_rounds (Patrol) is violated now.

    Members: q2r0, q2r1, q2r2, q2r3, q2r4, q2r5, q2r6, q2r7 and 2 more.
    """
    # protected region q2_rounds.check on begin
    return goal_tasks.patrol.violated(ci, Q2_ROUNDS)
    # protected region q2_rounds.check end


@kernel
def react_q2_rounds(ci: State) -> None:
    """Command the members of goal q2_rounds (Patrol).

    Members: q2r0, q2r1, q2r2, q2r3, q2r4, q2r5, q2r6, q2r7 and 2 more.
    """
    # protected region q2_rounds.react on begin
    goal_tasks.patrol.react(ci, Q2_ROUNDS)
    # protected region q2_rounds.react end


@kernel
def progress_q2_samples(ci: State) -> None:
    """Note what goal q2_samples (GatherSamples) has to remember, once a tick before its check.

    Members: q2r0.
    """
    # protected region q2_samples.progress on begin
    goal_tasks.gather_samples.progress(ci, Q2_SAMPLES)
    # protected region q2_samples.progress end


@kernel
def check_q2_samples(ci: State) -> bool:
    """Return whether goal q2_samples (GatherSamples) is violated now.

    Members: q2r0.
    """
    # protected region q2_samples.check on begin
    return goal_tasks.gather_samples.violated(ci, Q2_SAMPLES)
    # protected region q2_samples.check end


@kernel
def react_q2_samples(ci: State) -> None:
    """Command the members of goal q2_samples (GatherSamples).

    Members: q2r0.
    """
    # protected region q2_samples.react on begin
    goal_tasks.gather_samples.react(ci, Q2_SAMPLES)
    # protected region q2_samples.react end


@kernel
def progress(view: State) -> None:
    """Bring the progress of every goal up to the tick of a state."""
    progress_q0_buoy(view)
    progress_q0_rounds(view)
    progress_q0_samples(view)
    progress_q1_buoy(view)
    progress_q1_rounds(view)
    progress_q1_samples(view)
    progress_q2_buoy(view)
    progress_q2_rounds(view)
    progress_q2_samples(view)


@kernel
def check(view: State, violated: list[int]) -> None:
    """Write 1 for every goal that is violated in a state, else 0."""
    violated[CLEAR] = 1 if check_clear(view) else 0
    violated[WITHIN] = 1 if check_within(view) else 0
    violated[ENERGY] = 1 if check_energy(view) else 0
    violated[Q0_BUOY] = 1 if check_q0_buoy(view) else 0
    violated[Q0_ROUNDS] = 1 if check_q0_rounds(view) else 0
    violated[Q0_SAMPLES] = 1 if check_q0_samples(view) else 0
    violated[Q1_BUOY] = 1 if check_q1_buoy(view) else 0
    violated[Q1_ROUNDS] = 1 if check_q1_rounds(view) else 0
    violated[Q1_SAMPLES] = 1 if check_q1_samples(view) else 0
    violated[Q2_BUOY] = 1 if check_q2_buoy(view) else 0
    violated[Q2_ROUNDS] = 1 if check_q2_rounds(view) else 0
    violated[Q2_SAMPLES] = 1 if check_q2_samples(view) else 0


@kernel
def react(ci: State) -> None:
    """Command the robots: the first goal in model order that claims a channel keeps it."""
    react_clear(ci)
    react_within(ci)
    react_energy(ci)
    react_q0_buoy(ci)
    react_q0_rounds(ci)
    react_q0_samples(ci)
    react_q1_buoy(ci)
    react_q1_rounds(ci)
    react_q1_samples(ci)
    react_q2_buoy(ci)
    react_q2_rounds(ci)
    react_q2_samples(ci)
