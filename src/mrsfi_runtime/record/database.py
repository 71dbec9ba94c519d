"""The SQLite file of a campaign: its layout, its version, and errors that name the file.

Nothing of ``sqlite3`` leaves this module but the connection: what goes wrong in it becomes
a ``RecordError`` with the path, what was found and what was expected.

Every record from mrsfi 0.3.0 on, which began with version 4, stays readable. A later version only
adds columns. Where a record lacks one, its values are ``None`` and print as *not recorded*. Records
of versions 1 to 3 are refused.
"""

import json
import sqlite3
from collections.abc import Container, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.files import keep_names
from mrsfi_runtime.record.encoding import OUTCOME
from mrsfi_runtime.record.folder import new_name

SCHEMA = 4
"""Version of the layout that is written; a file of a newer one is refused."""

_FIRST = 4  # oldest version that is read

_APPLICATION = 0x4D525346  # "MRSF" in the file's header: this SQLite file is a campaign

_WAIT = 30.0  # seconds that a reader and a running campaign wait for each other


EVALUATION = ("idx", "generation", "fitness", "fault_ticks", *OUTCOME, "specification")
"""Columns of the table of evaluations."""


def quoted(columns: Iterable[str], stored: Container[str] = EVALUATION) -> str:
    """Return columns as a query names them, with NULL for one that a record does not have."""
    return ", ".join(f'"{name}"' if name in stored else "NULL" for name in columns)


_TABLES = (
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    f"CREATE TABLE evaluation ({quoted(EVALUATION)}, PRIMARY KEY (idx))",
    "CREATE TABLE failure (idx INTEGER PRIMARY KEY, generation, specification, traceback)",
    "CREATE TABLE generation (idx, statistics, population, random_state, PRIMARY KEY (idx))",
    "CREATE TABLE flight (idx INTEGER PRIMARY KEY, mission_seed, specification, found)",
)


def stored_columns(path: Path, connection: sqlite3.Connection) -> frozenset[str]:
    """Return the columns that a record has for evaluations."""
    with translated(path):
        columns = connection.execute("PRAGMA table_info(evaluation)")
        return frozenset(name for _, name, *_ in columns)


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
    if version < _FIRST:
        raise RecordError(
            f"{path}: found a campaign of version {version}, written by {_writer(connection)}; "
            f"expected version {_FIRST} or later, as mrsfi writes it from 0.3.0 on; open the "
            "campaign with the mrsfi that wrote it, or fly it anew with `mrsfi evolve`"
        )
    if version > SCHEMA:
        raise RecordError(
            f"{path}: found a campaign of version {version}; expected at most {SCHEMA}, which "
            "is what this mrsfi reads; open it with the newer mrsfi that wrote it"
        )


def _writer(connection: sqlite3.Connection) -> str:
    with suppress(sqlite3.Error, ValueError, TypeError, LookupError):
        ((text,),) = connection.execute("SELECT value FROM meta WHERE key = 'manifest'")
        return f"mrsfi {json.loads(text)['versions']['mrsfi']}"
    return "a mrsfi whose version is not recorded"
