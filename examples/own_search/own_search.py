"""A user-defined fitness function, mutation and search algorithm, named in campaign files.

Run from this folder, or with it on PYTHONPATH::

    mrsfi evolve ../../models/uuv_sampling --case own_parts.toml
    mrsfi evolve ../../models/uuv_sampling --case own_algorithm.toml
"""

import json
from collections.abc import Sequence
from random import Random

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.search.fitness import FitnessInput, Score
from mrsfi_runtime.search.loop import GenerationSummary
from mrsfi_runtime.search.space import SearchSpace, random_specification


def unseen_danger(findings: FitnessInput) -> float:
    """Return the undetected violations of a goal in ticks, and the missing samples."""
    return float(sum(findings.outcome.masked)) + 1000.0 / (1.0 + sum(findings.outcome.samples))


def shorter(
    space: SearchSpace, specification: Specification, rng: Random, share: float
) -> Specification:
    """Cut some windows in half, to find short faults that suffice."""
    return space.ordered(
        timed._replace(finish=(timed.start + timed.finish) // 2) if rng.random() < share else timed
        for timed in specification
    )


class HillClimber:
    """Keeps the best specification and changes one fault of it at a time.

    A search is asked for specifications, told their scores in the same order, and so on until
    it is finished. It must draw from ``settings.seed`` alone, so that a campaign that was
    killed can go on: its record is told to a new search from the beginning.
    """

    def __init__(self, space: SearchSpace, settings: CampaignSettings) -> None:
        self._space = space
        self._settings = settings
        self._rng = Random(settings.seed)
        self._best: tuple[float, int, Specification] | None = None
        self._asked: list[Specification] = []
        self._n_asked = 0
        self._n_turns = 0

    @property
    def is_finished(self) -> bool:
        """Whether the evaluations or the generations are used up."""
        limit = self._settings.evaluations
        if limit is not None:
            return self._n_asked >= limit
        return self._n_turns > self._settings.generations

    def ask(self) -> list[Specification]:
        """Return neighbours of the best so far; at first, random specifications."""
        room = self._settings.population
        if self._settings.evaluations is not None:
            room = min(room, self._settings.evaluations - self._n_asked)
        self._asked = [self._candidate() for _ in range(room)]
        return self._asked

    def _candidate(self) -> Specification:
        if self._best is None:
            return random_specification(self._space, self._settings.faults, self._rng)
        kept = list(self._best[2])
        kept.pop(self._rng.randrange(len(kept)))
        for timed in random_specification(self._space, self._settings.faults, self._rng):
            if not any(self._space.clash(timed, other) for other in kept):
                return self._space.ordered([*kept, timed])
        return self._best[2]

    def tell(self, scores: Sequence[Score]) -> GenerationSummary:
        """Keep the best and return the summary of the generation."""
        numbered = enumerate(zip(scores, self._asked, strict=True), self._n_asked)
        found = [(score.fitness, number, asked) for number, (score, asked) in numbered]
        self._best = max([*found, *([self._best] if self._best else [])], key=lambda one: one[0])
        self._n_asked += len(found)
        self._n_turns += 1
        fitness, number, _ = self._best
        return GenerationSummary(
            index=self._n_turns - 1,
            statistics={
                "n_evaluations": len(found),
                "mean": fitness,
                "std": 0.0,
                "min": fitness,
                "max": fitness,
            },
            population=(number,),
        )

    def random_state(self) -> str:
        """Return the state of the random generator, which a resumed campaign is checked by."""
        return json.dumps(self._rng.getstate())
