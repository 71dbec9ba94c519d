"""Findings: explained evaluations, those with alike cause sets as one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mrsfi_runtime.causes.cause_set import chosen
from mrsfi_runtime.causes.findings import findings
from mrsfi_runtime.model.faults import FaultPool, Specification, numbered
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.outcome import Outcome
from mrsfi_runtime.record.causes import RecordedCause
from mrsfi_runtime.record.named_faults import NamedFault, named_faults


@dataclass(frozen=True, slots=True)
class Finding:
    """Evaluations with alike causes.

    Attributes
    ----------
    evaluations
        Their indexes, the most critical first: the leader, whose cause stands for all.
    cause
        Cause of the leader.
    outcome
        What flying its cause set finds.
    faults
        Its cause set, named as in written specifications.
    """

    evaluations: tuple[int, ...]
    cause: RecordedCause
    outcome: Outcome
    faults: tuple[NamedFault, ...]

    @property
    def sentence(self) -> str:
        """What the leading fault did, and which faults it needs."""
        leading = self.cause.leading
        others = [fault.name for place, fault in enumerate(self.faults) if place != leading]
        said = self.cause.sentences[leading]
        return f"{said} With it: {' '.join(others)}." if others else said

    def as_json(self, goals: Sequence[str], duration: int) -> dict[str, Any]:
        """Return it as plain values.

        Parameters
        ----------
        goals, duration
            IDs of the mission's goals, and its ticks.
        """
        told = self.outcome.told(duration)
        causes = zip(self.faults, self.cause.sentences, self.cause.chains, strict=True)
        return {
            "evaluations": list(self.evaluations),
            "sentence": self.sentence,
            **{kind: dict(zip(goals, counts, strict=True)) for kind, counts in told.items()},
            "cause_set": [
                {
                    "id": fault.name,
                    "fault": fault.fault.id,
                    **fault.as_json(),
                    "sentence": sentence,
                    "chain": chain,
                }
                for fault, sentence, chain in causes
            ],
            "firmness": list(self.cause.firmness),
        }


def find_findings(
    mission: Mission,
    pool: FaultPool,
    causes: Sequence[RecordedCause],
    specifications: Mapping[int, Specification],
) -> tuple[Finding, ...]:
    """Return the findings among evaluations, the most critical first.

    Parameters
    ----------
    mission, pool
        What they were flown with.
    causes
        Their causes, the most critical first; those without a fault are left out.
    specifications
        Their faults, by index.
    """
    known = [(cause, cause.outcome) for cause in causes if cause.places]
    sets = [chosen(specifications[cause.index], cause.places) for cause, _ in known]
    found = []
    for group in findings(sets):
        cause, outcome = known[group[0]]
        assert outcome is not None
        names = numbered(timed.fault for timed in specifications[cause.index])
        found.append(
            Finding(
                tuple(known[member][0].index for member in group),
                cause,
                outcome,
                named_faults(
                    mission, pool, sets[group[0]], [names[place] for place in cause.places]
                ),
            )
        )
    return tuple(found)
