"""The report of a campaign, and pictures of what it found: tables, figures, models and a page."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache

from mrsfi.campaign_folders import OpenCampaign
from mrsfi.engines import AS_RECORDED, silent
from mrsfi.loading import specification_writer
from mrsfi.weaknesses import flying_again, harvested, way_of
from mrsfi_runtime.analysis.illustrations import Draw, DrawingProcess
from mrsfi_runtime.analysis.report import Shown, look_at, write_report
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.causes.mildest import least
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.errors import MrsfiError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.engine_settings import Workers


def report(
    campaign: OpenCampaign,
    ratio: str | None = None,
    draw: Draw | None = None,
    show: Callable[[Summary], None] = lambda _: None,
    *,
    latex: bool = False,
) -> None:
    """Write the report of a campaign into its folder.

    ``show`` is told what was found, before figures are drawn, by ``draw`` or a process begun for
    it. With ``latex``, it is written for a paper, too.
    """
    writer = specification_writer(campaign.folder.model)
    with _flying(campaign) as record, ExitStack() as stack:
        write_report(
            campaign.folder.path,
            campaign.mission,
            campaign.pool,
            writer,
            record=record,
            ratio=ratio,
            draw=draw or stack.enter_context(DrawingProcess()).draw,
            show=show,
            latex=latex,
        )


def show(campaign: OpenCampaign, number: int | None = None) -> Iterator[Shown]:
    """Draw a way to break a goal by its number, or the least that breaks each, and yield them.

    What is drawn already is not drawn again.
    """
    path, found = campaign.folder.path, harvested(campaign).ways
    wanted = least(found) if number is None else (way_of(path, found, number).at_least,)
    with _flying(campaign) as record:
        for way in wanted:
            yield look_at(campaign.folder, campaign.mission, campaign.pool, way, record)


@contextmanager
def _flying(campaign: OpenCampaign) -> Iterator[Record]:
    """Yield what flies specifications again, or says why nothing does, each time the same."""
    with ExitStack() as stack:

        @cache
        def flown_by() -> Engine | MrsfiError:
            flying = flying_again(campaign.folder.path, AS_RECORDED, Workers(1), silent)
            try:
                return stack.enter_context(flying)[2]
            except MrsfiError as error:
                return error

        def record(specification: Specification) -> Recording:
            engine = flown_by()
            if isinstance(engine, MrsfiError):
                raise engine
            return engine.record(specification)

        yield record
