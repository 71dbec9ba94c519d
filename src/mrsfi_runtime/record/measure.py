"""Which violations a campaign counts: its own measure, as its record keeps it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from mrsfi_runtime.errors import UsageError, expected
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Evaluation


@dataclass(frozen=True, slots=True)
class Measure:
    """The violations that a campaign looks at, one ``kind`` of ``COUNTED``.

    The record keeps means over ``n_seeds`` mission seeds, of the ``chosen`` goals in this order;
    with 1 it keeps counts, in the order of ``goals``. ``minimised`` is what of ``COSTS`` a front
    has few of beside many violations, if any.
    """

    kind: str
    n_seeds: int
    goals: tuple[str, ...]
    chosen: tuple[str, ...]
    duration: int
    minimised: str | None = None

    @classmethod
    def of(cls, settings: CampaignSettings, mission: Mission) -> Self:
        """Return the measure that the settings of a campaign name."""
        goals = mission.goal_ids
        return cls(
            kind=settings.violations,
            n_seeds=settings.replications,
            goals=goals,
            chosen=settings.goals or goals,
            duration=mission.duration,
            minimised=settings.minimise,
        )

    def __str__(self) -> str:
        return f"{self.words}{self.means}"

    @property
    def words(self) -> str:
        """What is counted, for people."""
        return "time missed" if self.kind == "missed" else f"{self.kind} violations"

    @property
    def means(self) -> str:
        """What follows the name of something that is a mean over mission seeds."""
        return "" if self.n_seeds == 1 else f", mean of {self.n_seeds} mission seeds"

    @property
    def is_shown_by_outcomes(self) -> bool:
        """Whether an outcome's believed and true counts already show it."""
        return self.n_seeds == 1 and self.kind in {"believed", "true"}

    def require(self, goals: Sequence[str]) -> None:
        """Refuse goals that the mission lacks, or whose mean is not recorded: a ``UsageError``."""
        known = [(self.goals, "a goal of the mission:")]
        if self.n_seeds > 1:
            why = "because the record keeps means over mission seeds of these only:"
            known.append((self.chosen, f"a goal of the campaign file, {why}"))
        for some, what in known:
            for goal in goals:
                if goal not in some:
                    raise UsageError(f"found goal '{goal}'; {expected(goal, some, what)}")

    def by_goal(self, evaluation: Evaluation) -> dict[str, float]:
        """Return the violations of each goal that is recorded, by its ID."""
        if self.n_seeds > 1:
            return dict(zip(self.chosen, evaluation.fitness[1:], strict=True))
        return dict(zip(self.goals, getattr(evaluation.outcome, self.kind), strict=True))


NONE = "–"
"""What a table shows where there is nothing."""


def ticks(count: float) -> str:
    """Return a count, or a mean of counts, as text."""
    return str(count) if isinstance(count, int) else f"{count:.2f}"
