"""Runs a campaign: an algorithm asks, engines evaluate, and the algorithm receives the fitness.

A recorded result is read, not flown again. It has to match the specification that the search asks
for at that point. A built-in search repeats only what came after its last kept state, at least a
generation. ``run_campaign`` is the loop; ``_Assessment`` scores one generation; ``ResumableRecord``
reads and writes results in the order in which the search asks.

References
----------
Source paper, sections III-D and III-E.
"""

import json
import math
from bisect import bisect_left
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from operator import itemgetter
from time import monotonic
from typing import TypeAlias

from mrsfi_runtime.errors import EvaluationError, RecordError, UsageError, expected
from mrsfi_runtime.fence import importing
from mrsfi_runtime.model.faults import FaultPool, Specification, fault_ticks
from mrsfi_runtime.model.mission import Evaluated, Mission, Outcome
from mrsfi_runtime.project_file import installed_version
from mrsfi_runtime.record.database import CampaignFolder, object_from_text, specification_text
from mrsfi_runtime.record.settings import MINIMISING, CampaignSettings
from mrsfi_runtime.record.store import CampaignStore, Evaluation, FailedEvaluation, Generation
from mrsfi_runtime.search import loop
from mrsfi_runtime.search.algorithms import ALGORITHMS, begin_search
from mrsfi_runtime.search.fitness import FITNESS_FUNCTIONS, Judge, Score, averaged, chosen
from mrsfi_runtime.search.space import CROSSOVERS, SearchSpace

WORST_FITNESS = 0.0
"""Fitness of a specification whose evaluation ended with an error, as of one without violations."""

Result: TypeAlias = Evaluation | FailedEvaluation
"""The result of one specification that the search asked for."""

EvaluateMany: TypeAlias = Callable[[Sequence[Specification]], Iterable[Evaluated]]
"""Evaluates fault specifications: one result each, in the same order, if possible at once."""


@dataclass(frozen=True, slots=True)
class CampaignProgress:
    """Progress of a campaign after a generation, whose index counts from 0.

    ``best`` is the highest fitness so far, ``mean`` the mean of this generation. Evaluations that
    end with an error are failures, and not counted in ``n_evaluations``.
    """

    generation: int
    best: float
    mean: float
    n_evaluations: int
    n_failures: int


def require_settings(
    settings: CampaignSettings,
    mission: Mission,
    algorithms: Mapping[str, loop.AlgorithmFactory] = ALGORITHMS,
) -> None:
    """Refuse settings that name an unknown function, goal or element."""
    tables: dict[str, Mapping[str, object]] = {
        "algorithm": algorithms,
        "selection": loop.SELECTIONS,
        "crossover_operator": CROSSOVERS,
        "mutation_operator": loop.MUTATIONS,
        "fitness": FITNESS_FUNCTIONS,
    }
    for key, table in tables.items():
        chosen(settings, key, table)
    if settings.minimise and settings.algorithm in algorithms.keys() - MINIMISING:
        raise UsageError(
            f"{settings.where('minimise')}: found '{settings.minimise}' with algorithm "
            f"'{settings.algorithm}', which uses only the fitness; expected algorithm "
            f"{' or '.join(map(repr, MINIMISING))}, or no minimise"
        )
    for key, known in (("goals", mission.goal_ids), ("protect", mission.elements)):
        for each in getattr(settings, key):
            if each not in known:
                wanted = expected(each, known)
                raise UsageError(f"{settings.where(key)}: found '{each}'; {wanted}")


def run_campaign(  # noqa: PLR0913 - four of them have a default
    settings: CampaignSettings,
    mission: Mission,
    pool: FaultPool,
    evaluate_many: EvaluateMany,
    store: CampaignStore,
    on_generation: Callable[[CampaignProgress], None] = lambda _: None,
    *,
    replicas: Sequence[EvaluateMany] = (),
    algorithms: Mapping[str, loop.AlgorithmFactory] = ALGORITHMS,
    clock: Callable[[], float] = monotonic,
    state_every: int = 1000,
) -> None:
    """Run a search to its end, and record each evaluation that is not recorded yet.

    Only a killed process loses evaluations: those that ``ResumableRecord.keep`` had not written
    yet. Each replica evaluates with another mission seed, at most 100 specifications at once. The
    state of the search is kept every ``state_every`` specifications.
    """
    with importing(CampaignFolder(store.path.parent).generated):
        require_settings(settings, mission, algorithms)
        algorithm = begin_search(SearchSpace.of(mission, pool), settings, algorithms)
        judge = Judge(settings, mission)
    record = ResumableRecord(store, settings.source, clock)
    evaluators = (evaluate_many, *replicas)
    assessment = _Assessment(settings, mission.duration, judge, evaluators, record, state_every)
    index = assessment.restore(algorithm)
    try:
        while not algorithm.is_finished:
            state = assessment.state(algorithm)
            summary = algorithm.tell(assessment.scores_of(algorithm.ask(), index))
            generation = Generation(
                index=summary.index,
                statistics=summary.statistics,
                population=assessment.evaluation_indexes(summary),
                random_state=algorithm.random_state(),
                state=state,
            )
            if not record.has(generation):
                record.keep(generation)
                on_generation(assessment.progress(summary))
            index += 1
    finally:
        try:
            record.write()
        except KeyboardInterrupt:  # a second Ctrl-C loses nothing either
            record.write()
            raise


@dataclass
class _Assessment:
    """Scores specifications, from the record or by evaluation, and counts evaluations."""

    _settings: CampaignSettings
    _duration: int
    _judge: Judge
    _evaluators: Sequence[EvaluateMany]
    _record: "ResumableRecord"
    _state_every: int
    _n_asked: int = 0
    _n_kept: int = 0  # of these, before the last kept state
    _n_evaluations: int = 0
    _best: float = WORST_FITNESS

    def state(self, algorithm: loop.Algorithm) -> str:
        """Return what ``restore`` needs to go on from here, if it is time to keep that."""
        n_new = self._n_asked - self._n_kept
        if n_new < self._state_every or not isinstance(algorithm, loop.GenerationalLoop):
            return ""
        self._n_kept = self._n_asked
        state = {"best": self._best, "versions": self._record.versions} | algorithm.state()
        return json.dumps(state)

    def restore(self, algorithm: loop.Algorithm) -> int:
        """Let a search go on from its last state; return the index of its next generation."""
        record = self._record
        state = record.store.kept("state", object_from_text) or {}
        is_usable = state.get("versions") == record.versions
        if not is_usable or not isinstance(algorithm, loop.GenerationalLoop):
            return 0
        try:
            self._best, (self._n_asked, index, _) = state["best"], state["counts"]
            self._n_kept, self._n_evaluations = self._n_asked, record.n_evaluated(self._n_asked)
            self._individual(self._n_asked - 1)  # all of them are recorded
            algorithm.restore(state, cache(self._individual), record.asked(self._n_asked))
        except (ArithmeticError, LookupError, RecordError, TypeError, ValueError) as error:
            raise RecordError(record.mismatch("the kept state of the search")) from error
        return int(index)

    def scores_of(self, specifications: Sequence[Specification], generation: int) -> list[Score]:
        scores: list[Score] = []
        n = 100  # specifications per call; failures are counted after each
        for first in range(0, len(specifications), n):
            chunk = specifications[first : first + n]
            n_failures = self._n_failures
            with closing(self._results(chunk, generation)) as results:
                scores += [self._counted(result) for result in results]
            n_most = self._settings.max_failures
            if self._n_failures > n_failures and self._n_failures >= n_most:
                last = [*self._record.failures.values()][self._n_failures - 1].traceback
                reason = last.rstrip().rpartition("\n")[2].partition(": ")[2]
                raise EvaluationError(
                    f"{self._n_failures} evaluations ended with an error; max_failures is "
                    f"{n_most}. All tracebacks are recorded; the last error: {reason}"
                )
        return scores

    def _results(
        self, specifications: Sequence[Specification], generation: int
    ) -> Generator[Result, None, None]:
        """Yield the recorded results of a chunk, then evaluate and record the rest."""
        number = self._n_asked
        recorded = self._record.recorded(number, self._n_evaluations, specifications, generation)
        for place, result in enumerate(recorded, number):
            self._require_same_score(result, place)
            yield result
        rest = specifications[len(recorded) :]
        if not rest:
            return
        flown = zip(*(evaluate(rest) for evaluate in self._evaluators), strict=True)
        for specification, evaluated in zip(rest, flown, strict=True):
            result = self._result(specification, evaluated, generation)
            yield result
            self._record.keep(result)

    def _result(
        self, specification: Specification, evaluated: Sequence[Evaluated], generation: int
    ) -> Result:
        outcomes = [each for each in evaluated if isinstance(each, Outcome)]
        for each in evaluated:
            if not isinstance(each, Outcome):
                return FailedEvaluation(self._n_asked, generation, specification, each.traceback)
        score = averaged([self._judge.score(each, specification) for each in outcomes])
        means = () if len(outcomes) == 1 else score.goals  # a single outcome has them already
        return Evaluation(
            index=self._n_evaluations,
            generation=generation,
            specification=specification,
            outcome=outcomes[0],
            fitness=(score.fitness, *means),
            fault_ticks=fault_ticks(specification, self._duration),
        )

    def _require_same_score(self, result: Result, place: int) -> None:
        """Refuse a record that another fitness function wrote."""
        if isinstance(result, FailedEvaluation) or len(self._evaluators) > 1:
            return  # of a mean, the record has only the first outcome
        score = self._judge.score(result.outcome, result.specification)
        if (score.fitness,) != result.fitness:
            raise RecordError(self._record.mismatch(f"the fitness of specification {place}"))

    def _counted(self, result: Result) -> Score:
        score, self._n_asked = self._score(result), self._n_asked + 1
        if isinstance(result, Evaluation):
            self._n_evaluations += 1
            self._best = score.fitness if result.index == 0 else max(self._best, score.fitness)
        return score

    def _score(self, result: Result) -> Score:
        if isinstance(result, FailedEvaluation):
            return Score(WORST_FITNESS, (0.0,) * self._judge.n_goals)
        fitness, *means = result.fitness
        return Score(fitness, tuple(means) or self._judge.goals(result.outcome), result.outcome)

    def _individual(self, number: int) -> loop.Individual:
        """Return a specification that was asked for, with its recorded score."""
        record = self._record
        result = record.failures.get(number) or record.store.evaluation(record.n_evaluated(number))
        return loop.Individual(result.specification, self._score(result), number)

    @property
    def _n_failures(self) -> int:
        return self._n_asked - self._n_evaluations

    def evaluation_indexes(self, summary: loop.GenerationSummary) -> tuple[int, ...]:
        """Return the index of each individual's evaluation, without those that failed."""
        flown = (each for each in summary.population if each not in self._record.failures)
        return tuple(map(self._record.n_evaluated, flown))

    def progress(self, summary: loop.GenerationSummary) -> CampaignProgress:
        return CampaignProgress(
            generation=summary.index,
            best=self._best,
            mean=summary.statistics["mean"],
            n_evaluations=self._n_evaluations,
            n_failures=self._n_failures,
        )


class ResumableRecord:
    """The record of a campaign, in the order in which its search asks."""

    def __init__(self, store: CampaignStore, source: str, clock: Callable[[], float]) -> None:
        self.store = store
        self._source = source
        self._clock = clock
        self._due = -math.inf  # when the next write may come
        self._pending: list[Result | Generation] = []
        self.failures = {failure.number: failure for failure in store.failures()}
        self.versions = {name: installed_version(name) for name in store.manifest.versions}
        self._n_recorded = store.n_evaluations + len(self.failures)

    def n_evaluated(self, number: int) -> int:
        """Return how many specifications before a number were evaluated without error."""
        return number - bisect_left([*self.failures], number)

    def asked(self, number: int) -> Iterator[str]:
        """Yield the texts of all specifications before a number."""
        columns, n_evaluated = ("specification",), self.n_evaluated(number)
        for texts in self.store.stored(columns, n_evaluated, itemgetter(0)):
            yield from texts
        failed = (each for each in self.failures.values() if each.number < number)
        yield from (specification_text(each.specification) for each in failed)

    def recorded(
        self, number: int, index: int, specifications: Sequence[Specification], generation: int
    ) -> list[Result]:
        """Return the results of specifications that are already recorded, the first ones or none.

        ``number`` were asked for before these; ``index`` of those were evaluated without error.
        """
        n_known = max(0, min(len(specifications), self._n_recorded - number))
        evaluations = iter([*self.store.evaluations(index, n_known)])
        results: list[Result] = []
        for place, asked in enumerate(specifications[:n_known], number):
            result = self.failures.get(place) or next(evaluations, None)
            if result is None or (result.specification, result.generation) != (asked, generation):
                raise RecordError(self.mismatch(f"specification {place} of the search"))
            results.append(result)
        return results

    def has(self, generation: Generation) -> bool:
        """Return whether a generation is recorded; refuse another one in its place."""
        recorded = self.store.generation(generation.index)
        if recorded is not None and recorded != generation:
            raise RecordError(self.mismatch(f"generation {generation.index}"))
        return recorded is not None

    def mismatch(self, place: str) -> str:
        """Return the message for a record that differs from the search at a place."""
        return (
            f"{self._source}: the search does not repeat its record: {place} differs; expected the "
            "same settings, models and code, and the same versions of mrsfi, Python and DEAP; "
            "resume with the versions in the record (manifest in campaign.sqlite), or begin a new "
            "campaign"
        )

    def keep(self, result: Result | Generation) -> None:
        """Write a new result or a finished generation, at once or with later ones.

        It waits only if writing would take more than a 20th of the time. At most a thousand wait;
        a killed process loses them.
        """
        self._pending.append(result)
        if isinstance(result, FailedEvaluation):
            self.failures[result.number] = result
        begin = self._clock()
        if begin >= self._due or len(self._pending) >= 1000:
            self.write()
            end = self._clock()
            self._due = end + 20 * (end - begin)

    def write(self) -> None:
        """Write all that wait, except those that an interrupted write has already stored."""
        if self._pending:
            kept = self._pending
            evaluation, failure, generation = self.store.next_indexes()
            self.store.append(
                [e for e in kept if isinstance(e, Evaluation) and e.index >= evaluation],
                [e for e in kept if isinstance(e, FailedEvaluation) and e.number >= failure],
                [e for e in kept if isinstance(e, Generation) and e.index >= generation],
            )
            kept.clear()
