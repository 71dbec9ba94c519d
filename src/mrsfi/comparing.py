"""Compare setups of a search, over several seeds.

``compared`` makes a run of each setup with each seed, all on one mission with the same number of
evaluations. Each run is a campaign, so a finished run is not repeated. A run that was made with
other models, code or settings is refused.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

import mrsfi_runtime
from mrsfi.campaign_folders import open_to_fly
from mrsfi.engines import now_and_then, project
from mrsfi.evolving import made, require_searchable, search
from mrsfi.folders import MissionFolders
from mrsfi_runtime.engine.flights import Evaluator
from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.record.database import CampaignFolder, canonical, file_hashes, only_writer
from mrsfi_runtime.record.engine_settings import EngineSettings
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
        began, keep = monotonic() - spent, now_and_then(partial(store.keep, _SECONDS))
        search(campaign, evaluator, lambda _: keep(lambda: repr(monotonic() - began)))
        found = measure_run(store, campaign.mission, monotonic() - began)
        result = replace(found, algorithm=name)
        store.keep(_RESULT, canonical(asdict(result)))
    return result
