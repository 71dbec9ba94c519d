"""The command ``mrsfi compare``, and the tables that it prints."""

from collections.abc import Mapping
from dataclasses import astuple
from itertools import groupby
from math import isinf
from pathlib import Path
from time import monotonic

import click
from rich.table import Table

from mrsfi.comparing import compared, settings_of, write_compared
from mrsfi.engines import Workers, evaluator
from mrsfi.folders import (
    campaign_file,
    find_mission,
)
from mrsfi.loading import load_fresh
from mrsfi.project import project
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.options import EngineOptions
from mrsfi_runtime.cli.tables import plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import TransportError, UsageError
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.study.comparison import Comparison
from mrsfi_runtime.study.folder import ComparisonFolder
from mrsfi_runtime.study.run_results import MOST_OBJECTIVES, RunResult
from mrsfi_runtime.study.runs import (
    only_comparison,
)


def compare_algorithms(  # noqa: PLR0913 - one for each option
    *,
    mission: str,
    generated: Path | None,
    case: str,
    algorithms: str,
    seeds: int,
    evaluations: int,
    workers: Workers,
    engine: EngineOptions,
    out: Path | None,
    is_json: bool,
) -> None:
    """Compare search algorithms on a mission."""
    flown_by = engine.settings(default=AUTO)
    workers.require_sense(flown_by)
    folders = find_mission(mission, generated)
    code = load_fresh(folders)
    settings = settings_of(campaign_file(folders, case), code, _names(algorithms), evaluations)
    tried = flown_by.tried(code, next(iter(settings.values())).mission_seed, tell)
    path = project().runs / f"compare-{folders.name}-{Path(case).stem}" if out is None else out
    with only_comparison(path, folders.models, folders.generated) as folder:
        comparison = _compared(folder, settings, seeds, tried, workers)
        content = write_compared(folder, folders.name, settings, comparison)
    _tell_fewer(comparison, evaluations)
    if is_json:
        print_json({"folder": str(path), **content})
    else:
        _print(comparison, folder, evaluations)


def _names(algorithms: str) -> list[str]:
    names = [name.strip() for name in algorithms.split(",")]
    if not all(names) or len(set(names)) < len(names):
        raise UsageError(
            f"--algorithms: found '{algorithms}'; expected different names with commas"
        )
    return names


def _compared(
    folder: ComparisonFolder,
    settings: Mapping[str, CampaignSettings],
    n_seeds: int,
    engine: EngineSettings,
    workers: Workers,
) -> Comparison:
    """Make the runs that are missing; tell of each, and how long the rest may take."""
    n_runs = len(settings) * n_seeds
    n_new = 0
    began = 0.0

    def tell_who(who: str) -> None:
        nonlocal began
        tell(f"comparison {folder.path}: {n_runs} runs, {engine.words}, {who}")
        began = monotonic()

    def tell_of(run: RunResult, n_done: int, is_new: bool) -> None:
        nonlocal n_new
        place = f"run {n_done}/{n_runs}  {run.algorithm} seed {run.seed}"
        if not is_new:
            tell(f"{place}  was finished already")
            return
        n_new += 1
        left = round((monotonic() - began) / n_new * (n_runs - n_done))
        tell(
            f"{place}  best {run.best_fitness:.2f}  evaluations {run.n_evaluations}  "
            f"{run.seconds:.1f} s  left {left // 60}:{left % 60:02d}"
        )

    code = load_code(folder.generated)
    seed = next(iter(settings.values())).mission_seed
    try:
        with evaluator(code, seed, engine, workers, tell, tell_who) as many:
            return compared(folder, settings, n_seeds, code, many, tell_of)
    except (KeyboardInterrupt, TransportError):
        tell(f"finished runs are kept in {folder.runs}; the same command goes on with the rest")
        raise


def _tell_fewer(comparison: Comparison, n_evaluations: int) -> None:
    """Say which algorithms did not use all of their evaluations."""
    for name in comparison.algorithms:
        n_fewer = sum(run.n_evaluations < n_evaluations for run in comparison.of(name))
        if n_fewer:
            tell(
                f"warning: {n_fewer} runs of {name} made fewer than {n_evaluations} evaluations, "
                "because some failed or the algorithm had nothing more to ask"
            )


def _print(comparison: Comparison, folder: ComparisonFolder, n_evaluations: int) -> None:
    title = (
        f"{len(comparison.algorithms)} algorithms, {len(comparison.seeds)} seeds, "
        f"{n_evaluations} evaluations a run"
    )
    print_table(title, quartile_table(comparison))
    if comparison.tests:
        print_table("Mann-Whitney U: does the first do better?", rank_test_table(comparison))
    for line in legend(comparison):
        click.echo(line)
    click.echo(f"runs         {folder.runs}")
    click.echo(f"tables       {folder.path}/runs.csv, quartiles.csv, tests.csv")
    click.echo(f"figures      {folder.figures}")
    click.echo(f"summary      {folder.summary}")


def quartile_table(comparison: Comparison) -> Table:
    """Return the quartiles of every measure, one line for each measure and algorithm."""
    rows = (
        (measure if number == 0 else "", name, *map(number_text, astuple(found)))
        for measure, by_algorithm in comparison.quartiles.items()
        for number, (name, found) in enumerate(by_algorithm.items())
    )
    head = ("measure", "algorithm")
    return plain_table(head, ("lower quartile", "median", "upper quartile"), rows)


def rank_test_table(comparison: Comparison) -> Table:
    """Return the tests of two algorithms, but for measures on which no two algorithms differ."""
    telling = {test.measure for test in comparison.tests if test.ranks.a12 != 0.5}
    rows = (
        (
            measure if number == 0 else "",
            test.first,
            test.second,
            f"{test.ranks.u:g}",
            probability(test.ranks.p_value),
            probability(test.holm_p_value),
            f"{test.ranks.a12:.3f}",
            test.effect,
        )
        for measure, tests in groupby(comparison.tests, lambda test: test.measure)
        if measure in telling
        for number, test in enumerate(tests)
    )
    head = ("measure", "first", "second")
    return plain_table(head, ("U", "p", "p (Holm)", "A12", "magnitude"), rows)


def legend(comparison: Comparison) -> list[str]:
    """Return what the names of measures mean, line by line."""
    names = [criterion.name for criterion in comparison.criteria]
    lines = ["fitness      best of a run"]
    if "hypervolume" in names:
        lines.append(
            "hypervolume  share of the possible, beyond the reference point of -1 violations"
        )
    else:
        lines.append(f"hypervolume  not computed: needs 2 to {MOST_OBJECTIVES} goals")
    if "at_once_1" in names:
        lines.append("at_once_k    evaluations until one specification broke k goals")
        lines.append("together_k   evaluations until all so far broke k goals between them")
    return lines


def number_text(value: float) -> str:
    """Return a measured number in four or more digits, and ``never`` for infinity."""
    if isinf(value):
        return "never"
    return f"{value:.6g}" if abs(value) >= 1 else f"{value:.4g}"


def probability(value: float) -> str:
    """Return a p-value in three digits."""
    return f"{value:.3f}" if value >= 0.001 else f"{value:.1e}"
