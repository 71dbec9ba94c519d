"""The report of a campaign: what it found, as tables, figures, models and a page."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache

from mrsfi.campaign_folders import OpenCampaign, load_own
from mrsfi.loading import specification_writer
from mrsfi_runtime.analysis.drawing import Draw, DrawingProcesses
from mrsfi_runtime.analysis.report import write_report
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import MrsfiError


def report(
    campaign: OpenCampaign,
    ratio: str | None = None,
    draw: Draw | None = None,
    show: Callable[[Summary], None] = lambda _: None,
) -> None:
    """Write the report of a campaign into its folder.

    Parameters
    ----------
    ratio
        Ratio of violations to pick by, such as ``g3:g1=2:1``.
    draw
        Draws the figures; without, processes of their own do.
    show
        Told what was found, before figures are drawn.

    Raises
    ------
    UsageError
        If the ratio makes no sense.
    """
    writer = specification_writer(campaign.folder.model)
    with ExitStack() as opened:
        record = opened.enter_context(_flying(campaign))
        draw = draw or opened.enter_context(DrawingProcesses()).draw
        write_report(
            campaign.folder.path,
            campaign.mission,
            campaign.pool,
            writer,
            record=record,
            ratio=ratio,
            draw=draw,
            show=show,
        )


@contextmanager
def _flying(campaign: OpenCampaign) -> Iterator[Record | str]:
    """Yield what flies specifications again, or why nothing does."""
    store = campaign.store
    if store.manifest.engine.is_foreign:
        yield "Flown on somebody else's simulation, which is not asked again."
        return
    try:
        code = load_own(campaign.folder, store)
    except MrsfiError as error:
        yield str(error)
        return
    seed = store.settings.mission_seed
    with ExitStack() as opened:

        @cache
        def engine() -> Engine:
            found = EngineSettings(AUTO).named(code, seed, lambda _: None)
            return opened.enter_context(found.open(code, seed))

        yield lambda specification: engine().record(specification)
