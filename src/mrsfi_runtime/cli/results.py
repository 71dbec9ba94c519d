"""The report of a campaign, written into its folder and printed."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click

from m2t.specification import write_specification
from mrsfi_runtime.analysis.fronts import Front
from mrsfi_runtime.analysis.report import SpecificationRow, write_report
from mrsfi_runtime.analysis.summary import RatioPick, Summary, as_json
from mrsfi_runtime.cli.campaigns import OpenCampaign
from mrsfi_runtime.cli.console import print_json, print_table
from mrsfi_runtime.cli.tables import critical_table, plain_table


def report(campaign: OpenCampaign, ratio: str | None, *, is_json: bool) -> None:
    """Write the report into a campaign's folder and print what it says.

    Parameters
    ----------
    ratio
        Ratio of violations to pick by, such as ``g3:g1=2:1``.
    is_json
        Print for a script, not for a person.
    """
    write = partial(_write_specification, campaign.folder.model)
    summary = write_report(campaign.folder.path, campaign.code, write, ratio=ratio)
    if is_json:
        content = as_json(summary, campaign.code.pool)
        print_json({"folder": str(campaign.folder.path), **content})
    else:
        _print_summary(campaign, summary)


def _write_specification(
    models: Path, rows: Sequence[SpecificationRow], path: Path, identifier: str
) -> None:
    write_specification(models, rows, path, identifier=identifier)


def _print_summary(campaign: OpenCampaign, summary: Summary) -> None:
    """Print the most critical specifications, the front, and where everything is."""
    folder = campaign.folder
    title = f"The {len(summary.top)} most critical of {summary.n_distinct} fault specifications"
    code = campaign.code
    print_table(title, critical_table(code.mission, code.pool, summary.top))
    if summary.front is not None:
        _print_front(summary.front)
    if summary.pick is not None:
        click.echo(_picked(campaign, summary.pick) + "\n")
    click.echo(f"specifications  {folder.critical}")
    click.echo(f"report          {folder.report}")
    click.echo(f"campaign        {folder.path}")
    click.echo(f"evaluations     {summary.n_evaluations}, failed {summary.n_failures}")
    click.echo(f"digest          {summary.digest}")


def _print_front(front: Front) -> None:
    table = plain_table((), ("evaluation", *front.goals))
    for point in front.points:
        table.add_row(str(point.evaluation), *map(str, point.violations))
    title = (
        f"Pareto front: {len(front.points)} trade-offs between {', '.join(front.goals)} (believed)"
    )
    print_table(title, table)


def _picked(campaign: OpenCampaign, pick: RatioPick) -> str:
    if pick.point is None:
        return f"nearest to {pick.ratio}: none, because no specification violates these goals"
    believed = campaign.store.evaluation(pick.point.evaluation).outcome.believed
    violations = dict(zip(campaign.code.mission.goal_ids, believed, strict=True))
    found = ", ".join(f"{goal} {violations[goal]}" for goal in pick.ratio.goals)
    return f"nearest to {pick.ratio}: evaluation {pick.point.evaluation} with {found}"
