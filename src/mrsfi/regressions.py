"""Findings that are kept beside the models of a mission, and flown against those of today."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic

from mrsfi.campaign_folders import OpenCampaign, findings_of, mission_of
from mrsfi.engines import Tell, opened, silent
from mrsfi.files import whole_file
from mrsfi.folders import MissionFolders
from mrsfi.loading import load_fresh, read_specification, specification_writer
from mrsfi_runtime.analysis.report import specification_rows
from mrsfi_runtime.causes.cause import find_cause
from mrsfi_runtime.causes.cause_set import KEEP
from mrsfi_runtime.causes.counts import Flights
from mrsfi_runtime.causes.recorded import NO_FAULT, sentences
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.settings import AUTO, REFERENCE, EngineSettings
from mrsfi_runtime.errors import EvaluationError, MrsfiError, UsageError
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.measure import Measure
from mrsfi_runtime.record.named_faults import named_faults
from mrsfi_runtime.record.regressions import Regression, folder_of, kept
from mrsfi_runtime.record.settings import CampaignSettings, following


@dataclass(frozen=True, slots=True)
class Checked:
    """What became of a kept finding.

    Attributes
    ----------
    regression
        The finding.
    counts
        What each goal that has a limit had at most, over the mission seeds, by its ID; empty if
        it could not be flown.
    error
        Why it could not, if so.
    gone
        Faults of it that the pool of today does not have; it carries copies of them.
    why
        Of one that came back, what each fault of its cause did, in words.
    seconds
        How long it took.
    """

    regression: Regression
    counts: dict[str, int]
    error: MrsfiError | None
    gone: tuple[str, ...]
    why: tuple[str, ...]
    seconds: float

    @property
    def exceeded(self) -> tuple[str, ...]:
        """IDs of the goals that have more than is kept."""
        return self.regression.exceeded(self.counts)

    @property
    def excess(self) -> str:
        """What exceeds its limit, in words."""
        limits, kind = self.regression.limits, self.regression.violations
        found = (f"{goal} {self.counts[goal]}, kept {limits[goal]}" for goal in self.exceeded)
        return f"{self.regression.name}: {kind} {'; '.join(found)}"


def keep(
    campaign: OpenCampaign,
    number: int = 1,
    name: str | None = None,
    limits: Mapping[str, int] | None = None,
) -> Regression:
    """Keep a finding of a campaign beside the models of its mission.

    Parameters
    ----------
    number
        Which finding, from 1 on.
    name
        Of its two files; after the campaign if left out.
    limits
        What each goal may have at most, by its ID; what the finding has if left out.

    Raises
    ------
    UsageError
        If there is no such finding, goal or mission, or something of that name is kept already.
    """
    path = campaign.folder.path
    campaign.store.require_flyable()  # counts of other rules are no limits of today's
    findings = findings_of(campaign)
    if not 1 <= number <= len(findings):
        has = f"1 … {len(findings)}" if findings else "a campaign that has findings; it has none"
        raise UsageError(f"{path}: found --finding {number}; expected {has}")
    found = findings[number - 1]
    settings = campaign.store.settings
    folders = mission_of(campaign)
    folder = folder_of(folders.models)
    stem = f"{path.resolve().name}-finding-{number}" if name is None else name
    if not stem or stem != Path(stem).name:
        raise UsageError(f"--name: found '{stem}'; expected the name of a file, without a folder")
    regression = Regression(
        folder / f"{stem}.toml",
        f"{path}, finding {number}: {found.sentence}",
        settings.violations,
        (settings.mission_seed,),
        {},
    )
    goals = campaign.mission.goal_ids
    counts = dict(zip(goals, getattr(found.outcome, settings.violations), strict=True))
    regression = replace(regression, limits=counts if limits is None else limits)
    regression.counts(goals, found.outcome)  # refuses goals that there are not
    if regression.path.exists() or regression.specification.exists():
        raise UsageError(
            f"{regression.path}: is kept already; choose another name with --name, or take new "
            f"limits over with: mrsfi keep {folders.named} --update"
        )
    specification = tuple(fault.timed for fault in found.faults)
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be made: {error.strerror}") from error
    specification_writer(folders.models)(
        specification_rows(campaign.pool, specification),
        regression.specification,
        "kept",
        [fault.name for fault in found.faults],
    )
    write_limits(regression)
    return regression


def write_limits(regression: Regression) -> None:
    """Write what a kept finding may have, as a whole file.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    with whole_file(regression.path) as file:
        file.write(regression.text().encode())


def all_kept(folders: MissionFolders) -> tuple[Regression, ...]:
    """Return the findings that are kept of a mission.

    Raises
    ------
    UsageError
        If there is none, which is no pass; or if limits cannot be read.
    """
    regressions = kept(folders.models)
    if not regressions:
        raise UsageError(
            f"{folders.models}: nothing is kept; expected at least one finding in regressions/; "
            "keep one with: mrsfi keep CAMPAIGN --finding 1"
        )
    return tuple(regressions)


def check_all(
    folders: MissionFolders,
    engine: EngineSettings,
    tell: Tell = silent,
    n_seeds: int | None = None,
    name: str | None = None,
) -> Iterator[Checked]:
    """Fly everything that is kept of a mission, and yield what became of each, by name.

    Parameters
    ----------
    folders
        The mission.
    engine
        Which engine flies; auto is compiled if that is built, and else reference.
    tell
        Told what cannot be compiled.
    n_seeds
        Number of mission seeds, from the first of each on, in place of its own.
    name
        The only one that is flown, if it is one.

    Raises
    ------
    UsageError
        If nothing is kept, or nothing of that name, or limits cannot be read.
    MrsfiError
        If the mission cannot be flown at all.
    """
    regressions = all_kept(folders)
    chosen = [each for each in regressions if name in {None, each.name}]
    if not chosen:
        names = ", ".join(each.name for each in regressions)
        raise UsageError(
            f"{folders.models}: found --name {name}; expected one that is kept: {names}"
        )
    code = load_fresh(folders)
    if engine.name == AUTO:
        engine = engine.tried(code, regressions[0].mission_seeds[0], tell, waits=False)
        engine = replace(engine, name=REFERENCE) if engine.name == AUTO else engine
    for regression in chosen:
        if n_seeds is not None:
            seeds = following(regression.mission_seeds[0], n_seeds)
            regression = replace(regression, mission_seeds=seeds)  # noqa: PLW2901
        yield _checked(regression, code, engine, tell)


def _checked(
    regression: Regression, code: MissionCode, settings: EngineSettings, tell: Tell
) -> Checked:
    began = monotonic()
    counts: dict[str, int] = {}
    gone: tuple[str, ...] = ()
    why: tuple[str, ...] = ()
    failure = None
    try:
        written = read_specification(regression.specification, code)
        gone = written.unknown
        flown = replace(code, pool=written.pool)
        with opened(flown, regression.mission_seeds[0], settings, tell) as engine:
            counts, worst = _worst(regression, engine, written.specification)
            if back := regression.exceeded(counts):
                why = _why(regression, engine, back, worst)
    except MrsfiError as error:
        failure = error
    return Checked(regression, counts, failure, gone, why, monotonic() - began)


def _worst(
    regression: Regression, engine: Engine, specification: Specification
) -> tuple[dict[str, int], int]:
    """Return the most that each goal has in any weather, and the seed of the worst weather."""
    goals = engine.code.mission.goal_ids
    found = {
        seed: regression.counts(goals, engine.evaluate(specification, seed))
        for seed in regression.mission_seeds
    }
    limits = regression.limits
    return (
        {goal: max(counts[goal] for counts in found.values()) for goal in limits},
        max(found, key=lambda seed: sum(found[seed][goal] - limits[goal] for goal in limits)),
    )


def _why(
    regression: Regression, engine: Engine, goals: tuple[str, ...], seed: int
) -> tuple[str, ...]:
    """Return what each fault did without which goals would have less, in words."""
    mission = engine.code.mission
    specification = engine.code.pool.written_specification()
    settings = CampaignSettings(violations=regression.violations, goals=goals)
    flights = Flights(engine.evaluate_many, Measure.of(settings, mission), (seed,))
    try:
        cause = find_cause(flights, engine, specification, KEEP)
    except EvaluationError as error:  # under a part of the faults: it came back all the same
        return (f"why is not known: {error}",)
    if cause is None or not cause.places:
        return (NO_FAULT,)
    names = [fault.id for fault in engine.code.pool]
    return sentences(cause, named_faults(mission, engine.code.pool, specification, names))
