"""The report of a campaign: written into its folder, and printed."""

import click

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.explaining import report as write_report
from mrsfi_runtime.analysis.illustrations import Draw
from mrsfi_runtime.analysis.summary import Summary, as_json
from mrsfi_runtime.analysis.tables import critical_table, front_table, harm_table
from mrsfi_runtime.analysis.weaknesses import matrix_table
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.cli.ways import print_verdicts


def report(
    campaign: OpenCampaign,
    ratio: str | None,
    *,
    is_json: bool,
    draw: Draw | None = None,
    latex: bool = False,
) -> None:
    """Write the report into a campaign's folder and print what it says, or JSON for a script."""

    def show(summary: Summary) -> None:
        if is_json:
            print_json({"folder": str(path), **as_json(summary)})
        else:
            _print_summary(campaign, summary)
        tell(f"drawing figures into {campaign.folder.figures}, and {campaign.folder.page}")
        if latex:
            tell(f"for LaTeX  {campaign.folder.latex}")

    path = campaign.folder.path
    try:
        write_report(campaign, ratio, draw, show, latex=latex)
    except KeyboardInterrupt:
        tell(f"figures are missing from the report; write it anew with: mrsfi report {path}")
        raise


def _print_summary(campaign: OpenCampaign, summary: Summary) -> None:
    folder, known = campaign.folder.path, summary.harvest
    mission, pool = campaign.mission, campaign.pool
    if known is not None and summary.ways:
        print_table(matrix_table(mission, pool, summary.ways))
    else:
        print_table(critical_table(summary.measure, pool, summary.top, summary.n_distinct))
    if summary.front is not None:
        print_table(front_table(summary.front))
    if summary.harm:
        print_table(harm_table(summary.harm, summary.measure))
    if summary.pick is not None:
        click.echo(f"{summary.pick.in_words(summary.measure)}\n")
    if known is not None:
        print_verdicts(campaign, known)
    failed = f", {summary.n_failures} failed" if summary.n_failures else ""
    click.echo(f"campaign  {folder}: {summary.counted}{failed}")
    click.echo(f"digest    {summary.digest}")
    click.echo(f"page      {campaign.folder.page}")
    if known is None:
        doubt, advice = summary.unrepeated, f"mrsfi explain {folder} --all"
        click.echo(f"caution   {doubt}" if doubt else f"next      {advice}")
    elif summary.ways:
        click.echo(f"next      mrsfi show {folder}")
