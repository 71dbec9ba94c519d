"""Campaigns from the first evaluation to the last."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from mrsfi.campaign_folders import FlyableCampaign, manifest_of
from mrsfi.engines import recorded_engine
from mrsfi.folders import MissionFolders
from mrsfi_runtime.causes.cover import ALGORITHMS
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.imported_files import imported_files
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.record.folder import CampaignFolder, only_writer
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.run import CampaignProgress, require_settings, run_campaign
from mrsfi_runtime.search.space import SearchSpace


def require_searchable(code: MissionCode, settings: CampaignSettings) -> None:
    """Refuse settings that make no sense for a mission, and a pool that cannot be searched."""
    require_settings(settings, code.mission, algorithms=ALGORITHMS)
    SearchSpace.of(code.mission, code.pool)


@contextmanager
def begun(
    path: Path,
    folders: MissionFolders,
    settings: CampaignSettings,
    case: str,
    engine: EngineSettings,
) -> Iterator[None]:
    """Make a campaign without evaluations and be its writer while the body runs."""
    folder = CampaignFolder.reserve(path)
    with only_writer(folder):
        imported = imported_files(folders.generated, settings.own_modules)
        folder.fill(folders.models, folders.generated, imported)
        manifest = manifest_of(folder, folders, case, recorded_engine(engine))
        CampaignStore.create(path, settings, manifest).close()
        yield


def search(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    progress: Callable[[CampaignProgress], None] = lambda _: None,
) -> None:
    """Run the search of a campaign to its end."""
    store = campaign.store
    settings = store.settings
    evaluate_many, *replicas = (
        partial(evaluator.evaluate_many, seed=seed) for seed in settings.mission_seeds
    )
    run_campaign(
        settings,
        campaign.code.mission,
        campaign.code.pool,
        evaluate_many,
        store,
        progress,
        replicas=replicas,
        algorithms=ALGORITHMS,
    )
