"""Compare setups of a search, and two campaigns from before and after a change.

``compared`` makes a run of each setup with each seed, all on one mission with the same number of
evaluations. Each run is a campaign, so a finished run is not repeated. A run that was made with
other models, code or settings is refused. ``changes`` simulates the weaknesses of each of two
campaigns in the mission of the other, and reports which went, came and stayed.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from time import monotonic
from typing import Any

import mrsfi_runtime
from mrsfi.campaign_folders import FlyableCampaign, open_campaign, open_to_fly
from mrsfi.engines import Given, Tell, project, silent
from mrsfi.evolving import made, require_searchable, search
from mrsfi.explaining import flying_again, harvested
from mrsfi.folders import MissionFolders
from mrsfi_runtime.analysis.tables import Table
from mrsfi_runtime.analysis.weaknesses import cause_in_words
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, Breaking
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import RecordError, SpecificationError, UsageError, counted
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.model.faults import Gate
from mrsfi_runtime.record.database import CampaignFolder, canonical, file_hashes, only_writer
from mrsfi_runtime.record.engine_settings import EngineSettings, Workers
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.study.comparison import (
    Comparison,
    RunResult,
    Sweep,
    Variant,
    as_json,
    compare,
    measure_run,
)
from mrsfi_runtime.study.folder import ComparisonFolder

_SOURCE, _SECONDS, _RESULT = "mrsfi_sha256", "seconds", "result"
"""Additional values in the record of a run."""

_NOTED = 1.0  # seconds between two notes of the time that a run has taken


def default_folder(mission: str, case: str, kind: str = "compare") -> Path:
    """Return the default folder of a comparison or sweep."""
    return project().runs / f"{kind}-{mission}-{Path(case).stem}"


def settings_of(
    file: Path, code: MissionCode, variants: Sequence[Variant], evaluations: int
) -> Iterator[tuple[str, CampaignSettings]]:
    """Yield name and settings of each setup: those of a campaign file, with its overrides."""
    for variant in variants:
        one = CampaignSettings.load(file, **variant.overrides, evaluations=evaluations)
        require_searchable(code, one)
        yield variant.name, one


def compared(
    path: Path,
    folders: MissionFolders,
    runs: Sequence[tuple[str, CampaignSettings]],
    sweep: Sweep | None,
    case: str,
    engine: EngineSettings,
    evaluating: Callable[[MissionCode], AbstractContextManager[Evaluator]],
    progress: Callable[[RunResult, int, bool], None],
) -> Comparison:
    """Make the missing runs of a comparison; write and return the result of all.

    All runs are created before the first one simulates, so that a later edit changes none of them.
    """
    folder = ComparisonFolder.reserve(path)
    places = [folder.run(name, one.seed) for name, one in runs]
    settings = [one for _, one in runs]
    with only_writer(folder):
        source = _hash_of_ours()
        _require_same(dict(zip(places, settings, strict=True)), folders, source, engine.side)
        folder.runs.mkdir(exist_ok=True)
        for place, one in zip(places, settings, strict=True):
            if not place.database.is_file():
                with made(place.path, folders, one, case, engine):
                    pass
        with open_to_fly(places[0].path) as campaign:
            code = campaign.code
        results: list[RunResult] = []
        with evaluating(code) as evaluator:
            for place, (name, _) in zip(places, runs, strict=True):
                with CampaignStore.open(place.path) as store:
                    kept = store.kept(_RESULT, RunResult.from_text)
                results.append(kept or _flown(place, name, evaluator, source))
                progress(results[-1], len(results), kept is None)
        names = tuple(dict.fromkeys(name for name, _ in runs))
        comparison = replace(compare(names, results, sweep), folder=path)
        varied = {"seed", *(sweep.values if sweep else ("algorithm",))}
        shared = {key: value for key, value in settings[0].as_json().items() if key not in varied}
        about = {"mission": folders.name, "semantics": SEMANTICS, "settings": shared}
        folder.write(comparison, about | as_json(comparison))
    return comparison


def _require_same(
    runs: Mapping[CampaignFolder, CampaignSettings], folders: MissionFolders, source: str, side: str
) -> None:
    """Refuse recorded runs that were made with other settings, files, code or engine side."""
    for place, settings in runs.items():
        if not place.database.is_file():
            continue
        imported = imported_files(folders.generated, settings.own_modules)
        files = file_hashes(folders.models, folders.generated, imported)
        with CampaignStore.open(place.path) as store:
            store.require_flyable()
            made_by = store.kept(_SOURCE, str) if any(store.next_indexes()) else source
            recorded = _subject(store.settings, store.manifest.sha256, made_by)
            recorded["side"] = store.manifest.engine.side
        today = _subject(settings, files, source) | {"side": side}
        other = sorted(key for key in {*recorded, *today} if recorded.get(key) != today.get(key))
        if other:
            found, wanted = (
                ", ".join(f"{key} {str(subject.get(key))[:20]}" for key in other[:5])
                for subject in (recorded, today)
            )
            raise RecordError(
                f"{place.path}: found a run with other {', '.join(other)}: {found}; expected "
                f"{wanted}; compare in another folder with --out, or remove this folder"
            )


def _subject(
    settings: CampaignSettings, files: Mapping[str, str], source: str | None
) -> dict[str, Any]:
    """Return the inputs that decide a run; campaign files count by their settings only."""
    decisive = {name: found for name, found in files.items() if not name.endswith(".toml")}
    return {**settings.as_json(), **decisive, _SOURCE: source}


def _hash_of_ours() -> str:
    """Return the hash of those packages of mrsfi whose source decides the result of a search."""
    digest = hashlib.sha256()
    package = Path(mrsfi_runtime.__file__).parent
    for room in ("model", "kernel", "cosimulation", "record", "search", "causes"):
        for file in sorted((package / room).rglob("*.py")):
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def _flown(place: CampaignFolder, name: str, evaluator: Evaluator, source: str) -> RunResult:
    with only_writer(place), open_to_fly(place.path) as campaign:
        store = campaign.store
        if not any(store.next_indexes()):
            store.keep(_SOURCE, source)
        spent = store.kept(_SECONDS, float) or 0.0
        began = noted = monotonic()

        def note(_: object) -> None:
            nonlocal noted
            if monotonic() - noted > _NOTED:
                noted = monotonic()
                store.keep(_SECONDS, repr(spent + noted - began))

        search(campaign, evaluator, note)
        found = measure_run(store, campaign.mission, spent + monotonic() - began)
        result = replace(found, algorithm=name)
        store.keep(_RESULT, canonical(asdict(result)))
    return result


WENT, CAME, STAYED, UNKNOWN = "went", "came", "stayed", "cannot be flown"


@dataclass(frozen=True, slots=True)
class Change:
    """A weakness as the campaign ``before`` found it, as the campaign ``after`` did, or both.

    ``breaks`` is whether its variant breaks the goal in the mission of the other campaign (of the
    one after, if both found it). It is ``None``, with a reason, if it cannot be simulated there.
    """

    goal: str
    cause: str
    before: GoalWeakness | None
    after: GoalWeakness | None
    breaks: bool | None
    reason: str = ""

    @property
    def weakness(self) -> GoalWeakness:
        """The weakness of the first campaign that found it."""
        found = self.before or self.after
        assert found is not None
        return found

    @property
    def verdict(self) -> str:
        """Whether it went, came or stayed; one that still breaks stayed, even if not found again.

        It went if only a false alarm remains, and came if it was only a false alarm before.
        """
        if self.before and self.after:
            truly, now = _is_true(self.before), _is_true(self.after)
            return STAYED if truly == now or self.breaks else WENT if truly else CAME
        if self.breaks is None:
            return UNKNOWN
        return STAYED if self.breaks else WENT if self.before else CAME

    @property
    def remark(self) -> str:
        """A remark on the verdict."""
        if self.before and self.after:
            alarm = {WENT: "a false alarm remains", CAME: "was only a false alarm before"}
            usual = "by other variants" if self.breaks is False else ""
            return alarm.get(self.verdict, usual)
        if self.verdict == STAYED:
            found = "not found again, but its variant still has this effect"
            return found if self.before else "found only now, but its variant had the effect before"
        return self.reason

    def as_json(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "verdict": self.verdict,
            "goal": self.weakness.goal,
            "faults": list(self.weakness.faults),
            "cause": self.cause,
            "before": self.before and self.before.number,
            "after": self.after and self.after.number,
            "breaks_there": self.breaks,
            "remark": self.remark,
        }


def _is_true(weakness: GoalWeakness) -> bool:
    return weakness.shown.column.kind != MEASURES[0]


def changes(
    before: Path, after: Path, engine: Given, workers: Workers, tell: Tell = silent
) -> tuple[Change, ...]:
    """Return how the weaknesses of a mission changed between two campaigns, by new flights."""
    by_cause, models, names = [], [], []
    for path in (before, after):
        with open_campaign(path) as campaign:
            listed = harvested(campaign).goal_weaknesses
            by_cause.append({(each.goal, each.faults): each for each in listed})
            models.append((campaign.mission, campaign.pool))
            names.append(campaign.store.manifest.mission or campaign.mission.name)
    if names[0] != names[1]:
        what = f"{after}: found a campaign of mission '{names[1]}'"
        raise UsageError(f"{what}; expected one of '{names[0]}', as {before} is")
    results: list[Change] = []
    for path, flown, others, (mission, pool), is_before in (
        (after, by_cause[0], by_cause[1], models[0], True),
        (before, by_cause[1], by_cause[0], models[1], False),
    ):
        weaknesses = [each for key, each in flown.items() if is_before or key not in others]
        with flying_again(path, engine, workers, tell) as (campaign, evaluator, _):
            there = _broken(campaign, evaluator, weaknesses)
        for weakness in weaknesses:
            other = others.get((weakness.goal, weakness.faults))
            old_one, new_one = (weakness, other) if is_before else (None, weakness)
            cause = cause_in_words(mission, pool, weakness)
            name = mission.label_of(weakness.goal)
            results.append(Change(name, cause, old_one, new_one, *there[weakness.number]))
    order = (WENT, CAME, UNKNOWN, STAYED)
    return tuple(sorted(results, key=lambda each: order.index(each.verdict)))


def _broken(
    campaign: FlyableCampaign, evaluator: Evaluator, weaknesses: Sequence[GoalWeakness]
) -> Mapping[int, tuple[bool | None, str]]:
    seed, gate = campaign.store.settings.mission_seed, Gate(campaign.mission, campaign.pool)
    outcomes: dict[int, tuple[bool | None, str]] = {}
    flyable = {}
    for weakness in weaknesses:
        try:
            form = gate.admitted(weakness.shown.witness)
        except SpecificationError as error:
            outcomes[weakness.number] = None, str(error)
            continue
        if weakness.goal in campaign.mission.goal_ids:
            flyable[weakness.number, weakness.shown.column] = form
        else:
            outcomes[weakness.number] = None, f"the mission has no goal {weakness.goal}"
    breaking = Breaking(campaign.mission, evaluator.evaluate_many, [seed])
    for (number, column), broken in zip(flyable, breaking([*flyable.values()], seed), strict=True):
        outcomes[number] = column in broken, ""
    return outcomes


def sentence(weaknesses: Iterable[Change]) -> str:
    """Return in a sentence how many weaknesses went, came and stayed."""
    verdicts = [each.verdict for each in weaknesses]
    numbers = {name: verdicts.count(name) for name in (WENT, CAME, STAYED)}
    counts = ", ".join(f"{n or 'none'} {name}" for name, n in numbers.items())
    unknown = verdicts.count(UNKNOWN)
    rest = f"; {counted(unknown, 'weaknesses')} can no longer be flown" if unknown else ""
    return f"Weaknesses: {counts}{rest}"


def change_table(weaknesses: Iterable[Change]) -> Table:
    """Return a row for each weakness: verdict, faults, goal, cause and remark."""
    rows = [
        (each.verdict, " and ".join(each.weakness.faults), each.goal, each.cause, each.remark)
        for each in weaknesses
    ]
    columns = ("verdict", "faults", "goal", "cause", "remark")
    return Table("Weaknesses before and after", columns, rows, columns[:2], columns[2:])
