"""The folders of campaigns: where they are, how they are opened, and whether a replay is the same.

``open_campaign`` reads a record and the campaign's copy of the models. ``open_to_fly`` also loads
its copy of the code, and refuses it if it changed since the campaign began. A replay must equal the
record bit for bit; ``require_same`` names the differences.
"""

import datetime as dt
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass, fields, replace
from pathlib import Path

from mrsfi.engines import Tell, from_here, project, silent
from mrsfi.folders import MissionFolders, find_mission, rendered
from mrsfi_runtime.analysis.fronts import Columns
from mrsfi_runtime.causes.harvest import KEPT
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine, tried
from mrsfi_runtime.errors import (
    GenerationError,
    ModelError,
    RecordError,
    ReplayMismatch,
    UsageError,
)
from mrsfi_runtime.fence import IMPORTED, copied_files
from mrsfi_runtime.generated_code import MissionCode, load_code, mission_from_text, pool_from_text
from mrsfi_runtime.model.faults import FaultPool, unprotected
from mrsfi_runtime.model.mission import Mission, Outcome
from mrsfi_runtime.project_file import MISSION_XMI, root
from mrsfi_runtime.record.database import CampaignFolder, hashes
from mrsfi_runtime.record.decisions import Cause, decision_on, decisions_of
from mrsfi_runtime.record.engine_settings import EngineSettings, Manifest
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure


@dataclass(frozen=True, slots=True)
class OpenCampaign:
    """A campaign with its store open, and the mission of its own copy of the models.

    ``pool`` has the faults among which it searches.
    """

    folder: CampaignFolder
    store: CampaignStore
    mission: Mission
    pool: FaultPool


@dataclass(frozen=True, slots=True)
class FlyableCampaign(OpenCampaign):
    """A campaign whose own copy of the code is loaded and unchanged."""

    code: MissionCode


def free_folder(mission: str, case: str) -> Path:
    """Make and return ``runs/<mission>-<case>-<n>`` with the first number that is free."""
    number = 1
    while True:
        path = project().runs / f"{mission}-{case}-{number}"
        try:
            path.mkdir(parents=True)
        except FileExistsError:
            number += 1
        except OSError as error:
            what = f"{path}: cannot be made: {error.strerror}"
            raise RecordError(f"{what}; choose a place with --out") from error
        else:
            return path


def campaigns_of(runs: Iterable[Path] = (), tell: Tell = silent) -> dict[Path, Manifest]:
    """Return what campaigns ran on, the earliest first, those without date before all others.

    By default, these are all in ``runs`` that can be read and have weaknesses.
    """
    found = {}
    for path in runs or sorted(each.parent for each in project().runs.glob("*/campaign.sqlite")):
        left_out = f"{path}: has no finished search for weaknesses"
        try:
            with CampaignStore.open(path) as store:
                if runs or store.kept(KEPT, str) is not None:
                    found[path], left_out = store.manifest, ""
        except RecordError as error:
            if runs:
                raise
            left_out = str(error)
        if left_out:
            tell(f"left out   {left_out}")
    return dict(sorted(found.items(), key=lambda each: str(each[1].created)))


def latest_folder() -> Path:
    """Return the campaign in ``runs`` that was written last."""
    runs = project().runs
    databases = [CampaignFolder(folder).database for folder in runs.glob("*")]
    written = {path.parent: path.stat().st_mtime_ns for path in databases if path.is_file()}
    if not written:
        what = f"found no campaign in {runs}/"
        raise UsageError(f"{what}; name its folder, or run `mrsfi evolve` first")
    return max(written, key=written.__getitem__)


@contextmanager
def open_campaign(path: Path) -> Iterator[OpenCampaign]:
    """Open a campaign for reading, without its code, so that a later mrsfi can read it."""
    folder = CampaignFolder(path)
    with CampaignStore.open(path) as store:
        texts = rendered(folder.model, "mission_loader.py", "fault_loader.py")
        mission = mission_from_text(texts["mission_loader.py"])
        pool = pool_from_text(texts["fault_loader.py"])
        pool = pool.without(store.manifest.engine.node_left_out)
        pool = unprotected(mission, pool, store.settings.protect)
        yield OpenCampaign(folder, store, mission, pool)


@contextmanager
def open_to_fly(path: Path, tell: Tell = silent) -> Iterator[FlyableCampaign]:
    """Open a campaign to fly it again or to continue it; its code must be unchanged.

    ``tell`` receives the files imported by the code that differ today.
    """
    folder = CampaignFolder(path)
    with CampaignStore.open(path) as store:
        store.require_flyable()
        folder.require_hashes(store.manifest.sha256)
        try:
            code = load_code(folder.generated)
        except GenerationError as error:
            what = f"{path}: the campaign's own copy of the generated code is incomplete: {error}"
            raise RecordError(f"{what}; expected the folder as `mrsfi evolve` left it") from error
        code = replace(code, pool=code.pool.without(store.manifest.engine.node_left_out))
        others = ", ".join(_edited(folder))
        if others:
            tell(f"{path} flies its own copies; today's project has other versions of: {others}")
        pool = unprotected(code.mission, code.pool, store.settings.protect)
        yield FlyableCampaign(folder, store, code.mission, pool, code)


def _edited(folder: CampaignFolder) -> Iterator[str]:
    """Yield each file imported by the code if Python finds one that differs from the copy."""
    for copy in copied_files(folder.generated):
        name = copy.relative_to(folder.generated / IMPORTED)
        found = (Path(place) / name for place in ("", *sys.path))
        today = next((path for path in found if path.is_file()), copy)
        if today.read_bytes() != copy.read_bytes():
            yield str(name)


def mission_of(campaign: OpenCampaign) -> MissionFolders:
    """Return the folders of a campaign's mission in the project of the working folder."""
    manifest = campaign.store.manifest
    place = from_here((root() / manifest.place).resolve()) if manifest.place else manifest.mission
    folders = find_mission(str(place))
    if manifest.sha256.get(MISSION_XMI) != hashes(folders.models).get(MISSION_XMI):
        (text,) = rendered(folders.models, "mission_loader.py").values()
        found = mission_from_text(text)
        if found.name != campaign.mission.name:
            raise UsageError(
                f"{folders.models}: found mission '{found.name}'; {campaign.folder.path} searched "
                f"'{campaign.mission.name}'; expected that one; go to its project"
            )
    return folders


def models_of(campaign: OpenCampaign) -> Path | None:
    """Return the folder of the models of a campaign's mission; ``None`` if that is gone."""
    try:
        return mission_of(campaign).models
    except (UsageError, ModelError):
        return None


def deciding(campaign: OpenCampaign, today: dt.date) -> Callable[[GoalWeakness], str]:
    """Return a function that returns the decision on a weakness in words, or an empty text."""
    models = models_of(campaign)
    decisions = decisions_of(models) if models else ()

    def decided(weakness: GoalWeakness) -> str:
        cause = Cause(weakness.goal, weakness.faults)
        found = decision_on(cause, weakness.measure, decisions)
        return found.in_words(today) if found else ""

    return decided


def find_evaluations(
    campaign: OpenCampaign, index: int | None, n: int = 1
) -> tuple[Evaluation, ...]:
    """Return one evaluation of a campaign, or without index the most critical distinct ones."""
    if index is not None:
        return (campaign.store.evaluation(index),)
    store = campaign.store
    best = Columns.read(store, Measure.of(store.settings, campaign.mission)).top(n)
    if not best:
        raise RecordError(f"{campaign.folder.path}: holds no evaluation yet; expected at least one")
    return tuple(map(store.evaluation, best))


def tried_again(campaign: FlyableCampaign, engine: EngineSettings, tell: Tell) -> EngineSettings:
    """Return settings of a definite engine, as ``tried``, for a campaign with or without flights.

    External parts that repeat themselves must fly its most critical evaluation as recorded.
    """
    store = campaign.store
    seed, record = store.settings.mission_seed, store.manifest.engine
    if not record.is_foreign or record.unrepeated or not store.n_evaluations:
        return tried(engine, campaign.code, seed, tell)
    (recorded,) = find_evaluations(campaign, None)
    with open_engine(engine, campaign.code, seed) as opened:
        outcome = opened.evaluate(recorded.specification)
    require_same(campaign.folder.path, recorded, outcome)
    return engine


def fly_all(campaign: FlyableCampaign, engine: Engine) -> Iterator[Evaluation]:
    """Fly every evaluation again; yield each that equals the record, and raise if one differs."""
    for recorded in campaign.store.evaluations():
        require_same(campaign.folder.path, recorded, engine.evaluate(recorded.specification))
        yield recorded


def require_same(folder: Path, recorded: Evaluation, outcome: Outcome) -> None:
    """Compare a replay with the record; a difference is a ``ReplayMismatch``."""
    pairs = zip(fields(Outcome), astuple(outcome), astuple(recorded.outcome), strict=True)
    differences = [
        f"{name.name} {now}, recorded {then}"
        for name, now, then in pairs
        if then not in {None, now}
    ]
    if differences:
        raise ReplayMismatch(
            f"{folder}: evaluation {recorded.index} differs from its record: "
            f"{'; '.join(differences)}. Expected the same, bit for bit; check whether the folder, "
            "mrsfi, Python, the kind of processor, or an external simulation or node has changed "
            "since (manifest in campaign.sqlite)"
        )
