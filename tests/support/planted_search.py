"""A search that asks once, for what ``planted.json`` in the current folder lists.

Copied beside a campaign file that names it, as a team would write one of its own.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import FitnessInput, Score
from mrsfi_runtime.search.loop import GenerationSummary
from mrsfi_runtime.search.space import SearchSpace


def truly_violated(findings: FitnessInput) -> float:
    """Return the true violations of all goals: a fitness of one's own."""
    return float(sum(findings.outcome.true))


class Planted:
    """Asks for the specifications that are listed."""

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        del space, settings
        listed = json.loads(Path("planted.json").read_text(encoding="utf-8"))
        self._asked: list[Specification] = [tuple(map(_timed, each)) for each in listed]
        self.is_finished = False

    def ask(self) -> list[Specification]:
        """Return all of them."""
        return self._asked

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """End the only generation."""
        self.is_finished = True
        fitness = [score.fitness for score in scores]
        statistics = {
            "n_evaluations": len(fitness),
            "mean": sum(fitness) / len(fitness),
            "std": 0.0,
            "min": min(fitness),
            "max": max(fitness),
        }
        return GenerationSummary(0, statistics, (0,))

    def random_state(self) -> str:
        """Return nothing: it draws nothing."""
        return "[]"


def _timed(fault: Sequence[Any]) -> TimedFault:
    name, start, finish, *values = fault
    return TimedFault(name, start, finish, *map(tuple, values))
