"""The command ``mrsfi keep``: keeps a weakness beside the models, and takes new limits over."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click

from mrsfi.campaign_folders import open_campaign
from mrsfi.folders import find_mission
from mrsfi.regressions import check_all, write_limits
from mrsfi.regressions import keep as keep_weakness
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.engines import EngineOptions
from mrsfi_runtime.engine.settings import AUTO


def keep(
    target: str,
    *,
    weakness: int | None,
    name: str | None,
    limits: Mapping[str, int] | None,
    update: bool,
    n_seeds: int | None,
    engine: EngineOptions,
) -> None:
    """Keep a weakness of a campaign, or take over what is counted today of all that is kept."""
    if update:
        if weakness is not None or limits is not None:
            raise click.UsageError(
                "--update is about all that is kept; give no weakness, no limits"
            )
        _update(target, name, n_seeds, engine)
        return
    if weakness is None:
        raise click.UsageError("--weakness N is missing: which weakness of the campaign to keep")
    with open_campaign(Path(target)) as campaign:
        flown_by = engine.settings(campaign.store.manifest.engine, AUTO)
        regression = keep_weakness(campaign, weakness, name, limits, n_seeds or 1, flown_by)
    tell(f"kept       {regression.specification}")
    tell(f"limits     {regression.path}")


def _update(mission: str, name: str | None, n_seeds: int | None, engine: EngineOptions) -> None:
    """Take over what is counted today, and print what changed."""
    folders = find_mission(mission)
    checked = [*check_all(folders, engine.settings(default=AUTO), tell, n_seeds, name)]
    failures = [each.error for each in checked if each.error is not None]
    if failures:
        raise failures[0]
    updated = [
        (each.regression, replace(each.regression, mission_seeds=each.seeds, limits=each.now))
        for each in checked
    ]
    changed = [(before, new) for before, new in updated if new != before]
    if changed:
        write_limits(folders, [new for _, new in changed])
    for before, new in changed:
        click.echo(before.name)
        if new.mission_seeds != before.mission_seeds:
            n_before, n_new = len(before.mission_seeds), len(new.mission_seeds)
            click.echo(f"  mission seeds: {n_before} → {n_new}")
        for goal, ticks in new.limits.items():
            if ticks != before.limits[goal]:
                click.echo(f"  {goal}: {before.limits[goal]} → {ticks}")
    if not changed:
        click.echo("no difference")
