"""The folder of a campaign, the texts that it stores, and its SQLite file.

``CampaignFolder`` names every file that a campaign may have; ``only_writer`` lets one process
write it at a time. ``canonical`` and its neighbours write values as JSON: one value has one text,
which reads back bit for bit. The rest is the SQLite file: layout, version and errors. Only the
connection of ``sqlite3`` leaves this module; each error becomes a ``RecordError`` with the path,
the problem and the expectation. ``store.py`` reads and writes the rows.

Every record from mrsfi 0.3.0 on, which began with version 4, stays readable. A later version only
adds columns and tables. Where a record lacks a column, its values are ``None`` and print as *not
recorded*. Records of versions 1 to 3 are refused.
"""

import fcntl
import hashlib
import json
import os
import re
import shutil
import sqlite3
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import fields
from itertools import chain
from operator import methodcaller
from pathlib import Path
from types import MappingProxyType
from typing import Any, Self

from mrsfi_runtime.errors import RecordError, SpecificationError
from mrsfi_runtime.fence import IMPORTED, copied_files
from mrsfi_runtime.files import OURS, keep_names, write_atomically
from mrsfi_runtime.model.faults import Specification, TimedFault, plain
from mrsfi_runtime.model.mission import Margin, Outcome


class CampaignFolder:
    """The folder ``runs/<name>`` of one campaign; a replay needs only its content."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.model = path / "model"  # copy of the mission folder
        self.generated = path / "generated"  # copy of the code; in a subfolder what it imports
        self.database = path / "campaign.sqlite"  # every evaluation and generation
        self.lock = path / "campaign.lock"  # held by the process that runs the campaign
        self.critical = path / "critical"  # the most critical specifications as XMI
        self.weaknesses = path / "weaknesses"  # the mildest variant of each weakness as XMI
        self.causes = path / "causes"  # cause sets of explained specifications as XMI
        self.figures = path / "figures"
        self.tables = path / "tables"  # the numbers of the figures
        self.summary = path / "summary.json"  # the report for scripts
        self.report = path / "report.md"
        self.latex = path / "report.tex"  # the same for a paper, on request
        self.page = path / "report.html"  # the same with animated flights

    @classmethod
    def reserve(cls, path: Path) -> Self:
        """Create a folder, or reuse one whose campaign was interrupted before its store existed."""
        folder = cls(path)
        with _system_words(path):
            folder.require_unused()
            path.mkdir(parents=True, exist_ok=True)
        return folder

    def fill(
        self,
        models_folder: Path,
        generated_folder: Path,
        imported: Mapping[str, Path] = MappingProxyType({}),
    ) -> None:
        """Copy models, code and imported files, by their target names; only for its writer."""
        with _system_words(self.path):
            self.require_unused()
            for source, target in ((models_folder, self.model), (generated_folder, self.generated)):
                shutil.rmtree(target, ignore_errors=True)
                target.mkdir()
                found = [path for path in sorted(source.iterdir()) if path.is_file()]
                _copy_files({path.name: path for path in found if OURS not in path.name}, target)
            (self.generated / IMPORTED).mkdir()
            _copy_files(imported, self.generated / IMPORTED)

    def files(self) -> list[Path]:
        """Return the campaign's files in order, without lock, bytecode and unfinished files."""
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
        """Refuse copies that differ from those with which the campaign began."""
        found = self.hashes()
        for name in {*recorded, *(name for name in found if name.startswith(IMPORTED))}:
            if recorded.get(name) != found.get(name):
                what = "is missing" if name not in found else "has changed since the campaign began"
                raise RecordError(
                    f"{self.path}: the campaign's copy of {name} {what}; expected the folder as "
                    "`mrsfi evolve` wrote it; restore the file, or begin a new campaign"
                )

    def require_unused(self) -> None:
        """Refuse a folder that holds more than an interrupted start leaves behind."""
        if not self.path.exists():
            return
        found = {entry.name for entry in self.path.iterdir()} if self.path.is_dir() else {"a file"}
        new = new_name(self.database)
        begun = {self.lock.name, self.model.name, self.generated.name, new, f"{new}-journal"}
        if found and not {self.lock.name} <= found <= begun:
            raise RecordError(
                f"{self.path}: is in use already; expected a new or empty folder. Give the "
                "campaign another name, or move the old folder away"
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
    """Return the name that a file has until it is complete."""
    return f"{path.name}.new"


@contextmanager
def _system_words(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise RecordError(
            f"{path}: cannot create the campaign folder: {error}; expected a writable place, and "
            "readable models and generated code"
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
    """Hold a campaign's lock, so that no other process writes it while the body runs.

    The operating system releases the lock when the process ends; children do not inherit it.
    """
    try:
        descriptor = os.open(folder.lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise RecordError(
            f"{folder.path}: cannot be opened or written: {error.strerror}; expected a writable "
            "campaign folder; change its permissions, or continue a copy of it"
        ) from error
    try:
        _seize(folder, descriptor)
        yield
    finally:
        os.close(descriptor)


@contextmanager
def no_writer(folder: CampaignFolder) -> Iterator[None]:
    """Let no process write a campaign while the body reads it; its folder may be read-only."""
    with ExitStack() as stack:
        with suppress(OSError):  # a copy without the file, or an unreadable one
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
            f"{folder.path}: another process{f' ({holder})' if holder else ''} is running this "
            "campaign; expected one at a time; wait until it ends, or end it and resume"
        ) from error
    except OSError as error:
        raise RecordError(
            f"{folder.lock}: cannot be locked: {error.strerror}; expected a file system with "
            "locks and free space; choose another place"
        ) from error


OUTCOME = tuple(each.name for each in fields(Outcome))
"""The fields of an outcome, in the order in which they are stored."""

COUNTS = OUTCOME[: OUTCOME.index("digest")]
"""Those fields that are count vectors."""

_ENCODER = json.JSONEncoder(
    separators=(",", ":"), ensure_ascii=False, allow_nan=False, default=methodcaller("item")
)


def canonical(value: Any) -> str:
    """Return the JSON text of a value, without spaces; a number not finite is a ValueError."""
    return _ENCODER.encode(value)


def specification_text(specification: Specification) -> str:
    """Return ``[["f9",100,900,[200.0,-450.0]],…]``; a trigger, if there is one, comes last."""
    rows = map(plain, specification)
    return canonical([timed if timed.trigger else timed[:-1] for timed in rows])


def specification(rows: Iterable[Any]) -> Specification:
    """Return the specification that decoded rows describe; a ValueError if they are invalid."""
    try:
        return tuple(
            plain(TimedFault(fault, start, finish, tuple(values), *trigger))
            for fault, start, finish, values, *trigger in rows
        )
    except (SpecificationError, TypeError) as error:
        raise ValueError(f"{error}") from error


def fault_texts(text: str) -> tuple[list[str], list[str]]:
    """Return the pool fault of each timed fault, and a text that identifies each.

    Decoding the timed faults of a specification would take six times as long.
    """
    faults = re.findall(r'\["([^"\\]*)",', text)  # it misses IDs with quotes or backslashes
    texts = text.removeprefix("[[")[:-3].split("]],[")
    is_plain = text.endswith("]]]") and "-0.0" not in text and '"]' not in text  # no triggers
    if is_plain and len(faults) == len(texts):
        return faults, texts
    (rows,) = lists([text])
    plain = [
        timed._replace(values=tuple(value + 0.0 for value in timed.values))  # 0 equals -0
        for timed in specification(rows)
    ]
    return [timed.fault for timed in plain], [specification_text((one,))[2:-3] for one in plain]


def lists(texts: Sequence[str]) -> list[list[Any]]:
    """Decode several JSON lists; one call for all is faster. A ValueError if one is no list."""
    decoded: list[list[Any]] = json.loads(f"[{','.join(texts)}]")
    if len(decoded) != len(texts) or not all(type(each) is list for each in decoded):
        raise ValueError(f"found {' '.join(texts)[:60]}; expected lists")
    return decoded


def integers(rows: Sequence[Sequence[Any]]) -> tuple[tuple[int, ...], ...]:
    """Return lists of integers as tuples; a ValueError if they hold anything else."""
    if not set(map(type, chain.from_iterable(rows))) <= {int}:
        raise ValueError(f"found {str(rows)[:60]}; expected lists of integers")
    return tuple(map(tuple, rows))


def margins(decoded: object) -> tuple[Margin | None, ...] | None:
    """Return margins as they are in an outcome; a ValueError if they are invalid."""
    if not decoded:
        return None
    if not isinstance(decoded, list):
        raise ValueError(f"found {str(decoded)[:60]}; expected a list of margins")  # noqa: TRY004 - the text is wrong
    return tuple(None if each is None else _margin(*each) for each in decoded)


def _margin(least: float, tick: int) -> Margin:
    if type(tick) is not int:
        raise ValueError(f"found tick {tick!r}; expected an integer")
    return float(least), tick


def object_from_text(text: str) -> dict[str, Any]:
    """Return a JSON object; a ValueError if the text is anything else."""
    value = json.loads(text)
    if not isinstance(value, dict):
        raise ValueError(f"found {text[:60]}; expected an object")  # noqa: TRY004 - the text is wrong, not its type
    return value


SCHEMA = 4
"""Version of the layout that is written; a file of a newer one is refused."""

_FIRST = 4  # oldest version that is read
_APPLICATION = 0x4D525346  # "MRSF" in the file's header: this SQLite file is a campaign
_WAIT = 30.0  # seconds that a reader and a running campaign wait for each other


EVALUATION = ("idx", "generation", "fitness", "fault_ticks", *OUTCOME, "specification")
"""Columns of the table of evaluations."""


def quoted(columns: Iterable[str], stored: Container[str] = EVALUATION) -> str:
    """Return columns as a query names them, with NULL for each that a record lacks."""
    return ", ".join(f'"{name}"' if name in stored else "NULL" for name in columns)


_TABLES = (
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    f"CREATE TABLE evaluation ({quoted(EVALUATION)}, PRIMARY KEY (idx))",
    "CREATE TABLE failure (idx INTEGER PRIMARY KEY, generation, specification, traceback)",
    "CREATE TABLE generation (idx, statistics, population, random_state, PRIMARY KEY (idx))",
    "CREATE TABLE flight (idx INTEGER PRIMARY KEY, mission_seed, specification, found)",
)

ELSEWHERE = (
    "CREATE TABLE IF NOT EXISTS elsewhere (idx INTEGER PRIMARY KEY, world, since, seconds, "
    "mission_seed, specification, found)"
)
"""The table of flights in other worlds, which a record lacks before the first of them."""


def inserting(table: str, n_values: int) -> str:
    """Return the statement that inserts rows; of evaluations in the order of their columns."""
    columns = f" ({quoted(EVALUATION)})" if table == "evaluation" else ""
    return f"INSERT INTO {table}{columns} VALUES ({', '.join('?' * n_values)})"


def completed(connection: sqlite3.Connection, columns: frozenset[str]) -> frozenset[str]:
    """Add the columns that an older record lacks, and return all."""
    for name in EVALUATION:
        if name not in columns:
            connection.execute(f'ALTER TABLE evaluation ADD COLUMN "{name}"')
    return columns | {*EVALUATION}


def create(path: Path, meta: Mapping[str, str]) -> None:
    """Create the file, and its folder if missing; it gets its name when it is complete."""
    with translated(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists():
        raise RecordError(
            f"{path}: a campaign exists there already; expected a new folder. "
            "Give the campaign another name, or move the old folder away"
        )
    new = path.with_name(new_name(path))
    with translated(path):
        for leftover in (new, new.with_name(f"{new.name}-journal")):
            leftover.unlink(missing_ok=True)
        with closing(_connect(new, "rwc")) as connection:
            fill(path, connection, meta)
        new.replace(path)
        keep_names(path.parent)


def fill(path: Path, connection: sqlite3.Connection, meta: Mapping[str, str]) -> None:
    """Create the tables of a campaign without evaluations; the path is for messages."""
    with transaction(path, connection):
        connection.execute(f"PRAGMA application_id = {_APPLICATION}")
        connection.execute(f"PRAGMA user_version = {SCHEMA}")
        for table in _TABLES:
            connection.execute(table)
        connection.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())


def open_existing(path: Path) -> sqlite3.Connection:
    """Open the file for reading and, where its permissions allow, for appending."""
    if not path.is_file():
        raise RecordError(
            f"{path.parent}: found no {path.name}; expected a campaign folder, as 'mrsfi evolve' "
            "writes it. A campaign that was interrupted before it began has none: begin it again"
        )
    with translated(path):
        connection = _connect(path, "rw")
        with closed_on_error(connection):
            _require_campaign(path, connection)
    return connection


@contextmanager
def closed_on_error(connection: sqlite3.Connection) -> Iterator[None]:
    """Close a connection if the body fails."""
    try:
        yield
    except BaseException:
        connection.close()
        raise


@contextmanager
def transaction(path: Path, connection: sqlite3.Connection) -> Iterator[sqlite3.Connection]:
    """Run the body as one transaction: stored whole at its end, or not at all."""
    with translated(path), connection:  # which commits, or rolls back
        connection.execute("BEGIN IMMEDIATE")
        yield connection


@contextmanager
def translated(path: Path) -> Iterator[None]:
    """Turn errors of SQLite and the file system into a ``RecordError`` that names the file."""
    try:
        yield
    except (sqlite3.Error, OSError) as error:
        raise RecordError(_sqlite_words(path, error)) from error


def _sqlite_words(path: Path, error: sqlite3.Error | OSError) -> str:
    """Return the problem, the expectation and the remedy, by SQLite's primary error code."""
    if isinstance(error, OSError):
        return _refused(path, str(error))
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM):
        return _refused(path, str(error))
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return (
            f"{path}: still locked by another process after {_WAIT:.0f} s; "
            "expected one writer at a time; wait until it ends"
        )
    if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
        begun = "earlier records are intact: free some space, then continue with: mrsfi "
        advice = f"{begun}evolve --resume {path.parent}" if path.is_file() else "free some space"
        return (
            f"{path}: cannot be written to or read from the disk: {error}; expected free space and "
            f"a working disk; {advice}"
        )
    return damaged(path, str(error))


def _refused(path: Path, found: str) -> str:
    return (
        f"{path}: cannot be opened or written: {found}; expected a readable and writable folder "
        "and file; choose another place, or change the permissions"
    )


def damaged(path: Path, found: str) -> str:
    """Return the message for a file with invalid content."""
    return (
        f"{path}: the record is damaged: {found}; expected a campaign database of "
        f"version {SCHEMA}; restore the file from a copy, or run the campaign again"
    )


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    connection = sqlite3.connect(uri, uri=True, timeout=_WAIT, isolation_level=None)
    with closed_on_error(connection):
        connection.execute("PRAGMA synchronous = EXTRA")  # a commit outlives the loss of power
    return connection


def _require_campaign(path: Path, connection: sqlite3.Connection) -> None:
    names = ("application_id", "user_version")
    (application,), (version,) = (connection.execute(f"PRAGMA {each}").fetchone() for each in names)
    if application != _APPLICATION:
        raise RecordError(
            f"{path}: found a SQLite file that is not a campaign; expected the record that "
            "'mrsfi evolve' writes; name a campaign folder"
        )
    if version < _FIRST:
        raise RecordError(
            f"{path}: found a campaign of version {version}, written by {_writer(connection)}; "
            f"expected version {_FIRST} or later, which mrsfi writes from 0.3.0 on; open the "
            "campaign with the mrsfi that wrote it, or run it again with `mrsfi evolve`"
        )
    if version > SCHEMA:
        raise RecordError(
            f"{path}: found a campaign of version {version}; this mrsfi reads at most version "
            f"{SCHEMA}; open it with the newer mrsfi that wrote it"
        )


def _writer(connection: sqlite3.Connection) -> str:
    with suppress(sqlite3.Error, ValueError, TypeError, LookupError):
        ((text,),) = connection.execute("SELECT value FROM meta WHERE key = 'manifest'")
        return f"mrsfi {json.loads(text)['versions']['mrsfi']}"
    return "a mrsfi whose version is not recorded"
