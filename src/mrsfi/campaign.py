"""What a search found, read from its folder."""

from collections.abc import Mapping
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mrsfi import reporting
from mrsfi.campaign_folders import open_campaign, open_to_fly, require_same
from mrsfi.engines import AS_RECORDED, again
from mrsfi.explaining import evaluations_of, explained, explainer_of_campaign
from mrsfi.flight import Flight, fly, frame
from mrsfi.regressions import keep
from mrsfi.weaknesses import harvested
from mrsfi_runtime.analysis.fronts import Columns
from mrsfi_runtime.analysis.report import Shown
from mrsfi_runtime.analysis.tables import evaluations_table, to_html
from mrsfi_runtime.analysis.weaknesses import verdict_table
from mrsfi_runtime.causes.cause_set import KEEP
from mrsfi_runtime.causes.explanation import Explanation
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.engine_settings import REFERENCE, Workers
from mrsfi_runtime.record.regressions import Regression
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure

if TYPE_CHECKING:
    from pandas import DataFrame

    from mrsfi_runtime.causes.weakness import Weakness
    from mrsfi_runtime.record.settings import CampaignSettings


class Campaign:
    """A campaign, open or ended, by its folder: every evaluation, and what came of it.

    Evaluations are numbered from 0 on, in the order in which they were flown.

    Parameters
    ----------
    folder
        As ``mrsfi evolve`` or ``Mission.evolve`` made it.

    Raises
    ------
    RecordError
        If it holds no campaign.
    """

    def __init__(self, folder: Path | str) -> None:
        self.folder = Path(folder)
        with open_campaign(self.folder) as campaign:
            self._mission = campaign.mission
            self.settings: CampaignSettings = campaign.store.settings

    def __repr__(self) -> str:
        return f"<Campaign {self.folder}, {len(self)} evaluations>"

    def _repr_html_(self) -> str:
        with open_campaign(self.folder) as campaign:
            try:
                known = harvested(campaign)
            except RecordError as error:
                return f"<p>{escape(str(error))}</p>"
            return to_html(verdict_table(campaign.mission, campaign.pool, known))

    def __len__(self) -> int:
        return len(self.fitness)

    @property
    def goals(self) -> tuple[str, ...]:
        """IDs of the goals, the second axis of ``violations``."""
        return self._columns.goals

    @property
    def fitness(self) -> NDArray[np.float64]:
        """What evaluations are ranked by, shape ``(n_evaluations,)``."""
        return self._columns.fitness

    @property
    def violations(self) -> NDArray[np.float64]:
        """Violations of the kind that the campaign looks at, shape ``(n_evaluations, n_goals)``."""
        return self._columns.violations.astype(np.float64)

    @property
    def weaknesses(self) -> "tuple[Weakness, ...]":
        """All the ways in which goals break, by goal; a ``RecordError`` if nobody looked."""
        with open_campaign(self.folder) as campaign:
            return harvested(campaign).weaknesses

    @property
    def ways(self) -> tuple[Way, ...]:
        """The same by goal and set of faults, numbered as ``keep`` takes them."""
        with open_campaign(self.folder) as campaign:
            return harvested(campaign).ways

    @property
    def digest(self) -> str:
        """SHA-256 over all evaluations: the same for the same search on any machine."""
        with CampaignStore.open(self.folder) as store:
            return store.digest()

    def to_frame(self) -> "DataFrame":
        """Return evaluations as a frame of pandas: a row each, with what came of each goal."""
        measure = Measure.of(self.settings, self._mission)
        with CampaignStore.open(self.folder) as store:
            return frame(evaluations_table("", store.flown(1), measure))

    def evaluation(self, index: int) -> Evaluation:
        """Return one evaluation: its specification, fitness and outcome.

        Raises
        ------
        RecordError
            If there is none of that index.
        """
        with CampaignStore.open(self.folder) as store:
            return store.evaluation(index)

    def top(self, n: int = 10) -> tuple[Evaluation, ...]:
        """Return the most critical evaluations that differ, the worst first."""
        with CampaignStore.open(self.folder) as store:
            return tuple(map(store.evaluation, self._columns.top(n)))

    def fly(self, index: int) -> Flight:
        """Fly an evaluation again, on the campaign's own copy of the code; return every tick.

        Raises
        ------
        RecordError
            If the campaign is of other rules of the world, or has no such evaluation.
        ReplayMismatch
            If it does not fly as it is recorded.
        """
        with open_to_fly(self.folder) as campaign:
            recorded = campaign.store.evaluation(index)
            seed = self.settings.mission_seed
            settings = again(AS_RECORDED, campaign.store.manifest.engine, REFERENCE)
            with open_engine(settings, campaign.code, seed) as engine:
                flight = fly(engine, campaign.pool, recorded.specification, seed)
            require_same(self.folder, recorded, flight.outcome)
            return flight

    def explain(self, index: int | None = None, keep: float = KEEP) -> Explanation | None:
        """Find out all about why one evaluation breaks goals.

        Parameters
        ----------
        index
            Which one; the most critical if left out.
        keep
            Share of each goal's violations that a cause set has to keep.

        Returns
        -------
        Explanation or None
            ``None`` if it violates nothing that is counted.

        Raises
        ------
        RecordError
            If the campaign is of other rules of the world, or has no such evaluation.
        ReplayMismatch
            If it does not fly as it is recorded.
        """
        with open_to_fly(self.folder) as campaign:
            some = [*evaluations_of(campaign, index)]
            about = explainer_of_campaign(campaign)
            settings = again(AS_RECORDED, campaign.store.manifest.engine)
            ((_, found),) = explained(about, some, settings, Workers(), keep)
            return found

    def keep(
        self,
        weakness: int = 1,
        name: str | None = None,
        limits: Mapping[str, int] | None = None,
        n_seeds: int = 1,
    ) -> Regression:
        """Keep a weakness beside the models of its mission, as ``mrsfi.regressions.keep`` does."""
        with open_campaign(self.folder) as campaign:
            return keep(campaign, weakness, name, limits, n_seeds)

    def report(self, ratio: str | None = None, *, latex: bool = False) -> Path:
        """Write tables, figures, models and page into the folder; return the report's file.

        Parameters
        ----------
        ratio
            Ratio of violations to pick by, such as ``g3:g1=2:1``.
        latex
            Write it for a paper, too, with figures as PDF; then that file is returned.
        """
        with open_campaign(self.folder) as campaign:
            reporting.report(campaign, ratio, latex=latex)
            return campaign.folder.latex if latex else campaign.folder.report

    def pack(self, out: Path | str) -> str:
        """Pack it into an archive that ``mrsfi check`` flies again; return the archive's digest."""
        from mrsfi.packing import pack  # noqa: PLC0415 - seldom used

        return pack(self.folder, Path(out))

    def show(self, weakness: int | None = None) -> tuple[Shown, ...]:
        """Draw a weakness by its number, or the least for each goal, as ``mrsfi show`` does."""
        with open_campaign(self.folder) as campaign:
            return tuple(reporting.show(campaign, weakness))

    @cached_property
    def _columns(self) -> Columns:
        measure = Measure.of(self.settings, self._mission)
        with CampaignStore.open(self.folder) as store:
            return Columns.read(store, measure, measure.chosen)
