"""The command ``mrsfi show``: how goals break, in words and in pictures."""

from pathlib import Path

import click

from mrsfi.campaign_folders import open_campaign
from mrsfi.reporting import show
from mrsfi.weaknesses import harvested
from mrsfi_runtime.analysis.weaknesses import said


def show_ways(run: Path, number: int | None) -> None:
    """Print each way to break a goal as soon as it is drawn, and its pictures."""
    with open_campaign(run) as campaign:
        found = harvested(campaign)
        if number is None:
            click.echo(f"{said(campaign.mission.goal_ids, found.ways, found.n_flights)}\n")
        for each in show(campaign, number):
            click.echo(f"{each.way.number}  {each.title}")
            for line in (*each.sentences, *each.figures):
                click.echo(f"    {line}")
            click.echo()
