"""The report of a campaign: written into its folder, and printed."""

import click

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.reporting import report as write_report
from mrsfi_runtime.analysis.campaign_tables import critical_table, front_table, harm_table
from mrsfi_runtime.analysis.drawing import Draw
from mrsfi_runtime.analysis.summary import Summary, as_json
from mrsfi_runtime.analysis.weaknesses import matrix_table, said, way_table
from mrsfi_runtime.causes.ways import least
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.terminal import print_table


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
        print_table(matrix_table(mission, pool, summary.ways))
        _print_least(campaign, summary)
    else:
        print_table(critical_table(measure, pool, summary.top, summary.n_distinct))
    if summary.front is not None:
        print_table(front_table(summary.front))
    if summary.harm:
        print_table(harm_table(summary.harm, measure))
    if summary.pick is not None:
        click.echo(f"{summary.pick.in_words(measure)}\n")
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
    title = "The least that breaks each goal, in its mildest form"
    print_table(way_table(title, campaign.mission, campaign.pool, shown))
    for way in shown:
        if way.mildest is not None:
            click.echo(f"{way.number} {way.mildest.sentence}\n")
        for sentence in summary.sentences.get(way.number, ()):
            click.echo(f"{way.number} {way.goal}: {sentence}\n")
