"""The command ``mrsfi explain``: which faults of a specification break which goal, and why."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import click

from mrsfi.campaign_folders import FlyableCampaign, open_to_fly
from mrsfi.engines import own_engine
from mrsfi.folders import MissionFolders, find_mission, is_mission
from mrsfi.loading import load_fresh, read_specification, specification_writer
from mrsfi_runtime.analysis.columns import top
from mrsfi_runtime.analysis.findings import find_findings
from mrsfi_runtime.analysis.report import SpecificationWriter, specification_rows
from mrsfi_runtime.causes.cause_set import chosen
from mrsfi_runtime.causes.counts import Flights
from mrsfi_runtime.causes.explanation import Explanation, explain
from mrsfi_runtime.causes.recorded import recorded
from mrsfi_runtime.cli.console import print_json, tell
from mrsfi_runtime.cli.engines import (
    EngineOptions,
    WorkerOptions,
)
from mrsfi_runtime.cli.explained import (
    CAUSE_SET,
    SIMPLEST,
    Shown,
    as_json,
    of_goal,
    print_explanation,
)
from mrsfi_runtime.cli.progress import tell_of_fitness
from mrsfi_runtime.cli.replay import find_evaluation, require_same
from mrsfi_runtime.cli.tables import print_findings
from mrsfi_runtime.engine.flights import Engine, Evaluator
from mrsfi_runtime.engine.settings import AUTO, EngineSettings
from mrsfi_runtime.errors import ReplayMismatch, UsageError
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import Specification, numbered
from mrsfi_runtime.record.campaign import Evaluation
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.named_faults import NamedFault, named_faults
from mrsfi_runtime.record.regressions import folder_of
from mrsfi_runtime.record.settings import VIOLATIONS, CampaignSettings


@dataclass(frozen=True, slots=True)
class Subject:
    """A specification that is to be explained.

    Attributes
    ----------
    name
        Stem of what is written about it.
    title
        What it is, for people.
    faults
        Its timed faults.
    recorded
        What a campaign found under it, if it comes from one.
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
class Case:
    """All that specifications are explained with.

    Attributes
    ----------
    code
        The mission, its pool that of the specifications.
    measure
        What is counted.
    mission_seeds
        Weathers that are counted together.
    write
        Writes faults of the specifications as a model.
    folder
        Where the cause sets are written.
    source
        The file, or the campaign.
    """

    code: MissionCode
    measure: Measure
    mission_seeds: tuple[int, ...]
    write: SpecificationWriter
    folder: Path
    source: Path


def explain_faults(  # noqa: PLR0913 - one parameter per option
    target: str,
    generated: Path | None,
    *,
    engine: EngineOptions,
    workers: WorkerOptions,
    faults: Path | None,
    best: bool,
    evaluation: int | None,
    n_top: int | None,
    keep: float,
    kind: str | None,
    seed: int | None,
    out: Path | None,
    is_json: bool,
) -> None:
    """Find out which faults of a specification break which goal."""
    chosen = {"--best": best or None, "--evaluation": evaluation, "--top": n_top}
    given = [option for option, value in chosen.items() if value is not None]
    if len(given) > 1:
        raise click.UsageError(f"{' and '.join(given)} exclude each other")
    if faults is not None:
        if given:
            raise click.UsageError(f"{given[0]} is about a campaign; --faults names a file")
        settings = engine.settings(default=AUTO)
        case, subject = _of_file(find_mission(target, generated), faults, kind, seed, out)
        _explain_all(case, [subject], settings, workers, keep, is_json=is_json)
        return
    if seed is not None or generated is not None:
        option = "--generated" if seed is None else "--seed"
        raise click.UsageError(
            f"{option} needs --faults; a campaign has code and weather of its own"
        )
    with open_to_fly(_run(target)) as campaign:
        recorded_by = campaign.store.manifest.engine
        settings = engine.settings(recorded_by if recorded_by.is_foreign else None, AUTO)
        subjects = _of_run(campaign, evaluation, n_top)
        case = _case_of_run(campaign, kind, out)
        _explain_all(case, subjects, settings, workers, keep, is_json=is_json)


def _of_file(
    folders: MissionFolders, path: Path, kind: str | None, seed: int | None, out: Path | None
) -> tuple[Case, Subject]:
    """Return a written specification, and what it is explained with."""
    if out is None and path.resolve().parent == folder_of(folders.models).resolve():
        raise UsageError(
            f"{path}: is a kept finding, and its cause sets would stand among those that are kept; "
            "expected another folder: name it with --out"
        )
    code = load_fresh(folders)
    written = read_specification(path, code)
    for oddity in written.oddities(path, code.mission):
        tell(oddity)
    pool = written.pool
    case = Case(
        code=replace(code, pool=pool),
        measure=Measure.of(CampaignSettings(violations=kind or VIOLATIONS[0]), code.mission),
        mission_seeds=(1 if seed is None else seed,),
        write=written.write,
        folder=path.parent if out is None else out,
        source=path,
    )
    return case, Subject(
        path.stem, str(path), named_faults(code.mission, pool, written.specification)
    )


def _run(target: str) -> Path:
    """Return the folder of a campaign.

    Raises
    ------
    UsageError
        If it is none, but the name of a mission.
    """
    path = Path(target)
    if not CampaignFolder(path).database.is_file() and is_mission(target):
        raise UsageError(
            f"found mission '{target}'; expected the folder of a campaign, or --faults FILE with a "
            "fault specification of the mission"
        )
    return path


def _case_of_run(campaign: FlyableCampaign, kind: str | None, out: Path | None) -> Case:
    settings = campaign.store.settings
    measure = Measure.of(settings, campaign.mission)
    measure = measure if kind is None else replace(measure, kind=kind)
    tell_of_fitness(settings, measure)
    return Case(
        code=campaign.code,
        measure=measure,
        mission_seeds=settings.mission_seeds,
        write=specification_writer(campaign.folder.model),
        folder=campaign.folder.causes if out is None else out,
        source=campaign.folder.path,
    )


def _of_run(campaign: FlyableCampaign, index: int | None, n_top: int | None) -> list[Subject]:
    """Return evaluations of a campaign, the most critical one if neither is given."""
    measure = Measure.of(campaign.store.settings, campaign.mission)
    evaluations = () if n_top is None else top(campaign.store, measure, n_top)
    return [
        Subject(
            f"evaluation_{each.index}",
            f"evaluation {each.index} of {campaign.folder.path}, fitness {each.fitness[0]:.2f}",
            named_faults(
                campaign.mission,
                campaign.pool,
                each.specification,
                numbered(timed.fault for timed in each.specification),
            ),
            each,
        )
        for each in evaluations or (find_evaluation(campaign, index),)
    ]


def _explain_all(
    case: Case,
    subjects: Sequence[Subject],
    settings: EngineSettings,
    workers: WorkerOptions,
    keep: float,
    *,
    is_json: bool,
) -> None:
    """Explain specifications one after the other; print each, and write its cause set."""
    workers.require_sense(settings)
    seed = case.mission_seeds[0]
    if settings.name == AUTO:
        settings = workers.tried(case.code, seed, settings)
    told, causes = [], []
    with (
        workers.evaluator(case.code, seed, settings) as evaluator,
        own_engine(evaluator, case.code, seed, settings) as engine,
    ):
        for subject in subjects:
            if not settings.has_simulation:
                require_repeatable(engine, subject)
            shown, found = _explain(case, evaluator, engine, subject, keep)
            if is_json:
                told.append(as_json(shown, found))
            else:
                print_explanation(shown, found)
            if found is not None and subject.recorded is not None:
                causes.append(recorded(subject.recorded.index, found.cause, subject.faults))
    mission = case.code.mission
    known = {each.recorded.index: each.specification for each in subjects if each.recorded}
    findings = find_findings(mission, case.code.pool, causes, known)
    goals, duration = mission.goal_ids, mission.duration
    if is_json:
        grouped = [finding.as_json(goals, duration) for finding in findings]
        print_json({"explanations": told, "findings": grouped})
    elif len(subjects) > 1:
        print_findings(goals, duration, findings)


def _explain(
    case: Case, evaluator: Evaluator, engine: Engine, subject: Subject, keep: float
) -> tuple[Shown, Explanation | None]:
    """Explain a specification, which flies as it is recorded, and write its cause set."""
    flights = Flights(evaluator.evaluate_many, case.measure, case.mission_seeds)
    if subject.recorded is not None:
        require_same(case.source, subject.recorded, flights.outcome(subject.specification))
    found = explain(flights, engine, subject.specification, keep)
    paths = _write(case, subject, found)
    return Shown(case.code, case.measure, subject.title, subject.faults, keep, paths), found


def require_repeatable(engine: Engine, subject: Subject) -> None:
    """Refuse somebody else's simulation on which the same specification flies differently.

    Raises
    ------
    ReplayMismatch
        If two flights of it differ.
    """
    first, second = (engine.evaluate(subject.specification) for _ in range(2))
    if first != second:
        raise ReplayMismatch(
            f"{subject.title}: flown twice, it had violations {first.believed} and "
            f"{second.believed} believed, {first.true} and {second.true} true, digests "
            f"{first.digest[:8]}… and {second.digest[:8]}…; expected a simulation that repeats "
            "itself; without one, no cause can be told from chance"
        )


def _write(case: Case, subject: Subject, found: Explanation | None) -> dict[str, Path]:
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
        path = case.folder / f"{subject.name}-{kind}.xmi"
        rows = specification_rows(case.code.pool, specification)
        identifier = f"{subject.name}_{kind}".replace("-", "_")
        names = [subject.faults[place].name for place in places]
        try:
            case.folder.mkdir(parents=True, exist_ok=True)
            case.write(rows, path, identifier, names)
        except OSError as error:
            raise UsageError(
                f"{path}: cannot be written: {error.strerror}; name another folder with --out"
            ) from error
        paths[what] = path
    return paths
