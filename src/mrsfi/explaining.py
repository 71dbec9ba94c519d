"""Why specifications of a campaign, or from a file, break goals, with cause sets as models."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from mrsfi.campaign_folders import FlyableCampaign, find_evaluations, require_same
from mrsfi.engines import Tell, flying, silent
from mrsfi.folders import MissionFolders
from mrsfi.loading import load_fresh, read_specification, specification_writer
from mrsfi_runtime.analysis.report import SpecificationWriter, specification_rows
from mrsfi_runtime.causes.cause_set import Flights, chosen
from mrsfi_runtime.causes.explanation import Explanation
from mrsfi_runtime.causes.explanation import explain as find_out
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import tried
from mrsfi_runtime.errors import ReplayMismatch, UsageError
from mrsfi_runtime.files import telling
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import Specification, numbered
from mrsfi_runtime.record.engine_settings import AUTO, BOTH, EngineSettings, Workers
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.regressions import folder_of
from mrsfi_runtime.record.settings import VIOLATIONS, CampaignSettings
from mrsfi_runtime.record.store import Evaluation, Measure

CAUSE_SET, SIMPLEST = "cause set", "simplest form"
"""What specifications are that come of an explanation."""


@dataclass(frozen=True, slots=True)
class NamedSpecification:
    """A specification that is to be explained, and what a campaign found under it, if it is of one.

    The name is the stem of what is written about it; the title says what it is, for people.
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
    """All that specifications are explained with.

    The code has the pool of the specifications; counts of all mission seeds are summed; ``write``
    writes faults as a model, into ``folder``; ``source`` is the file, or the campaign.
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
        """Write cause sets and the simplest form as XMI; return the files by what they are."""
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
            rows = specification_rows(self.code.pool, specification)
            identifier = f"{subject.name}_{kind}".replace("-", "_")
            names = [subject.faults[place].name for place in places]
            with telling(path, "name another folder with --out"):
                self.folder.mkdir(parents=True, exist_ok=True)
                self.write(rows, path, identifier, names)
            paths[what] = path
        return paths


def of_goal(goal: str) -> str:
    """Return what the cause set of one goal is called."""
    return f"{CAUSE_SET} of {goal}"


def explainer_of_file(
    folders: MissionFolders,
    path: Path,
    kind: str | None,
    seed: int | None,
    out: Path | None,
    tell: Tell,
) -> tuple[Explainer, NamedSpecification]:
    """Return a written specification, and what it is explained with; tell what is odd about it.

    Believed violations are counted if no other kind is named, in mission seed 1 if none is. Cause
    sets go beside the file if no folder is named, but never among kept weaknesses.
    """
    if out is None and path.resolve().parent == folder_of(folders.models).resolve():
        raise UsageError(
            f"{path}: is a kept weakness, and its cause sets would stand among what is kept; "
            "expected another folder: name it with --out"
        )
    code = load_fresh(folders)
    written = read_specification(path, code, tell)
    pool = written.pool
    explainer = Explainer(
        code=replace(code, pool=pool),
        measure=Measure.of(CampaignSettings(violations=kind or VIOLATIONS[0]), code.mission),
        mission_seeds=(1 if seed is None else seed,),
        write=specification_writer(written.models),
        folder=path.parent if out is None else out,
        source=path,
    )
    return explainer, NamedSpecification(
        path.stem, str(path), named_faults(code.mission, pool, written.specification)
    )


def explainer_of_campaign(
    campaign: FlyableCampaign, kind: str | None = None, out: Path | None = None
) -> Explainer:
    """Return what evaluations of a campaign are explained with; by default it counts the same."""
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
    """Yield specifications, each with all about why it breaks goals; ``None`` if it breaks none.

    One that does not fly as it is recorded is a ``ReplayMismatch``.
    """
    workers.require_sense(engine)
    code, seed = explainer.code, explainer.mission_seeds[0]
    if engine.name == AUTO:
        engine = tried(engine, code, seed, tell)
    with flying(code, seed, engine, workers, tell) as (evaluator, own):
        for each in specifications:
            if engine.side != BOTH and each.recorded is None:
                require_repeatable(own, each)
            flights = Flights(evaluator.evaluate_many, explainer.measure, explainer.mission_seeds)
            if each.recorded is not None:
                require_same(explainer.source, each.recorded, flights.outcome(each.specification))
            yield each, find_out(flights, own, each.specification, keep)


def require_repeatable(engine: Engine, subject: NamedSpecification) -> None:
    """Refuse what somebody else flies if the same specification flies differently."""
    first, second = (engine.evaluate(subject.specification) for _ in range(2))
    if first != second:
        raise ReplayMismatch(
            f"{subject.title}: flown twice, it had violations {first.believed} and "
            f"{second.believed} believed, {first.true} and {second.true} true, digests "
            f"{first.digest[:8]}… and {second.digest[:8]}…; expected what repeats itself; without "
            "that, no cause can be told from chance"
        )
