"""The manifest: hashes of what was generated from what, so that edits are noticed.

It stands beside the generated files as ``manifest.json``. No hash stands in the files
themselves, where it would change with every model and clutter every review. It also says which
semantics the code was generated for, and so does every copy of it.
"""

import json
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

from m2t.protected_regions import FileRecord
from mrsfi_runtime.errors import GenerationError
from mrsfi_runtime.model.semantics import SEMANTICS

MANIFEST = "manifest.json"

SCHEMA = 1
GENERATOR = "1"
"""Version of visitors and templates together; raised when generated text changes."""


def dumps(sources: Mapping[str, str], files: Mapping[str, FileRecord]) -> str:
    """Return a manifest as JSON: the SHA-256 of what was read, by name, and what was generated."""
    document = {
        "schema": SCHEMA,
        "generator": GENERATOR,
        "semantics": SEMANTICS,
        "sources": dict(sources),
        "files": {name: _entry(record) for name, record in files.items()},
    }
    return json.dumps(document, indent=2, sort_keys=True) + "\n"


def loads(text: str, name: str) -> dict[str, tuple[FileRecord, ...]]:
    """Return what a manifest remembers of files, by name: what is as any record was generated.

    Several stand there where an earlier mrsfi was killed while it generated.

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
        return {_file_name(path): _records(entry) for path, entry in document["files"].items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise GenerationError(
            f"{name}: is no manifest ({type(error).__name__}: {error}); restore it from version "
            "control, or delete it: then everything in the generated files counts as edited"
        ) from error


def is_alike(one: str | None, other: str) -> bool:
    """Return whether manifests differ at most in how models were spelt that mean the same."""
    return one is not None and _but_sources(one) == _but_sources(other)


def _but_sources(text: str) -> dict[str, Any]:
    return {**json.loads(text), "sources": None}


def _entry(record: FileRecord) -> dict[str, Any]:
    return {"skeleton": record.skeleton, "regions": dict(record.regions)}


def _records(entry: Any) -> tuple[FileRecord, ...]:
    return tuple(
        FileRecord(str(each["skeleton"]), dict(each["regions"].items()))
        for each in (entry if isinstance(entry, list) else [entry])
    )


def _file_name(name: str) -> str:
    if name != PurePath(name).name:
        raise ValueError(f"found {name!r} where a file name was expected")
    return name
