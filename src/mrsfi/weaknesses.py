"""What breaks the goals of a mission at the least, as a campaign has found out."""

from mrsfi.campaign_folders import OpenCampaign
from mrsfi_runtime.causes.cover import covered
from mrsfi_runtime.causes.weakness import Known
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.settings import COVERING
from mrsfi_runtime.search.space import SearchSpace


def known_by(campaign: OpenCampaign) -> Known:
    """Return what a campaign that covers has found until now; another one is a ``RecordError``."""
    store = campaign.store
    if store.settings.algorithm != COVERING:
        raise RecordError(
            f"{campaign.folder.path}: was searched by '{store.settings.algorithm}', which seeks "
            f"the worst specifications; expected a campaign of '{COVERING}'; begin one with: mrsfi "
            f"evolve {store.manifest.place or store.manifest.mission} --algorithm {COVERING}"
        )
    flown = {each.specification: each.outcome for each in store.evaluations()}
    outcomes = flown | {each.specification: None for each in store.failures()}
    space = SearchSpace.of(campaign.mission, campaign.pool)
    return covered(space, store.settings, outcomes)
