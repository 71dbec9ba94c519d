"""Two campaigns of one mission, before and after a change: what went, what came, what stayed."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mrsfi.campaign_folders import FlyableCampaign, open_campaign
from mrsfi.engines import Given, Tell, silent
from mrsfi.weaknesses import flying_again, harvested
from mrsfi_runtime.analysis.tables import Table
from mrsfi_runtime.analysis.weaknesses import cause_in_words
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.causes.weakness import MEASURES, Breaking
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.errors import SpecificationError, UsageError, counted
from mrsfi_runtime.model.faults import Gate
from mrsfi_runtime.record.engine_settings import Workers

WENT, CAME, STAYED, UNKNOWN = "went", "came", "stayed", "cannot be flown"


@dataclass(frozen=True, slots=True)
class Change:
    """A way to break a goal as the campaign ``before`` found it, as that ``after`` did, or both.

    ``breaks`` says whether its form, flown in the mission of the campaign that it is not of (that
    after, if both found it), breaks the goal; ``None``, with a reason, if it cannot be flown there.
    """

    goal: str
    cause: str
    before: Way | None
    after: Way | None
    breaks: bool | None
    reason: str = ""

    @property
    def way(self) -> Way:
        """As it was found first."""
        found = self.before or self.after
        assert found is not None
        return found

    @property
    def verdict(self) -> str:
        """What became of it; a weakness that no search found again, but still breaks, stayed.

        One of which only a false alarm is left went, and one that was a false alarm only came.
        """
        if self.before and self.after:
            truly, now = _is_true(self.before), _is_true(self.after)
            return STAYED if truly == now or self.breaks else WENT if truly else CAME
        if self.breaks is None:
            return UNKNOWN
        return STAYED if self.breaks else WENT if self.before else CAME

    @property
    def remark(self) -> str:
        """What stands beside the verdict."""
        if self.before and self.after:
            alarm = {WENT: "a false alarm is left", CAME: "was a false alarm only"}
            usual = "in other forms" if self.breaks is False else ""
            return alarm.get(self.verdict, usual)
        if self.verdict == STAYED:
            found = "not found again; its form breaks the goal as before"
            return found if self.before else "found only now; its form broke the goal before"
        return self.reason

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "verdict": self.verdict,
            "goal": self.way.goal,
            "faults": list(self.way.faults),
            "cause": self.cause,
            "before": self.before and self.before.number,
            "after": self.after and self.after.number,
            "breaks_there": self.breaks,
            "remark": self.remark,
        }


def _is_true(way: Way) -> bool:
    return way.shown.column.kind != MEASURES[0]


def changes(
    before: Path, after: Path, engine: Given, workers: Workers, tell: Tell = silent
) -> tuple[Change, ...]:
    """Return what became of the weaknesses of a mission between two campaigns, each flown anew."""
    found, models, names = [], [], []
    for path in (before, after):
        with open_campaign(path) as campaign:
            found.append({_key(way): way for way in harvested(campaign).ways})
            models.append((campaign.mission, campaign.pool))
            names.append(campaign.store.manifest.mission or campaign.mission.name)
    if names[0] != names[1]:
        raise UsageError(
            f"{after}: found a campaign of mission '{names[1]}'; expected one of '{names[0]}', as "
            f"{before} is"
        )
    old, new = found
    told: list[Change] = []
    for path, flown, others, (mission, pool), is_before in (
        (after, old, new, models[0], True),
        (before, new, old, models[1], False),
    ):
        ways = [way for key, way in flown.items() if is_before or key not in others]
        with flying_again(path, engine, workers, tell) as (campaign, evaluator, _):
            there = _broken(campaign, evaluator, ways)
        for way in ways:
            old_one, new_one = (way, others.get(_key(way))) if is_before else (None, way)
            cause = cause_in_words(mission, pool, way)
            name = mission.label_of(mission.goals[mission.goal_ids.index(way.goal)])
            told.append(Change(name, cause, old_one, new_one, *there[way.number]))
    order = (WENT, CAME, UNKNOWN, STAYED)
    return tuple(sorted(told, key=lambda each: order.index(each.verdict)))


def _key(way: Way) -> tuple[str, tuple[str, ...]]:
    return way.goal, way.faults


def _broken(
    campaign: FlyableCampaign, evaluator: Evaluator, ways: Sequence[Way]
) -> Mapping[int, tuple[bool | None, str]]:
    seed, gate = campaign.store.settings.mission_seed, Gate(campaign.mission, campaign.pool)
    told: dict[int, tuple[bool | None, str]] = {}
    flyable = {}
    for way in ways:
        try:
            form = gate.admitted(way.shown.witness)
        except SpecificationError as error:
            told[way.number] = None, str(error)
            continue
        if way.goal in campaign.mission.goal_ids:
            flyable[way.number, way.shown.column] = form
        else:
            told[way.number] = None, f"the mission has no goal {way.goal}"
    breaking = Breaking(campaign.mission, evaluator.evaluate_many, [seed])
    for (number, column), broken in zip(flyable, breaking([*flyable.values()], seed), strict=True):
        told[number] = column in broken, ""
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
        (each.verdict, " and ".join(each.way.faults), each.goal, each.cause, each.remark)
        for each in found
    ]
    columns = ("verdict", "faults", "goal", "under", "remark")
    return Table("What became of each weakness", columns, rows, columns[:2], columns[2:])
