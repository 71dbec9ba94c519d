"""The command ``mrsfi explain``: which faults of a specification break which goal, and why."""

from collections.abc import Sequence
from pathlib import Path

import click

from mrsfi.campaign_folders import open_to_fly
from mrsfi.engines import own_engine
from mrsfi.explaining import (
    Explainer,
    NamedSpecification,
    evaluation_of,
    explainer_of_campaign,
    explainer_of_file,
    most_critical,
    require_repeatable,
)
from mrsfi.folders import find_mission, is_mission
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import EngineOptions, WorkerOptions
from mrsfi_runtime.cli.explained import Shown, as_json, print_explanation
from mrsfi_runtime.cli.progress import tell_of_fitness
from mrsfi_runtime.cli.weaknesses import harvest_now
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.record.folder import CampaignFolder


def explain_faults(  # noqa: PLR0913 - one parameter per option
    target: str,
    generated: Path | None,
    *,
    engine: EngineOptions,
    workers: WorkerOptions,
    faults: Path | None,
    best: bool,
    is_all: bool,
    evaluation: int | None,
    n_top: int | None,
    keep: float,
    kind: str | None,
    seed: int | None,
    out: Path | None,
    is_json: bool,
) -> None:
    """Find out which faults of a specification break which goal."""
    chosen = {
        "--best": best or None,
        "--all": is_all or None,
        "--evaluation": evaluation,
        "--top": n_top,
    }
    given = [option for option, value in chosen.items() if value is not None]
    if len(given) > 1:
        raise click.UsageError(f"{' and '.join(given)} exclude each other")
    if faults is not None:
        if given:
            raise click.UsageError(f"{given[0]} is about a campaign; --faults names a file")
        settings = engine.settings(default=AUTO)
        folders = find_mission(target, generated)
        explainer, subject = explainer_of_file(folders, faults, kind, seed, out, tell)
        _explain_all(explainer, [subject], settings, workers, keep, is_json=is_json)
        return
    if seed is not None or generated is not None:
        option = "--generated" if seed is None else "--seed"
        raise click.UsageError(
            f"{option} needs --faults; a campaign has code and mission seed of its own"
        )
    if is_all:
        harvest_now(_run(target), engine, workers, is_json=is_json)
        return
    with open_to_fly(_run(target), tell) as campaign:
        recorded_by = campaign.store.manifest.engine
        settings = engine.settings(recorded_by if recorded_by.is_foreign else None, AUTO)
        subjects = [] if n_top is None else most_critical(campaign, n_top)
        subjects = subjects or [evaluation_of(campaign, evaluation)]
        explainer = explainer_of_campaign(campaign, kind, out)
        tell_of_fitness(campaign.store.settings, explainer.measure)
        _explain_all(explainer, subjects, settings, workers, keep, is_json=is_json)


def _run(target: str) -> Path:
    """Return the folder of a campaign; the name of a mission is a ``UsageError`` that says so."""
    path = Path(target)
    if not CampaignFolder(path).database.is_file() and is_mission(target):
        raise UsageError(
            f"found mission '{target}'; expected the folder of a campaign, or --faults FILE with a "
            "fault specification of the mission"
        )
    return path


def _explain_all(
    explainer: Explainer,
    subjects: Sequence[NamedSpecification],
    settings: EngineSettings,
    workers: WorkerOptions,
    keep: float,
    *,
    is_json: bool,
) -> None:
    """Explain specifications one after the other; print each, and write its cause set."""
    workers.require_sense(settings)
    seed = explainer.mission_seeds[0]
    if settings.name == AUTO:
        settings = settings.tried(explainer.code, seed, tell)
    told = []
    with (
        workers.evaluator(explainer.code, seed, settings) as evaluator,
        own_engine(evaluator, explainer.code, seed, settings) as engine,
    ):
        for subject in subjects:
            if not settings.has_simulation:
                require_repeatable(engine, subject)
            found = explainer.explain(evaluator, engine, subject, keep)
            paths = explainer.write_sets(subject, found)
            shown = Shown(
                explainer.code, explainer.measure, subject.title, subject.faults, keep, paths
            )
            if is_json:
                told.append(as_json(shown, found))
            else:
                print_explanation(shown, found)
    if is_json:
        print_json({"explanations": told})
