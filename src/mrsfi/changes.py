"""Two campaigns of one mission, before and after a change: what went, what came, what stayed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mrsfi.campaign_folders import FlyableCampaign, open_campaign
from mrsfi.engines import Choice, Tell, Workers, silent
from mrsfi.weaknesses import flying_again, harvested
from mrsfi_runtime.analysis.table import Table
from mrsfi_runtime.analysis.verdicts import cause_in_words, name_of
from mrsfi_runtime.causes.ways import Way
from mrsfi_runtime.causes.weakness import broken_by, yardstick_of
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.errors import SpecificationError, UsageError, counted
from mrsfi_runtime.model.gate import Gate
from mrsfi_runtime.model.mission import Mission

WENT, CAME, STAYED, UNKNOWN = "went", "came", "stayed", "cannot be flown"


@dataclass(frozen=True, slots=True)
class Change:
    """A way to break a goal that one campaign found, or both, and whether it breaks it there too.

    ``is_before`` and ``is_after`` say who found it; ``breaks`` whether its form, flown in the
    mission of the other one, breaks the goal; ``None``, with a reason, if it cannot be flown there.
    """

    way: Way
    goal: str
    cause: str
    is_before: bool
    is_after: bool
    breaks: bool | None
    reason: str = ""

    @property
    def verdict(self) -> str:
        """What became of it; a weakness that no search found again, but still breaks, stayed."""
        if (self.is_before and self.is_after) or self.breaks:
            return STAYED
        if self.breaks is None:
            return UNKNOWN
        return WENT if self.is_before else CAME

    @property
    def remark(self) -> str:
        """What stands beside the verdict."""
        if self.verdict == STAYED and not self.is_after:
            return "not found again, and its form breaks the goal as before"
        if self.verdict == STAYED and not self.is_before:
            return "found only now, and its form broke the goal before"
        if self.is_before and self.is_after and self.breaks is False:
            return "in other forms"
        return self.reason

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "verdict": self.verdict,
            "goal": self.way.goal,
            "faults": list(self.way.faults),
            "cause": self.cause,
            "found": [n for n, is_so in ((0, self.is_before), (1, self.is_after)) if is_so],
            "breaks_there": self.breaks,
            "remark": self.remark,
        }


def changes(
    before: Path, after: Path, engine: Choice, workers: Workers, tell: Tell = silent
) -> tuple[Change, ...]:
    """Return what became of the weaknesses of a mission between two campaigns.

    Each is flown in its form in the mission of the campaign that did not find it, and those that
    both found in that of the later one. Campaigns of different missions, or that did not look for
    weaknesses, are refused.
    """
    found, missions = [], []
    for path in (before, after):
        with open_campaign(path) as campaign:
            found.append({(way.goal, way.faults): way for way in harvested(campaign).ways})
            missions.append(campaign.store.manifest.mission or campaign.mission.name)
    if missions[0] != missions[1]:
        raise UsageError(
            f"{after}: found a campaign of mission '{missions[1]}'; expected one of "
            f"'{missions[0]}', as {before} is"
        )
    old, new = found
    told: list[Change] = []
    for path, flown, others, is_before in ((after, old, new, True), (before, new, old, False)):
        ways = [way for key, way in flown.items() if is_before or key not in others]
        with flying_again(path, engine, workers, tell) as (campaign, evaluator, _):
            there = _broken(campaign, evaluator, ways)
        with open_campaign(before if is_before else after) as campaign:
            for way in ways:
                breaks, reason = there[way.number]
                known = is_before and (way.goal, way.faults) in others
                told.append(
                    Change(
                        way,
                        _name(campaign.mission, way),
                        cause_in_words(campaign.mission, campaign.pool, way),
                        is_before,
                        known or not is_before,
                        breaks,
                        reason,
                    )
                )
    order = (WENT, CAME, UNKNOWN, STAYED)
    return tuple(sorted(told, key=lambda each: order.index(each.verdict)))


def _name(mission: Mission, way: Way) -> str:
    name = name_of(mission, mission.goals[mission.goal_ids.index(way.goal)])
    return name if name == way.goal else f"{name} {way.goal}"


def _broken(
    campaign: FlyableCampaign, evaluator: Evaluator, ways: Sequence[Way]
) -> Mapping[int, tuple[bool | None, str]]:
    """Return by number whether the form of each way breaks its goal in a campaign's mission."""
    seed, gate = campaign.store.settings.mission_seed, Gate(campaign.mission, campaign.pool)
    told: dict[int, tuple[bool | None, str]] = {}
    flyable = {}
    for way in ways:
        try:
            flyable[way.number] = gate.admitted(way.shown.witness)
        except SpecificationError as error:
            told[way.number] = None, str(error)
            continue
        if way.goal not in campaign.mission.goal_ids:
            told[way.number] = None, f"the mission has no goal {way.goal}"
    fault_free, *flown = evaluator.evaluate_many([(), *flyable.values()], seed)
    yardstick = yardstick_of(campaign.mission, fault_free, seed)
    by_number = dict(zip(flyable, flown, strict=True))
    for way in ways:
        if way.number not in told:
            broken = broken_by(yardstick, by_number[way.number])
            told[way.number] = way.shown.column in broken, ""
    return told


def sentence(found: Iterable[Change]) -> str:
    """Say how many weaknesses went, came and stayed."""
    verdicts = [each.verdict for each in found]
    numbers = {name: verdicts.count(name) for name in (WENT, CAME, STAYED)}
    told = ", ".join(f"{n or 'none'} {name}" for name, n in numbers.items())
    unknown = verdicts.count(UNKNOWN)
    rest = f"; {counted(unknown, 'weaknesses')} cannot be flown any more" if unknown else ""
    return f"Weaknesses: {told}{rest}"


def change_table(found: Iterable[Change]) -> Table:
    """Return a row for each weakness: what became of it, of which goal, under what."""
    rows = [
        (each.verdict, each.goal, " and ".join(each.way.faults), each.cause,
         each.remark)
        for each in found
    ]  # fmt: skip
    columns = ("verdict", "goal", "faults", "under", "remark")
    return Table("What became of each weakness", columns, rows, columns[:3], columns[3:])
