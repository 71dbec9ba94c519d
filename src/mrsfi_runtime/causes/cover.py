"""The search ``cover``: all the ways in which goals break, without a fitness, by ``probing``."""

import json
from collections.abc import Mapping, Sequence
from random import Random
from types import MappingProxyType

from mrsfi_runtime.causes.probing import Probing
from mrsfi_runtime.causes.weakness import Known, Yardstick
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search import algorithms
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import AlgorithmFactory, GenerationSummary
from mrsfi_runtime.search.space import SearchSpace


class Cover:
    """The algorithm: see the module; ``known`` is what it has learnt until now.

    It ends after as many evaluations as the settings say, when all bounds are as low as they say,
    or where there is nothing left to try.
    """

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self._space = space
        self._most, self._until = settings.evaluations, settings.until
        self._rng = Random(settings.seed)
        self.known = Known(space.gate.mission)
        self._probing = Probing(space, self.known, settings.faults, self._rng)
        self._yardstick: Yardstick | None = None
        self._n_asked = 0
        self._n_generations = 0
        self._next: list[Specification] = [(), *self._probing.turn()][: self._most]

    @property
    def is_finished(self) -> bool:
        """Whether all evaluations are used up, or all is known."""
        return not self._next

    def ask(self) -> list[Specification]:
        """Return the specifications of the next turn."""
        return self._next

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Learn what they break, and end the turn."""
        for specification, score in zip(self._next, scores, strict=True):
            if not specification and score.outcome is not None:
                self._yardstick = Yardstick.of(self._space.gate.mission, score.outcome)
            broken = self._yardstick.broken(score.outcome) if self._yardstick else frozenset()
            self.known.learn(specification, broken)
        first, self._n_asked = self._n_asked, self._n_asked + len(scores)
        fitness = [score.fitness for score in scores]
        self._n_generations += 1
        left = None if self._most is None else self._most - self._n_asked
        turn = self._probing.turn()[:left]
        bounds = map(self.known.bound, self.known.sets)
        self._next = [] if self._until is not None and max(bounds) <= self._until else turn
        population = range(first, self._n_asked)
        return GenerationSummary.of(self._n_generations - 1, len(scores), fitness, population)

    def random_state(self) -> str:
        """Return the state of the random generator as JSON text."""
        return json.dumps(self._rng.getstate())


def covered(
    space: SearchSpace, settings: CampaignSettings, outcomes: Mapping[Specification, Outcome | None]
) -> Known:
    """Return what a search knew after it was told the outcomes of a record; ``None`` is a failure.

    It may have been ended in the midst of a turn.
    """
    search = Cover(space, settings)
    while not search.is_finished and all(each in outcomes for each in search.ask()):
        search.tell([Score(0.0, (), outcomes[each]) for each in search.ask()])
    return search.known


ALGORITHMS: Mapping[str, AlgorithmFactory] = MappingProxyType(
    {**algorithms.ALGORITHMS, "cover": Cover}
)
"""All algorithms by their name in a campaign file, those of ``ALGORITHM_NAMES``."""
