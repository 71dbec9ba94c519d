"""The runs of a comparison: every algorithm with every seed, those that are finished not again."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import Any

import mrsfi_runtime
from mrsfi_runtime.causes.cover import ALGORITHMS
from mrsfi_runtime.engine.region_sources import imported_files
from mrsfi_runtime.errors import GenerationError, RecordError
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.imported_copies import IMPORTED
from mrsfi_runtime.model.semantics import SEMANTICS, difference, flown_by
from mrsfi_runtime.record.folder import hashes, only_writer
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search.resumable_record import EvaluateMany
from mrsfi_runtime.search.run import run_campaign
from mrsfi_runtime.semantics_of_code import generated_semantics
from mrsfi_runtime.study.folder import ComparisonFolder
from mrsfi_runtime.study.run_results import RunResult, measure_run

_VARIED = ("algorithm", "seed")
_DECISIVE = ("model", "kernel", "cosimulation", "record", "search", "causes")
"""Rooms of mrsfi whose source decides what a search finds."""


@contextmanager
def only_comparison(path: Path, models: Path, generated: Path) -> Iterator[ComparisonFolder]:
    """Be the writer of a comparison while the body runs, and make its folder if it is new.

    The folder keeps a copy of the models and of the generated code that its runs fly. One that is
    another mission's, holds something else or has another writer is a ``RecordError``.
    """
    folder = ComparisonFolder(path)
    if not folder.runs.is_dir():
        ComparisonFolder.reserve(path)
    imported = imported_files(generated)
    with only_writer(folder):
        if not folder.runs.is_dir():
            folder.fill(models, generated, imported)
            folder.runs.mkdir()
        _require_flyable(folder)
        _require_same_files(models, folder.model)
        _require_same_files(generated, folder.generated)
        _require_same_imports(imported, folder.generated / IMPORTED)
        folder.tidy()
        yield folder


def _require_flyable(folder: ComparisonFolder) -> None:
    """Refuse a folder whose runs flew under other rules of the world; its copy of the code says."""
    try:
        found = generated_semantics(folder.generated)
    except GenerationError:
        return  # a copy that is not whole is refused as one that differs
    if found != SEMANTICS:
        raise RecordError(
            f"{folder.path}: {difference(found)}; go on with {flown_by(found)}, compare in another "
            "folder with --out, or remove this one"
        )


def _require_same_files(source: Path, copy: Path) -> None:
    """Refuse a copy that differs from its source, but for campaign files: runs tell of these."""
    expected, found = hashes(source), hashes(copy)
    for name in sorted({*expected, *found}):
        if expected.get(name) != found.get(name) and not name.endswith(".toml"):
            raise RecordError(_differs(copy / name, source / name))


def _require_same_imports(imported: Mapping[str, Path], copies: Path) -> None:
    """Refuse other files than the code imported then, of which an earlier mrsfi kept no copies."""
    for name, path in imported.items() if copies.is_dir() else ():
        copy = copies / name
        if not copy.is_file() or copy.read_bytes() != path.read_bytes():
            raise RecordError(_differs(copy, path))


def _differs(copy: Path, source: Path) -> str:
    return (
        f"{copy}: the comparison's own copy differs from {source}; expected the mission that its "
        "runs flew; compare in another folder with --out, or remove this one"
    )


def _hash(files: Sequence[Path]) -> str:
    digest = hashlib.sha256()
    for file in files:
        content = file.read_bytes()
        digest.update(f"{file.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()


def common_settings(settings: CampaignSettings) -> dict[str, Any]:
    """Return the settings that all runs of a comparison share."""
    return {key: value for key, value in settings.as_json().items() if key not in _VARIED}


def _subject(settings: CampaignSettings) -> dict[str, Any]:
    """Return what decides the runs of an algorithm, beside mission and seed.

    Beside the settings that is the source of what searches and flies, a user's own modules
    included, so that no result of an earlier version stands beside one of a later.
    """
    package = Path(mrsfi_runtime.__file__).parent
    sources = [file for room in _DECISIVE for file in sorted((package / room).rglob("*.py"))]
    return {
        **common_settings(settings),
        "mrsfi_sha256": _hash(sources),
        "own_sha256": {
            name: _hash([*imported_files(Path(), [name]).values()]) for name in settings.own_modules
        },
    }


def runs_of(
    folder: ComparisonFolder,
    settings: Mapping[str, CampaignSettings],
    n_seeds: int,
    code: MissionCode,
    evaluators: Sequence[EvaluateMany],
) -> Iterator[tuple[RunResult, bool]]:
    """Yield the result of every algorithm with every seed, and whether it was made just now.

    Seeds are 1 to ``n_seeds``; all algorithms have their turn with a seed before the next. There is
    an evaluator for each of the mission seeds over which fitness is averaged.
    """
    subjects = {name: _subject(one) for name, one in settings.items()}
    for seed in range(1, n_seeds + 1):
        for name, one in settings.items():
            run = folder.kept(name, seed, subjects[name])
            is_new = run is None
            if run is None:
                run = _flown(folder, replace(one, seed=seed), code, evaluators)
                folder.keep(run, subjects[name])
            yield run, is_new


def _flown(
    folder: ComparisonFolder,
    settings: CampaignSettings,
    code: MissionCode,
    evaluators: Sequence[EvaluateMany],
) -> RunResult:
    """Run a search, recorded as any campaign is, in a folder that goes with its end."""
    with folder.scratch() as place, CampaignStore.create(place, settings, Manifest()) as store:
        began = monotonic()
        first, *replicas = evaluators
        run_campaign(
            settings,
            code.mission,
            code.pool,
            first,
            store,
            replicas=replicas,
            algorithms=ALGORITHMS,
        )
        seconds = monotonic() - began
        return measure_run(
            settings,
            code.mission,
            store.evaluations(),
            n_failures=store.n_failures,
            seconds=seconds,
            digest=store.digest(),
        )
