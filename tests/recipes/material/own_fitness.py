"""A fitness function of a team's own."""

from mrsfi_runtime.search.fitness import FitnessInput


def masked(findings: FitnessInput) -> float:
    """Return the ticks at which a goal was violated and nobody knew."""
    return float(sum(findings.outcome.masked))
