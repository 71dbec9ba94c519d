"""Campaigns from the first evaluation to the last.

``begun`` makes a new campaign and ``resumed`` opens an interrupted one; ``evolve`` runs either to
its end: search, a second flight of the first specifications, and the harvest of weaknesses. All
objections to a campaign are reported before anything is written. For an external node,
``within_reach`` finds the faults that reach it; ``repetition_checked`` checks that flights repeat.
"""

import platform
import subprocess
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from random import Random
from types import MappingProxyType
from typing import TypeAlias

from mrsfi.campaign_folders import FlyableCampaign, free_folder, open_to_fly, tried_again
from mrsfi.engines import Tell, own_engine, silent
from mrsfi.engines import evaluator as evaluating
from mrsfi.explaining import harvest
from mrsfi.folders import MissionFolders
from mrsfi_runtime.analysis.fronts import parse_ratio
from mrsfi_runtime.causes.confirmation import N_LOOKS
from mrsfi_runtime.causes.harvest import Cover
from mrsfi_runtime.engine.compiled.engine import differing
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.opening import open_engine, tried
from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import EvaluationError, ReplayMismatch, UsageError, WorkerLost, counted
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Specification, unprotected
from mrsfi_runtime.model.mission import Evaluated, FailedFlight, Mission
from mrsfi_runtime.project_file import installed_version
from mrsfi_runtime.record.database import CampaignFolder, only_writer
from mrsfi_runtime.record.engine_settings import (
    BOTH,
    CI,
    INJECTOR,
    EngineSettings,
    Manifest,
    Workers,
)
from mrsfi_runtime.record.settings import COVER, CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Measure
from mrsfi_runtime.search import algorithms
from mrsfi_runtime.search.loop import AlgorithmFactory
from mrsfi_runtime.search.run import CampaignProgress, EvaluateMany, require_settings, run_campaign
from mrsfi_runtime.search.space import SearchSpace, random_specification

ALGORITHMS: Mapping[str, AlgorithmFactory] = MappingProxyType(
    {**algorithms.ALGORITHMS, "cover": Cover}
)
"""All algorithms by their name in a campaign file, those of ``ALGORITHM_NAMES``."""


def within_reach(
    code: MissionCode, engine: EngineSettings, tell: Tell
) -> tuple[MissionCode, EngineSettings]:
    """Return code and settings without the faults that cannot be injected; report these.

    If no fault is left, it is a ``UsageError``.
    """
    if engine.side != INJECTOR:
        return code, engine
    from mrsfi_runtime.cosimulation import node_speech  # noqa: PLC0415 - brings types of ROS

    speech = node_speech.Speech.of(engine.node_mapping, code.mission)
    beyond = node_speech.out_of_reach(code.mission, code.pool, speech)
    touching = defaultdict(list)
    for fault, touched in beyond.items():
        touching[touched].append(fault)
    if touching:
        listed = "; ".join(f"{what} ({', '.join(faults)})" for what, faults in touching.items())
        tell(f"left out, because no topic of your node carries what they change: {listed}")
    pool = code.pool.without(beyond)
    if not pool:
        raise UsageError(
            f"none of {counted(len(code.pool), 'faults')} can be injected: no topic of [node] "
            "carries what they change (docs/node.md)"
        )
    return replace(code, pool=pool), replace(engine, node_left_out=tuple(beyond))


def repetition_checked(
    code: MissionCode, engine: EngineSettings, settings: CampaignSettings, tell: Tell
) -> tuple[EngineSettings, str]:
    """Fly one specification several times; return settings, and why results may be chance.

    If external parts repeat themselves, each specification is flown once and the text is empty. If
    not, or if the node runs by its own clock, each is flown several times.
    """
    if not engine.is_foreign:
        return engine, ""
    space = SearchSpace.of(code.mission, unprotected(code.mission, code.pool, settings.protect))
    specification = random_specification(space, settings.faults, Random(settings.seed))
    with open_engine(engine, code, settings.mission_seed) as opened:
        found = [opened.evaluate(specification) for _ in range(N_LOOKS)]
    is_same, is_free = all(each == found[0] for each in found), engine.is_free
    seen = f"one specification, flown {N_LOOKS} times, "
    seen += "was the same" if is_same else f"had {', '.join(map(_shown, found))}"
    if is_same and not is_free:
        tell(f"flights with {engine.parts} repeat themselves: {seen}")
        return engine, ""
    how = "the node runs by its own clock" if is_free else "they do not repeat themselves"
    doubt = f"flights with {engine.parts} may be chance, because {how}: {seen}; each is flown "
    doubt += f"{N_LOOKS} times and judged by the median, and weaknesses are not searched for"
    tell(f"warning: {doubt}")
    return replace(engine, repeats=N_LOOKS), doubt


_NOW = partial(datetime.now, UTC)

Progress: TypeAlias = Callable[[CampaignProgress], None]
"""Receives the progress of a search after each generation."""

_UNEXPLAINED = "unexplained"  # key in the record of a campaign without weaknesses
_SEARCHED = "searched"  # key of the numbers of its results when a search has ended


def require_searchable(code: MissionCode, settings: CampaignSettings) -> None:
    """Refuse settings that do not fit a mission, and a pool that cannot be searched."""
    require_settings(settings, code.mission, algorithms=ALGORITHMS)
    left = unprotected(code.mission, code.pool, settings.protect)
    if settings.protect and not left:
        raise UsageError(
            f"{settings.where('protect')}: found {', '.join(settings.protect)}, which leaves out "
            f"all of {counted(len(code.pool), 'faults')}; expected elements without some faults"
        )
    SearchSpace.of(code.mission, left)


@contextmanager
def begun(
    folders: MissionFolders,
    code: MissionCode,
    settings: CampaignSettings,
    case: str,
    engine: EngineSettings,
    *,
    out: Path | None = None,
    ratio: str | None = None,
    tell: Tell = silent,
) -> Iterator[tuple[FlyableCampaign, EngineSettings]]:
    """Make a campaign without evaluations, and yield it to its only writer, with its engine.

    All objections are raised before anything is written. ``ratio`` is the ratio by which its report
    will pick a specification.
    """
    code, engine = within_reach(code, engine, tell)
    require_searchable(code, settings)
    if settings.protect:
        left_out = len(code.pool) - len(unprotected(code.mission, code.pool, settings.protect))
        what = f"{left_out} of {counted(len(code.pool), 'faults')}"
        tell(f"left out: {what}, which strike or touch {', '.join(settings.protect)}")
    _require_ratio(settings, code.mission, ratio)
    flown_by = tried(engine, code, settings.mission_seed, tell)
    engine, doubt = repetition_checked(code, engine, settings, tell)
    flown_by = replace(flown_by, repeats=engine.repeats)
    path = out or free_folder(folders.name, Path(case).stem)
    with made(path, folders, settings, case, engine), open_to_fly(path, tell) as campaign:
        campaign.store.record_difference(doubt)
        yield campaign, flown_by


@contextmanager
def made(
    path: Path,
    folders: MissionFolders,
    settings: CampaignSettings,
    case: str,
    engine: EngineSettings,
    clock: Callable[[], datetime] = _NOW,
) -> Iterator[None]:
    """Make a campaign without evaluations, and be its only writer while the body runs.

    ``clock`` returns the date and time that its record keeps.
    """
    commit, is_edited = commit_of(folders)
    folder = CampaignFolder.reserve(path)
    with only_writer(folder):
        imported = imported_files(folders.generated, settings.own_modules)
        folder.fill(folders.models, folders.generated, imported)
        manifest = Manifest(
            mission=folders.name,
            place=folders.place,
            case=case,
            engine=engine,
            versions={
                name: installed_version(name)
                for name in ("python", "mrsfi", "deap", "numpy", "pyecore")
            },
            machine=platform.machine(),
            sha256=folder.hashes(),
            cover=COVER,
            created=clock().isoformat(timespec="milliseconds"),
            commit=commit,
            is_edited=is_edited,
        )
        CampaignStore.create(path, settings, manifest).close()
        yield


def commit_of(folders: MissionFolders) -> tuple[str, bool]:
    """Return the commit of a mission's folder, and whether models or code differ from it.

    Without git the commit is empty.
    """
    line = ["git", "-C", str(folders.models), "-c", "core.fsmonitor=false", "status"]
    line += ["--porcelain=v2", "--branch", "--", ".", str(folders.generated.resolve())]
    try:
        done = subprocess.run(line, capture_output=True, check=True, encoding="utf-8", timeout=30)
    except (OSError, ValueError, subprocess.SubprocessError):
        return "", False
    head, *rest = done.stdout.splitlines()
    commit = head.removeprefix("# branch.oid ")
    return ("", False) if commit == "(initial)" else (commit, any(each[0] != "#" for each in rest))


@contextmanager
def resumed(
    path: Path, engine: EngineSettings, *, ratio: str | None, tell: Tell
) -> Iterator[tuple[FlyableCampaign, EngineSettings]]:
    """Yield an interrupted campaign to its only writer, with the engine that continues it."""
    with only_writer(CampaignFolder(path)), open_to_fly(path, tell) as campaign:
        store = campaign.store
        store.require_repeatable()
        warn_of_versions(store.manifest, tell)
        counts = f"{store.n_generations} generations, {store.n_evaluations} evaluations"
        tell(f"resuming {path}: {counts} and {store.n_failures} failures are recorded")
        _require_ratio(store.settings, campaign.mission, ratio)
        yield campaign, tried_again(campaign, engine, tell)


def warn_of_versions(manifest: Manifest, tell: Tell) -> None:
    """Warn of each version that decides a result and differs today."""
    for name, version in manifest.versions.items():
        now = installed_version(name)
        if now != version:
            what = f"begun with {name} {version}, continued with {now}"
            tell(f"warning: {what}: the result may differ from an uninterrupted run")


def _beyond(campaign: FlyableCampaign) -> str:
    """Return the ranges of the parameters that a search varies beyond the values of the pool."""
    space = SearchSpace.of(campaign.mission, campaign.pool)
    wide: dict[str, tuple[float, float]] = {}
    for identifier, candidate in space.candidates.items():
        fault = space.gate.pool[identifier]
        ranges = zip(fault.kind.parameters, fault.values, candidate.bounds, strict=True)
        for parameter, value, (low, high) in ranges:
            if low < value or value < high:
                before = wide.get(parameter.name, (low, high))
                wide[parameter.name] = min(low, before[0]), max(high, before[1])
    return ", ".join(f"{name} {low:.6g} … {high:.6g}" for name, (low, high) in wide.items())


def _require_ratio(settings: CampaignSettings, mission: Mission, ratio: str | None) -> None:
    """Refuse a wrong ratio before the search, not after it."""
    if ratio is not None:
        Measure.of(settings, mission).require(parse_ratio(ratio).goals)


def evolve(
    campaign: FlyableCampaign,
    engine: EngineSettings,
    workers: Workers,
    watched: AbstractContextManager[Progress],
    *,
    explains: bool | None = None,
    tell: Tell = silent,
) -> None:
    """Search to the end, and then find all weaknesses.

    ``watched`` yields the function to call after each generation. ``explains`` is as the campaign
    was begun if left out. If external parts do not repeat themselves, there is only the search.
    """
    path, store, settings = campaign.folder.path, campaign.store, campaign.store.settings
    explains = _explains(store, explains)
    seed, before = settings.mission_seed, (store.n_generations, store.n_flights)

    def tell_who(who: str) -> None:
        tell(f"campaign {path}: {settings.algorithm}, seed {settings.seed}, {engine.words}, {who}")
        if not store.n_evaluations and (wide := _beyond(campaign)):
            tell(f"ranges searched beyond the pool's values: {wide}")

    with evaluating(campaign.code, seed, engine, workers, tell, tell_who) as many:
        _finish_search(campaign, many, watched, tell)
        if settings.is_short(store.n_evaluations + store.n_failures):
            what = f"{store.n_evaluations} of {settings.evaluations} evaluations"
            tell(f"the search ended after {what}: it found no new specification to fly")
        if explains and not store.manifest.engine.unrepeated:
            try:
                with own_engine(many, campaign.code, seed, engine) as own:
                    harvest(campaign, many, own, tell)
            except WorkerLost:
                raise
            except EvaluationError as error:
                tell(f"weaknesses are not searched for: {error}")
    if (store.n_generations, store.n_flights) == before:
        tell("the campaign was finished already; its report is written again")


def _finish_search(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    watched: AbstractContextManager[Progress],
    tell: Tell,
) -> None:
    """Search to the end; what the record says has ended is not repeated, which takes long."""
    store = campaign.store

    def size() -> str:
        return f"{store.n_evaluations} {store.n_failures} {store.n_generations}"

    if store.kept(_SEARCHED, str) != size():
        with watched as progress:
            search(campaign, evaluator, progress, tell)
        store.keep(_SEARCHED, size())


def _explains(store: CampaignStore, asked: bool | None) -> bool:
    """Return whether to search for weaknesses: as asked, or as the campaign was begun."""
    if asked is False:
        store.keep(_UNEXPLAINED, "")
    is_wanted = store.kept(_UNEXPLAINED, str) is None or store.n_flights > 0
    return is_wanted if asked is None else asked


def search(
    campaign: FlyableCampaign, evaluator: Evaluator, progress: Progress, tell: Tell = silent
) -> None:
    """Run the search of a campaign to its end, and fly its first specifications again.

    There is one for each worker, and the last comes first. If one has another outcome, this is
    recorded. With external parts ``tell`` receives a warning; without, it is a ``ReplayMismatch``.
    """
    store, settings = campaign.store, campaign.store.settings
    firsts: list[tuple[Specification, Evaluated]] = []
    evaluate_many: EvaluateMany
    evaluate_many, *replicas = (
        partial(evaluator.evaluate_many, seed=seed) for seed in settings.mission_seeds
    )

    def noted(specifications: Sequence[Specification]) -> Iterator[Evaluated]:
        for each, found in zip(specifications, evaluate_many(specifications), strict=True):
            if len(firsts) < evaluator.n_workers:
                firsts.append((each, found))
            yield found

    run_campaign(
        settings,
        campaign.mission,
        campaign.pool,
        noted,
        store,
        progress,
        replicas=replicas,
        algorithms=ALGORITHMS,
    )
    if store.manifest.engine.is_foreign and store.manifest.engine.unrepeated:
        return
    again = evaluate_many([specification for specification, _ in reversed(firsts)])
    for (specification, found), other in zip(reversed(firsts), again, strict=True):
        if other != found and {type(other), type(found)} != {FailedFlight}:
            seen = f"had {_shown(found)} and, once more at the end, {_shown(other)}"
            _doubt(campaign, specification, seen, tell)
            return


def _doubt(campaign: FlyableCampaign, flown: Specification, seen: str, tell: Tell) -> None:
    store, side = campaign.store, campaign.store.manifest.engine.side
    known = (each.index for each in store.evaluations() if each.specification == flown)
    what = f"does not repeat itself: evaluation {next(known, 'that failed')} {seen}"
    if side != BOTH:
        what = f"the external {'simulation' if side == CI else 'node'} {what}"
        tell(f"warning: {what}; results may be chance")
    else:
        found = differing(campaign.code, flown, store.settings.mission_seed)
        what = f"the mission {what}; {found}"
    store.record_difference(f"{what}; results may be chance")
    if side == BOTH:
        raise ReplayMismatch(f"{campaign.folder.path}: {what}; then begin a new campaign")


def _shown(found: Evaluated) -> str:
    if isinstance(found, FailedFlight):
        return "an error"
    return f"{sum(found.believed)} believed violations (digest {found.digest[:8]}…)"
