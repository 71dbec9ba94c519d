"""The report of a campaign: written into its folder, and printed."""

from collections.abc import Sequence

import click

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.reporting import report as write_report
from mrsfi_runtime.analysis.drawing import Draw
from mrsfi_runtime.analysis.fronts import Front, Harm, Pick
from mrsfi_runtime.analysis.summary import Summary, as_json
from mrsfi_runtime.analysis.tables import Rows, front_table, harm_table, in_words
from mrsfi_runtime.analysis.weaknesses import said
from mrsfi_runtime.causes.ways import least
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.tables import critical_tables, plain_table
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.cli.ways import print_list, print_ways
from mrsfi_runtime.record.measure import Measure, ticks


def report(
    campaign: OpenCampaign, ratio: str | None, *, is_json: bool, draw: Draw | None = None
) -> None:
    """Write the report into a campaign's folder and print what it says, or JSON for a script."""

    def show(summary: Summary) -> None:
        if is_json:
            print_json({"folder": str(path), **as_json(summary)})
        else:
            _print_summary(campaign, summary)
        tell(f"drawing figures into {campaign.folder.figures}, and {campaign.folder.page}")

    path = campaign.folder.path
    try:
        write_report(campaign, ratio, draw, show)
    except KeyboardInterrupt:
        tell(f"figures are missing from the report; write it anew with: mrsfi report {path}")
        raise


def _print_summary(campaign: OpenCampaign, summary: Summary) -> None:
    """Print what breaks goals, or the most critical specifications; and where everything is."""
    folder, measure = campaign.folder, summary.measure
    mission, pool = campaign.mission, campaign.pool
    if summary.harvest is not None and summary.ways:
        click.echo(f"{said(mission.goal_ids, summary.ways, summary.harvest.n_flights)}\n")
        print_ways(mission, pool, summary.ways)
        _print_least(campaign, summary)
    else:
        n_top, n_distinct = len(summary.top), summary.n_distinct
        title = f"The {n_top} most critical of {n_distinct} fault specifications"
        print_table(title, *critical_tables(measure, pool, summary.top))
    if summary.front is not None:
        _print_front(summary.front)
    if summary.harm:
        _print_harm(summary.harm, summary.measure)
    if summary.pick is not None:
        click.echo(_picked(campaign, summary.pick, summary.measure) + "\n")
    if summary.ways:
        click.echo(f"all ways        mrsfi weaknesses {folder.path}")
        click.echo(f"pictures        mrsfi show {folder.path}")
    click.echo(f"specifications  {folder.critical}")
    click.echo(f"report          {folder.report}")
    click.echo(f"page            {folder.page}")
    click.echo(f"campaign        {folder.path}")
    click.echo(f"evaluations     {summary.n_evaluations}, failed {summary.n_failures}")
    click.echo(f"digest          {summary.digest}")


def _print_least(campaign: OpenCampaign, summary: Summary) -> None:
    """Print what is the least that breaks each goal, in its mildest form, and how that comes."""
    shown = least(summary.ways)
    print_list(
        campaign.mission,
        campaign.pool,
        shown,
        "The least that breaks each goal, in its mildest form",
    )
    for way in shown:
        if way.mildest is not None:
            click.echo(f"{way.number} {way.mildest.sentence}\n")
        for sentence in summary.sentences.get(way.number, ()):
            click.echo(f"{way.number} {way.goal}: {sentence}\n")


def _print_front(front: Front) -> None:
    title = (
        f"Pareto front: {len(front.points)} trade-offs between {', '.join(front.aims)} "
        f"({front.counts})"
    )
    _print_numbers(title, front_table(front))


def _print_harm(harm: Sequence[Harm], measure: Measure) -> None:
    title = f"Most harm with how few {measure.minimised} ({measure}, {', '.join(measure.chosen)})"
    _print_numbers(title, harm_table(harm, str(measure.minimised)))


def _print_numbers(title: str, rows: Rows) -> None:
    header, *numbers = in_words(rows)
    print_table(title, plain_table((), header, numbers))


def _picked(campaign: OpenCampaign, pick: Pick, measure: Measure) -> str:
    if pick.point is None:
        return f"nearest to {pick.ratio}: none, because no specification violates these goals"
    violations = measure.by_goal(campaign.store.evaluation(pick.point.evaluation))
    found = ", ".join(f"{goal} {ticks(violations[goal])}" for goal in pick.ratio.goals)
    return (
        f"nearest to {pick.ratio}: evaluation {pick.point.evaluation} with {found} "
        f"({measure}){pick.distance_in_words}"
    )
