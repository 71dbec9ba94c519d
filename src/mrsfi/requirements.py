"""The results of a mission's requirements, by a campaign, written into a ReqIF file.

A result is the gravest one of the goals that stand for the requirement. It comes from the detection
of the campaign's weaknesses. ``mrsfi.models`` reads requirements into a model.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from m2t.generate import rendered_file
from m2t.models.load import load_mission_folder
from m2t.models.requirements import ReqifFile
from mrsfi.campaign_folders import open_campaign
from mrsfi.folders import MissionFolders
from mrsfi_runtime.analysis.weaknesses import State, verdicts
from mrsfi_runtime.causes.harvest import Harvest, known_by
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.generated_code import mission_from_text
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Goal, Mission
from mrsfi_runtime.search.space import SearchSpace

NOT_SEARCHED = "not searched"
"""Result of a requirement for which no goal stands, or without a finished search."""

UNRECORDED, ANYWAY, NONE_FOUND = "detection not recorded", "violated without faults", "none found"

RESULTS = ("undetected", UNRECORDED, "late", "in time", ANYWAY, NONE_FOUND, NOT_SEARCHED)
"""Results of a requirement, the gravest first."""


def export_results(
    folders: MissionFolders, file: ReqifFile, run: Path, output: Path
) -> Mapping[str, str]:
    """Write a ReqIF file with the results of its requirements, and return these by ID.

    The model of the mission states which goals stand for a requirement, the campaign in ``run``
    what breaks them. If such a goal is not the one that the campaign flew, it is a ``UsageError``.
    """
    models = load_mission_folder(folders.models)
    mission = mission_from_text(rendered_file("mission_loader.py", models))
    with open_campaign(run) as campaign:
        flown = {goal.id: _task(goal) for goal in campaign.mission.goals}
        for goal in mission.goals:
            if goal.requirements and flown.get(goal.id) != _task(goal):
                what = f"goal '{goal.id}' of {folders.models} is not the one that {run} flew"
                raise UsageError(f"{what}; expected the same goal; fly a campaign again")
        known = known_by(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
        found = {} if known is None else results(mission, campaign.pool, known)
    shown = {each.id: found.get(each.id, NOT_SEARCHED) for each in file.requirements}
    with whole_file(output) as written:
        written.write(file.with_results(shown))
    return shown


def _task(goal: Goal) -> Goal:
    """Return a goal without what no flight depends on."""
    return replace(goal, name="", requirements=(), severity=0, integrity_level="", rationale="")


def results(mission: Mission, pool: FaultPool, known: Harvest) -> dict[str, str]:
    """Return the result of each requirement for which a goal of a mission stands, by its ID."""
    found: dict[str, str] = {}
    state = {each.goal: each.state for each in verdicts(mission, pool, known)}
    for goal in mission.goals:
        of_goal = [ANYWAY if state[goal.id] is State.BROKEN_ANYWAY else NONE_FOUND]
        for each in known.goal_weaknesses:
            if each.goal == goal.id and each.measure != MEASURES[0]:
                worst = each.shown.detection.worst if each.shown.detection else UNRECORDED
                of_goal.append("undetected" if worst == "never" else worst)
        for requirement in goal.requirements:
            both = (*of_goal, found.get(requirement, NOT_SEARCHED))
            found[requirement] = min(both, key=RESULTS.index)
    return found
