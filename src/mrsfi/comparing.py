"""Search algorithms beside each other: the same mission, the same seeds, as many evaluations."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from mrsfi.evolving import require_searchable
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.semantics import SEMANTICS
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import Comparison, as_json, compare
from mrsfi_runtime.study.folder import ComparisonFolder
from mrsfi_runtime.study.run_results import RunResult
from mrsfi_runtime.study.runs import common_settings, runs_of


def settings_of(
    file: Path, code: MissionCode, algorithms: Sequence[str], evaluations: int
) -> dict[str, CampaignSettings]:
    """Return the settings of each algorithm: those of a campaign file, and as many evaluations."""
    settings = {}
    for name in algorithms:
        one = CampaignSettings.load(file, algorithm=name, seed=1, evaluations=evaluations)
        require_searchable(code, one)
        settings[name] = one
    return settings


def compared(
    folder: ComparisonFolder,
    settings: Mapping[str, CampaignSettings],
    n_seeds: int,
    code: MissionCode,
    evaluator: Evaluator,
    progress: Callable[[RunResult, int, bool], None] = lambda *_: None,
) -> Comparison:
    """Make the runs that a comparison lacks, and return what all of them say.

    ``progress`` is told each run, how many there are with it, and whether it was made just now.
    """
    seeds = next(iter(settings.values())).mission_seeds
    evaluators = [partial(evaluator.evaluate_many, seed=seed) for seed in seeds]
    runs: list[RunResult] = []
    for run, is_new in runs_of(folder, settings, n_seeds, code, evaluators):
        runs.append(run)
        progress(run, len(runs), is_new)
    return compare(tuple(settings), runs)


def write_compared(
    folder: ComparisonFolder,
    mission: str,
    settings: Mapping[str, CampaignSettings],
    comparison: Comparison,
) -> dict[str, Any]:
    """Write tables, figures and summary of a comparison; return the summary."""
    content = {
        "mission": mission,
        "semantics": SEMANTICS,
        "settings": common_settings(next(iter(settings.values()))),
        **as_json(comparison),
    }
    folder.write(comparison, content)
    return content
