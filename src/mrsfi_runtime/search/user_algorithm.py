"""A search of which a team wrote a part: what it makes must be what may be flown."""

from collections.abc import Sequence
from dataclasses import dataclass

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.algorithms import ALGORITHMS
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import Algorithm, GenerationSummary
from mrsfi_runtime.search.space import SearchSpace
from mrsfi_runtime.search.user_functions import chosen, told_by_line

_OPERATORS = ("algorithm", "crossover_operator", "mutation_operator")


def begin_search(space: SearchSpace, settings: CampaignSettings) -> Algorithm:
    """Begin the search that settings name; check what it makes if a team wrote a part of it."""
    algorithm = chosen(settings, "algorithm", ALGORITHMS)(space, settings)
    written = [name for name in (getattr(settings, key) for key in _OPERATORS) if ":" in name]
    if not written:
        return algorithm
    where = f"{settings.source}: [search] {' or '.join(repr(name) for name in written)}"
    return _UserAlgorithm(algorithm, space, where)


@dataclass(frozen=True, slots=True)
class _UserAlgorithm:
    algorithm: Algorithm
    space: SearchSpace
    where: str

    @property
    def is_finished(self) -> bool:
        with told_by_line(self.where):
            return self.algorithm.is_finished

    def ask(self) -> list[Specification]:
        with told_by_line(self.where):
            asked = self.algorithm.ask()
            return [self.space.require(specification, self.where) for specification in asked]

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        with told_by_line(self.where):
            return self.algorithm.tell(scores)

    def random_state(self) -> str:
        with told_by_line(self.where):
            return self.algorithm.random_state()
