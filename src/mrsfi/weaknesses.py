"""What breaks the goals of a mission at the least, as a campaign has found out."""

from mrsfi.campaign_folders import OpenCampaign
from mrsfi_runtime.causes.cover import covered
from mrsfi_runtime.causes.weakness import Weakness
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.settings import COVERING
from mrsfi_runtime.search.space import SearchSpace


def weaknesses_of(campaign: OpenCampaign) -> tuple[Weakness, ...]:
    """Return the weaknesses that a campaign which covers has found until now.

    Those of each goal stand together, in model order, small sets of faults first. A campaign that
    searched otherwise is a ``RecordError``.
    """
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
    return covered(space, store.settings, outcomes).weaknesses()
