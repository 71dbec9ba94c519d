"""Campaigns that count masked violations, or means over two mission seeds."""

from dataclasses import replace

from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Evaluation
from tests.support.campaigns import evaluation

GOALS = ("g1", "g3")
MASKED = CampaignSettings(violations="masked", goals=GOALS, fitness="focused")
MEANS = replace(MASKED, violations="believed", replications=2)


def masking(index: int, masked: tuple[int, ...]) -> Evaluation:
    """Return an evaluation whose belief says the opposite of what it hides."""
    believed = tuple(100 - count for count in masked)
    found = evaluation(index, believed, fitness=float(sum(masked)))
    return replace(found, outcome=replace(found.outcome, masked=masked))


def missing(index: int, missed: tuple[int, ...]) -> Evaluation:
    """Return an evaluation without violations whose goals were missed for so many ticks."""
    found = evaluation(index, (0,) * len(missed), fitness=float(sum(missed)))
    return replace(found, outcome=replace(found.outcome, missed=missed))


def averaged(index: int, first_seed: tuple[int, ...], means: tuple[float, float]) -> Evaluation:
    return replace(evaluation(index, first_seed), fitness=(sum(means), *means))


HIDING = [masking(0, (3, 0, 1, 0, 0, 0)), masking(1, (2, 0, 5, 0, 0, 0)), masking(2, (1,) * 6)]
FLOWN_TWICE = [
    averaged(0, (900, 0, 900, 0, 0, 0), (450.0, 451.5)),
    averaged(1, (10, 0, 10, 0, 0, 0), (500.5, 12.0)),
    averaged(2, (999, 0, 0, 0, 0, 0), (499.5, 0.0)),
]
