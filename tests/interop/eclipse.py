"""Real Eclipse EMF and Epsilon for tests: one Java program, built once, one start per call."""

import fcntl
import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

from tests.support.missing import skip
from tests.support.tree import ROOT

Note: TypeAlias = Callable[..., None]
"""Takes figures for the end of the run: the name of a part, then counts such as ``files=6``."""

METAMODELS = tuple(str(ROOT / "metamodels" / name) for name in ("mission.ecore", "faults.ecore"))

NO_PROJECTS: Mapping[str, Path] = MappingProxyType({})

_PROJECT = ROOT / "tests" / "interop" / "java"
_TARGET = _PROJECT / "target"
_BUILT = _TARGET / ".built"
_MAIN = "org.mrsfi.interop.Main"
_TIMEOUT_S = 900
_FLAGS: Mapping[str, Sequence[str]] = MappingProxyType({"evl": ("-XX:+UseSerialGC",)})
"""By command: constraints run long enough for the second compiler to halve their time."""


def harness(command: str, request: dict[str, Any]) -> dict[str, Any]:
    """Have Eclipse carry out a command.

    Parameters
    ----------
    command
        ``resave`` loads, validates and saves every file of ``models`` into folder ``out``, with
        the folders in ``projects`` open by their names;
        ``evl`` checks every list of files in ``models`` by ``program``, and fixes what it
        offers to fix, in memory; ``eol`` and ``egl`` run ``program`` over the files of
        ``models`` together, ``egl`` into ``target``; ``configured`` runs ``program``, EOL or EVL,
        as a run configuration of Eclipse does, each file a model by itself that is stored.
    request
        What the command needs; paths are texts; ``metamodels`` may be left out.

    Returns
    -------
    dict
        ``models`` for ``resave`` and ``evl``, in the order of the request; ``printed`` for
        ``eol``; ``written`` for ``egl``; ``printed``, ``warned`` and, of EVL, ``unsatisfied`` for
        ``configured``.
    """
    require_harness()
    path = os.pathsep.join((str(_TARGET / "classes"), str(_TARGET / "dependency" / "*")))
    java = [
        "java",
        *_FLAGS.get(command, ("-XX:TieredStopAtLevel=1",)),
        "-Xss8m",
        "-Dfile.encoding=UTF-8",
        "-cp",
        path,
        _MAIN,
        command,
    ]
    finished = subprocess.run(
        java,
        input=json.dumps({"metamodels": METAMODELS, **request}),
        capture_output=True,
        encoding="utf-8",
        timeout=_TIMEOUT_S,
        check=False,
    )
    assert finished.returncode == 0, f"the harness failed at {command}:\n{finished.stderr}"
    answer: dict[str, Any] = json.loads(finished.stdout)
    return answer


def require_harness() -> None:
    """Skip the test if the program cannot run here; with MRSFI_CI set, fail it."""
    reason = missing()
    if reason:
        skip(reason)


@cache
def missing() -> str:
    """Build the program if its sources are newer; return what is missing, or an empty text."""
    if shutil.which("java") is None:
        return "Java is missing; install Java 17 or newer"
    with (_PROJECT / "pom.xml").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several workers ask at once
        return _build()


def _build() -> str:
    if _is_fresh():
        return ""
    if shutil.which("mvn") is None:
        return "Maven is missing and the Java program is not built; install Maven 3.8 or newer"
    command = ["mvn", "-q", "-B", "clean", "package"]
    built = subprocess.run(command, cwd=_PROJECT, capture_output=True, text=True, check=False)
    if built.returncode:
        return f"the Java program does not build:\n{built.stdout}"
    _BUILT.touch()
    return ""


def _is_fresh() -> bool:
    if not _BUILT.exists():
        return False
    sources = (_PROJECT / "pom.xml", *_PROJECT.glob("src/**/*.java"))
    return max(source.stat().st_mtime for source in sources) <= _BUILT.stat().st_mtime


@dataclass(frozen=True, slots=True)
class Saved:
    """What Eclipse made of a file: what it has against it, and the bytes that it saves."""

    path: Path
    problems: tuple[str, ...]
    saved: Path
    original: bytes
    content: bytes

    @property
    def is_equal(self) -> bool:
        """Whether Eclipse saves the bytes that it loaded."""
        return self.content == self.original

    @property
    def difference(self) -> str:
        """The first line that differs, as it was and as Eclipse saves it."""
        return difference(self.path, self.original, self.content)


def difference(path: Path, old: bytes, new: bytes) -> str:
    """Return the first line that differs between two contents of a file; empty if none does."""
    pairs = enumerate(zip_longest(old.split(b"\n"), new.split(b"\n")), 1)
    return next((f"{path}:{n}: {a!r} became {b!r}" for n, (a, b) in pairs if a != b), "")


def resave(
    paths: Sequence[Path],
    out: Path,
    metamodels: Sequence[str] = METAMODELS,
    projects: Mapping[str, Path] = NO_PROJECTS,
) -> list[Saved]:
    """Return what Eclipse makes of files, each loaded and saved by itself.

    Files below the folder of a project are loaded as those of a workspace that has it.
    """
    files = [str(path) for path in paths]
    folders = {name: str(folder) for name, folder in projects.items()}
    request = {"metamodels": metamodels, "models": files, "out": str(out), "projects": folders}
    answer = harness("resave", request)
    return [_saved(path, found) for path, found in zip(paths, answer["models"], strict=True)]


def _saved(path: Path, found: dict[str, Any]) -> Saved:
    """Return one answer of the harness; a file that cannot be loaded is not saved at all."""
    saved = Path(found["saved"] or os.devnull)
    return Saved(path, tuple(found["errors"]), saved, path.read_bytes(), saved.read_bytes())


def require_same(part: str, emf: Sequence[Saved], ours: Iterable[bytes], note: Note) -> None:
    """Note the figures, then require that we save what Eclipse saves, without problems."""
    different = [
        difference(file.path, file.content, content)
        for file, content in zip(emf, ours, strict=True)
        if content != file.content
    ]
    note(
        part,
        files_checked=len(emf),
        with_equal_bytes=len(emf) - len(different),
        differences=len(different),
        complaints_of_EMF=sum(len(file.problems) for file in emf),
    )
    assert [found for file in emf for found in file.problems] == []
    assert different[:9] == []
