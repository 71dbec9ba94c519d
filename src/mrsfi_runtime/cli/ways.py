"""How weaknesses are printed: which fault breaks which goal, as a matrix and as a list."""

from collections.abc import Sequence
from dataclasses import replace

import click

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.explaining import untried
from mrsfi_runtime.analysis.weaknesses import (
    State,
    facts,
    harmless,
    headline,
    matrix_table,
    not_found,
    verdicts,
    way_table,
)
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.causes.weakness import Known
from mrsfi_runtime.cli.console import print_json
from mrsfi_runtime.cli.terminal import print_table, print_words
from mrsfi_runtime.errors import counted

_MOST_UNTRIED = 10
"""Faults and pairs that are named at most, of those that were never flown."""


def print_verdicts(
    campaign: OpenCampaign, known: Harvest, goals: Sequence[str] | None = None
) -> None:
    """Print of some goals in a sentence each whether they break, by what, and how sure that is."""
    mission, pool = campaign.mission, campaign.pool
    wanted = mission.goal_ids if goals is None else goals
    found = [each for each in verdicts(mission, pool, known) if each.goal in wanted]
    print_words((headline(found), "bold"))
    for fact in facts(mission, pool, found, known.ways):
        print_words(fact)
    click.echo()
    held = [each for each in found if each.state is State.HOLDS]
    for each in found[: len(found) - len(held)]:
        state = (each.words, "bold red" if each.state <= State.VIOLATED else "bold")
        print_words((each.label, "bold"), " ", state, each.because)
        print_words(" · ".join(each.evidence), indent=4)
    for unknown in dict.fromkeys(each.unknown for each in held):
        some = ", ".join(each.label for each in held if each.unknown == unknown)
        print_words(("Nothing was found that breaks ", "bold"), f"{some} ({unknown})")
    for each in held:
        if each.nearest:
            print_words(f"{each.label} {each.nearest}", indent=4)
    click.echo()


def print_all(
    campaign: OpenCampaign, known: Harvest, found: Sequence[Way], goals: Sequence[str]
) -> None:
    """Print ways to break goals, what was not found of these, and what was never flown."""
    mission, pool = campaign.mission, campaign.pool
    print_verdicts(campaign, known, goals)
    if found:
        print_table(matrix_table(mission, pool, found))
        print_table(way_table("How, in one of the forms that do", mission, pool, found))
    click.echo("\n".join(not_found(known.known, each) for each in goals) + "\n")
    click.echo(f"{harmless(pool, known.ways)}\n{_never_flown(campaign)}")


def _never_flown(campaign: OpenCampaign) -> str:
    n_faults, never = len(campaign.pool), untried(campaign)
    return (
        f"Of {n_faults} faults and {n_faults * (n_faults - 1) // 2} pairs, never flown: "
        f"{', '.join(' with '.join(each) for each in never[:_MOST_UNTRIED]) or 'none'}"
        f"{f' and {len(never) - _MOST_UNTRIED} more' if len(never) > _MOST_UNTRIED else ''}"
    )


def print_bounds(known: Known, goals: Sequence[str]) -> None:
    """Print how seldom some goals may break in a way that is not known, for a script."""
    told = [
        {"goal": column.goal, "measure": column.kind, "draws": n, "bound": known.bound(column)}
        for column, n in known.n_kept.items()
        if column.goal in goals
    ]
    print_json(told)


def print_mildest(campaign: OpenCampaign, found: Sequence[Way], *, is_json: bool) -> None:
    """Print the mildest form of each of some ways to break a goal."""
    told = [(way, way.mildest) for way in found if way.mildest is not None]
    if is_json:
        print_json([{"number": way.number, **each.as_json()} for way, each in told])
        return
    shown = [replace(way, by=(each.weakness,)) for way, each in told]
    title = "The mildest form that was found"
    print_table(way_table(title, campaign.mission, campaign.pool, shown))
    for way, each in told:
        click.echo(f"{way.number}  {each.sentence} ({counted(each.n_flights, 'flights')})")
