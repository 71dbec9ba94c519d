"""What breaks the goals of a mission at the least, as a campaign has found out, and files of it."""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import combinations, islice
from pathlib import Path
from time import monotonic
from types import MappingProxyType

from mrsfi.campaign_folders import FlyableCampaign, OpenCampaign, open_to_fly, tried_again
from mrsfi.engines import Given, Tell, again, flying
from mrsfi_runtime.analysis import documents
from mrsfi_runtime.analysis.illustrations import Drawing, drawn
from mrsfi_runtime.analysis.tables import as_csv
from mrsfi_runtime.analysis.weaknesses import (
    failure_modes,
    goal_in_words,
    modes_as_csv,
    modes_as_markdown,
)
from mrsfi_runtime.causes import mildest as shrinking
from mrsfi_runtime.causes.cause_set import Prober
from mrsfi_runtime.causes.harvest import Harvest, known_by
from mrsfi_runtime.causes.harvest import harvest as find_out
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.causes.weakness import Known, Weakness, detected, faults_of, in_seeds
from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import RecordError, UsageError, counted
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.model.mission import Evaluated
from mrsfi_runtime.record.engine_settings import Workers
from mrsfi_runtime.record.settings import following
from mrsfi_runtime.record.store import RecordedFlight
from mrsfi_runtime.search.space import SearchSpace

FMEA = MappingProxyType({".csv": modes_as_csv, ".md": modes_as_markdown})
FAULT_TREES = MappingProxyType(
    {".xml": documents.as_open_psa, ".txt": documents.as_pfta, ".pft": documents.as_pfta}
)
"""What files are written as, by what their names end in."""

MAPS = (".csv", ".png", ".svg")
"""What the name of a map may end in."""

_EVERY = 2.0
"""Seconds between two lines about a harvest."""


def require_format(path: Path, known: Collection[str]) -> None:
    """Refuse a file whose name does not end in one of what is known."""
    if path.suffix not in known:
        wanted = f"a name that ends in {' or '.join(known)}"
        raise UsageError(f"{path}: found the ending '{path.suffix}'; expected {wanted}")


def harvested(campaign: OpenCampaign) -> Harvest:
    """Return all the ways in which goals break, as far as a campaign has found them."""
    found = known_by(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
    if found is None:
        path = campaign.folder.path
        raise RecordError(
            f"{path}: found evaluations, and not yet what breaks which goal at the least; "
            f"expected a campaign that has looked for it; let it: mrsfi explain {path} --all"
        )
    return found


def way_of(run: Path, found: Sequence[Way], number: int) -> Way:
    """Return the way of a number among those of a campaign; one that is not is a ``UsageError``."""
    for way in found:
        if way.number == number:
            return way
    numbers = ", ".join(str(way.number) for way in found) or "none, because nothing breaks"
    raise UsageError(f"{run}: found no weakness {number}; expected one of {numbers}")


def untried(campaign: OpenCampaign) -> tuple[tuple[str, ...], ...]:
    """Return the faults that no specification had, and the pairs that none had together."""
    flown: set[frozenset[str]] = {
        faults_of(each.specification) for each in campaign.store.flights()
    }
    flown.update(campaign.store.fault_sets())
    known = {some for each in flown for n in (1, 2) for some in combinations(sorted(each), n)}
    faults = [fault.id for fault in campaign.pool]
    every = (some for n in (1, 2) for some in combinations(faults, n))
    return tuple(some for some in every if tuple(sorted(some)) not in known)


@contextmanager
def flying_again(
    run: Path, engine: Given, workers: Workers, tell: Tell
) -> Iterator[tuple[FlyableCampaign, Evaluator, Engine]]:
    """Yield a campaign, what evaluates specifications of it, and an engine of this process."""
    with open_to_fly(run, tell) as campaign:
        settings = again(engine, campaign.store.manifest.engine)
        workers.require_sense(settings)
        seed = campaign.store.settings.mission_seed
        settings = tried_again(campaign, settings, tell)
        with flying(campaign.code, seed, settings, workers, tell) as (evaluator, own):
            yield campaign, evaluator, own


def harvest(campaign: FlyableCampaign, evaluator: Evaluator, engine: Engine, tell: Tell) -> None:
    """Find and record all the ways in which goals break, unless the campaign knows them."""
    store, space = campaign.store, SearchSpace.of(campaign.mission, campaign.pool)
    n_before, told = len(store.flights()), -math.inf

    def tell_of(known: Known, n_flown: int, n_most: int | None) -> None:
        nonlocal told
        if n_flown > n_before and monotonic() - told > _EVERY:
            told = monotonic()
            most = "flights, mildest forms" if n_most is None else f"of at most {n_most} flights"
            tell(f"harvest  {n_flown} {most}  {_found(known.weaknesses())}")

    found = find_out(space, store, evaluator.evaluate_many, engine.record, tell_of)
    if len(store.flights()) > n_before:
        tell(f"harvest  {counted(found.n_flights, 'flights')}  {_found(found.weaknesses)}")


def _found(weaknesses: Iterable[Weakness]) -> str:
    found = {(each.column.goal, each.faults) for each in weaknesses}
    goals = {goal for goal, _ in found}
    return f"{counted(len(found), 'ways')} to break {counted(len(goals), 'goals')}"


def refined(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    record: Record,
    found: Sequence[Way],
    n_seeds: int | None,
    *,
    is_mildest: bool,
) -> list[Way]:
    """Return ways, each with its mildest form if asked for, in as many mission seeds as asked.

    To seek the mildest form, by the gravest measure, takes some 30 flights for each, which count
    for its detection, too.
    """
    seed = campaign.store.settings.mission_seed
    prober = Prober[Evaluated](evaluator.evaluate_many, lambda _, __, flown: flown)
    told = [one for way in found for one in way.by]
    if is_mildest:
        space, known = SearchSpace.of(campaign.mission, campaign.pool), harvested(campaign).known
        shown, seeds = [way.shown for way in found], following(seed, shrinking.N_SEEDS)
        least = shrinking.mildest(space, known, shown, prober, record, seeds)
        told = [one.weakness for one in least]
    if n_seeds is not None:
        seeds = following(seed, n_seeds)
        told = [*in_seeds(campaign.mission, told, prober, seeds)]
    if is_mildest:
        flown = (RecordedFlight(seed, each, found) for (each, seed), found in prober.known.items())
        again = iter(detected(campaign.mission, campaign.store, told, flown))
        forms = (replace(each, weakness=next(again)) for each in least)
        return [replace(way, mildest=form) for way, form in zip(found, forms, strict=True)]
    again = iter(told)
    return [replace(way, by=tuple(islice(again, len(way.by)))) for way in found]


def write_map(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    record: Record,
    way: Way,
    path: Path,
) -> None:
    """Fly milder forms of a way to break a goal, and write which do, as one of ``MAPS``.

    All are flown in the campaign's mission seed, and judged by the gravest measure.
    """
    space = SearchSpace.of(campaign.mission, campaign.pool)
    deviation, seed = shrinking.Deviation(space, record(())), campaign.store.settings.mission_seed
    tried = shrinking.tried_map(deviation, way.shown, evaluator.evaluate_many, seed)
    if path.suffix == ".csv":
        content = as_csv([shrinking.Tried._fields, *tried])
    else:
        goal = goal_in_words(campaign.mission, way.goal)
        title = f"{goal}, broken by {' and '.join(way.faults)}"
        content = drawn(Drawing("tried_map", (title, tried)))[path.suffix]
    with whole_file(path) as file:
        file.write(content)


def write_fmea(campaign: OpenCampaign, found: Sequence[Way], record: Record, path: Path) -> None:
    """Write failure modes and effects, flown in the campaign's mission seed, as one of ``FMEA``."""
    mission = campaign.store.manifest.mission or campaign.mission.name
    modes = failure_modes(campaign.mission, campaign.pool, found, record)
    with whole_file(path) as file:
        file.write(FMEA[path.suffix](mission, modes))


def write_fault_trees(campaign: OpenCampaign, found: Sequence[Way], path: Path) -> None:
    """Write the fault tree of each goal, as one of ``FAULT_TREES``."""
    with whole_file(path) as file:
        file.write(FAULT_TREES[path.suffix](campaign.mission, campaign.pool, found))
