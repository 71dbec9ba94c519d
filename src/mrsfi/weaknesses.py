"""What breaks the goals of a mission at the least, as a campaign has found out."""

from collections.abc import Callable

from mrsfi.campaign_folders import FlyableCampaign, OpenCampaign
from mrsfi_runtime.causes.harvest import Harvest, NotHarvestedError
from mrsfi_runtime.causes.harvest import harvest as find_out
from mrsfi_runtime.causes.weakness import Known
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.search.space import SearchSpace


def harvested(campaign: OpenCampaign) -> Harvest:
    """Return all the ways in which goals break, as far as a campaign has found them.

    One that was not harvested is a ``RecordError``, unless its algorithm is ``cover``.
    """
    try:
        return find_out(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
    except NotHarvestedError:
        path = campaign.folder.path
        raise RecordError(
            f"{path}: found evaluations, and not yet what breaks which goal at the least; "
            f"expected a campaign that has looked for it; let it: mrsfi explain {path} --all"
        ) from None


def harvest(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    on_flown: Callable[[Known, int, int], None] = lambda *_: None,
) -> Harvest:
    """Find all the ways in which goals break, as far as the campaign does not know them yet.

    What is flown is recorded. ``on_flown`` is told what is known, how many flights were taken until
    now, and how many it may take.
    """
    space = SearchSpace.of(campaign.mission, campaign.pool)
    return find_out(space, campaign.store, evaluator.evaluate_many, on_flown)
