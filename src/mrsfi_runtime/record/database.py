"""The SQLite file of a campaign: its layout, its version, and errors that name the file.

Nothing of ``sqlite3`` leaves this module but the connection: what goes wrong in it becomes
a ``RecordError`` with the path, what was found and what was expected.
"""

import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.encoding import COUNTS

SCHEMA = 1
"""Version of the layout; a file of a newer one is refused."""

_APPLICATION = 0x4D525346  # "MRSF" in the file's header: this SQLite file is a campaign
_WAIT = 30.0  # seconds that a reader and a running campaign wait for each other

_COUNTS = ", ".join(f'"{name}"' for name in COUNTS)
_EVALUATION = f"idx, generation, specification, fitness, fault_ticks, {_COUNTS}, digest"
_TABLES = (
    "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL)",
    f"CREATE TABLE evaluation ({_EVALUATION}, PRIMARY KEY (idx))",
    "CREATE TABLE failure (idx INTEGER PRIMARY KEY, generation, specification, traceback)",
    "CREATE TABLE generation (idx, statistics, population, random_state, PRIMARY KEY (idx))",
)

INSERT_EVALUATION = f"INSERT INTO evaluation VALUES ({', '.join('?' * (6 + len(COUNTS)))})"
INSERT_FAILURE = "INSERT INTO failure (generation, specification, traceback) VALUES (?, ?, ?)"
INSERT_GENERATION = "INSERT INTO generation VALUES (?, ?, ?, ?)"
SELECT_EVALUATION = f"SELECT {_EVALUATION} FROM evaluation"
SELECT_DIGESTED = f"SELECT specification, {_COUNTS}, digest, fitness FROM evaluation"
SELECT_FAILURE = "SELECT generation, specification, traceback FROM failure"
SELECT_GENERATION = "SELECT idx, statistics, population, random_state FROM generation"


def create(path: Path, meta: Mapping[str, str]) -> sqlite3.Connection:
    """Make the file, and its folder if that is missing, in one transaction.

    Raises
    ------
    RecordError
        If there is a file already, or none can be written.
    """
    with translated(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists():
        message = (
            f"{path}: found a campaign there already; expected a new folder. "
            "Give the campaign another name, or move the old one away"
        )
        raise RecordError(message)
    with translated(path):
        connection = _connect(path, "rwc")
    try:
        with transaction(path, connection):
            connection.execute(f"PRAGMA application_id = {_APPLICATION}")
            connection.execute(f"PRAGMA user_version = {SCHEMA}")
            for table in _TABLES:
                connection.execute(table)
            connection.executemany("INSERT INTO meta VALUES (?, ?)", meta.items())
    except BaseException:
        connection.close()
        raise
    return connection


def open_existing(path: Path) -> sqlite3.Connection:
    """Open the file for reading and, where its permissions allow, for appending.

    Raises
    ------
    RecordError
        If there is none, or it is no campaign, or a damaged one, or one of a newer version.
    """
    if not path.is_file():
        message = (
            f"{path.parent}: found no {path.name}; expected the folder of a campaign, "
            "as 'mrsfi evolve' writes it"
        )
        raise RecordError(message)
    with translated(path):
        connection = _connect(path, "rw")
    try:
        with translated(path):
            _require_campaign(path, connection)
    except BaseException:
        connection.close()
        raise
    return connection


@contextmanager
def transaction(path: Path, connection: sqlite3.Connection) -> Iterator[sqlite3.Connection]:
    """Run the body as one transaction: stored whole at its end, or not at all."""
    with translated(path):
        connection.execute("BEGIN IMMEDIATE")
        try:
            yield connection
        except BaseException:
            if connection.in_transaction:
                connection.rollback()
            raise
        connection.commit()


@contextmanager
def translated(path: Path) -> Iterator[None]:
    """Turn what SQLite and the file system say into a ``RecordError`` that names the file."""
    try:
        yield
    except (sqlite3.Error, OSError) as error:
        message = str(error)
        if isinstance(error, OSError) or "readonly" in message or "unable to open" in message:
            explained = (
                f"{path}: cannot be opened or written: {message}; "
                "expected a folder and file that can be; choose another place, "
                "or change the permissions"
            )
        elif "locked" in message:
            explained = (
                f"{path}: still locked by another process after {_WAIT:.0f} s; "
                "expected one writer at a time; wait until it is done"
            )
        elif "full" in message:
            explained = f"{path}: found no space left; expected room to append; free some"
        else:
            explained = damaged(path, message)
        raise RecordError(explained) from error


def damaged(path: Path, found: str) -> str:
    """Return the message for a file whose content makes no sense."""
    return (
        f"{path}: the record is damaged: {found}; expected a campaign database of "
        f"version {SCHEMA}; restore the file from a copy, or run the campaign anew"
    )


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    uri = f"{path.absolute().as_uri()}?mode={mode}"
    return sqlite3.connect(uri, uri=True, timeout=_WAIT, isolation_level=None)


def _require_campaign(path: Path, connection: sqlite3.Connection) -> None:
    ((application,),) = connection.execute("PRAGMA application_id").fetchall()
    ((version,),) = connection.execute("PRAGMA user_version").fetchall()
    if application != _APPLICATION:
        message = (
            f"{path}: found a SQLite file that is not a campaign; expected the record of "
            "'mrsfi evolve' (a run that was killed before it began leaves an empty one: "
            "remove the folder)"
        )
        raise RecordError(message)
    if version > SCHEMA:
        message = (
            f"{path}: found a campaign of version {version}; expected at most {SCHEMA}, which "
            "is what this mrsfi reads; open it with the newer mrsfi that wrote it"
        )
        raise RecordError(message)
