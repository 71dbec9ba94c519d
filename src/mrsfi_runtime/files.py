"""Files that mrsfi writes: one file atomically, or several as one change.

A change survives a kill at any moment. The file ``.mrsfi-change`` in its folder is both lock and
journal. It exists only during a change, or after a command was killed. It has a line with the
process, a line with the files and their replacements, and, once all new files are on the disk
beside the old ones, the line ``"whole"``. The next command that holds the lock completes the
change; if that line is missing, it removes the new files.

Begin with ``whole_file`` and ``changing``. ``MARKER`` matches the lines around a protected region.
"""

import errno
import fcntl
import json
import os
import re
import stat
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep
from typing import IO, Any, TextIO

from mrsfi_runtime.errors import UsageError

OURS = ".mrsfi-"  # part of the names of all files that exist only during a change
JOURNAL = f"{OURS}change"
_WHOLE = "whole"
_PATIENCE = 30.0  # seconds for which a command waits for another one


@contextmanager
def written_file(path: Path) -> Iterator[TextIO]:
    """Open a file for the user; if it cannot be written, it is a ``UsageError``."""
    with writable(path), path.open("w", encoding="utf-8", newline="\n") as file:
        yield file


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for the user that appears only if the body succeeds.

    A file that cannot be written is a ``UsageError``.
    """
    is_device = path.exists() and not path.is_file()  # or a pipe
    with writable(path), path.open("wb") if is_device else _replacing(path) as file:
        yield file


def write_atomically(path: Path, content: bytes) -> None:
    """Replace a file atomically: after a crash it has either its old or its new content."""
    with _replacing(path) as file:
        file.write(content)


@contextmanager
def _replacing(path: Path) -> Iterator[IO[bytes]]:
    """Open a file that replaces another one at the end, through a symbolic link."""
    target = path.resolve()
    new = target.with_name(f".{os.getpid()}-{target.name[:200]}{OURS}new")
    try:
        with new.open("wb") as file:
            yield file
            _keep(file, target)
        new.replace(target)
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Yield a folder to fill, which gets its name only if the body succeeds.

    A folder that cannot be written is a ``UsageError``.
    """
    with changing(path.parent) as change, writable(path, "name another folder"):
        (new,) = change.begin({path: b""}).values()
        new.mkdir()
        yield new
        new.rename(path)


@contextmanager
def changing(folder: Path, *, waits: bool = True) -> Iterator["Change"]:
    """Lock the files of a folder, such as a mission's, against other processes.

    First, the change of a killed command is completed or undone, and reported on standard error. A
    folder that cannot be written, or that another process keeps locked, is a ``UsageError``.
    """
    with writable(folder, "nothing is changed"):
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(folder, _PATIENCE if waits else 0.0)
    change = Change(folder, descriptor)
    try:
        if done := change.settle():
            sys.stderr.write(f"mrsfi: {folder}: {done}\n")
        change.note(os.getpid())
        yield change
    finally:
        try:
            change.settle()
            (folder / JOURNAL).unlink(missing_ok=True)
        finally:
            os.close(descriptor)


def settle(*folders: Path) -> None:
    """Complete or undo the changes of a killed command in folders."""
    for folder in folders:
        journal = folder / JOURNAL
        with suppress(FileNotFoundError):
            if journal.is_file():
                is_begun = b"[" in journal.read_bytes()
                unless = () if is_begun else (UsageError,)  # another command is still writing
                with suppress(*unless), changing(folder, waits=is_begun):
                    pass


class Change:
    """Changes files as the only process that may; ``changing`` yields it."""

    def __init__(self, folder: Path, descriptor: int) -> None:
        self._folder = folder
        self._root = folder.resolve()
        self._journal = descriptor

    def replace(self, contents: Mapping[Path, bytes | None]) -> None:
        """Write new contents of files, or remove those with ``None``: all of them, or none.

        Symbolic links stay; their targets are replaced. A file that cannot be written is a
        ``UsageError``.
        """
        try:
            new = self.begin(contents)
            for path, staged in new.items():
                with writable(path, "nothing is changed"):
                    if path.is_dir():
                        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
                    staged.parent.mkdir(parents=True, exist_ok=True)
                    with staged.open("xb") as file:
                        file.write(contents[path] or b"")
                        _keep(file, path.resolve())
            for folder in {path.parent for path in new.values()}:
                keep_names(folder)
            self.note(_WHOLE)
        finally:
            self.settle()

    def begin(self, contents: Mapping[Path, bytes | None]) -> dict[Path, Path]:
        """Note the files to be replaced, and return the paths for the new files until then."""
        new, entries = {}, []
        for number, (path, content) in enumerate(contents.items()):
            target = path.resolve() if content is not None else path.parent.resolve() / path.name
            staged = target.with_name(f".{os.getpid()}-{number}{OURS}new")
            entry = [os.path.relpath(each, self._root) for each in (target, staged)]
            with writable(path, "nothing is changed"):
                entries.append((*entry, _time(target), content is None))
            if content is not None:
                new[path] = staged
        self.note(entries)
        return new

    def note(self, value: object) -> None:
        """Write a line into the journal, and wait until it is on the disk."""
        line = json.dumps(value).encode() + b"\n"
        with writable(self._folder, "nothing is changed"):
            while line:
                line = line[os.write(self._journal, line) :]
            os.fsync(self._journal)

    def settle(self) -> str:
        """Complete a change that is noted as whole, else undo it; return a report in words."""
        notes = _notes(self._journal)
        entries = next((note for note in notes if isinstance(note, list)), [])
        end, done = (_finish, "finished") if _WHOLE in notes else (_undo, "undid")
        with writable(
            self._folder, "a change is half done; repair that, and the next command completes it"
        ):
            found = [
                name
                for target, new, *how in entries
                for name in end(self._root / target, self._root / new, *how)
            ]
            for folder in {(self._root / each[0]).parent for each in entries if _WHOLE in notes}:
                keep_names(folder)
            os.ftruncate(self._journal, 0)
        told = f"{done} the changes of a command that was interrupted: {', '.join(found)}"
        return told if found else ""


def _notes(journal: int) -> list[Any]:
    """Return the complete lines of a journal."""
    *lines, _ = os.pread(journal, os.fstat(journal).st_size, 0).split(b"\n")
    with suppress(ValueError):
        return [json.loads(line) for line in lines]
    return []


def _finish(target: Path, new: Path, time: int | None, is_removed: bool) -> Iterator[str]:
    """Replace or remove a file, unless this is done; yield its name, and that of a kept edit."""
    if is_removed or new.exists():
        if _time(target) not in {None, time}:
            kept = target.replace(target.with_name(f"{target.name}.edited"))
            yield f"{kept.name} (edited since then)"
        if is_removed:
            target.unlink(missing_ok=True)
        else:
            new.replace(target)
        yield target.name


def _undo(target: Path, new: Path, *_: object) -> Iterator[str]:
    """Remove a new file, and its folder if that is empty then; yield its name."""
    if new.exists():
        yield target.name
        if new.is_dir():
            import shutil  # noqa: PLC0415 - slow

            shutil.rmtree(new)
        new.unlink(missing_ok=True)
    with suppress(OSError):
        new.parent.rmdir()


def _locked(folder: Path, patience: float) -> int:
    """Return the journal of a folder, locked; the lock ends with the process."""
    journal = folder / JOURNAL
    until = monotonic() + patience
    while True:
        with ExitStack() as opened:
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW
            descriptor = os.open(journal, flags, 0o666)
            opened.callback(os.close, descriptor)
            if os.fstat(descriptor).st_uid != os.geteuid():  # it could name any file
                raise PermissionError(errno.EPERM, f"{JOURNAL} is another user's")
            with suppress(BlockingIOError, FileNotFoundError):  # locked, or removed
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if os.path.samestat(os.fstat(descriptor), journal.stat()):
                    opened.pop_all()
                    return descriptor
            if monotonic() > until:
                holder = next((f" ({note})" for note in _notes(descriptor)), "")
                raise UsageError(
                    f"{folder}: another process{holder} is changing it; expected one at a time; "
                    "wait until it is done, or end it"
                )
        sleep(0.02)


def _keep(file: IO[bytes], target: Path) -> None:
    """Wait until the content is on the disk; give it the rights of the file that it replaces."""
    file.flush()
    os.fsync(file.fileno())
    with suppress(FileNotFoundError):
        os.fchmod(file.fileno(), stat.S_IMODE(target.stat().st_mode))


def keep_names(folder: Path) -> None:
    """Wait until the names of a folder's files are on the disk, for the case of a power cut."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _time(path: Path) -> int | None:
    with suppress(FileNotFoundError):
        return path.stat().st_mtime_ns
    return None


@contextmanager
def writable(path: Path, advice: str = "name another file") -> Iterator[None]:
    """Turn an error of the operating system into a ``UsageError`` about this file."""
    try:
        yield
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}; {advice}") from error


@contextmanager
def temporary_files_writable() -> Iterator[None]:
    """Turn an error of the operating system into a ``UsageError`` about temporary files."""
    try:
        yield
    except OSError as error:
        import tempfile  # noqa: PLC0415 - slow

        raise UsageError(
            f"{tempfile.tempdir or 'TMPDIR'}: mrsfi cannot write temporary files there: "
            f"{error.strerror}; set TMPDIR to a folder with more room"
        ) from error


MARKER = re.compile(
    r"^[ \t]*# protected region (?P<id>\S+) (?:(?P<state>on|off) begin|end)[ \t]*(?:\n|\Z)",
    re.MULTILINE,
)
"""A marker line with its line end; the end of a region has no ``state``."""


def not_a_manifest(place: object, error: Exception) -> str:
    """Return the start of a message about a broken manifest of generated code."""
    broken = f"{place}: is not a manifest ({type(error).__name__}: {error})"
    return f"{broken}; restore it from version control, or delete it"


def lines_in_regions(text: str) -> Mapping[int, str]:
    """Return the regions of lines, by line number."""
    found = {}
    region = ""
    for number, line in enumerate(text.split("\n"), start=1):
        marker = MARKER.fullmatch(line)
        if marker is not None:
            region = marker["id"] if marker["state"] else ""
        elif region:
            found[number] = region
    return found
