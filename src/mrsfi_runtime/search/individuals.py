"""Individuals as DEAP sees them: lists of immutable timed faults with a fitness.

The classes are plain ones: ``deap.creator`` would keep them in a global registry.
"""

from collections.abc import Sequence
from random import Random
from typing import Any, ClassVar, Self

from deap import base

from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.fitness import Score, require_finite
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.variation import Crossover, Mutation, crossed, mutated


class Criticality(base.Fitness):  # type: ignore[misc]  # DEAP has no types
    """How critical a fault specification is; more is more critical."""

    weights: ClassVar[tuple[float, ...]] = (1.0,)


class GoalVector(base.Fitness):  # type: ignore[misc]  # DEAP has no types
    """Violations of each chosen goal; more is more critical."""

    def __init__(self, violations: Sequence[float] = ()) -> None:
        self.weights = (1.0,) * len(violations)
        super().__init__(violations)


class Individual(list[TimedFault]):
    """A fault specification in evolution, in the order of ``SearchSpace.ordered``.

    Attributes
    ----------
    fitness
        What DEAP compares; without a value until the individual is evaluated.
    score
        What it was told to be, last.
    number
        Which of the specifications that the algorithm asked for, from 0; ``None`` before.
    """

    def __init__(self, specification: Specification) -> None:
        super().__init__(specification)
        self.fitness: base.Fitness = Criticality()
        self.score = Score(0.0, ())
        self.number: int | None = None

    @property
    def specification(self) -> Specification:
        """The timed faults as an immutable value."""
        return tuple(self)

    @property
    def is_evaluated(self) -> bool:
        """Whether the fitness is known."""
        return bool(self.fitness.valid)

    def assess(self, score: Score) -> None:
        """Take the score.

        Raises
        ------
        EvaluationError
            If it is not finite.
        """
        require_finite(self.specification, score)
        self.score = score
        self.fitness = self._compared(score)

    def _compared(self, score: Score) -> base.Fitness:
        return Criticality((score.fitness,))

    def become(self, specification: Specification) -> None:
        """Take the timed faults of another; the fitness is lost if they differ."""
        if specification != self.specification:
            self[:] = specification
            del self.fitness.values
            self.number = None

    def clone(self) -> Self:
        """Return a copy that shares the immutable timed faults."""
        copy = type(self)(self.specification)
        if self.is_evaluated:
            copy.assess(self.score)
        copy.number = self.number
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.clone()


class GoalIndividual(Individual):
    """An individual that DEAP compares by its goal vector."""

    def _compared(self, score: Score) -> base.Fitness:
        return GoalVector(score.goals)


def mutate(
    individual: Individual,
    space: SearchSpace,
    rng: Random,
    share: float,
    operator: Mutation = mutated,
) -> tuple[Individual]:
    """Mutate in place, and return the individual, as DEAP's operators do."""
    individual.become(operator(space, individual.specification, rng, share))
    return (individual,)


def mate(
    first: Individual,
    second: Individual,
    space: SearchSpace,
    rng: Random,
    operator: Crossover = crossed,
) -> tuple[Individual, Individual]:
    """Exchange faults in place, and return both, as DEAP's operators do."""
    one, other = operator(space, first.specification, second.specification, rng)
    first.become(one)
    second.become(other)
    return first, second
