"""The command ``mrsfi keep``: keeps a finding beside the models, and takes new limits over."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import click

from m2t.specification import write_specification
from mrsfi_runtime.analysis.columns import top
from mrsfi_runtime.analysis.findings import Finding, find_findings
from mrsfi_runtime.analysis.report import specification_rows
from mrsfi_runtime.analysis.summary import N_TOP, explained
from mrsfi_runtime.cli.campaigns import OpenCampaign, open_campaign
from mrsfi_runtime.cli.console import tell, whole_file
from mrsfi_runtime.cli.engines import EngineOptions
from mrsfi_runtime.cli.folders import find_mission
from mrsfi_runtime.cli.regressions import check_all
from mrsfi_runtime.engine.settings import AUTO
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.regressions import Regression, folder_of


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
        _keep(campaign, finding, name, limits)


def _keep(
    campaign: OpenCampaign, number: int, name: str | None, limits: Mapping[str, int] | None
) -> None:
    path = campaign.folder.path
    campaign.store.require_flyable()  # counts of other rules are no limits of today's
    found = _finding(campaign, number)
    settings = campaign.store.settings
    folders = find_mission(campaign.store.manifest.mission)
    folder = folder_of(folders.models)
    stem = f"{path.resolve().name}-finding-{number}" if name is None else name
    if not stem or stem != Path(stem).name:
        raise UsageError(f"--name: found '{stem}'; expected the name of a file, without a folder")
    regression = Regression(
        folder / f"{stem}.toml",
        f"{path}, finding {number}: {found.sentence}",
        settings.violations,
        (settings.mission_seed,),
        {},
    )
    goals = campaign.mission.goal_ids
    counts = dict(zip(goals, getattr(found.outcome, settings.violations), strict=True))
    regression = replace(regression, limits=counts if limits is None else limits)
    regression.counts(goals, found.outcome)  # refuses goals that there are not
    if regression.path.exists() or regression.specification.exists():
        raise UsageError(
            f"{regression.path}: is kept already; choose another name with --name, or take new "
            f"limits over with: mrsfi keep {folders.name} --update"
        )
    specification = tuple(fault.timed for fault in found.faults)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be made: {error.strerror}") from error
    write_specification(
        folders.models,
        specification_rows(campaign.pool, specification),
        regression.specification,
        identifier="kept",
        names=[fault.name for fault in found.faults],
    )
    _write(regression)
    tell(f"kept       {regression.specification}")
    tell(f"limits     {regression.path}")


def _finding(campaign: OpenCampaign, number: int) -> Finding:
    store = campaign.store
    measure = Measure.of(store.settings, campaign.mission)
    tops = {each.index: each.specification for each in top(store, measure, N_TOP)}
    findings = find_findings(campaign.mission, campaign.pool, explained(store, tops), tops)
    if not 1 <= number <= len(findings):
        has = f"1 … {len(findings)}" if findings else "a campaign that has findings; it has none"
        raise UsageError(f"{campaign.folder.path}: found --finding {number}; expected {has}")
    return findings[number - 1]


def _update(mission: str, name: str | None, engine: EngineOptions) -> None:
    """Take over what is counted today, and print what changed."""
    folders = find_mission(mission)
    checked = [*check_all(folders, engine.settings(default=AUTO), name=name)]
    failures = [each.error for each in checked if each.error is not None]
    if failures:
        raise failures[0]
    n_changed = 0
    for each in checked:
        before = each.regression.limits
        if each.counts == before:
            continue
        n_changed += 1
        _write(replace(each.regression, limits=each.counts))
        click.echo(each.regression.name)
        for goal, ticks in each.counts.items():
            if ticks != before[goal]:
                click.echo(f"  {goal}: {before[goal]} → {ticks}")
    if not n_changed:
        click.echo("no difference")


def _write(regression: Regression) -> None:
    with whole_file(regression.path) as file:
        file.write(regression.text().encode())
