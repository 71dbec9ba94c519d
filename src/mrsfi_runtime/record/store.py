"""The store of a campaign: evaluations, failures, generations and later flights in one file.

Each append is one transaction with a rollback journal. So a run that is killed at any moment loses
at most its current append, and the next reader finds every earlier one. Indexes of evaluations and
generations count from 0 without gaps. An invalid row is a ``RecordError`` that names the file.

``CampaignStore`` reads and appends the values that are defined above it; the functions below it
turn rows into values and back. ``Measure`` names the violations that a campaign counts.
"""

import hashlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from operator import itemgetter
from pathlib import Path
from sqlite3 import Connection
from typing import Any, Self, TypeVar

from mrsfi_runtime.errors import RecordError, UsageError, expected
from mrsfi_runtime.model.fault_types import SEMANTICS, difference
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import (
    Evaluated,
    FailedFlight,
    Margin,
    Mission,
    Outcome,
    Repetition,
)
from mrsfi_runtime.record import database
from mrsfi_runtime.record.database import CampaignFolder
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import COVER, COVERING, CampaignSettings

T = TypeVar("T")

_DEEP = 3  # the first semantics whose margins below 0 are of the worst tick, not of the first one
_BATCH = 2000  # evaluations whose texts are held at once
_KEEP = "INSERT OR REPLACE INTO meta VALUES (?, ?)"


@dataclass(frozen=True, slots=True)
class Flown:
    """The result of an evaluation, without the specification, which takes longest to read.

    The first value of ``fitness`` ranks it. If that is a mean over mission seeds, the mean
    violations of each chosen goal follow. ``fault_ticks`` sums the active ticks of all faults.
    """

    index: int
    generation: int
    outcome: Outcome
    fitness: tuple[float, ...]
    fault_ticks: int


@dataclass(frozen=True, slots=True)
class Evaluation(Flown):
    """A fault specification, and the result of its evaluation."""

    specification: Specification


@dataclass(frozen=True, slots=True)
class Generation:
    """A finished generation."""

    index: int
    statistics: Mapping[str, float]  # n_evaluations; mean, std, min, max of the fitness
    population: tuple[int, ...]  # evaluation index of each individual
    random_state: str  # of the search's random generator after it, as JSON text
    state: str = field(default="", compare=False)  # of the search before it; mostly left out


@dataclass(frozen=True, slots=True)
class FailedEvaluation:
    """A specification whose evaluation raised an error in the mission's code."""

    number: int  # of the specifications that the search asked for, from 0, failed or not
    generation: int
    specification: Specification
    traceback: str


@dataclass(frozen=True, slots=True)
class RecordedFlight:
    """The result of a specification with one mission seed."""

    mission_seed: int
    specification: Specification
    found: Evaluated

    def row(self) -> tuple[int, str, str]:
        """Return it as it is stored: mission seed, specification, result."""
        found: object = self.found.traceback if isinstance(self.found, FailedFlight) else None
        if isinstance(self.found, Outcome):
            values = {name: getattr(self.found, name) for name in database.OUTCOME}
            found = {name: each for name, each in values.items() if each is not None}
        text = database.specification_text(self.specification)
        return int(self.mission_seed), text, database.canonical([found])

    @classmethod
    def from_row(cls, row: tuple[int, str, str]) -> Self:
        """Return the flight of such a row; ``ValueError`` or ``TypeError`` if it is invalid."""
        seed, specification_text, text = row
        faults, (found, *rest) = database.lists([specification_text, text])
        specification = database.specification(faults)
        if isinstance(found, str) and not rest:
            return cls(int(seed), specification, FailedFlight(found))
        least, most = {*database.COUNTS, "digest"}, {*database.OUTCOME}
        if rest or not isinstance(found, dict) or not least <= {*found} <= most:
            raise ValueError(f"found {text[:60]}; expected the outcome of a flight, or an error")
        return cls(int(seed), specification, _outcome(*map(found.get, database.OUTCOME)))


@dataclass(frozen=True, slots=True)
class FlightElsewhere:
    """A flight in another world than the campaign's, and how many seconds it took.

    ``world`` is how the world is reached; ``since`` has the first tick from which on each goal, by
    a measure, is broken.
    """

    world: str
    flown: RecordedFlight
    since: Mapping[tuple[str, str], int]
    seconds: float

    @classmethod
    def from_row(cls, row: tuple[Any, ...]) -> Self:
        """Return the flight of a row; ``ValueError`` or ``TypeError`` if it is invalid."""
        _, world, text, seconds, *flown = row
        (rows,) = database.lists([text])
        since = {(str(goal), str(kind)): int(tick) for goal, kind, tick in rows}
        return cls(str(world), RecordedFlight.from_row((*flown,)), since, float(seconds))


class CampaignStore(AbstractContextManager["CampaignStore"]):
    """Read and extend one campaign; use ``create`` or ``open``, and close it."""

    def __init__(self, path: Path, connection: Connection) -> None:
        self.path = path
        self._connection = connection
        rows = dict(self._select("SELECT key, value FROM meta"))
        settings = self._decoded(database.object_from_text, rows.get("settings"))
        try:
            self.settings = CampaignSettings.from_json(settings, str(path.parent))
        except UsageError as error:
            raise RecordError(database.damaged(path, str(error))) from error
        manifest = self._decoded(database.object_from_text, rows.get("manifest"))
        self.manifest = Manifest.from_json(manifest)
        columns = self._select("PRAGMA table_info(evaluation)")
        self._columns = frozenset(name for _, name, *_ in columns)

    @classmethod
    def create(cls, folder: Path, settings: CampaignSettings, manifest: Manifest) -> Self:
        """Start the store of a new campaign in a folder, which is made if it is missing."""
        meta = {
            "settings": database.canonical(settings.as_json()),
            "manifest": database.canonical(manifest.as_json()),
        }
        database.create(CampaignFolder(folder).database, meta)
        return cls.open(folder)

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Open a campaign, finished or interrupted, also while it is still running."""
        path = CampaignFolder(folder).database
        connection = database.open_existing(path)
        with database.closed_on_error(connection):
            return cls(path, connection)

    def require_flyable(self) -> None:
        """Refuse to fly a campaign of other semantics, because results would differ."""
        found, release = self.manifest.semantics, self.manifest.versions.get("mrsfi")
        if found != SEMANTICS:
            folder = self.path.parent
            raise RecordError(
                f"{folder}: {difference(found)}; fly the campaign with mrsfi {release}, "
                f"read it with `mrsfi report {folder}`, or begin a new one"
            )

    def require_repeatable(self) -> None:
        """Refuse to repeat a search by other rules of ``cover``, which would ask for others."""
        found, release = self.manifest.cover, self.manifest.versions.get("mrsfi")
        if self.settings.algorithm == COVERING and found != COVER:
            raise RecordError(
                f"{self.path.parent}: found a search by version {found} of `{COVERING}`; this "
                f"mrsfi has version {COVER}, which does not repeat it; continue and read the "
                f"campaign with mrsfi {release}, or begin a new one"
            )

    @property
    def has_depths(self) -> bool:
        """Whether margins say how far goals were beyond their limits at worst."""
        return self.manifest.semantics >= _DEEP

    def close(self) -> None:
        """Close the file; everything appended stays."""
        self._connection.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def append(
        self,
        evaluations: Iterable[Evaluation] = (),
        failures: Iterable[FailedEvaluation] = (),
        generations: Sequence[Generation] = (),
    ) -> None:
        """Store all in one transaction; nothing if an index does not follow those stored."""
        text, faults = database.canonical, database.specification_text
        rows = {
            "evaluation": [_row(evaluation) for evaluation in evaluations],
            "failure": [
                (int(each.number), int(each.generation), faults(each.specification), each.traceback)
                for each in failures
            ],
            "generation": [
                (each.index, text(each.statistics), text(each.population), each.random_state)
                for each in generations
            ],
        }
        with database.transaction(self.path, self._connection) as connection:
            for table, new in rows.items():
                next_index = self._next(table)
                for index, row in enumerate(new, next_index):
                    if table != "failure" and row[0] != index:
                        raise ValueError(f"found {table} {row[0]}; expected {index} next")
                if new:
                    if table == "evaluation":
                        self._columns = database.completed(connection, self._columns)
                    connection.executemany(database.inserting(table, len(new[0])), new)
            states = [("state", each.state) for each in generations if each.state]
            connection.executemany(_KEEP, states)

    @property
    def n_evaluations(self) -> int:
        """How many evaluations are stored."""
        return self._next("evaluation")

    def evaluations(
        self, first: int = 0, n_most: int | None = None, step: int = 1
    ) -> Iterator[Evaluation]:
        """Yield evaluations in index order: all, or at most ``n_most`` from ``first`` on.

        Of these, every ``step``-th.
        """
        end = self.n_evaluations if n_most is None else first + n_most
        for rows in self._batches(self._from_evaluations(), range(first, end, step)):
            for row in rows:
                yield self._decoded(_evaluation, row)

    def fault_sets(self) -> Iterator[frozenset[str]]:
        """Yield the pool faults of each evaluation, in index order."""
        for texts in self.stored(("specification",), self.n_evaluations, itemgetter(0)):
            yield from (frozenset(self._decoded(database.fault_texts, each)[0]) for each in texts)

    def flown(self, step: int) -> Iterator[Flown]:
        """Yield results in index order: of evaluation 0, and of every ``step``-th after it."""
        query = self._from_evaluations(database.EVALUATION[:-1])
        for rows in self._batches(query, range(0, self.n_evaluations, step)):
            for row in rows:
                yield self._decoded(lambda row: Flown(*_flown(row)), row)

    def stored(
        self, columns: Sequence[str], n: int, decode: Callable[[Sequence[Sequence[Any]]], T]
    ) -> Iterator[T]:
        """Yield columns of the first ``n`` evaluations, decoded, thousands at a time."""
        n_read = 0
        for rows in self._batches(self._from_evaluations(columns), range(n)):
            n_expected = min(_BATCH, n - n_read)
            if len(rows) != n_expected:
                found = f"{len(rows)} evaluations from {n_read} on"
                raise RecordError(database.damaged(self.path, f"{found} in place of {n_expected}"))
            n_read += n_expected
            yield self._decoded(decode, list(zip(*rows, strict=True)))

    def margins(self) -> Iterator[tuple[int, list[int], tuple[Margin | None, ...]]]:
        """Yield evaluations with true violations and margins by goal, where these are recorded."""
        query = self._from_evaluations(("idx", "true", "margins"))
        for rows in self._batches(query, range(self.n_evaluations)):
            known = [row for row in rows if row[2] is not None]
            texts = [text for _, *both in known for text in both]
            lists = self._decoded(database.lists, texts)
            for (index, *_), true, each in zip(known, lists[::2], lists[1::2], strict=True):
                margins = self._decoded(database.margins, each)
                yield index, true, margins or ()

    def evaluation(self, index: int) -> Evaluation:
        """Return one evaluation."""
        rows = self._select(f"{self._from_evaluations()} WHERE idx = ?", (int(index),))
        if not rows:
            n_found = self.n_evaluations
            range_ = f"expected 0 to {n_found - 1}" if n_found else "none is recorded yet"
            raise RecordError(f"{self.path}: found no evaluation {index}; {range_}")
        return self._decoded(_evaluation, rows[0])

    def generations(self) -> Iterator[Generation]:
        """Yield all finished generations in order."""
        n = 256  # are read at once: the state of a random generator is a long text
        for first in range(0, self.n_generations, n):
            query = "SELECT * FROM generation WHERE idx >= ? AND idx < ? ORDER BY idx"
            for row in self._select(query, (first, first + n)):
                yield self._decoded(_generation, row)

    def populated(self) -> tuple[int, ...]:
        """Return the indexes of the finished generations that have a population."""
        rows = self._select("SELECT idx FROM generation WHERE population <> '[]' ORDER BY idx")
        return tuple(index for (index,) in rows)

    def generation(self, index: int) -> Generation | None:
        """Return one finished generation; ``None`` if it is not finished."""
        rows = self._select("SELECT * FROM generation WHERE idx = ?", (int(index),))
        return self._decoded(_generation, rows[0]) if rows else None

    @property
    def n_generations(self) -> int:
        """How many finished generations are stored."""
        return self._next("generation")

    @property
    def n_failures(self) -> int:
        """How many failed evaluations are stored."""
        return int(self._select("SELECT count(*) FROM failure")[0][0])

    def next_indexes(self) -> tuple[int, int, int]:
        """Undo an interrupted append; return the next indexes, for failures the next number."""
        if self._connection.in_transaction:
            self._connection.rollback()
        return self._next("evaluation"), self._next("failure"), self._next("generation")

    def failures(self) -> tuple[FailedEvaluation, ...]:
        """Return the failed evaluations in the order in which they were asked for."""
        rows = self._select("SELECT * FROM failure ORDER BY idx")
        return tuple(self._decoded(_failure, row) for row in rows)

    def kept(self, key: str, decode: Callable[[str], T]) -> T | None:
        """Return the text that is stored under a key, decoded; ``None`` if there is none."""
        rows = self._select("SELECT value FROM meta WHERE key = ?", (key,))
        return self._decoded(decode, rows[0][0]) if rows else None

    def keep(self, key: str, text: str) -> None:
        """Store a text under a key, in place of an earlier one."""
        with database.transaction(self.path, self._connection) as connection:
            connection.execute(_KEEP, (key, text))

    def record_difference(self, text: str) -> None:
        """Record how two flights of one specification differed, or an empty text."""
        engine = replace(self.manifest.engine, unrepeated=text)
        self.manifest = replace(self.manifest, engine=engine)
        self.keep("manifest", database.canonical(self.manifest.as_json()))

    @property
    def n_flights(self) -> int:
        """How many flights after the search are stored."""
        return self._next("flight")

    def flights(self) -> tuple[RecordedFlight, ...]:
        """Return the flights after the search, in order."""
        rows = self._select("SELECT mission_seed, specification, found FROM flight ORDER BY idx")
        return tuple(self._decoded(RecordedFlight.from_row, row) for row in rows)

    def flown_with(self, sets: Collection[frozenset[str]]) -> Iterator[RecordedFlight]:
        """Yield all evaluations of exactly one of the sets, or of no fault."""
        for index, faults in enumerate(self.fault_sets()):
            if faults in sets or not faults:
                each = self.evaluation(index)
                yield RecordedFlight(self.settings.mission_seed, each.specification, each.outcome)

    def append_flights(self, flights: Iterable[RecordedFlight]) -> None:
        """Store flights after the search, in one transaction."""
        rows = [(None, *flight.row()) for flight in flights]
        with database.transaction(self.path, self._connection) as connection:
            connection.executemany("INSERT INTO flight VALUES (?, ?, ?, ?)", rows)

    def flights_elsewhere(self) -> tuple[FlightElsewhere, ...]:
        """Return the flights in other worlds, in order."""
        if not self._select("SELECT 1 FROM sqlite_master WHERE name = 'elsewhere'"):
            return ()
        return tuple(self._decoded(FlightElsewhere.from_row, row) for row in self.rows("elsewhere"))

    def append_elsewhere(self, flight: FlightElsewhere) -> None:
        """Store a flight in another world."""
        since = database.canonical([[*broken, tick] for broken, tick in flight.since.items()])
        row = None, flight.world, since, float(flight.seconds), *flight.flown.row()
        with database.transaction(self.path, self._connection) as connection:
            connection.execute(database.ELSEWHERE)
            connection.execute("INSERT INTO elsewhere VALUES (?, ?, ?, ?, ?, ?, ?)", row)

    def forget_elsewhere(self, world: str) -> None:
        """Remove all flights in a world."""
        with database.transaction(self.path, self._connection) as connection:
            connection.execute(database.ELSEWHERE)
            connection.execute("DELETE FROM elsewhere WHERE world = ?", (world,))

    def rows(self, table: str) -> list[tuple[Any, ...]]:
        """Return all rows of a table, as they are stored."""
        return self._select(f"SELECT * FROM {table} ORDER BY idx")

    def digest(self) -> str:
        """Return SHA-256 over specification, outcome and fitness of all evaluations in order."""
        digest = hashlib.sha256()
        query = self._from_evaluations(("specification", *database.COUNTS, "digest", "fitness"))
        for rows in self._batches(query, range(self.n_evaluations)):
            lines = [*map(database.canonical, rows), ""]
            digest.update("\n".join(lines).encode())
        return digest.hexdigest()

    def _from_evaluations(self, columns: Sequence[str] = database.EVALUATION) -> str:
        """Return the query for columns of all evaluations."""
        return f"SELECT {database.quoted(columns, self._columns)} FROM evaluation"

    def _next(self, table: str) -> int:
        """Return the next index, which is the number of rows, because indexes have no gaps."""
        return int(self._select(f"SELECT coalesce(max(idx) + 1, 0) FROM {table}")[0][0])

    def _batches(self, query: str, indexes: range) -> Iterator[list[tuple[Any, ...]]]:
        """Yield rows of some thousand evaluations at a time, without a lock in between."""
        for first in range(indexes.start, indexes.stop, _BATCH * indexes.step):
            end = min(first + _BATCH * indexes.step, indexes.stop)
            where = "WHERE idx >= ? AND idx < ? AND (idx - ?) % ? = 0 ORDER BY idx"
            yield self._select(f"{query} {where}", (first, end, first, indexes.step))

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
    counts = (getattr(outcome, name) for name in database.COUNTS)
    beside = outcome.margins, outcome.detection, outcome.repetition
    numbers = [*map(float, evaluation.fitness)], *counts
    fitness, *found = map(database.canonical, numbers)
    return (
        int(evaluation.index),
        int(evaluation.generation),
        fitness,
        int(evaluation.fault_ticks),
        *found,
        outcome.digest,
        *(database.canonical(each) if each else None for each in beside),
        database.specification_text(evaluation.specification),
    )


def _evaluation(row: Sequence[Any]) -> Evaluation:
    *flown, text = row
    (specification,) = database.lists([text])
    return Evaluation(*_flown(flown), database.specification(specification))


def _flown(row: Sequence[Any]) -> tuple[int, int, Outcome, tuple[float, ...], int]:
    index, generation, fitness_text, fault_ticks, *texts, digest, margins, detection, repetition = (
        row
    )
    texts += [each or "[]" for each in (margins, detection, repetition)]
    fitness, *counts, margins, detection, repetition = database.lists([fitness_text, *texts])
    outcome = _outcome(*counts, digest, margins, detection, repetition)
    return index, generation, outcome, tuple(map(float, fitness)), fault_ticks


def _generation(row: tuple[Any, ...]) -> Generation:
    index, statistics, population, random_state = row
    (individuals,) = database.integers(database.lists([population]))
    return Generation(index, database.object_from_text(statistics), individuals, random_state)


def _failure(row: tuple[Any, ...]) -> FailedEvaluation:
    number, generation, text, traceback = row
    (specification,) = database.lists([text])
    return FailedEvaluation(number, generation, database.specification(specification), traceback)


def _outcome(*found: Any) -> Outcome:
    """Return an outcome from its stored fields; those after the digest may be missing."""
    *counts, digest, margins, late, repetition = found
    detection = tuple((n, n_late) for n, n_late in database.integers(late or ())) or None
    named: dict[str, Any] = dict(zip(database.COUNTS, database.integers(counts), strict=True))
    return Outcome(
        **named,
        digest=digest,
        margins=database.margins(margins),
        detection=detection,
        repetition=_repetition(*repetition) if repetition else None,
    )


def _repetition(n_flights: int, n_late: int, broken: Sequence[int]) -> Repetition:
    (n_flights, n_late), goals = database.integers([(n_flights, n_late), broken])
    return Repetition(n_flights, n_late, goals)


@dataclass(frozen=True, slots=True)
class Measure:
    """The violations that a campaign counts, one ``kind`` of ``COUNTED``.

    The record has means over ``n_seeds`` mission seeds, of the ``chosen`` goals in this order;
    with one seed it has counts, in the order of ``goals``. ``minimised`` is the one of ``COSTS``
    that a front minimises while it maximises violations, if any.
    """

    kind: str
    n_seeds: int
    goals: tuple[str, ...]
    chosen: tuple[str, ...]
    duration: int
    minimised: str | None = None

    @classmethod
    def of(cls, settings: CampaignSettings, mission: Mission) -> Self:
        """Return the measure that the settings of a campaign name."""
        goals = mission.goal_ids
        return cls(
            kind=settings.violations,
            n_seeds=settings.replications,
            goals=goals,
            chosen=settings.goals or goals,
            duration=mission.duration,
            minimised=settings.minimise,
        )

    def __str__(self) -> str:
        return f"{self.words}{self.means}"

    @property
    def words(self) -> str:
        """The counted quantity, in words."""
        names = {"missed": "time after failure", "masked": "undetected violations"}
        return names.get(self.kind, f"{self.kind} violations")

    @property
    def means(self) -> str:
        """The suffix of the name of a mean over mission seeds; empty with one seed."""
        return "" if self.n_seeds == 1 else f", mean of {self.n_seeds} mission seeds"

    @property
    def is_shown_by_outcomes(self) -> bool:
        """Whether an outcome's believed and true counts already show it."""
        return self.n_seeds == 1 and self.kind in {"believed", "true"}

    def require(self, goals: Sequence[str]) -> None:
        """Refuse goals that the mission lacks, or whose mean is not recorded: a ``UsageError``."""
        known = [(self.goals, "a goal of the mission:")]
        if self.n_seeds > 1:
            why = "because the record keeps means over mission seeds of these only:"
            known.append((self.chosen, f"a goal of the campaign file, {why}"))
        for names, what in known:
            for goal in goals:
                if goal not in names:
                    raise UsageError(f"found goal '{goal}'; {expected(goal, names, what)}")

    def by_goal(self, evaluation: Evaluation) -> dict[str, float]:
        """Return the violations of each goal that is recorded, by its ID."""
        if self.n_seeds > 1:
            return dict(zip(self.chosen, evaluation.fitness[1:], strict=True))
        return dict(zip(self.goals, getattr(evaluation.outcome, self.kind), strict=True))
