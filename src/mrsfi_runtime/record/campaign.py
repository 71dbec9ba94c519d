"""The store of a campaign: evaluations, failures, generations and causes, in one SQLite file.

Each append is one transaction with a rollback journal, so a run that is killed at any
moment loses at most the append it was in, and whoever opens the folder next finds every
earlier one.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from sqlite3 import Connection
from typing import Any, Self, TypeVar

from mrsfi_runtime.errors import RecordError, UsageError
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.model.semantics import SEMANTICS, difference, flown_by
from mrsfi_runtime.record import database, encoding
from mrsfi_runtime.record.causes import RecordedCause
from mrsfi_runtime.record.folder import CampaignFolder
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Evaluation:
    """A fault specification, and what flying it gave.

    Attributes
    ----------
    index
        Place in the campaign, from 0, without gaps.
    generation
        Generation that asked for it, from 0.
    fitness
        What it is ranked by, first; more is more critical. If it is a mean over mission
        seeds, the mean violations of each chosen goal follow.
    fault_ticks
        Ticks at which faults were active, summed over the timed faults.
    """

    index: int
    generation: int
    specification: Specification
    outcome: Outcome
    fitness: tuple[float, ...]
    fault_ticks: int


@dataclass(frozen=True, slots=True)
class Generation:
    """A finished generation.

    Attributes
    ----------
    statistics
        ``n_evaluations``, and ``mean``, ``std``, ``min``, ``max`` of the population's fitness.
    population
        Evaluation index of each individual, shape ``(n_individuals,)``.
    random_state
        State of the search's random generator after it, as JSON text.
    """

    index: int
    statistics: Mapping[str, float]
    population: tuple[int, ...]
    random_state: str


@dataclass(frozen=True, slots=True)
class FailedEvaluation:
    """A specification whose evaluation raised an error in the mission's own code.

    Attributes
    ----------
    number
        Which of the specifications that the search asked for, from 0, those that failed and
        those that did not counted together.
    """

    number: int
    generation: int
    specification: Specification
    traceback: str


class CampaignStore(AbstractContextManager["CampaignStore"]):
    """Read and extend one campaign; use ``create`` or ``open``, and close it.

    Attributes
    ----------
    settings, manifest
        What the campaign was started with.
    """

    def __init__(self, path: Path, connection: Connection) -> None:
        self.path = path
        self._connection = connection
        rows = dict(self._select("SELECT key, value FROM meta"))
        settings = self._decoded(encoding.object_from_text, rows.get("settings"))
        try:
            self.settings = CampaignSettings.from_json(settings, str(path.parent))
        except UsageError as error:
            raise RecordError(database.damaged(path, str(error))) from error
        manifest = self._decoded(encoding.object_from_text, rows.get("manifest"))
        self.manifest = Manifest.from_json(manifest)
        self._counts = database.stored_counts(path, connection)
        self._evaluations = database.select_evaluations(self._counts)

    @classmethod
    def create(cls, folder: Path, settings: CampaignSettings, manifest: Manifest) -> Self:
        """Start the store of a new campaign in a folder, which is made if it is missing.

        Raises
        ------
        RecordError
            If the folder holds a campaign already or cannot be written.
        """
        meta = {
            "settings": encoding.canonical(settings.as_json()),
            "manifest": encoding.canonical(manifest.as_json()),
        }
        database.create(CampaignFolder(folder).database, meta)
        return cls.open(folder)

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Open a campaign, finished or interrupted, also while it is still running.

        Raises
        ------
        RecordError
            If the folder holds no campaign, a damaged one, or one of a newer version.
        """
        path = CampaignFolder(folder).database
        connection = database.open_existing(path)
        with database.closed_on_error(connection):
            return cls(path, connection)

    def require_flyable(self) -> None:
        """Refuse to fly what was found under other rules of the world: it would differ.

        Raises
        ------
        RecordError
            Naming the semantics of the record, that of this mrsfi, and which mrsfi flies it.
        """
        found, release = self.manifest.semantics, self.manifest.versions.get("mrsfi", "")
        if found != SEMANTICS:
            folder = self.path.parent
            raise RecordError(
                f"{folder}: {difference(found)}; fly the campaign with {flown_by(found, release)}, "
                f"read it with `mrsfi report {folder}`, or begin a new one"
            )

    def close(self) -> None:
        """Close the file; everything appended stays."""
        self._connection.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def append(
        self,
        evaluations: Iterable[Evaluation] = (),
        failures: Iterable[FailedEvaluation] = (),
        generations: Iterable[Generation] = (),
    ) -> None:
        """Store evaluations, failures and finished generations in one transaction.

        The indexes of evaluations and of generations follow those stored.

        Raises
        ------
        ValueError
            If an index leaves a gap or is taken, or a number is not finite.
        RecordError
            If the file cannot be written. In both cases nothing of this append is stored.
        """
        rows = {
            "evaluation": [_row(evaluation) for evaluation in evaluations],
            "failure": [_failure_row(failure) for failure in failures],
            "generation": [_generation_row(generation) for generation in generations],
        }
        with database.transaction(self.path, self._connection) as connection:
            _require_next("evaluation", rows["evaluation"], self.n_evaluations)
            _require_next("generation", rows["generation"], self.n_generations)
            for table, new in rows.items():
                if new:
                    marks = ", ".join("?" * len(new[0]))
                    connection.executemany(f"INSERT INTO {table} VALUES ({marks})", new)

    @property
    def n_evaluations(self) -> int:
        """How many evaluations are stored."""
        return self._count("evaluation")

    def evaluations(self, first: int = 0, n_most: int | None = None) -> tuple[Evaluation, ...]:
        """Return evaluations in index order: all, or at most so many from one index on."""
        rows = self._select(
            f"{self._evaluations} WHERE idx >= ? ORDER BY idx LIMIT ?",
            (first, -1 if n_most is None else n_most),  # SQLite takes -1 for no limit
        )
        decode = partial(_evaluation, self._counts)
        return tuple(self._decoded(decode, row) for row in rows)

    def evaluation(self, index: int) -> Evaluation:
        """Return one evaluation.

        Raises
        ------
        RecordError
            If the campaign has none of that index.
        """
        rows = self._select(f"{self._evaluations} WHERE idx = ?", (int(index),))
        if not rows:
            n_found = self.n_evaluations
            expected = f"0 to {n_found - 1}" if n_found else "no number: it holds none yet"
            raise RecordError(f"{self.path}: found no evaluation {index}; expected {expected}")
        return self._decoded(partial(_evaluation, self._counts), rows[0])

    def generations(self) -> tuple[Generation, ...]:
        """Return all finished generations in order."""
        rows = self._select("SELECT * FROM generation ORDER BY idx")
        return tuple(self._decoded(_generation, row) for row in rows)

    def generation(self, index: int) -> Generation | None:
        """Return one finished generation, or nothing if it is not finished."""
        rows = self._select("SELECT * FROM generation WHERE idx = ?", (int(index),))
        return self._decoded(_generation, rows[0]) if rows else None

    @property
    def n_generations(self) -> int:
        """How many finished generations are stored."""
        return self._count("generation")

    def failures(self) -> tuple[FailedEvaluation, ...]:
        """Return the failed evaluations in the order in which they were asked for."""
        rows = self._select("SELECT * FROM failure ORDER BY idx")
        return tuple(self._decoded(_failure, row) for row in rows)

    def causes(self) -> tuple[RecordedCause, ...]:
        """Return what was found out about causes, in the order of the evaluations."""
        if not self._select("SELECT 1 FROM sqlite_master WHERE name = 'cause'"):
            return ()  # a record of an earlier mrsfi
        rows = self._select(
            "SELECT cause.idx, content, specification FROM cause LEFT JOIN evaluation "
            "ON evaluation.idx = cause.idx ORDER BY cause.idx"
        )
        return tuple(self._decoded(RecordedCause.from_row, row) for row in rows)

    def append_cause(self, cause: RecordedCause) -> None:
        """Store what was found out about an evaluation.

        Raises
        ------
        RecordError
            If something is stored about it already, or the file cannot be written.
        """
        with database.transaction(self.path, self._connection) as connection:
            connection.execute(database.CAUSE_TABLE)
            connection.execute("INSERT INTO cause VALUES (?, ?)", (int(cause.index), cause.text()))

    def digest(self) -> str:
        """Return SHA-256 over specification, outcome and fitness of all evaluations in order.

        Two campaigns with the same digest found the same, bit for bit, however their
        evaluations were divided into appends.
        """
        digest = hashlib.sha256()
        for row in self._select(database.select_digested(self._counts)):
            digest.update(encoding.canonical(row).encode())
            digest.update(b"\n")
        return digest.hexdigest()

    def _count(self, table: str) -> int:
        ((n_rows,),) = self._select(f"SELECT count(*) FROM {table}")
        return int(n_rows)

    def _select(self, query: str, values: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        with database.translated(self.path):
            return self._connection.execute(query, values).fetchall()

    def _decoded(self, decode: Callable[[Any], T], stored: Any) -> T:
        try:
            return decode(stored)
        except (ValueError, TypeError) as error:
            raise RecordError(database.damaged(self.path, str(error))) from error


def _row(evaluation: Evaluation) -> tuple[Any, ...]:
    outcome = evaluation.outcome
    return (
        int(evaluation.index),
        int(evaluation.generation),
        encoding.specification_text(evaluation.specification),
        encoding.canonical([float(number) for number in evaluation.fitness]),
        int(evaluation.fault_ticks),
        *(encoding.canonical(getattr(outcome, name)) for name in encoding.COUNTS),
        outcome.digest,
    )


def _evaluation(names: Sequence[str], row: tuple[Any, ...]) -> Evaluation:
    """Return what a row says of an evaluation, whose counts have names in their order."""
    index, generation, specification_text, fitness_text, fault_ticks, *texts, digest = row
    specification, fitness, *found = encoding.lists([specification_text, fitness_text, *texts])
    counts: dict[str, Any] = dict.fromkeys(encoding.LATER_COUNTS)
    counts.update(zip(names, encoding.integers(found), strict=True))
    return Evaluation(
        index=index,
        generation=generation,
        specification=encoding.specification(specification),
        outcome=Outcome(**counts, digest=digest),
        fitness=tuple(map(float, fitness)),
        fault_ticks=fault_ticks,
    )


def _require_next(what: str, rows: Iterable[tuple[Any, ...]], first: int) -> None:
    """Refuse rows whose indexes do not follow those stored."""
    for expected, row in enumerate(rows, first):
        if row[0] != expected:
            raise ValueError(f"found {what} {row[0]}; expected {expected} next")


def _generation_row(generation: Generation) -> tuple[Any, ...]:
    return (
        int(generation.index),
        encoding.canonical(dict(generation.statistics)),
        encoding.canonical(generation.population),
        generation.random_state,
    )


def _generation(row: tuple[Any, ...]) -> Generation:
    index, statistics, population, random_state = row
    (individuals,) = encoding.integers(encoding.lists([population]))
    return Generation(index, encoding.object_from_text(statistics), individuals, random_state)


def _failure_row(failure: FailedEvaluation) -> tuple[Any, ...]:
    specification = encoding.specification_text(failure.specification)
    return int(failure.number), int(failure.generation), specification, failure.traceback


def _failure(row: tuple[Any, ...]) -> FailedEvaluation:
    number, generation, text, traceback = row
    (specification,) = encoding.lists([text])
    return FailedEvaluation(number, generation, encoding.specification(specification), traceback)
