"""The SQLite file of a campaign: its layout, its version, and errors that name the file.

Nothing of ``sqlite3`` leaves this module but the connection: what goes wrong in it becomes
a ``RecordError`` with the path, what was found and what was expected.
"""

import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.files import keep_names
from mrsfi_runtime.record.encoding import BESIDE, COUNTS
from mrsfi_runtime.record.folder import new_name

SCHEMA = 3
"""Version of the layout; a file of a newer one is refused, so that no earlier mrsfi flies it.

In version 1 nothing says which semantics was flown, and outcomes may have fewer counts. Up to
version 2 no outcome has margins; detection may be missing in version 3.
"""

_APPLICATION = 0x4D525346  # "MRSF" in the file's header: this SQLite file is a campaign

_WAIT = 30.0  # seconds that a reader and a running campaign wait for each other


def quoted(columns: Iterable[str]) -> str:
    """Return columns as a query names them, also those whose names are words of SQL."""
    return ", ".join(f'"{name}"' for name in columns)


def _columns(
    counts: Iterable[str], beside: Iterable[str], specification: str = "specification"
) -> str:
    head = f"idx, generation, {specification}, fitness, fault_ticks"
    return f"{head}, {quoted(counts)}, digest, {', '.join(beside)}"


FLIGHT_TABLE = (
    "CREATE TABLE IF NOT EXISTS flight "
    "(idx INTEGER PRIMARY KEY, mission_seed, specification, found)"
)
"""Makes the table of flights after a search, which a record of an earlier mrsfi lacks."""

EVALUATION = f"evaluation ({_columns(COUNTS, BESIDE)})"
"""The table of evaluations with its columns, which in an older record stand in another order."""

_TABLES = (
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    f"CREATE TABLE {EVALUATION[:-1]}, PRIMARY KEY (idx))",
    "CREATE TABLE failure (idx INTEGER PRIMARY KEY, generation, specification, traceback)",
    "CREATE TABLE generation (idx, statistics, population, random_state, PRIMARY KEY (idx))",
    FLIGHT_TABLE,
)


def stored_columns(path: Path, connection: sqlite3.Connection) -> tuple[str, ...]:
    """Return what a record has of an outcome and its digest; an older one has fewer."""
    with translated(path):
        columns = {row[1] for row in connection.execute("PRAGMA table_info(evaluation)")}
    return tuple(name for name in (*COUNTS, *BESIDE) if name in columns)


def select_evaluations(stored: Sequence[str], specification: str = "specification") -> str:
    """Return the query for evaluations by ``stored_columns``; something may stand for faults."""
    counts = [name for name in stored if name not in BESIDE]
    beside = [name if name in stored else "NULL" for name in BESIDE]
    return f"SELECT {_columns(counts, beside, specification)} FROM evaluation"


def add_column(connection: sqlite3.Connection, name: str) -> None:
    """Make a column of ``BESIDE`` that a record of an earlier mrsfi lacks."""
    connection.execute(f"ALTER TABLE evaluation ADD COLUMN {name}")
    connection.execute(f"PRAGMA user_version = {SCHEMA}")


def create(path: Path, meta: Mapping[str, str]) -> None:
    """Make the file, and its folder if that is missing; under its name it appears whole."""
    with translated(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists():
        raise RecordError(
            f"{path}: found a campaign there already; expected a new folder. "
            "Give the campaign another name, or move the old one away"
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
    """Make the tables of a campaign without evaluations; the path is for messages."""
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
            f"{path.parent}: found no {path.name}; expected the folder of a campaign, "
            "as 'mrsfi evolve' writes it; one that was ended before it began has none: "
            "begin it anew"
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
    """Turn what SQLite and the file system say into a ``RecordError`` that names the file."""
    try:
        yield
    except (sqlite3.Error, OSError) as error:
        raise RecordError(_explained(path, error)) from error


def _explained(path: Path, error: sqlite3.Error | OSError) -> str:
    """Return what was found, what was expected and what to do, by SQLite's primary code."""
    if isinstance(error, OSError):
        return _refused(path, str(error))
    code = getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
    if code in (sqlite3.SQLITE_READONLY, sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_PERM):
        return _refused(path, str(error))
    if code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
        return (
            f"{path}: still locked by another process after {_WAIT:.0f} s; "
            "expected one writer at a time; wait until it is done"
        )
    if code in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
        begun = "what was recorded before is whole: free some room, then continue with: mrsfi "
        advice = f"{begun}evolve --resume {path.parent}" if path.is_file() else "free some room"
        return (
            f"{path}: the disk did not take a write or give a read: {error}; expected room to "
            f"append and a sound disk; {advice}"
        )
    return damaged(path, str(error))


def _refused(path: Path, found: str) -> str:
    return (
        f"{path}: cannot be opened or written: {found}; expected a folder and file that can be; "
        "choose another place, or change the permissions"
    )


def damaged(path: Path, found: str) -> str:
    """Return the message for a file whose content makes no sense."""
    return (
        f"{path}: the record is damaged: {found}; expected a campaign database of "
        f"version {SCHEMA}; restore the file from a copy, or run the campaign anew"
    )


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    connection = sqlite3.connect(uri, uri=True, timeout=_WAIT, isolation_level=None)
    with closed_on_error(connection):
        connection.execute("PRAGMA synchronous = EXTRA")  # a commit outlives the loss of power
    return connection


def _require_campaign(path: Path, connection: sqlite3.Connection) -> None:
    ((application,),) = connection.execute("PRAGMA application_id").fetchall()
    ((version,),) = connection.execute("PRAGMA user_version").fetchall()
    if application != _APPLICATION:
        raise RecordError(
            f"{path}: found a SQLite file that is not a campaign; expected the record of "
            "'mrsfi evolve'; name the folder of one"
        )
    if version > SCHEMA:
        raise RecordError(
            f"{path}: found a campaign of version {version}; expected at most {SCHEMA}, which "
            "is what this mrsfi reads; open it with the newer mrsfi that wrote it"
        )
