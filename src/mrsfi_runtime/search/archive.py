"""The best of all evaluations of a campaign: hall of fame, Pareto front and logbook.

References
----------
Source paper, section III-D and equation (3).
"""

from collections.abc import Mapping

from deap import tools

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.individuals import GoalVector, Individual


class FrontPoint:
    """A point of the Pareto front.

    Attributes
    ----------
    evaluation
        Index of the first evaluation that reached it.
    fitness
        Its goal vector.
    """

    def __init__(self, evaluation: int, fitness: GoalVector) -> None:
        self.evaluation = evaluation
        self.fitness = fitness


class Archive:
    """What DEAP keeps of a campaign.

    Attributes
    ----------
    hall_of_fame
        The most critical different individuals, best first; ``number`` is their evaluation.
    front
        The ``FrontPoint`` of every goal vector that no other dominates.
    logbook
        Statistics of each generation.
    """

    def __init__(self, n_best: int = 10) -> None:
        self.hall_of_fame = tools.HallOfFame(n_best)
        self.front = tools.ParetoFront()
        self.logbook = tools.Logbook()
        self._offered: set[tuple[float, ...]] = set()

    def add(self, evaluation: int, specification: Specification, score: Score) -> None:
        """Offer an evaluation with its fitness and goal vector.

        A goal vector is offered to the front once: a second one is on it already or was
        dominated, and each offer costs a comparison with the whole front.
        """
        best = self.hall_of_fame
        if len(best) < best.maxsize or score.fitness > best[-1].score.fitness:
            individual = Individual(specification)
            individual.assess(score)
            individual.number = evaluation
            best.update([individual])
        if score.goals not in self._offered:
            self._offered.add(score.goals)
            self.front.update([FrontPoint(evaluation, GoalVector(score.goals))])

    def log(self, generation: int, statistics: Mapping[str, float]) -> None:
        """Enter the statistics of a generation in the logbook."""
        self.logbook.record(generation=generation, **statistics)
