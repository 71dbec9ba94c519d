"""The command ``mrsfi keep``: keeps a finding beside the models, and takes new limits over."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click

from mrsfi.campaign_folders import open_campaign
from mrsfi.folders import find_mission
from mrsfi.regressions import check_all, write_limits
from mrsfi.regressions import keep as keep_finding
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.engines import EngineOptions
from mrsfi_runtime.engine.settings import AUTO


def keep(
    target: str,
    *,
    finding: int | None,
    name: str | None,
    limits: Mapping[str, int] | None,
    update: bool,
    engine: EngineOptions,
) -> None:
    """Keep a finding of a campaign, or take over what is counted today of all that is kept."""
    if update:
        if finding is not None or limits is not None:
            raise click.UsageError("--update is about all that is kept; it takes no other option")
        _update(target, name, engine)
        return
    if finding is None:
        raise click.UsageError("--finding N is missing: which finding of the campaign to keep")
    with open_campaign(Path(target)) as campaign:
        regression = keep_finding(campaign, finding, name, limits)
    tell(f"kept       {regression.specification}")
    tell(f"limits     {regression.path}")


def _update(mission: str, name: str | None, engine: EngineOptions) -> None:
    """Take over what is counted today, and print what changed."""
    folders = find_mission(mission)
    checked = [*check_all(folders, engine.settings(default=AUTO), tell, name=name)]
    failures = [each.error for each in checked if each.error is not None]
    if failures:
        raise failures[0]
    changed = [each for each in checked if each.counts != each.regression.limits]
    if changed:
        write_limits(folders, [replace(each.regression, limits=each.counts) for each in changed])
    for each in changed:
        before = each.regression.limits
        click.echo(each.regression.name)
        for goal, ticks in each.counts.items():
            if ticks != before[goal]:
                click.echo(f"  {goal}: {before[goal]} → {ticks}")
    if not changed:
        click.echo("no difference")
