"""Weaknesses that are kept beside the models of a mission, and flown with those of today.

``keep`` writes a weakness of a campaign as a specification and limits; ``check_all`` flies all kept
weaknesses, and ``update`` replaces their limits by today's counts. A weakness that cannot be flown
or judged is an error, never a pass. ``regression_test`` makes test cases for pytest. ``decide``
writes what a team decided on a weakness.
"""

import datetime as dt
from collections import defaultdict
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, TypeAlias

from mrsfi.engines import AS_RECORDED, Given, Tell, evaluator, project, silent
from mrsfi.folders import MissionFolders, find_mission, folders_at, load_fresh
from mrsfi.loading import Written, load_models, read_specification, specification_writer
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.engine.opening import open_engine, quickest
from mrsfi_runtime.errors import (
    EvaluationError,
    MrsfiError,
    SpecificationError,
    UndecidedWeakness,
    UsageError,
)
from mrsfi_runtime.files import changing, writable
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import FaultPool, Specification, original
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.decisions import (
    Cause,
    Decision,
    decision_file,
    decision_files,
    decision_on,
    decisions_of,
    read_decision,
)
from mrsfi_runtime.record.engine_settings import AUTO, BOTH, EngineSettings, Workers, parts_of
from mrsfi_runtime.record.settings import CampaignSettings, Regression, folder_of, following, kept

if TYPE_CHECKING:
    from mrsfi.campaign_folders import OpenCampaign
    from mrsfi_runtime.causes.mildest import GoalWeakness

_ALL = Workers()  # one for each processor


@dataclass(frozen=True, slots=True)
class Checked:
    """The result of a kept weakness, with its mission ``seeds`` and the ``seconds`` that it took.

    ``counts`` has the maximum count of each limited goal, by ID, over the seeds of the limits; it
    is empty if the weakness could not be flown, and ``error`` is the reason. ``others`` has the
    same for the other seeds. ``gone`` are its faults that are not in today's pool; the kept file
    has copies of them. If a limit is exceeded, ``why`` has what each fault of the cause did, and
    ``places`` the lines of the models or regions concerned. ``faults`` are the pool's, sorted.
    ``about`` has sentences on what its goals stand for, and on decisions.

    A decision is a result, too: it has no limits, and ``warning`` says whether it has expired.
    """

    regression: Regression
    seeds: tuple[int, ...]
    counts: Mapping[str, int] = field(default_factory=dict)
    others: Mapping[str, int] = field(default_factory=dict)
    error: MrsfiError | None = None
    gone: tuple[str, ...] = ()
    why: tuple[str, ...] = ()
    seconds: float = 0.0
    places: tuple[tuple[Path, int], ...] = ()
    faults: tuple[str, ...] = ()
    about: tuple[str, ...] = ()
    warning: str = ""
    is_decision: bool = False

    @property
    def exceeded(self) -> tuple[str, ...]:
        """IDs of the goals that exceed their limits."""
        return self.regression.exceeded(self.counts)

    @property
    def excess(self) -> str:
        """The goals that exceed their limits, in words."""
        return self._excess(self.counts)

    @property
    def now(self) -> dict[str, int]:
        """The maximum count of each limited goal over all seeds."""
        return {goal: max(most, self.others.get(goal, 0)) for goal, most in self.counts.items()}

    @property
    def failure(self) -> MrsfiError | None:
        """Why it cannot be judged: not flown, or more violations in seeds without a limit."""
        if self.exceeded or not self.regression.exceeded(self.others):
            return self.error
        path = self.regression.path
        return UsageError(
            f"{path}: the limits are for mission seeds "
            f"{', '.join(map(str, self.regression.mission_seeds))}; in other seeds "
            f"{self._excess(self.others)}; to limit these, too: mrsfi keep "
            f"{path.parent.parent} --update --name {path.stem} --seeds {len(self.seeds)}"
        )

    def _excess(self, counts: Mapping[str, int]) -> str:
        limits, kind = self.regression.limits, self.regression.violations
        excess = (
            f"{goal} ({kind}) exceeds its limit ({counts[goal]}, allowed {limits[goal]})"
            for goal in self.regression.exceeded(counts)
        )
        return f"{self.regression.name}: {'; '.join(excess)}"


def keep(
    campaign: "OpenCampaign",
    number: int = 1,
    name: str | None = None,
    limits: Mapping[str, int] | None = None,
    n_seeds: int = 1,
    engine: Given = AS_RECORDED,
    accepted: str = "",
) -> Regression:
    """Keep a weakness, by its number from 1 on, beside the models of its mission.

    Its files are named after the campaign unless ``name`` is given. The limit is on the goal, by
    the gravest measure by which it breaks: the maximum over ``n_seeds`` mission seeds, beginning
    with the campaign's, unless ``limits`` are given, by goal ID. In seeds that the campaign did not
    fly, the engine flies the campaign's own code. ``accepted`` is why the limits are accepted.
    """
    from mrsfi.campaign_folders import mission_of  # noqa: PLC0415 - not for a check, as below
    from mrsfi.explaining import flying_again, harvested, weakness_of  # noqa: PLC0415
    from mrsfi_runtime.analysis.weaknesses import evidence  # noqa: PLC0415

    path = campaign.folder.path
    campaign.store.require_flyable()  # counts of other rules are no limits of today's
    known = harvested(campaign)
    weakness = weakness_of(path, known.goal_weaknesses, number)
    specification = weakness.shown.witness
    settings = campaign.store.settings
    folders = mission_of(campaign)
    folder = folder_of(folders.models)
    stem = f"{path.resolve().name}-weakness-{number}" if name is None else name
    if not stem or stem != Path(stem).name:
        raise UsageError(f"--name: found '{stem}'; expected the name of a file, without a folder")
    regression = Regression(
        folder / f"{stem}.toml",
        f"{_origin(campaign, weakness)}. {evidence(weakness)}",
        weakness.measure,
        following(settings.mission_seed, n_seeds),
        {weakness.goal: 0} if limits is None else limits,
        accepted=accepted,
        side=campaign.store.manifest.engine.side,
    )
    goals = campaign.mission.goal_ids
    counts = regression.counts(goals, known.outcomes[specification], "--max")  # refuses other goals
    _require_new(regression, folders)
    if limits is None:
        counted, others = [counts], regression.mission_seeds[1:]
        if others:
            with flying_again(path, engine, Workers(1), silent) as (_, __, own):
                flown = (own.evaluate(specification, seed) for seed in others)
                counted += [regression.counts(goals, each) for each in flown]
        regression = replace(regression, limits=_most(counted))
    contents: dict[Path, bytes] = {regression.path: regression.text().encode()}
    write = specification_writer(folders.models, contents.__setitem__)
    write(campaign.pool, specification, regression.specification, "kept", None)
    with changing(folders.models) as change:
        _require_new(regression, folders)
        change.replace(contents)
    return regression


def _origin(campaign: "OpenCampaign", weakness: "GoalWeakness") -> str:
    """Return in words where a weakness was found, and what it is."""
    from mrsfi_runtime.analysis.weaknesses import sentence  # noqa: PLC0415

    found = sentence(campaign.mission, campaign.pool, weakness)
    faults = " and ".join(weakness.faults)
    return f"{campaign.folder.path}, weakness {weakness.number} ({faults}): {found}"


def decide(
    campaign: "OpenCampaign",
    number: int,
    kind: str,
    because: str,
    by: str,
    today: dt.date,
    *,
    until: dt.date | None = None,
    of: int | None = None,
) -> Decision:
    """Decide on a weakness by its number, in place of an earlier decision on it.

    ``kind`` is one of ``KINDS``; a duplicate is one of the weakness with the number ``of``.
    """
    from mrsfi.campaign_folders import mission_of  # noqa: PLC0415
    from mrsfi.explaining import harvested, weakness_of  # noqa: PLC0415

    path, known = campaign.folder.path, harvested(campaign).goal_weaknesses
    weakness, models = weakness_of(path, known, number), mission_of(campaign).models
    original = None if of is None else weakness_of(path, known, of)
    if original == weakness:
        raise UsageError(f"--of: found {of}, the weakness itself; expected another weakness")
    cause = Cause(weakness.goal, weakness.faults)
    decision = Decision(
        decision_file(models, cause, weakness.measure),
        weakness.goal,
        weakness.measure,
        weakness.faults,
        kind,
        because,
        by,
        today,
        until,
        None if original is None else Cause(original.goal, original.faults),
        _origin(campaign, weakness),
    )
    Decision.parse(decision.path, decision.text())  # refuses what a file may not have
    with changing(models) as change:
        gone = {each.path: None for each in decisions_of(models) if each.cause == cause}
        change.replace({**gone, decision.path: decision.text().encode()})
    return decision


def _require_new(regression: Regression, folders: MissionFolders) -> None:
    with writable(regression.path, "choose another name with --name"):
        if regression.path.exists() or regression.specification.exists():
            raise UsageError(
                f"{regression.path}: exists already; choose another name with --name, or replace "
                f"its limits with: mrsfi keep {folders.named} --update"
            )


def update(
    folders: MissionFolders,
    engine: EngineSettings,
    tell: Tell = silent,
    n_seeds: int | None = None,
    name: str | None = None,
    accepted: str = "",
) -> list[tuple[Regression, Regression]]:
    """Replace the limits of all kept weaknesses, or of one, by today's counts; return the changes.

    If one cannot be judged, nothing is written.
    """
    checked = [*check_all(folders, engine, tell, n_seeds, name)]
    for each in checked:
        if each.error is not None:
            raise each.error
    changed = []
    for each in checked:
        before, because = each.regression, accepted or each.regression.accepted
        new = replace(before, mission_seeds=each.seeds, limits=each.now, accepted=because)
        if new != before:
            changed.append((before, new))
    if changed:
        with changing(folders.models) as change:
            change.replace({new.path: new.text().encode() for _, new in changed})
    return changed


def all_kept(folders: MissionFolders) -> tuple[Regression, ...]:
    """Return all kept weaknesses of a mission; if there are none, it is a ``UsageError``."""
    regressions = kept(folders.models)
    if not regressions:
        found = f"{folders.models}: no weakness is kept; expected at least one in regressions/"
        raise UsageError(f"{found}; keep one with: mrsfi keep CAMPAIGN --weakness 1")
    return regressions


def missions_with_kept() -> Iterator[MissionFolders]:
    """Yield all folders below ``models`` with kept weaknesses or decisions, also without models."""
    models = project().models
    named = ("*/regressions", "*/decisions", "**/regressions", "**/decisions")  # * follows links
    for folder in sorted({path.parent for each in named for path in models.glob(each)}):
        if kept(folder) or decision_files(folder):
            name = folder.relative_to(models).as_posix()
            yield replace(folders_at(folder), name=name)


def check_mission(
    folders: MissionFolders,
    engine: EngineSettings,
    tell: Tell,
    n_seeds: int | None,
    today: dt.date,
    *,
    is_strict: bool,
    workers: Workers = _ALL,
) -> list[Checked]:
    """Fly all kept weaknesses of a mission, and compare its decisions with the models and a date.

    One of both is needed. If the check is strict, an expired decision is an error.
    """
    models, files, decided = folders.models, decision_files(folders.models), list[Decision]()
    checked = list[Checked]()
    if kept(models) or not files:
        checked += check_all(folders, engine, tell, n_seeds, workers=workers)
    rows, load = [], cache(load_models)
    for path in files:
        row = Checked(Regression(path, "", "", (), {}), (), places=((path, 1),), is_decision=True)
        try:
            decided.append(decision := read_decision(path))
            loaded = load(models)
            decision.require_known([each.ID for each in (*loaded.mission.goals, *loaded.pool)])
        except MrsfiError as error:
            rows.append(replace(row, error=error))
            continue
        about = decision.sentence(today)
        warning = f"{path}: {about} Decide again" if decision.has_expired(today) else ""
        expired = UndecidedWeakness(warning) if warning and is_strict else None
        rows.append(replace(row, error=expired, about=(about,), warning=warning))
    for place, each in enumerate(checked):
        kind, goals = each.regression.violations, each.regression.limits
        some = {decision_on(Cause(goal, each.faults), kind, decided) for goal in goals}
        sentences = sorted(one.sentence(today) for one in some if one)
        checked[place] = replace(each, about=(*each.about, *sentences))
    return checked + rows


def _names(models: Path, known: Container[str]) -> dict[Cause, str]:
    """Return the names of kept weaknesses, but for unreadable ones, by what they limit."""
    names: dict[Cause, str] = {}
    for each in kept(models):
        if each.defect is None:
            copies = [fault.ID for fault in load_models(each.specification).pool]
            names |= {Cause(goal, _faults_of(copies, known)): each.name for goal in each.limits}
    return names


def settled(
    campaign: "OpenCampaign",
    found: "Iterable[GoalWeakness]",
    today: dt.date,
    *,
    is_valid: bool = False,
) -> dict[int, dict[str, str]]:
    """Return cells of an FMEA by weakness: what the team decided on it, and kept of it.

    Others have none. With ``is_valid``, neither has a weakness whose decision has expired.
    """
    from mrsfi.campaign_folders import models_of  # noqa: PLC0415

    models, cells = models_of(campaign), dict[int, dict[str, str]]()
    if models is None:
        return cells
    names, decisions = _names(models, campaign.pool.by_id), decisions_of(models)
    for each in found:
        cause = Cause(each.goal, each.faults)
        decision, name = decision_on(cause, each.measure, decisions), names.get(cause)
        row, status = dict[str, str](), [f"kept as a test ({name})"] if name else []
        if decision is not None and not (is_valid and decision.has_expired(today)):
            row["recommended action"] = decision.because if decision.kind == "mitigate" else ""
            row["owner"] = decision.by
            status.insert(0, decision.in_words(today))
        if status:
            cells[each.number] = {**row, "status": "; ".join(status)}
    return cells


def _faults_of(copies: Iterable[str], known: Container[str]) -> tuple[str, ...]:
    return tuple(sorted({original(each, known) for each in copies}))


def check_all(
    folders: MissionFolders,
    engine: EngineSettings,
    tell: Tell = silent,
    n_seeds: int | None = None,
    name: str | None = None,
    workers: Workers = _ALL,
) -> Iterator[Checked]:
    """Fly all kept weaknesses of a mission, or one by its name; yield the result of each.

    They fly together on all workers. The engine auto is compiled if that is built, else reference;
    few short flights begin at once, on the reference engine in this process.
    ``n_seeds`` is the number of mission seeds: first those of the limits, then those that follow
    the first one.
    """
    regressions = all_kept(folders)
    chosen = [each for each in regressions if name in {None, each.name}]
    if not chosen:
        names = ", ".join(each.name for each in regressions)
        what = f"{folders.models}: found --name {name}"
        raise UsageError(f"{what}; expected one that is kept: {names}")
    workers.require_sense(engine)
    fresh = []
    for each in chosen:
        seeds = own = each.mission_seeds
        if n_seeds is not None and own:
            seeds = tuple(dict.fromkeys((*own, *following(own[0], n_seeds))))[:n_seeds]
        fresh.append(Checked(each, seeds, error=each.defect))
    try:
        code = load_fresh(folders)
        seed = next((each.seeds[0] for each in fresh if each.seeds), 1)
        n_flights = sum(len(each.seeds) for each in fresh)
        flown_by, workers = quickest(engine, workers, code, seed, tell, n_flights)
    except MrsfiError as error:
        yield from (replace(each, error=each.error or error) for each in fresh)
        return
    read = [(each, None) if each.error else _read(each, code, flown_by, tell) for each in fresh]
    began = monotonic()
    readable = [(found, written) for found, written in read if written]
    flown = _flown_together(readable, code, flown_by, workers)
    seconds = (monotonic() - began) / len(read)
    for found, written in read:
        judged = _judged(found, written, flown, code, engine) if written else found
        yield replace(judged, seconds=judged.seconds + seconds)


_Outcomes: TypeAlias = Mapping[tuple[str, int], Outcome]
"""Outcomes by name of a kept weakness and mission seed."""


def _read(
    found: Checked, code: MissionCode, settings: EngineSettings, tell: Tell
) -> tuple[Checked, Written | None]:
    """Read the specification of a kept weakness; there is none if it cannot be flown."""
    regression = found.regression
    try:
        if regression.side not in {BOTH, settings.side}:
            flown_with = parts_of(regression.side)
            what = f"{regression.path}: its limits are counts of {flown_with}"
            raise UsageError(f"{what}; expected the same, with --side {regression.side}")
        written = read_specification(regression.specification, code)
        if written.late:
            late = "; ".join(written.late)
            raise SpecificationError(f"{late}; expected the mission that it was kept for")
    except MrsfiError as error:
        return replace(found, error=error), None
    faults = _faults_of((fault.id for fault in written.pool), code.pool.by_id)
    goals = [goal for goal in code.mission.goal_ids if goal in regression.limits]
    stakes = {code.mission.label_of(each): code.mission.stakes_of(each) for each in goals}
    about = tuple(f"{goal}: {each}." for goal, each in stakes.items() if each)
    for oddity in regression.idle(code.mission.duration):
        tell(oddity)
    return replace(found, faults=faults, about=about), written


def _flown_together(
    read: Iterable[tuple[Checked, Written]],
    code: MissionCode,
    settings: EngineSettings,
    workers: Workers,
) -> _Outcomes:
    """Fly kept weaknesses with one evaluator; return the outcomes of flights without an error.

    Their pools are joined. Each weakness without an outcome flies alone, and reports its own error.
    """
    pool, flights = FaultPool("kept", ()), defaultdict[int, dict[str, Specification]](dict)
    for found, written in read:
        own, name = written.pool.with_prefix(f"{found.regression.name}/"), found.regression.name
        pool = replace(pool, faults=pool.faults + own.faults, triggers=pool.triggers + own.triggers)
        for seed in found.seeds:
            flights[seed][name] = own.written_specification()
    outcomes = dict[tuple[str, int], Outcome]()
    if not flights:
        return outcomes
    if workers.dask is None:
        workers = Workers(min(workers.count(settings), sum(map(len, flights.values()))))
    joined = replace(code, pool=pool)
    with suppress(MrsfiError), evaluator(joined, min(flights), settings, workers) as many:
        results = [many.evaluate_many([*some.values()], seed) for seed, some in flights.items()]
        for (seed, some), found_in in zip(flights.items(), results, strict=True):
            for name, outcome in zip(some, found_in, strict=True):
                if isinstance(outcome, Outcome):
                    outcomes[name, seed] = outcome
    return outcomes


def _judged(
    found: Checked,
    written: Written,
    flown: _Outcomes,
    code: MissionCode,
    settings: EngineSettings,
) -> Checked:
    """Compare the outcomes of a kept weakness with its limits; if exceeded, find out why."""
    began, regression = monotonic(), found.regression
    own_code, goals = replace(code, pool=written.pool), code.mission.goal_ids
    try:
        with ExitStack() as opened:
            engine = cache(
                lambda: opened.enter_context(open_engine(settings, own_code, found.seeds[0]))
            )
            others = dict[int, dict[str, int]]()
            for seed in found.seeds:
                outcome = flown.get((regression.name, seed))
                if outcome is None:
                    outcome = engine().evaluate(written.specification, seed)
                others[seed] = regression.counts(goals, outcome)
            own = {seed: others.pop(seed) for seed in regression.mission_seeds if seed in others}
            found = replace(
                found,
                gone=written.unknown,
                counts=_most(own.values()),
                others=_most(others.values()),
            )
            if found.exceeded:
                worst = max(own, key=lambda seed: sum(own[seed].values()))
                why, models = _why(regression, engine(), found.exceeded, worst), written.models()
                places = tuple(
                    (models.mission_path, models.nodes[goal].line)
                    for goal in models.mission.goals
                    if goal.ID in found.exceeded
                )
                found = replace(found, why=why, places=places)
    except MrsfiError as error:
        line = getattr(error, "line", None)  # of a region
        found = replace(found, error=error, places=(line,) if line else ())
    return replace(found, seconds=monotonic() - began)


def _most(counts: Iterable[Mapping[str, int]]) -> dict[str, int]:
    most: dict[str, int] = {}
    for each in counts:
        most |= {goal: max(ticks, most.get(goal, 0)) for goal, ticks in each.items()}
    return most


def _why(
    regression: Regression, engine: Engine, goals: tuple[str, ...], seed: int
) -> tuple[str, ...]:
    """Return sentences on the faults without which the goals would have fewer violations."""
    from mrsfi_runtime.causes.cause_set import Flights  # noqa: PLC0415
    from mrsfi_runtime.causes.chain import find_cause  # noqa: PLC0415
    from mrsfi_runtime.record.observers import named_faults  # noqa: PLC0415
    from mrsfi_runtime.record.settings import KEEP  # noqa: PLC0415
    from mrsfi_runtime.record.store import Measure  # noqa: PLC0415

    mission = engine.code.mission
    specification = engine.code.pool.written_specification()
    settings = CampaignSettings(violations=regression.violations, goals=goals)
    flights = Flights(engine.evaluate_many, Measure.of(settings, mission), (seed,))
    try:
        cause = find_cause(flights, engine, specification, KEEP)
    except EvaluationError as error:  # with a part of the faults; the limit is exceeded anyway
        return (f"The cause is not known: {error}",)
    if cause is None or not cause.places:
        return ("Without its faults, the violations occur as well",)
    names = [fault.id for fault in engine.code.pool]
    return cause.sentences(mission, named_faults(mission, engine.code.pool, specification, names))


def regression_test(
    mission: str, engine: str = AUTO, n_seeds: int | None = None
) -> Callable[[str], None]:
    """Return a test with a case for each kept weakness of a mission.

    Parameters
    ----------
    mission
        Name of a folder under ``models`` of the working folder, or the path of a mission folder.
    engine
        ``auto``, ``reference``, ``compiled`` or ``rosbridge``.
    n_seeds
        Number of mission seeds: first those of the limits, then others.

    Raises
    ------
    UsageError
        If there is no such mission, or it has no kept weakness: an empty suite would pass.

    Examples
    --------
    In a file that pytest collects::

        from mrsfi.regressions import regression_test

        test_what_was_found = regression_test("uuv_sampling")
    """
    import pytest  # noqa: PLC0415 - for tests alone

    folders = find_mission(mission)
    names = [regression.name for regression in all_kept(folders)]

    @pytest.mark.parametrize("weakness", names)
    def test_kept_weakness(weakness: str) -> None:
        (checked,) = check_all(folders, EngineSettings(engine), n_seeds=n_seeds, name=weakness)
        if checked.failure is not None:
            raise checked.failure
        found = f"{checked.excess}; from {checked.regression.found}"
        assert not checked.exceeded, "\n".join((found, *checked.why))

    return test_kept_weakness
