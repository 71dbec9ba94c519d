"""Write generated files so that a crash at any moment loses nothing.

All texts are staged in a folder beside the target first. Then, in this order:

1. the coming manifest is moved into the target under the name of ``PENDING``;
2. every changed file is replaced by its staged text, one ``os.replace`` each;
3. files that are no longer generated are removed;
4. ``PENDING`` is renamed to ``MANIFEST``, which ends the generation.

A crash leaves every single file either old or new, and hand-written code is in both. If it
comes between 1 and 4, both manifests stand in the target, and a text that either of them
remembers counts as generated: a half-done generation is not mistaken for edits by hand. The
next generation writes down which of the two each file is (``_settled``) before it begins.
"""

import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from m2t.manifest import GENERATOR, MANIFEST, PENDING, Manifest, dumps, loads
from m2t.protected_regions import (
    FileRecord,
    GeneratedFile,
    is_hand_written,
    merge,
    parse,
    record_of,
    text_hash,
)
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError


@dataclass(frozen=True, slots=True)
class GenerationPlan:
    """What a generation would do.

    Attributes
    ----------
    target
        Folder of the generated files.
    existing
        Texts that stand in the folder, by file name; only files that are or were generated.
    contents
        Texts that are to stand there, merged with hand-written code.
    gone
        Files of earlier generations that are to be removed.
    manifest
        Text of the coming manifest.
    settled
        Text of the manifest that takes stock of a generation that a crash ended, if one did.
    """

    target: Path
    existing: Mapping[str, str]
    contents: Mapping[str, str]
    gone: tuple[str, ...]
    manifest: str
    settled: str | None

    @property
    def changed(self) -> tuple[str, ...]:
        """Files that are missing or stand there with another text."""
        return tuple(
            name for name, text in self.contents.items() if self.existing.get(name) != text
        )

    @property
    def stale(self) -> tuple[str, ...]:
        """Everything that the generation would write or remove, the manifest included."""
        is_recorded = self.settled is None and self.existing.get(MANIFEST) == self.manifest
        return self.changed + self.gone + (() if is_recorded else (MANIFEST,))


@dataclass(frozen=True, slots=True)
class GenerationResult:
    """Names of the files that a generation wrote, left as they were, and removed."""

    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    removed: tuple[str, ...]


def plan_files(
    target: Path, rendered: Mapping[str, str], sources: Mapping[str, str], *, force: bool = False
) -> GenerationPlan:
    """Merge rendered files with those that stand in a folder; write nothing.

    Parameters
    ----------
    target
        Folder of the generated files; need not exist.
    rendered
        Text of every file by name, as its template renders it.
    sources
        SHA-256 of every model and metamodel by file name.
    force
        Overwrite edits outside protected regions.

    Raises
    ------
    ProtectedRegionError
        If hand-written code would be lost.
    GenerationError
        If the folder cannot be read.
    """
    manifests = _manifests(target)
    remembered = {name: None for manifest in manifests for name in manifest.files}
    standing = _standing(target, [*rendered, *(name for name in remembered)])
    records = {
        name: tuple(manifest.files[name] for manifest in manifests if name in manifest.files)
        for name in standing
    }
    contents: dict[str, str] = {}
    files: dict[str, FileRecord] = {}
    for name, text in rendered.items():
        generated = parse(text, f"{target / name} (as generated)")
        files[name] = record_of(generated)
        old = standing.get(name)
        contents[name] = merge(generated, old, records[name], force=force) if old else text
    gone = tuple(name for name in remembered if name in standing and name not in rendered)
    for name in gone:
        _require_no_code(standing[name], records[name])
    existing = {name: file.text for name, file in standing.items()}
    recorded = _read(target / MANIFEST)
    if recorded is not None:
        existing[MANIFEST] = recorded
    is_unfinished = (target / PENDING).exists()
    settled = {
        name: _settled(standing[name], records[name]) for name in remembered & standing.keys()
    }
    return GenerationPlan(
        target,
        existing,
        contents,
        gone,
        dumps(Manifest(GENERATOR, sources, files)),
        dumps(Manifest(GENERATOR, sources, settled)) if is_unfinished else None,
    )


def write(plan: GenerationPlan) -> GenerationResult:
    """Carry out a plan, as the module describes; what does not change is not touched.

    Raises
    ------
    GenerationError
        If a file cannot be written; what stands in the folder stays usable.
    """
    changed = plan.changed
    if plan.stale:
        try:
            _replace(plan, changed)
        except OSError as error:
            raise GenerationError(
                f"{plan.target}: cannot be written ({error}); "
                "no hand-written code is lost; mend the cause and generate again"
            ) from error
    unchanged = tuple(name for name in plan.contents if name not in changed)
    return GenerationResult(changed, unchanged, plan.gone)


def _replace(plan: GenerationPlan, changed: tuple[str, ...]) -> None:
    target = plan.target.resolve()
    staging = target.parent / f".{target.name}.staging"
    if staging.exists():
        shutil.rmtree(staging)
    target.mkdir(parents=True, exist_ok=True)
    staging.mkdir()
    try:
        for name in changed:
            _stage(staging / name, plan.contents[name])
        _stage(staging / PENDING, plan.manifest)
        if plan.settled is not None:
            _stage(staging / MANIFEST, plan.settled)
            (staging / MANIFEST).replace(target / MANIFEST)
        (staging / PENDING).replace(target / PENDING)
        for name in changed:
            (staging / name).replace(target / name)
        for name in plan.gone:
            (target / name).unlink()
        (target / PENDING).replace(target / MANIFEST)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _stage(path: Path, text: str) -> None:
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


def _manifests(target: Path) -> list[Manifest]:
    """Return the manifest and that of an unfinished generation, as far as they exist."""
    found = []
    for name in (MANIFEST, PENDING):
        text = _read(target / name)
        if text is not None:
            found.append(loads(text, str(target / name)))
    return found


def _standing(target: Path, names: list[str]) -> dict[str, GeneratedFile]:
    standing = {}
    for name in names:
        text = _read(target / name)
        if text is not None:
            standing[name] = parse(text, str(target / name))
    return standing


def _read(path: Path) -> str | None:
    """Return the text of a file with plain line ends, or ``None`` if it does not exist."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise GenerationError(
            f"{path}: cannot be read as text in UTF-8 ({error}); mend or remove it"
        ) from error
    return text.replace("\r\n", "\n")


def _settled(file: GeneratedFile, records: tuple[FileRecord, ...]) -> FileRecord:
    """Return the record of an existing file, taking from each record what is true of it."""
    skeleton = text_hash(file.skeleton)
    regions = dict(records[0].regions)
    for region in file.regions.values():
        body = text_hash(region.body)
        if any(record.regions.get(region.id) == body for record in records):
            regions[region.id] = body
    is_known = any(record.skeleton == skeleton for record in records)
    return FileRecord(skeleton if is_known else records[0].skeleton, regions)


def _require_no_code(file: GeneratedFile, records: tuple[FileRecord, ...]) -> None:
    if is_hand_written(file, records):
        raise ProtectedRegionError(
            f"{file.name}: is no longer generated but holds hand-written code; "
            "move the code elsewhere and delete the file"
        )
