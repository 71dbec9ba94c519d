"""Explain a campaign: causes of one specification, all weaknesses, and its report.

``explained`` flies parts of a specification and finds which faults break which goal; cause sets
are written as models. ``harvest`` searches for weaknesses, ``harvested`` reads them; ``map_of``,
``fmea_of`` and ``export_results`` make files of them. ``report`` and ``show`` write tables,
figures, models and a page. Flights of a campaign use its own copy of the code.
"""

import datetime as dt
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import count, islice
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from mrsfi.campaign_folders import (
    FlyableCampaign,
    OpenCampaign,
    campaigns_of,
    deciding,
    find_evaluations,
    open_campaign,
    open_to_fly,
    require_same,
    tried_again,
)
from mrsfi.engines import AS_RECORDED, Given, Tell, again, flying, now_and_then, project, silent
from mrsfi.folders import MissionFolders, load_fresh
from mrsfi.loading import read_specification, specification_writer
from mrsfi_runtime.analysis import documents
from mrsfi_runtime.analysis.report import Shown, SpecificationWriter, draw_weakness, write_report
from mrsfi_runtime.analysis.summary import Summary
from mrsfi_runtime.analysis.tables import as_csv
from mrsfi_runtime.analysis.weaknesses import State, verdicts
from mrsfi_runtime.causes import mildest as shrinking
from mrsfi_runtime.causes.cause_set import Flights, Prober, chosen
from mrsfi_runtime.causes.explanation import Explanation
from mrsfi_runtime.causes.explanation import explain as find_out
from mrsfi_runtime.causes.harvest import Harvest, known_by, recorded_by
from mrsfi_runtime.causes.harvest import harvest as find_weaknesses
from mrsfi_runtime.causes.mildest import GoalWeakness, least
from mrsfi_runtime.causes.weakness import MEASURES, Known, Weakness, detected, in_seeds
from mrsfi_runtime.causes.weakness import untried as untried_in
from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.opening import tried
from mrsfi_runtime.engine.recording import Record, Recording
from mrsfi_runtime.errors import (
    MrsfiError,
    RecordError,
    ReplayMismatch,
    UsageError,
    counted,
    time_left,
)
from mrsfi_runtime.files import whole_file, writable
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification, numbered
from mrsfi_runtime.model.mission import Evaluated, Mission
from mrsfi_runtime.record.engine_settings import AUTO, BOTH, EngineSettings, Workers
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.settings import VIOLATIONS, CampaignSettings, folder_of, following
from mrsfi_runtime.record.store import CampaignStore, Evaluation, Measure, RecordedFlight
from mrsfi_runtime.search.space import SearchSpace

if TYPE_CHECKING:
    from m2t.models.requirements import ReqifFile

CAUSE_SET, SIMPLEST = "cause set", "simplest variant"
"""Kinds of specifications that an explanation writes."""


@dataclass(frozen=True, slots=True)
class NamedSpecification:
    """A specification to explain, with its evaluation if it is of a campaign.

    ``name`` is the stem of the files about it, ``title`` describes it to people.
    """

    name: str
    title: str
    faults: tuple[NamedFault, ...]
    recorded: Evaluation | None = None

    @property
    def specification(self) -> Specification:
        """The faults without their names."""
        return tuple(fault.timed for fault in self.faults)


@dataclass(frozen=True, slots=True)
class Explainer:
    """Everything that is needed to explain specifications.

    ``code`` has their pool. Counts are summed over the mission seeds. ``write`` writes faults as a
    model into ``folder``. ``source`` is the file or the campaign.
    """

    code: MissionCode
    measure: Measure
    mission_seeds: tuple[int, ...]
    write: SpecificationWriter
    folder: Path
    source: Path

    def write_sets(
        self, subject: NamedSpecification, found: Explanation | None
    ) -> Mapping[str, Path]:
        """Write cause sets and the simplest variant as XMI; return the files by kind."""
        if found is None:
            return {}
        cause, whole = found.cause, subject.specification
        written = [
            (CAUSE_SET, "cause", cause.places, cause.faults),
            (SIMPLEST, "simplest", cause.places, found.simplest),
            *(
                (of_goal(each.goal), f"cause-{each.goal}", each.places, chosen(whole, each.places))
                for each in found.goals
            ),
        ]
        paths = {}
        for what, kind, places, specification in written:
            if not places:
                continue
            path = self.folder / f"{subject.name}-{kind}.xmi"
            identifier = f"{subject.name}_{kind}".replace("-", "_")
            names = [subject.faults[place].name for place in places]
            with writable(path, "name another folder with --out"):
                self.folder.mkdir(parents=True, exist_ok=True)
                self.write(self.code.pool, specification, path, identifier, names)
            paths[what] = path
        return paths


def of_goal(goal: str) -> str:
    """Return the kind of the cause set of one goal."""
    return f"{CAUSE_SET} of {goal}"


def explainer_of_file(
    folders: MissionFolders,
    path: Path,
    kind: str | None,
    seed: int | None,
    out: Path | None,
    tell: Tell,
) -> tuple[Explainer, NamedSpecification]:
    """Return a written specification and its explainer; ``tell`` gets warnings about it.

    By default, believed violations are counted, in mission seed 1, and cause sets are written
    beside the file, but never among kept weaknesses.
    """
    if out is None and path.resolve().parent == folder_of(folders.models).resolve():
        raise UsageError(
            f"{path}: is a kept weakness; its cause sets would be written among the kept "
            "weaknesses; expected another folder: name it with --out"
        )
    code = load_fresh(folders)
    written = read_specification(path, code, tell)
    named = named_faults(code.mission, written.pool, written.specification)
    explainer = Explainer(
        code=replace(code, pool=written.pool),
        measure=Measure.of(CampaignSettings(violations=kind or VIOLATIONS[0]), code.mission),
        mission_seeds=(1 if seed is None else seed,),
        write=specification_writer(written.models),
        folder=path.parent if out is None else out,
        source=path,
    )
    return explainer, NamedSpecification(path.stem, str(path), named)


def explainer_of_campaign(
    campaign: FlyableCampaign, kind: str | None = None, out: Path | None = None
) -> Explainer:
    """Return the explainer of a campaign's evaluations; by default with the same measure."""
    settings = campaign.store.settings
    measure = Measure.of(settings, campaign.mission)
    return Explainer(
        code=campaign.code,
        measure=measure if kind is None else replace(measure, kind=kind),
        mission_seeds=settings.mission_seeds,
        write=specification_writer(campaign.folder.model),
        folder=campaign.folder.causes if out is None else out,
        source=campaign.folder.path,
    )


def evaluations_of(
    campaign: FlyableCampaign, index: int | None, n: int = 1
) -> Iterator[NamedSpecification]:
    """Yield what ``find_evaluations`` returns, with names for the faults."""
    for found in find_evaluations(campaign, index, n):
        names = numbered(timed.fault for timed in found.specification)
        yield NamedSpecification(
            f"evaluation_{found.index}",
            f"evaluation {found.index} of {campaign.folder.path}, fitness {found.fitness[0]:.2f}",
            named_faults(campaign.mission, campaign.pool, found.specification, names),
            found,
        )


def explained(
    explainer: Explainer,
    specifications: Iterable[NamedSpecification],
    engine: EngineSettings,
    workers: Workers,
    keep: float,
    tell: Tell = silent,
) -> Iterator[tuple[NamedSpecification, Explanation | None]]:
    """Yield specifications with their explanations; ``None`` if a specification breaks no goal.

    A flight that differs from its record is a ``ReplayMismatch``.
    """
    workers.require_sense(engine)
    code, seed = explainer.code, explainer.mission_seeds[0]
    if engine.name == AUTO:
        engine = tried(engine, code, seed, tell)
    with flying(code, seed, engine, workers, tell) as (evaluator, own):
        for each in specifications:
            if engine.side != BOTH and each.recorded is None:
                require_repeatable(own, each)
            flights = _telling(evaluator, explainer, tell)
            if each.recorded is not None:
                require_same(explainer.source, each.recorded, flights.outcome(each.specification))
            yield each, find_out(flights, own, each.specification, keep)


def _telling(evaluator: Evaluator, explainer: Explainer, tell: Tell) -> Flights:
    """Return flights that tell how many are done, of those that are asked for so far."""
    n_done, tell_of = count(1), now_and_then(tell)

    def evaluate(some: Sequence[Specification], seed: int) -> Iterator[Evaluated]:
        for each in evaluator.evaluate_many(some, seed):
            *_, part = flights.n_flown
            done = f"{next(n_done)} of at least {counted(flights.n_flown.total(), 'flights')}"
            tell_of(partial("explain  {}  {}".format, done, part))
            yield each

    flights = Flights(evaluate, explainer.measure, explainer.mission_seeds)
    return flights


def require_repeatable(engine: Engine, subject: NamedSpecification) -> None:
    """Refuse an external simulator or node if the same specification gives two results."""
    first, second = (engine.evaluate(subject.specification) for _ in range(2))
    if first != second:
        raise ReplayMismatch(
            f"{subject.title}: flown twice, it had violations {first.believed} and "
            f"{second.believed} believed, {first.true} and {second.true} true, digests "
            f"{first.digest[:8]}… and {second.digest[:8]}…; expected the same twice: otherwise a "
            "cause cannot be distinguished from chance"
        )


MAPS = (".csv", ".png", ".svg")
"""Suffixes of maps."""


def require_format(path: Path, known: Collection[str]) -> None:
    """Refuse a file with another suffix than the known ones."""
    if path.suffix not in known:
        wanted = f"a name that ends in {' or '.join(known)}"
        raise UsageError(f"{path}: found the ending '{path.suffix}'; expected {wanted}")


def harvested(campaign: OpenCampaign) -> Harvest:
    """Return the weaknesses that a campaign has found."""
    found = known_by(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
    if found is None:
        path = campaign.folder.path
        what = f"{path}: found evaluations, and no finished search for weaknesses"
        raise RecordError(f"{what}; expected both: run mrsfi explain {path} --all")
    return found


def harvested_beside(campaign: OpenCampaign, others: Iterable[Path]) -> list[Harvest]:
    """Return the weaknesses of a campaign, then those of others that differ in the search.

    They need the same models, code and mission seed, and different search seeds; else it is a
    ``UsageError``.
    """
    found, runs = [harvested(campaign)], {campaign.store.settings.seed: campaign.folder.path}
    wanted, run = same_flights(campaign), campaign.folder.path
    for path in others:
        with open_campaign(path) as other:
            flown, seed = same_flights(other), other.store.settings.seed
            changed = [name for name in {**wanted, **flown} if wanted.get(name) != flown.get(name)]
            if changed:
                raise UsageError(
                    f"{path}: differs from {run} in {', '.join(changed)}; expected a campaign of "
                    "the same mission, pool, code and mission seed"
                )
            if seed in runs:
                raise UsageError(
                    f"{path}: found search seed {seed}, as in {runs[seed]}; expected another "
                    "search seed, because the same one repeats the same draws"
                )
            runs[seed] = path
            found.append(harvested(other))
    return found


def known_since(campaign: OpenCampaign) -> Callable[[GoalWeakness], str]:
    """Return a function that returns the day on which a weakness was found first, if recorded.

    Campaigns of the same mission in the project's ``runs`` count. If the first has no date, it is
    the day of this campaign, "or earlier".
    """
    first, ours = dict[tuple[str, tuple[str, ...]], str](), campaign.store.manifest
    for path, manifest in campaigns_of().items():
        if manifest.mission == ours.mission:
            with suppress(RecordError), CampaignStore.open(path) as store:
                first = dict.fromkeys(recorded_by(store), str(manifest.created)[:10]) | first
    day = str(ours.created)[:10]
    earlier = f"{day} or earlier" if day else ""
    return lambda each: first.get((each.goal, each.faults), day) or earlier


def same_flights(campaign: OpenCampaign) -> dict[str, object]:
    """Return all that decides the results of a campaign's flights, by name."""
    manifest = campaign.store.manifest
    return {
        **{name: each for name, each in manifest.sha256.items() if not name.endswith(".toml")},
        "mission seed": campaign.store.settings.mission_seed,
        "faults": [fault.id for fault in campaign.pool],
        "rules of the world": manifest.semantics,
        "node": manifest.engine.node_sha256,
    }


def weakness_of(run: Path, found: Sequence[GoalWeakness], number: int) -> GoalWeakness:
    """Return a campaign's weakness by its number; an unknown number is a ``UsageError``."""
    for weakness in found:
        if weakness.number == number:
            return weakness
    numbers = ", ".join(str(each.number) for each in found) or "none, because none was found"
    raise UsageError(f"{run}: found no weakness {number}; expected one of {numbers}")


def untried(campaign: OpenCampaign, known: Harvest, goals: Collection[str]) -> dict[int, int]:
    """Return how many sets of faults the campaign did not try in its mission seed, by size."""
    searched = {each.specification: each.outcome for each in campaign.store.evaluations()}
    faults, flights = [fault.id for fault in campaign.pool], {**searched, **known.outcomes}
    return untried_in(known.known, known.yardstick, faults, flights, goals)


@contextmanager
def flying_again(
    run: Path, engine: Given, workers: Workers, tell: Tell
) -> Iterator[tuple[FlyableCampaign, Evaluator, Engine]]:
    """Yield a campaign, an evaluator of its specifications, and an engine of this process."""
    with open_to_fly(run, tell) as campaign:
        settings = again(engine, campaign.store.manifest.engine)
        workers.require_sense(settings)
        seed = campaign.store.settings.mission_seed
        settings = tried_again(campaign, settings, tell)
        with flying(campaign.code, seed, settings, workers, tell) as (evaluator, own):
            yield campaign, evaluator, own


def harvest(campaign: FlyableCampaign, evaluator: Evaluator, engine: Engine, tell: Tell) -> None:
    """Search for all weaknesses of a campaign and record them, unless it has."""
    store, space = campaign.store, SearchSpace.of(campaign.mission, campaign.pool)
    n_before, began, tell_of = store.n_flights, monotonic(), now_and_then(tell)

    def progress(unit: str, n_done: int, n_most: int, known: Known) -> None:
        nonlocal began
        if not n_done:
            began = monotonic()
        else:
            rest = (monotonic() - began) / n_done * (n_most - n_done)
            done = f"harvest  {n_done} of at most {n_most} {unit}"
            tell_of(lambda: f"{done}  {_found(known.weaknesses())}  {time_left(rest)}")

    evaluate, record = evaluator.evaluate_many, partial(evaluator.record_many, engine)
    n, found = find_weaknesses(space, store, evaluate, record, progress)
    if store.n_flights > n_before:
        tell(f"harvest  {counted(n, 'flights')}  {_found(found)}")


def _found(weaknesses: Iterable[Weakness]) -> str:
    found = {(each.column.goal, each.faults) for each in weaknesses}
    goals = {goal for goal, _ in found}
    if not found:
        return "no weakness yet"
    return f"{counted(len(found), 'weaknesses')} of {counted(len(goals), 'goals')}"


def refined(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    engine: Engine,
    found: Sequence[GoalWeakness],
    n_seeds: int | None,
    *,
    is_mildest: bool,
) -> list[GoalWeakness]:
    """Return weaknesses, with their mildest variants if asked for, in ``n_seeds`` mission seeds.

    The mildest variant, by the gravest measure, takes some 30 flights each. These count for its
    detection, too.
    """
    seed = campaign.store.settings.mission_seed
    prober = Prober[Evaluated](evaluator.evaluate_many, lambda _, __, flown: flown)
    judged = [one for each in found for one in each.by]
    if is_mildest:
        space, known = SearchSpace.of(campaign.mission, campaign.pool), harvested(campaign).known
        shown, seeds = [each.shown for each in found], following(seed, shrinking.N_SEEDS)
        record = partial(evaluator.record_many, engine)
        least = shrinking.mildest(space, known, shown, prober, record, seeds)
        judged = [one.weakness for one in least]
    if n_seeds is not None:
        seeds = following(seed, n_seeds)
        judged = [*in_seeds(campaign.mission, judged, prober, seeds)]
    if is_mildest:
        flown = (RecordedFlight(seed, each, found) for (each, seed), found in prober.known.items())
        later = (*campaign.store.flights(), *flown)
        again = iter(detected(campaign.mission, campaign.store, judged, later))
        mild = (replace(each, weakness=next(again)) for each in least)
        return [replace(weakness, mildest=each) for weakness, each in zip(found, mild, strict=True)]
    again = iter(judged)
    return [replace(each, by=tuple(islice(again, len(each.by)))) for each in found]


def map_of(
    campaign: FlyableCampaign,
    evaluator: Evaluator,
    record: Record,
    weakness: GoalWeakness,
    suffix: str,
) -> bytes:
    """Fly milder variants of a weakness, and return which break the goal, as one of ``MAPS``.

    They are flown in the campaign's mission seed, and judged by the gravest measure.
    """
    space = SearchSpace.of(campaign.mission, campaign.pool)
    deviation, seed = shrinking.Deviation(space, record(())), campaign.store.settings.mission_seed
    tried = shrinking.tried_map(deviation, weakness.shown, evaluator.evaluate_many, seed)
    if suffix == ".csv":
        return as_csv([shrinking.Tried._fields, *tried])
    from mrsfi_runtime.analysis import plots  # noqa: PLC0415 - matplotlib takes its time

    title = f"{campaign.mission.label_of(weakness.goal)} under {' and '.join(weakness.faults)}"
    return plots.rendered(plots.tried_map(title, tried), [suffix])[suffix]


def fmea_of(
    campaign: OpenCampaign,
    found: Sequence[GoalWeakness],
    record: Record,
    settled: Mapping[int, Mapping[str, str]],
    suffix: str,
) -> bytes:
    """Return failure modes and effects, flown in the campaign's mission seed.

    ``settled`` has what the team decided (``regressions.settled``).
    """
    name, mission = campaign.store.manifest.mission or campaign.mission.name, campaign.mission
    modes = documents.failure_modes(mission, campaign.pool, found, record, project().fmea, settled)
    return documents.FMEA[suffix](documents.fmea(name, modes))


def report(
    campaign: OpenCampaign,
    ratio: str | None = None,
    show: Callable[[Summary], None] = lambda _: None,
    *,
    draws: bool = True,
    latex: bool = False,
    today: dt.date | None = None,
) -> None:
    """Write the report of a campaign into its folder.

    ``show`` gets the results before the figures are drawn; without ``draws`` there are none. With
    ``latex``, the report is written for a paper, too. ``today`` is the day for which the report has
    the decisions on weaknesses, and since when these are known; without it, neither.
    """
    writer = specification_writer(campaign.folder.model)
    with _flying(campaign) as record:
        write_report(
            campaign.folder.path,
            campaign.mission,
            campaign.pool,
            writer,
            record=record,
            ratio=ratio,
            show=show,
            draws=draws,
            latex=latex,
            decided=deciding(campaign, today) if today else lambda _: "",
            since=known_since(campaign) if today else lambda _: "",
        )


def show(campaign: OpenCampaign, number: int | None = None) -> Iterator[Shown]:
    """Draw a weakness by its number, or one of each goal, and yield it; keep figures that exist."""
    path, found = campaign.folder.path, harvested(campaign).goal_weaknesses
    wanted = least(found) if number is None else (weakness_of(path, found, number).at_least,)
    with _flying(campaign) as record:
        for weakness in wanted:
            yield draw_weakness(campaign.folder, campaign.mission, campaign.pool, weakness, record)


@contextmanager
def _flying(campaign: OpenCampaign) -> Iterator[Record]:
    """Yield a function that flies specifications again, or raises the reason why it cannot."""
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


RESULTS = (
    *("undetected", "detection not recorded", "late", "in time"),
    *("violated without faults", "none found", "not searched"),
)
"""Results of a requirement, the gravest first."""

_UNDETECTED, _UNRECORDED, *_, _ANYWAY, _NONE_FOUND, _NOT_SEARCHED = RESULTS


def export_results(file: "ReqifFile", run: Path, output: Path) -> Mapping[str, tuple[str, ...]]:
    """Write a ReqIF file with the results of its requirements; return their IDs by result.

    The campaign in ``run`` has what breaks goals, and its mission which requirements these have.
    """
    with open_campaign(run) as campaign:
        known = known_by(SearchSpace.of(campaign.mission, campaign.pool), campaign.store)
        found = {} if known is None else results(campaign.mission, campaign.pool, known)
    shown = {each.id: found.get(each.id, _NOT_SEARCHED) for each in file.requirements}
    with whole_file(output) as written:
        written.write(file.with_results(shown))
    by_result = {each: tuple(own for own in shown if shown[own] == each) for each in RESULTS}
    return {**by_result, "written": (str(output),)}


def results(mission: Mission, pool: FaultPool, known: Harvest) -> dict[str, str]:
    """Return the result of each requirement for which a goal of a mission stands, by its ID."""
    found: dict[str, str] = {}
    for verdict in verdicts(mission, pool, known):
        of_goal = [_ANYWAY if verdict.state is State.BROKEN_ANYWAY else _NONE_FOUND]
        for each in known.goal_weaknesses:
            if each.goal == verdict.goal and each.measure != MEASURES[0]:
                worst = each.shown.detection.worst if each.shown.detection else _UNRECORDED
                of_goal.append(_UNDETECTED if worst == "never" else worst)
        for own in mission.goals[mission.goal_ids.index(verdict.goal)].requirements:
            found[own] = min(*of_goal, found.get(own, _NOT_SEARCHED), key=RESULTS.index)
    return found
