"""The folder of a campaign: every file and subfolder it may hold, and one writer at a time."""

import fcntl
import hashlib
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import MappingProxyType
from typing import Self

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.files import OURS, keep_names, write_atomically
from mrsfi_runtime.imported_copies import IMPORTED, copied_files


class CampaignFolder:
    """The folder ``runs/<name>`` of one campaign.

    ``model`` and ``generated`` are copies of what the campaign runs on, so that a replay does
    not depend on what was edited since.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.model = path / "model"  # copy of the mission folder
        self.generated = path / "generated"  # copy of the code; in a subfolder what it imports
        self.database = path / "campaign.sqlite"  # every evaluation and generation
        self.lock = path / "campaign.lock"  # by the process that runs the campaign
        self.critical = path / "critical"  # the most critical specifications as XMI
        self.weaknesses = path / "weaknesses"  # the least that breaks each goal as XMI
        self.causes = path / "causes"  # cause sets of explained specifications as XMI
        self.figures = path / "figures"
        self.tables = path / "tables"  # the numbers behind them
        self.summary = path / "summary.json"  # what a script reads of the report
        self.report = path / "report.md"
        self.latex = path / "report.tex"  # the same for a paper, where asked for
        self.page = path / "report.html"  # the same with flights to be looked at

    @classmethod
    def reserve(cls, path: Path) -> Self:
        """Make a new folder, or take one whose campaign was ended before its store was made."""
        folder = cls(path)
        with _explained(path):
            folder.require_unused()
            path.mkdir(parents=True, exist_ok=True)
        return folder

    def fill(
        self,
        models_folder: Path,
        generated_folder: Path,
        imported: Mapping[str, Path] = MappingProxyType({}),
    ) -> None:
        """Copy models, code and, by where it goes, what that imports; only its writer may."""
        with _explained(self.path):
            self.require_unused()
            for source, target in ((models_folder, self.model), (generated_folder, self.generated)):
                shutil.rmtree(target, ignore_errors=True)
                target.mkdir()
                found = [path for path in sorted(source.iterdir()) if path.is_file()]
                _copy_files({path.name: path for path in found if OURS not in path.name}, target)
            (self.generated / IMPORTED).mkdir()
            _copy_files(imported, self.generated / IMPORTED)

    def files(self) -> list[Path]:
        """Return the campaign's own files in order, without lock, bytecode and unfinished ones."""
        places = {*vars(self).values()} - {self.path, self.lock}
        found = {path for place in places for path in (place, *place.rglob("*"))}
        return sorted(
            path
            for path in found
            if path.is_file() and path.parent.name != "__pycache__" and OURS not in path.name
        )

    def hashes(self) -> dict[str, str]:
        """Return SHA-256 of every copied file by name."""
        place = self.generated / IMPORTED
        imported = {
            path.relative_to(place).as_posix(): path for path in copied_files(self.generated)
        }
        return file_hashes(self.model, self.generated, imported)

    def require_hashes(self, recorded: Mapping[str, str]) -> None:
        """Refuse copies that are not those that the campaign was begun on."""
        found = self.hashes()
        for name in {*recorded, *(name for name in found if name.startswith(IMPORTED))}:
            if recorded.get(name) != found.get(name):
                what = "gone" if name not in found else "another one than it was begun on"
                raise RecordError(
                    f"{self.path}: the campaign's own copy of {name} is {what}; expected the "
                    "folder as `mrsfi evolve` left it; restore the file, or begin a new campaign"
                )

    def require_unused(self) -> None:
        """Refuse a folder that holds more than a start that was ended leaves behind."""
        if not self.path.exists():
            return
        found = {entry.name for entry in self.path.iterdir()} if self.path.is_dir() else {"a file"}
        new = new_name(self.database)
        begun = {self.lock.name, self.model.name, self.generated.name, new, f"{new}-journal"}
        if found and not {self.lock.name} <= found <= begun:
            raise RecordError(
                f"{self.path}: found something there already; expected a new or empty folder. "
                "Give the campaign another name, or move the old one away"
            )


def file_hashes(models: Path, generated: Path, imported: Mapping[str, Path]) -> dict[str, str]:
    """Return SHA-256 of every file that a campaign copies, by the name of its copy."""
    names = {f"{IMPORTED}/{name}": _hash(path) for name, path in imported.items()}
    return hashes(generated) | hashes(models) | names


def hashes(folder: Path) -> dict[str, str]:
    """Return SHA-256 of a folder's files by name, in order, without its subfolders."""
    files = sorted(path for path in folder.glob("*") if path.is_file() and OURS not in path.name)
    return {path.name: _hash(path) for path in files}


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def new_name(path: Path) -> str:
    """Return the name that a file has until it is whole."""
    return f"{path.name}.new"


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RecordError(
            f"{path}: cannot make the campaign folder: {error}; expected a place that can be "
            "written, and readable models and generated code"
        ) from error


def _copy_files(files: Mapping[str, Path], target: Path) -> None:
    for name, file in files.items():
        place = target / name
        place.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(place, file.read_bytes())
        keep_names(place.parent)
    keep_names(target)


@contextmanager
def only_writer(folder: CampaignFolder) -> Iterator[None]:
    """Let nobody else write a campaign while the body runs.

    The lock is the operating system's, on a file that stays: however the process ends, the
    lock ends with it, and nothing has to be removed by hand. Child processes do not keep it.
    """
    try:
        descriptor = os.open(folder.lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise RecordError(
            f"{folder.path}: cannot be opened or written: {error.strerror}; expected the folder "
            "of a campaign that can be; change its permissions, or continue a copy of it"
        ) from error
    try:
        _seize(folder, descriptor)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def no_writer(folder: CampaignFolder) -> Iterator[None]:
    """Let nobody write a campaign while the body reads it; its folder may be read-only."""
    with ExitStack() as stack:
        with suppress(OSError):  # copied without it, or not to be read at all
            descriptor = os.open(folder.lock, os.O_RDONLY | os.O_CLOEXEC)
            stack.callback(os.close, descriptor)
            _seize(folder, descriptor, is_shared=True)
        yield


def _seize(folder: CampaignFolder, descriptor: int, *, is_shared: bool = False) -> None:
    try:
        kind = fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX
        fcntl.flock(descriptor, kind | fcntl.LOCK_NB)
        if not is_shared:
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
