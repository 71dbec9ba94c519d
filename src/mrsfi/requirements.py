"""The results of a mission's requirements, by a campaign, written into a ReqIF file.

A result is the gravest one of the goals that stand for the requirement. It comes from the detection
of the campaign's weaknesses. ``mrsfi.models`` reads requirements into a model.
"""

from collections.abc import Mapping
from pathlib import Path

from m2t.models.requirements import ReqifFile
from mrsfi.campaign_folders import open_campaign
from mrsfi_runtime.analysis.weaknesses import State, verdicts
from mrsfi_runtime.causes.harvest import Harvest, known_by
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.search.space import SearchSpace

RESULTS = (
    *("undetected", "detection not recorded", "late", "in time"),
    *("violated without faults", "none found", "not searched"),
)
"""Results of a requirement, the gravest first."""

_UNDETECTED, _UNRECORDED, *_, _ANYWAY, _NONE_FOUND, _NOT_SEARCHED = RESULTS


def export_results(file: ReqifFile, run: Path, output: Path) -> Mapping[str, tuple[str, ...]]:
    """Write a ReqIF file with the results of its requirements; return their IDs by result.

    The campaign in ``run`` has what breaks goals, and its mission which requirements these have.
    """
    with open_campaign(run) as campaign:
        known = known_by(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
        found = {} if known is None else results(campaign.mission, campaign.pool, known)
    shown = {each.id: found.get(each.id, _NOT_SEARCHED) for each in file.requirements}
    with whole_file(output) as written:
        written.write(file.with_results(shown))
    by_result = {each: tuple(own for own in shown if shown[own] == each) for each in RESULTS}
    return {**by_result, "written": (str(output),)}


def results(mission: Mission, pool: FaultPool, known: Harvest) -> dict[str, str]:
    """Return the result of each requirement for which a goal of a mission stands, by its ID."""
    found: dict[str, str] = {}
    for verdict in verdicts(mission, pool, known):
        of_goal = [_ANYWAY if verdict.state is State.BROKEN_ANYWAY else _NONE_FOUND]
        for each in known.goal_weaknesses:
            if each.goal == verdict.goal and each.measure != MEASURES[0]:
                worst = each.shown.detection.worst if each.shown.detection else _UNRECORDED
                of_goal.append(_UNDETECTED if worst == "never" else worst)
        for own in mission.goals[mission.goal_ids.index(verdict.goal)].requirements:
            found[own] = min(*of_goal, found.get(own, _NOT_SEARCHED), key=RESULTS.index)
    return found
