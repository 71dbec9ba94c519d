"""The command ``mrsfi evolve``: begins a campaign or continues one, by one writer at a time."""

import platform
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from mrsfi.campaign_folders import FlyableCampaign, free_folder, open_to_fly
from mrsfi.evolving import begun, require_searchable, search
from mrsfi.folders import campaign_file, find_mission
from mrsfi.loading import load_fresh
from mrsfi.versions import installed_version
from mrsfi_runtime.analysis.drawing import DrawingProcess
from mrsfi_runtime.analysis.fronts import parse_ratio
from mrsfi_runtime.analysis.report import map_drawing
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.engines import (
    EngineOptions,
    WorkerOptions,
)
from mrsfi_runtime.cli.progress import search_progress, share
from mrsfi_runtime.cli.report import report
from mrsfi_runtime.cli.weaknesses import show_harvest
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import EvaluationError, TransportError, UsageError, WorkerLost
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.folder import CampaignFolder, only_writer
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore

_FREE = frozenset(
    {"resume", "ratio", "no_explain", "is_json"}
    | {option.name for options in (EngineOptions, WorkerOptions) for option in fields(options)}
)
"""Parameters of ``mrsfi evolve`` that do not decide what a campaign finds."""


@contextmanager
def resumed(path: Path, ctx: click.Context) -> Iterator[None]:
    """Be the writer of a campaign from before while the body runs."""
    with CampaignStore.open(path) as store:  # first: a lock makes no sense where no campaign is
        store.require_flyable()
        manifest, settings = store.manifest, store.settings
    begun_with = {"mission": manifest.mission, "case": manifest.case, **settings.as_json()}
    _require_same_options(path, ctx, begun_with)
    with only_writer(CampaignFolder(path)):
        _tell_other_versions(manifest.versions)
        with CampaignStore.open(path) as store:
            tell(
                f"resuming {path}: {store.n_generations} generations, {store.n_evaluations} "
                f"evaluations and {store.n_failures} failures are recorded"
            )
        yield


def _require_same_options(path: Path, ctx: click.Context, recorded: Mapping[str, Any]) -> None:
    for parameter in ctx.command.params:
        name = str(parameter.name)
        if name in _FREE or ctx.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        given = ctx.params[name]
        label = parameter.opts[0] if isinstance(parameter, click.Option) else "MISSION"
        if name not in recorded:
            raise UsageError(
                f"{label} {given}: makes no sense with --resume; {path} goes on in its own folder, "
                "on its own copies of models and code; leave it out"
            )
        found = Path(given).name if name == "mission" else given
        if found != recorded[name]:
            raise UsageError(
                f"{label}: found {given}; {path} was begun with {recorded[name]} and goes on with "
                "it; leave the option out, or begin a new campaign without --resume"
            )


def _tell_other_versions(recorded: Mapping[str, str]) -> None:
    for name, version in recorded.items():
        now = platform.python_version() if name == "python" else installed_version(name)
        if now != version:
            tell(
                f"warning: begun with {name} {version}, going on with {now}: "
                "the result may differ from that of one run"
            )


def evolve(
    ctx: click.Context,
    /,
    *,
    engine: EngineOptions,
    workers: WorkerOptions,
    resume: Path | None,
    ratio: str | None,
    no_explain: bool,
    is_json: bool,
    **given: Any,
) -> None:
    """Evolve fault specifications against a mission and print the most critical."""
    tried = None
    if resume is None:
        asked = engine.settings(default=AUTO)
        workers.require_sense(asked)
        path, writer, tried = _new_campaign(ratio, asked, **given)
    else:
        path, writer = resume, resumed(resume, ctx)
    with writer, open_to_fly(path, tell) as campaign:
        _require_ratio(campaign.store.settings, campaign.mission, ratio)
        with DrawingProcess(map_drawing(campaign.mission)) as process:
            flown_by = tried or _tried(campaign, engine, workers)
            _search(campaign, flown_by, workers, explains=not no_explain)
            report(campaign, ratio, is_json=is_json, draw=process.draw)


def _new_campaign(
    ratio: str | None,
    engine: EngineSettings,
    mission: str | None,
    generated: Path | None,
    case: str | None,
    out: Path | None,
    **overrides: object,
) -> tuple[Path, AbstractContextManager[None], EngineSettings]:
    """Refuse what cannot be searched; return the campaign's folder, what begins it, the engine."""
    if mission is None:
        raise UsageError("found no MISSION; expected one, or --resume DIR to go on with a campaign")
    case = case or "a"
    folders = find_mission(mission, generated)
    settings = CampaignSettings.load(campaign_file(folders, case), **overrides)
    code = load_fresh(folders)
    require_searchable(code, settings)
    _require_ratio(settings, code.mission, ratio)
    tried = engine.tried(code, settings.mission_seed, tell)
    path = free_folder(folders.name, Path(case).stem) if out is None else out
    return path, begun(path, folders, settings, case, engine), tried


def _tried(
    campaign: FlyableCampaign, options: EngineOptions, workers: WorkerOptions
) -> EngineSettings:
    """Return the engine that a campaign from before goes on with."""
    engine = options.settings(campaign.store.manifest.engine, AUTO)
    workers.require_sense(engine)
    return engine.tried(campaign.code, campaign.store.settings.mission_seed, tell)


def _require_ratio(settings: CampaignSettings, mission: Mission, ratio: str | None) -> None:
    """Refuse a ratio that makes no sense before the search, not after it."""
    if ratio is not None:
        Measure.of(settings, mission).require(parse_ratio(ratio).goals)


def _search(
    campaign: FlyableCampaign, settings: EngineSettings, workers: WorkerOptions, *, explains: bool
) -> None:
    """Search, and then find all the ways in which goals break."""
    path, store = campaign.folder.path, campaign.store
    chosen = store.settings

    def tell_who(who: str) -> None:
        tell(f"campaign {path}: {chosen.algorithm}, seed {chosen.seed}, {settings.words}, {who}")

    seed = chosen.mission_seed
    try:
        with workers.evaluator(campaign.code, seed, settings, tell_who) as evaluator:
            n_generations = store.n_generations
            _run(campaign, evaluator)
            is_new = store.n_generations > n_generations
            if explains and settings.has_simulation:
                is_new |= _harvest(campaign, evaluator, settings)
    except (KeyboardInterrupt, TransportError, WorkerLost):
        tell(f"what was found until now is kept; see it with: mrsfi report {path}")
        tell(f"go on with: mrsfi evolve --resume {path}")
        raise
    if not is_new:
        tell("was finished already; its report is written anew")


def _run(campaign: FlyableCampaign, evaluator: Evaluator) -> None:
    """Run the search to its end, and show how far it is."""
    store = campaign.store
    n_flown = store.n_evaluations + store.n_failures
    recorded = share(store.settings, store.n_generations, n_flown)
    with search_progress(store.settings, recorded) as progress:
        search(campaign, evaluator, progress)


def _harvest(campaign: FlyableCampaign, evaluator: Evaluator, settings: EngineSettings) -> bool:
    """Find all the ways in which goals break; return whether anything was flown."""
    try:
        return show_harvest(campaign, evaluator, settings)
    except WorkerLost:
        raise
    except EvaluationError as error:
        tell(f"what breaks which goal is not looked for: {error}")
        return False
