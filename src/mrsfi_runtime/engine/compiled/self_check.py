"""Remembers beside compiled code what the reference engine showed of it."""

import os
import sys
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

from mrsfi_runtime.engine.source_hash import installed, source_hash, team_files
from mrsfi_runtime.mission import NOTHING_LOADED, MissionCode

FLIES = "flies"
"""Said of a mission that flew without faults on plain Python."""

SAME = "same"
"""Said of compiled code whose flights were, bit for bit, those of the reference engine."""


class SelfCheck:
    """Empty files beside the compiled code of a mission, named after all that such a word hangs on.

    Parameters
    ----------
    folder
        Where the code is cached.
    code, seed
        The mission.

    Notes
    -----
    These are the machine code; the generated files, mission, pool and seed; all modules of the team
    that are loaded; mrsfi, Python, the installed libraries and the machine. If any of them changes,
    or the file is lost, nothing is known; nor is it while a module may be another than its file.
    """

    def __init__(self, folder: Path, code: MissionCode, seed: int) -> None:
        self._folder = folder
        self._code = code
        self._seed = seed
        self._sources = self._source_digest()

    def is_known(self, word: str) -> bool:
        """Return whether something was remembered of this very code."""
        path = self._path(word)
        return path is not None and path.is_file()

    def remember(self, word: str) -> None:
        """Remember something, unless a file was edited or loaded since, or none can be written."""
        path = self._path(word)
        if path is not None and self._source_digest() == self._sources:
            with suppress(OSError):
                path.touch()

    def _path(self, word: str) -> Path | None:
        """Return the file; ``None`` if numba keeps machine code elsewhere, or none can be told."""
        machine_code = sorted(self._folder.glob("__pycache__/*.nbc"))
        digest = _digest(machine_code)
        if not machine_code or digest is None or self._sources is None:
            return None
        return self._folder / f"{word}_{self._sources}_{digest}"

    def _source_digest(self) -> str | None:
        """Return a digest of all but the machine code."""
        team = team_files()
        if any(path.stat().st_mtime > NOTHING_LOADED for path in team if path.exists()):
            return None  # edited perhaps after it was loaded
        generated = sorted(self._code.directory.glob("*.py"))
        values = (self._code.mission, self._code.pool, self._seed, len(generated))
        machine = (source_hash(), sys.version, installed(), tuple(os.uname()))
        return _digest([*generated, *team], repr((values, machine)))


def _digest(paths: list[Path], text: str = "") -> str | None:
    """Return a digest of files, by their names, and of a text; ``None`` if one cannot be read."""
    digest = sha256(text.encode())
    try:
        for path in paths:
            content = path.read_bytes()
            digest.update(f"\n{path.name} {len(content)}\n".encode() + content)
    except OSError:
        return None
    return digest.hexdigest()[:24]
