"""The faults that a specification's violations are due to, and how they come to break goals."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import NamedTuple

from mrsfi_runtime.causes.cause_set import Places, Question, chosen, floor
from mrsfi_runtime.causes.chain import Chain, chains, sentence
from mrsfi_runtime.causes.counts import ALL_OR_NONE, Column, Counts, Flights
from mrsfi_runtime.engine.flights import Engine
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Outcome
from mrsfi_runtime.record.observers import NamedFault
from mrsfi_runtime.record.settings import following

N_SEEDS = 20
"""Mission seeds in which a cause set is flown, from its own on."""


class Robustness(NamedTuple):
    """What a count is in several mission seeds, and in how many of them above 0."""

    median: float
    least: int
    most: int
    n_violated: int


@dataclass(frozen=True, slots=True)
class Cause:
    """What a specification's violations are due to.

    ``places`` are the cause set: the faults without which the violations would not be. ``counts``
    are under all faults, ``fault_free`` under none, ``kept`` under the set, all by ``columns``. Of
    the set are ``outcome`` and ``chains``, in the first mission seed, and ``robustness``, in
    ``N_SEEDS`` of them.
    """

    specification: Specification
    columns: tuple[Column, ...]
    counts: Counts
    fault_free: Counts
    places: Places
    kept: Counts
    outcome: Outcome
    chains: tuple[Chain, ...]
    robustness: tuple[Robustness, ...]

    @property
    def faults(self) -> Specification:
        """The cause set as a specification."""
        return chosen(self.specification, self.places)

    def sentences(self, faults: Sequence[NamedFault]) -> tuple[str, ...]:
        """Return what each fault of it did, in words; ``faults`` are all of the specification."""
        told = zip(self.places, self.chains, strict=True)
        return tuple(sentence(faults[place], chain) for place, chain in told)


def find_cause(
    flights: Flights, engine: Engine, specification: Specification, keep: float
) -> Cause | None:
    """Find out what a specification's violations are due to; ``None`` if there are none.

    An engine records what has to be looked at, in the first of the mission seeds. A cause set keeps
    a share of every count, above 0, at most 1. If the mission's own code fails, that is an
    ``EvaluationError``.
    """
    with flights.on(ALL_OR_NONE):
        counts, fault_free = flights.counts(specification), flights.counts(())
    if not any(counts):
        return None
    with flights.on("cause set"):
        columns = range(len(flights.columns))
        places = Question(flights, specification, floor(counts, keep, columns)).minimum()
        cause = chosen(specification, places)
    with flights.on("chains"):
        flights.spend(len(cause) + 1 if cause else 0)
        record = partial(engine.record, seed=flights.mission_seeds[0])
        linked = chains(record, engine.code.mission, cause) if cause else ()
    with flights.on("other mission seeds"):
        seeds = following(flights.mission_seeds[0], N_SEEDS)
        firm = robustness([flights.counts(cause, seed) for seed in seeds])
    return Cause(
        specification=specification,
        columns=flights.columns,
        counts=counts,
        fault_free=fault_free,
        places=places,
        kept=flights.counts(cause),
        outcome=flights.outcome(cause),
        chains=linked,
        robustness=firm,
    )


def robustness(by_seed: Sequence[Counts]) -> tuple[Robustness, ...]:
    """Return what each count is over mission seeds, one entry a column."""
    return tuple(
        Robustness(median(counts), min(counts), max(counts), sum(map(bool, counts)))
        for counts in zip(*by_seed, strict=True)
    )
