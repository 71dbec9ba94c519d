"""Runs a campaign: asks an algorithm, evaluates, records, and tells it the fitness.

References
----------
Source paper, sections III-D and III-E.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from mrsfi_runtime.errors import EvaluationError, UsageError
from mrsfi_runtime.model.faults import FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.campaign import Evaluation, Generation
from mrsfi_runtime.search.algorithms import ALGORITHMS, AlgorithmFactory, GenerationSummary
from mrsfi_runtime.search.archive import Archive
from mrsfi_runtime.search.fitness import FITNESS_FUNCTIONS, FitnessFunction, goal_vector
from mrsfi_runtime.search.selection import SELECTIONS
from mrsfi_runtime.search.settings import CampaignSettings
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.specifications import fault_ticks

WORST_FITNESS = 0.0
"""Fitness of a specification whose evaluation failed; that of one without a violation."""

_CHUNK = 100  # evaluations that are recorded together: what a killed run can lose


class FailedOutcome(Protocol):
    """An evaluation that ended in an error of the mission's own code."""

    @property
    def traceback(self) -> str:
        """What Python said."""


EvaluateMany: TypeAlias = Callable[[Sequence[Specification]], Sequence[Outcome | FailedOutcome]]
"""Evaluates fault specifications; one result each, in the same order."""


class Recorder(Protocol):
    """Keeps what a campaign finds, as ``CampaignStore`` does."""

    def append(self, evaluations: Sequence[Evaluation]) -> None:
        """Keep evaluations, all or none."""

    def add_failure(self, specification: Specification, generation: int, traceback: str) -> None:
        """Keep a specification whose evaluation failed."""

    def close_generation(self, generation: Generation) -> None:
        """Keep a finished generation."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a campaign is, after a generation.

    Attributes
    ----------
    generation
        Index of the generation just closed, from 0.
    best
        Highest fitness of the campaign so far.
    mean
        Mean fitness of the generation.
    n_evaluations, n_failures
        Of the campaign so far; failures are not counted as evaluations.
    front_size
        Number of different goal vectors on the Pareto front.
    """

    generation: int
    best: float
    mean: float
    n_evaluations: int
    n_failures: int
    front_size: int


def require_settings(
    settings: CampaignSettings,
    mission: Mission,
    algorithms: Mapping[str, AlgorithmFactory] = ALGORITHMS,
    fitness_functions: Mapping[str, FitnessFunction] = FITNESS_FUNCTIONS,
) -> None:
    """Refuse settings that name what does not exist.

    Raises
    ------
    UsageError
        If the algorithm, the selection, the fitness function or a goal is unknown.
    """
    settings.chosen("algorithm", algorithms)
    settings.chosen("selection", SELECTIONS)
    settings.chosen("fitness", fitness_functions)
    for goal in settings.goals:
        if goal not in mission.goal_ids:
            known = ", ".join(mission.goal_ids)
            message = (
                f"{settings.source}: [search] goals: found '{goal}'; "
                f"mission '{mission.name}' has {known}"
            )
            raise UsageError(message)


def run_campaign(
    settings: CampaignSettings,
    mission: Mission,
    pool: FaultPool,
    evaluate_many: EvaluateMany,
    store: Recorder,
    on_generation: Callable[[Progress], None] = lambda _: None,
    *,
    algorithms: Mapping[str, AlgorithmFactory] = ALGORITHMS,
    fitness_functions: Mapping[str, FitnessFunction] = FITNESS_FUNCTIONS,
) -> Archive:
    """Run a search to its end and record every evaluation.

    An interrupt (``KeyboardInterrupt``) leaves what was recorded until then.

    Parameters
    ----------
    evaluate_many
        Called with at most 100 specifications, whose results are recorded together.
    store
        Where evaluations, failures and generations go.
    on_generation
        Called after each generation.

    Returns
    -------
    Archive
        The most critical individuals and the Pareto front of all evaluations.

    Raises
    ------
    UsageError
        If the settings name what does not exist.
    EvaluationError
        If ``settings.max_failures`` evaluations failed, or a fitness is not finite.
    """
    require_settings(settings, mission, algorithms, fitness_functions)
    algorithm = settings.chosen("algorithm", algorithms)(SearchSpace.of(mission, pool), settings)
    fitness = settings.chosen("fitness", fitness_functions)
    assessment = _Assessment(settings, mission, fitness, evaluate_many, store)
    generation = 0
    while not algorithm.is_finished:
        specifications = algorithm.ask()
        summary = algorithm.tell(assessment.fitness_of(specifications, generation))
        store.close_generation(
            Generation(
                index=summary.index,
                statistics=summary.statistics,
                population=assessment.evaluation_indexes(summary),
                random_state=algorithm.random_state(),
            )
        )
        on_generation(assessment.progress(summary))
        generation += 1
    return assessment.archive


class _Assessment:
    """Evaluates and records specifications, and counts."""

    def __init__(
        self,
        settings: CampaignSettings,
        mission: Mission,
        fitness: FitnessFunction,
        evaluate_many: EvaluateMany,
        store: Recorder,
    ) -> None:
        self.archive = Archive()
        self._settings = settings
        self._duration = mission.duration
        chosen = settings.goals or mission.goal_ids
        self._goals = tuple(mission.goal_ids.index(goal) for goal in chosen)
        self._fitness = fitness
        self._evaluate_many = evaluate_many
        self._store = store
        self._indexes: list[int | None] = []  # evaluation of each specification asked for
        self._n_evaluations = 0

    def fitness_of(self, specifications: Sequence[Specification], generation: int) -> list[float]:
        """Return the fitness of specifications after recording them."""
        fitness: list[float] = []
        for first in range(0, len(specifications), _CHUNK):
            chunk = specifications[first : first + _CHUNK]
            results = self._evaluate_many(chunk)
            fitness += self._recorded(chunk, results, generation)
        return fitness

    def _recorded(
        self,
        specifications: Sequence[Specification],
        results: Sequence[Outcome | FailedOutcome],
        generation: int,
    ) -> list[float]:
        evaluations: list[Evaluation] = []
        failures: list[tuple[Specification, str]] = []
        fitness = []
        for specification, result in zip(specifications, results, strict=True):
            if isinstance(result, Outcome):
                evaluation = self._evaluation(specification, result, generation)
                evaluations.append(evaluation)
                self._indexes.append(evaluation.index)
                fitness.append(evaluation.fitness[0])
            else:
                failures.append((specification, result.traceback))
                self._indexes.append(None)
                fitness.append(WORST_FITNESS)
        self._store.append(evaluations)
        for specification, traceback in failures:
            self._store.add_failure(specification, generation, traceback)
        self._require_few_failures(failures)
        return fitness

    def _evaluation(
        self, specification: Specification, outcome: Outcome, generation: int
    ) -> Evaluation:
        index = self._n_evaluations
        self._n_evaluations += 1
        fitness = self._fitness(outcome, self._goals, self._duration)
        self.archive.add(index, specification, fitness, goal_vector(outcome, self._goals))
        return Evaluation(
            index=index,
            generation=generation,
            specification=specification,
            outcome=outcome,
            fitness=(fitness,),
            fault_ticks=fault_ticks(specification, self._duration),
        )

    def _require_few_failures(self, latest: Sequence[tuple[Specification, str]]) -> None:
        if latest and self._n_failures >= self._settings.max_failures:
            reason = latest[-1][1].rstrip().rpartition("\n")[2].partition(": ")[2]
            message = (
                f"{self._n_failures} evaluations failed; max_failures is "
                f"{self._settings.max_failures}. All are recorded with their tracebacks; "
                f"the last one: {reason}"
            )
            raise EvaluationError(message)

    @property
    def _n_failures(self) -> int:
        return len(self._indexes) - self._n_evaluations

    def evaluation_indexes(self, summary: GenerationSummary) -> tuple[int, ...]:
        """Return the evaluation of each individual; who failed has none and is left out."""
        indexes = (self._indexes[number] for number in summary.population)
        return tuple(index for index in indexes if index is not None)

    def progress(self, summary: GenerationSummary) -> Progress:
        """Return how far the campaign is and enter the generation in the logbook."""
        self.archive.log(summary.index, summary.statistics)
        best = self.archive.hall_of_fame
        return Progress(
            generation=summary.index,
            best=best[0].fitness.values[0] if best else WORST_FITNESS,
            mean=summary.statistics["mean"],
            n_evaluations=self._n_evaluations,
            n_failures=self._n_failures,
            front_size=len(self.archive.front),
        )
