"""Files that somebody asked for."""

import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import IO, TextIO

from mrsfi_runtime.errors import UsageError


@contextmanager
def written_file(path: Path) -> Iterator[TextIO]:
    """Open a file that the user asked for.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    with _telling(path), path.open("w", encoding="utf-8", newline="\n") as file:
        yield file


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file that the user asked for, which is there when the body ends well, or not at all.

    Raises
    ------
    UsageError
        If it cannot be written.
    """
    if path.exists() and not path.is_file():  # a device or a pipe
        with _telling(path), path.open("wb") as file:
            yield file
        return
    new = path.with_name(f".{path.name}.new")
    try:
        with _telling(path):
            with new.open("wb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            if path.exists():
                new.chmod(stat.S_IMODE(path.stat().st_mode))
            new.replace(path)
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Replace files by new contents: all of them, or none if one cannot be written.

    Raises
    ------
    UsageError
        If one cannot be.
    """
    with ExitStack() as files:
        for path, content in contents.items():
            files.enter_context(whole_file(path)).write(content)


@contextmanager
def _telling(path: Path) -> Iterator[None]:
    """Say of a file that it cannot be written."""
    try:
        yield
    except OSError as error:
        raise UsageError(
            f"{path}: cannot be written: {error.strerror}; name another file"
        ) from error
