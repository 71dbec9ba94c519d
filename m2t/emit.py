"""Merge generated files with what stands in their folder: what is to be written, what is to go.

The manifest, ``manifest.json``, stands beside the generated files: hashes of what was generated
from what, so that edits are noticed. No hash stands in the files themselves, where it would change
with every model and clutter every review. It also says which semantics the code was generated for,
and so does every copy of it.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path, PurePath
from typing import Any

from m2t.protected_regions import FileRecord, is_hand_written, merge, parse, record_of
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError
from mrsfi_runtime.model.fault_types import SEMANTICS

MANIFEST = "manifest.json"
SCHEMA = 1
GENERATOR = "1"
"""Version of visitors and templates together; raised when generated text changes."""


@dataclass(frozen=True, slots=True)
class GenerationPlan:
    """What a generation would do: texts that stand in the folder, and are to stand there, by name.

    Standing texts are only those of files that are or were generated; coming ones are merged with
    hand-written code. Files of earlier generations are to go.
    """

    target: Path
    existing: Mapping[str, str]
    contents: Mapping[str, str]
    removed: tuple[str, ...]
    manifest: str

    @property
    def written(self) -> tuple[str, ...]:
        """Files that are missing or stand there with another text."""
        return tuple(
            name for name, text in self.contents.items() if self.existing.get(name) != text
        )

    @property
    def unchanged(self) -> tuple[str, ...]:
        """Files that stand there as they are to."""
        return tuple(name for name in self.contents if name not in self.written)

    @property
    def stale(self) -> tuple[str, ...]:
        """What does not follow from what the models mean, the manifest included."""
        recorded, coming = self.existing.get(MANIFEST), self.manifest
        is_recorded = recorded is not None and _but_sources(recorded) == _but_sources(coming)
        return self.written + self.removed + (() if is_recorded else (MANIFEST,))

    @property
    def changes(self) -> dict[Path, bytes | None]:
        """New content by path of all that changes; ``None`` for what is to go."""
        texts = {**self.contents, MANIFEST: self.manifest}
        new = {name: text for name, text in texts.items() if self.existing.get(name) != text}
        contents = {self.target / name: text.encode() for name, text in new.items()}
        return {**contents, **{self.target / name: None for name in self.removed}}


def plan_files(
    target: Path,
    rendered: Mapping[str, str],
    sources: Mapping[str, str],
    *,
    force: bool = False,
    rewrite: Callable[[str, str], str] = lambda _, text: text,
) -> GenerationPlan:
    """Merge rendered files, by name, with those that stand in a folder; write nothing.

    Sources are the SHA-256 of every model and metamodel by file name. Edits outside protected
    regions are refused unless forced, hand-written code that would be lost is in any case. A text
    that stands there may be rewritten, by its name, before it is merged.
    """
    recorded = _read(target / MANIFEST)
    known = {} if recorded is None else loads(recorded, str(target / MANIFEST))
    texts = {name: _read(target / name) for name in (*rendered, *known)}
    existing = {name: text for name, text in texts.items() if text is not None}
    standing = {
        name: parse(rewrite(name, text), str(target / name)) for name, text in existing.items()
    }
    contents: dict[str, str] = {}
    coming: dict[str, FileRecord] = {}
    for name, text in rendered.items():
        generated = parse(text, f"{target / name} (as generated)")
        coming[name] = record_of(generated)
        old = standing.get(name)
        contents[name] = merge(generated, old, known.get(name), force=force) if old else text
    removed = tuple(name for name in known if name in standing and name not in rendered)
    for name in removed:
        if is_hand_written(standing[name], known[name]):
            raise ProtectedRegionError(
                f"{target / name}: is no longer generated but holds hand-written code; "
                "move the code elsewhere and delete the file"
            )
    existing |= {} if recorded is None else {MANIFEST: recorded}
    return GenerationPlan(target, existing, contents, removed, dumps(sources, coming))


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


def dumps(sources: Mapping[str, str], files: Mapping[str, FileRecord]) -> str:
    """Return a manifest as JSON: the SHA-256 of what was read, by name, and what was generated."""
    document = {
        "schema": SCHEMA,
        "generator": GENERATOR,
        "semantics": SEMANTICS,
        "sources": dict(sources),
        "files": {name: asdict(record) for name, record in files.items()},
    }
    return json.dumps(document, indent=2, sort_keys=True) + "\n"


def loads(text: str, name: str) -> dict[str, FileRecord]:
    """Return what a manifest remembers of files, by name.

    What is no manifest, or one of a newer mrsfi, raises a ``GenerationError`` about ``name``.
    """
    try:
        document = json.loads(text)
        schema = int(document["schema"])
        if schema > SCHEMA:
            raise GenerationError(
                f"{name}: has schema {schema}, written by a newer mrsfi; this one knows {SCHEMA}; "
                "generate with the newer one"
            )
        return {_file_name(path): _record(entry) for path, entry in document["files"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise GenerationError(
            f"{name}: is no manifest ({type(error).__name__}: {error}); restore it from version "
            "control, or delete it: then everything in the generated files counts as edited"
        ) from error


def _but_sources(text: str) -> dict[str, Any]:
    """Return a manifest without how models were spelt that may mean the same."""
    return {**json.loads(text), "sources": None}


def _record(entry: Any) -> FileRecord:
    return FileRecord(str(entry["skeleton"]), dict(entry["regions"].items()))


def _file_name(name: str) -> str:
    if name != PurePath(name).name:
        raise ValueError(f"found {name!r} where a file name was expected")
    return name
