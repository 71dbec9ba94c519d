"""One writer at a time: the lock of a campaign folder, which ends with its process."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.folder import CampaignFolder


@contextmanager
def only_writer(folder: CampaignFolder) -> Iterator[None]:
    """Let nobody else write a campaign while the body runs.

    The lock is the operating system's, on a file that stays: however the process ends, the
    lock ends with it, and nothing has to be removed by hand. Child processes do not keep it.

    Raises
    ------
    RecordError
        If another process holds the lock, or the folder cannot be written.
    """
    descriptor = _opened(folder.lock)
    try:
        _seize(folder, descriptor)
        yield
    finally:
        os.close(descriptor)


def _opened(path: Path) -> int:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise RecordError(
            f"{path.parent}: cannot be opened or written: {error.strerror}; expected the folder "
            "of a campaign that can be; change its permissions, or continue a copy of it"
        ) from error


def _seize(folder: CampaignFolder, descriptor: int) -> None:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.ftruncate(descriptor, 0)
        os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
    except BlockingIOError as error:
        holder = os.pread(descriptor, 20, 0).decode("ascii", "replace").strip()
        raise RecordError(
            f"{folder.path}: found another process{f' ({holder})' if holder else ''} running this "
            "campaign; expected one at a time; wait until it is done, or end it and resume"
        ) from error
    except OSError as error:
        raise RecordError(
            f"{folder.lock}: cannot be locked: {error.strerror}; expected a file system with "
            "locks and some room; choose another place"
        ) from error
