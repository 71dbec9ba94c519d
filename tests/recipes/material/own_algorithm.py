"""A search of a team's own: walks on from the newest specification that did no worse."""

import json
from collections.abc import Sequence
from random import Random
from statistics import fmean, pstdev

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import Score
from mrsfi_runtime.search.loop import GenerationSummary
from mrsfi_runtime.search.space import SearchSpace, random_specification


class Walk:
    """Leaves out a fault of the best specification at each step, and begins anew with none."""

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self._space = space
        self._settings = settings
        self._rng = Random(settings.seed)
        self._best: tuple[float, Specification] = (-1.0, ())
        self._asked: list[Specification] = []
        self._n_asked = 0
        self._n_turns = 0

    @property
    def is_finished(self) -> bool:
        """Whether the generations are used up."""
        return self._n_turns > self._settings.generations

    def ask(self) -> list[Specification]:
        """Return as many steps as the population has individuals."""
        self._asked = [self._step() for _ in range(self._settings.population)]
        return self._asked

    def _step(self) -> Specification:
        kept = list(self._best[1])
        if not kept:
            return random_specification(self._space, self._settings.faults, self._rng)
        kept.pop(self._rng.randrange(len(kept)))
        return self._space.ordered(kept)

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Keep the best and say how the generation went."""
        fitness = [score.fitness for score in scores]
        for found in zip(fitness, self._asked, strict=True):
            self._best = found if found[0] >= self._best[0] else self._best
        first, self._n_asked = self._n_asked, self._n_asked + len(fitness)
        self._n_turns += 1
        return GenerationSummary(
            index=self._n_turns - 1,
            statistics={
                "n_evaluations": len(fitness),
                "mean": fmean(fitness),
                "std": pstdev(fitness),
                "min": min(fitness),
                "max": max(fitness),
            },
            population=tuple(range(first, self._n_asked)),
        )

    def random_state(self) -> str:
        """Return the state of the random generator, which a resumed campaign is checked by."""
        return json.dumps(self._rng.getstate())
