"""Which rules of the world generated code was made for, told without loading it."""

import json
from pathlib import Path

from mrsfi_runtime.errors import GenerationError
from mrsfi_runtime.model.semantics import SEMANTICS, UNNUMBERED, difference, flown_by

MANIFEST = "manifest.json"
"""File of a folder of generated code that says what it was generated for."""


def generated_semantics(directory: Path) -> int:
    """Return the version of the world's rules that a folder's code was generated for.

    A manifest that is missing or is none does not say: a ``GenerationError``.
    """
    path = directory / MANIFEST
    if not path.is_file():
        raise GenerationError(f"{path}: no such file; run `mrsfi generate` to make it")
    try:
        return int(json.loads(path.read_bytes()).get("semantics", UNNUMBERED))
    except (ValueError, TypeError, AttributeError) as error:
        raise GenerationError(
            f"{path}: is no manifest ({type(error).__name__}: {error}); restore it from version "
            "control, or delete it and run `mrsfi generate`"
        ) from error


def require_semantics(directory: Path) -> None:
    """Refuse code that was generated for other rules of the world than this runtime flies.

    The ``GenerationError`` names both versions, and what to do.
    """
    found = generated_semantics(directory)
    if found != SEMANTICS:
        remedy = "run `mrsfi generate`, then review the diff and your regions"
        raise GenerationError(
            f"{directory / MANIFEST}: {difference(found)}; "
            f"{remedy if found < SEMANTICS else f'use {flown_by(found)}'}"
        )
