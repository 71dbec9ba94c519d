"""Write generated files so that a crash at any moment loses nothing.

All texts are staged in a folder beside the target first. Then, in this order:

1. the manifest is replaced by one that remembers every file as it was and as it will be;
2. every changed file is replaced by its staged text, one ``os.replace`` each;
3. files that are no longer generated are removed;
4. the manifest is replaced by that of the new files alone, which ends the generation.

A crash leaves every single file either old or new, and hand-written code is in both. If it
comes between 1 and 4, a text that the manifest remembers in either way counts as generated: a
half-done generation is not mistaken for edits by hand.
"""

import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from m2t.manifest import MANIFEST, dumps, is_alike, loads
from m2t.protected_regions import (
    FileRecord,
    GeneratedFile,
    is_hand_written,
    merge,
    parse,
    record_of,
)
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError

_BOTH = "manifest of both"


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
    removed
        Files of earlier generations that are to go.
    manifest
        Text of the coming manifest.
    manifest_of_both
        Text of the manifest that stands while files are replaced.
    """

    target: Path
    existing: Mapping[str, str]
    contents: Mapping[str, str]
    removed: tuple[str, ...]
    manifest: str
    manifest_of_both: str

    @property
    def written(self) -> tuple[str, ...]:
        """Files that are missing or stand there with another text."""
        return tuple(
            name for name, text in self.contents.items() if self.existing.get(name) != text
        )

    @property
    def unchanged(self) -> tuple[str, ...]:
        """Files that stand there as they are to."""
        return tuple(
            name for name, text in self.contents.items() if self.existing.get(name) == text
        )

    @property
    def stale(self) -> tuple[str, ...]:
        """What does not follow from what the models mean, the manifest included."""
        is_recorded = is_alike(self.existing.get(MANIFEST), self.manifest)
        return self.written + self.removed + (() if is_recorded else (MANIFEST,))


def plan_files(
    target: Path,
    rendered: Mapping[str, str],
    sources: Mapping[str, str],
    *,
    force: bool = False,
    rewrite: Callable[[str, str], str] = lambda _, text: text,
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
    rewrite
        Edits the text of a standing file, by its name, before it is merged.

    Raises
    ------
    ProtectedRegionError
        If hand-written code would be lost.
    GenerationError
        If the folder cannot be read.
    """
    recorded = _read(target / MANIFEST)
    known = {} if recorded is None else loads(recorded, str(target / MANIFEST))
    texts = {name: _read(target / name) for name in (*rendered, *known)}
    existing = {name: text for name, text in texts.items() if text is not None}
    standing = {
        name: parse(rewrite(name, text), str(target / name)) for name, text in existing.items()
    }
    contents: dict[str, str] = {}
    coming: dict[str, tuple[FileRecord, ...]] = {}
    for name, text in rendered.items():
        generated = parse(text, f"{target / name} (as generated)")
        coming[name] = (record_of(generated),)
        old = standing.get(name)
        contents[name] = merge(generated, old, known.get(name, ()), force=force) if old else text
    removed = tuple(name for name in known if name in standing and name not in rendered)
    for name in removed:
        _require_no_code(standing[name], known[name])
    both = {name: known.get(name, ()) + coming.get(name, ()) for name in (*known, *coming)}
    existing |= {} if recorded is None else {MANIFEST: recorded}
    return GenerationPlan(
        target, existing, contents, removed, dumps(sources, coming), dumps(sources, both)
    )


def write(plan: GenerationPlan) -> None:
    """Carry out a plan, as the module describes; what does not change is not touched.

    A file that cannot be written raises a ``GenerationError``; the folder stays usable.
    """
    if plan.stale or plan.existing.get(MANIFEST) != plan.manifest:
        try:
            _replace(plan)
        except OSError as error:
            raise GenerationError(
                f"{plan.target}: cannot be written ({error}); "
                "no hand-written code is lost; mend the cause and generate again"
            ) from error


def _replace(plan: GenerationPlan) -> None:
    target = plan.target.resolve()
    staging = target.parent / f".{target.name}.staging"
    if staging.exists():
        shutil.rmtree(staging)
    target.mkdir(parents=True, exist_ok=True)
    staging.mkdir()
    try:
        for name in plan.written:
            _stage(staging / name, plan.contents[name])
        _stage(staging / _BOTH, plan.manifest_of_both)
        _stage(staging / MANIFEST, plan.manifest)
        (staging / _BOTH).replace(target / MANIFEST)
        for name in plan.written:
            (staging / name).replace(target / name)
        for name in plan.removed:
            (target / name).unlink()
        (staging / MANIFEST).replace(target / MANIFEST)
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _stage(path: Path, text: str) -> None:
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())


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


def _require_no_code(file: GeneratedFile, records: tuple[FileRecord, ...]) -> None:
    if is_hand_written(file, records):
        raise ProtectedRegionError(
            f"{file.name}: is no longer generated but holds hand-written code; "
            "move the code elsewhere and delete the file"
        )
