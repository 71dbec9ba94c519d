"""The manifest: hashes of what was generated from what, so that edits are noticed.

It stands beside the generated files as ``manifest.json``. No hash stands in the files
themselves, where it would change with every model and clutter every review.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from m2t.protected_regions import FileRecord
from mrsfi_runtime.errors import GenerationError

MANIFEST = "manifest.json"
PENDING = "manifest.pending.json"
"""The manifest of a generation under way; see ``m2t.emit``."""

SCHEMA = 1
GENERATOR = "1"
"""Version of visitors and templates together; raised when generated text changes."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """What one generation was made from and what it made.

    Attributes
    ----------
    generator
        Version of the generator.
    sources
        SHA-256 of every model and metamodel by file name.
    files
        What to remember of every generated file, by its path relative to the folder.
    """

    generator: str
    sources: Mapping[str, str]
    files: Mapping[str, FileRecord]


def dumps(manifest: Manifest) -> str:
    """Return a manifest as JSON with sorted keys and a newline at the end."""
    document = {
        "schema": SCHEMA,
        "generator": manifest.generator,
        "sources": dict(manifest.sources),
        "files": {
            path: {"skeleton": record.skeleton, "regions": dict(record.regions)}
            for path, record in manifest.files.items()
        },
    }
    return json.dumps(document, indent=2, sort_keys=True) + "\n"


def loads(text: str, name: str) -> Manifest:
    """Return the manifest that a text holds.

    Parameters
    ----------
    text
        JSON as ``dumps`` writes it.
    name
        Path for messages.

    Raises
    ------
    GenerationError
        If the text is no manifest, or one of a newer mrsfi.
    """
    try:
        document = json.loads(text)
        schema = int(document["schema"])
        if schema > SCHEMA:
            raise GenerationError(
                f"{name}: has schema {schema}, written by a newer mrsfi; this one knows {SCHEMA}; "
                "generate with the newer one"
            )
        return Manifest(
            generator=_text(document["generator"]),
            sources=_texts(document["sources"]),
            files={
                _file_name(path): FileRecord(_text(entry["skeleton"]), _texts(entry["regions"]))
                for path, entry in document["files"].items()
            },
        )
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise GenerationError(
            f"{name}: is no manifest ({type(error).__name__}: {error}); restore it from version "
            "control, or delete it: then everything in the generated files counts as edited"
        ) from error


def _texts(value: Any) -> dict[str, str]:
    return {_text(key): _text(entry) for key, entry in value.items()}


def _file_name(value: Any) -> str:
    name = _text(value)
    if name != PurePath(name).name:
        raise ValueError(f"found {name!r} where a file name was expected")
    return name


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"found {value!r} where a text was expected")
    return value
