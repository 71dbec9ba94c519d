"""Individuals as DEAP sees them: lists of immutable timed faults with a fitness.

The classes are plain ones: ``deap.creator`` would keep them in a global registry.
"""

import math
from random import Random
from typing import Any, ClassVar, Self

from deap import base

from mrsfi_runtime.errors import EvaluationError
from mrsfi_runtime.model.faults import Specification, TimedFault
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.variation import crossed, mutated


class Criticality(base.Fitness):  # type: ignore[misc]  # DEAP has no types
    """How critical a fault specification is; more is more critical."""

    weights: ClassVar[tuple[float, ...]] = (1.0,)


class Individual(list[TimedFault]):
    """A fault specification in evolution, in the order of ``SearchSpace.ordered``.

    Attributes
    ----------
    fitness
        Without a value until the individual is evaluated.
    number
        Which of the specifications that the algorithm asked for, from 0; ``None`` before.
    """

    def __init__(self, specification: Specification) -> None:
        super().__init__(specification)
        self.fitness = Criticality()
        self.number: int | None = None

    @property
    def specification(self) -> Specification:
        """The timed faults as an immutable value."""
        return tuple(self)

    @property
    def is_evaluated(self) -> bool:
        """Whether the fitness is known."""
        return bool(self.fitness.valid)

    def assess(self, fitness: float) -> None:
        """Set the fitness.

        Raises
        ------
        EvaluationError
            If it is not a finite number: DEAP takes NaN for better than everything.
        """
        if not math.isfinite(fitness):
            message = f"the fitness of {self.specification} is {fitness}; expected a finite number"
            raise EvaluationError(message)
        self.fitness.values = (fitness,)

    def become(self, specification: Specification) -> None:
        """Take the timed faults of another; the fitness is lost if they differ."""
        if specification != self.specification:
            self[:] = specification
            del self.fitness.values
            self.number = None

    def clone(self) -> Self:
        """Return a copy that shares the immutable timed faults."""
        copy = type(self)(self.specification)
        copy.fitness.wvalues = self.fitness.wvalues
        copy.number = self.number
        return copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.clone()


def mutate(individual: Individual, space: SearchSpace, rng: Random, share: float) -> None:
    """Mutate in place, as DEAP's operators do."""
    individual.become(mutated(space, individual.specification, rng, share))


def mate(first: Individual, second: Individual, space: SearchSpace, rng: Random) -> None:
    """Exchange faults in place, as DEAP's operators do."""
    for individual, specification in zip(
        (first, second),
        crossed(space, first.specification, second.specification, rng),
        strict=True,
    ):
        individual.become(specification)
