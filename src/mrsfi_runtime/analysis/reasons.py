"""Why a fault changed no goal: what a flight shows beside the same flight without the fault.

Both meet the same weather, so that every difference comes from the fault. A reason is a predicate
on the differences, and words with what was measured; the one whose predicate is true is given.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_FLOOR, Decimal
from typing import NamedTuple, TypeAlias

from mrsfi_runtime.analysis.margins import Margins, margins
from mrsfi_runtime.causes.observed import Read, known, sent
from mrsfi_runtime.kernel.flight import Verdicts
from mrsfi_runtime.kernel.state import State
from mrsfi_runtime.model.mission import Mission


class _Side(NamedTuple):
    """Truth or belief of a tick: what is known, what goals have to spare, which are violated."""

    known: Read
    spare: list[Margins | None]
    violated: list[int]


class _Moment(NamedTuple):
    """A tick of the flight without the fault."""

    sides: tuple[_Side, _Side]
    sent: Read


@dataclass(slots=True)
class Twin:
    """Observer of the flight without the fault, for flights in the same weather."""

    moments: list[_Moment] = field(default_factory=list)

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Remember a tick."""
        sides = (_side(world, verdicts.is_true), _side(belief, verdicts.is_believed))
        self.moments.append(_Moment(sides, sent(world, belief)))


def _side(view: State, violated: Sequence[int]) -> _Side:
    spare = [margins(view, g) for g in range(len(view.goals))]
    return _Side(known(view), spare, [*violated])


_Limit: TypeAlias = tuple[int, str]
"""Index of a goal, and what is left to a limit of it, in words."""


@dataclass(frozen=True, slots=True)
class Differences:
    """How a flight differs from its twin.

    Attributes
    ----------
    n_targets
        Properties that the fault touches.
    applied
        Ticks at which it was active.
    n_true, n_believed, n_sent, n_verdicts
        Ticks at which the truth, the belief, the commands sent and the verdicts are others.
    spare
        The least that was left to each limit, of all ticks at which it was other than in the twin,
        and the goal not violated.
    alike
        Goals of whose limits nothing is said: they are violated where a margin is another, or
        their check is none of those known here.
    """

    n_targets: int
    applied: int
    n_true: int
    n_believed: int
    n_sent: int
    n_verdicts: int
    spare: Mapping[_Limit, float]
    alike: frozenset[int]

    @property
    def is_same(self) -> bool:
        """Whether neither truth, belief nor commands differ at any tick."""
        return self.n_true == self.n_believed == self.n_sent == 0


class Comparison:
    """Observer that compares a flight with its twin tick by tick.

    Parameters
    ----------
    twin
        Has seen the whole flight without the fault.
    """

    def __init__(self, twin: Twin) -> None:
        self._moments = twin.moments
        self._n = {"true": 0, "believed": 0, "sent": 0, "verdicts": 0}
        self._spare: dict[_Limit, float] = {}
        self._alike: set[int] = set()

    def __call__(self, world: State, belief: State, verdicts: Verdicts) -> None:
        """Compare a tick."""
        moment = self._moments[world.mission.tick]
        views = ("true", world, verdicts.is_true), ("believed", belief, verdicts.is_believed)
        is_judged_alike = True
        for (name, view, violated), before in zip(views, moment.sides, strict=True):
            is_judged_alike &= before.violated == [*violated]
            if known(view) != before.known:
                self._n[name] += 1
                self._weigh(view, violated, before)
        self._n["sent"] += sent(world, belief) != moment.sent
        self._n["verdicts"] += not is_judged_alike

    def _weigh(self, view: State, violated: Sequence[int], before: _Side) -> None:
        """Note what is left to the limits, as far as a goal's check judges by them."""
        for g, is_violated in enumerate(violated):
            spare = margins(view, g)
            if spare is None or (min(spare.values()) < 0.0) != bool(is_violated):
                self._alike.add(g)
            elif spare != before.spare[g]:
                if is_violated:
                    self._alike.add(g)
                else:
                    self._keep(g, spare, before.spare[g] or {})

    def _keep(self, g: int, spare: Margins, before: Margins) -> None:
        for what, left in spare.items():
            if left != before.get(what):
                self._spare[g, what] = min(left, self._spare.get((g, what), math.inf))

    def differences(self, n_targets: int, applied: int) -> Differences:
        """Return what was found until now, of a fault that touches and did so much."""
        n = self._n
        return Differences(
            n_targets=n_targets,
            applied=applied,
            n_true=n["true"],
            n_believed=n["believed"],
            n_sent=n["sent"],
            n_verdicts=n["verdicts"],
            spare=dict(self._spare),
            alike=frozenset(self._alike),
        )


class Reason(NamedTuple):
    """Why goals did not change: words that say the truth of a flight if a predicate is true of it.

    ``words`` have room for ticks at which belief, commands and truth differ. ``is_near`` says
    whether margins have a part in it.
    """

    holds: Callable[[Differences], bool]
    words: str
    is_near: bool = False


REASONS: Mapping[str, Reason] = {
    "uncarried": Reason(
        lambda found: found.is_same and found.n_targets == 0,
        "its message does not carry the property",
    ),
    "inactive": Reason(
        lambda found: found.is_same and found.n_targets > 0 and found.applied == 0,
        "it is active at no tick",
    ),
    "same": Reason(
        lambda found: found.is_same and found.n_targets > 0 and found.applied > 0,
        "it says or commands what is so anyway: nothing differs at any tick",
    ),
    "believed": Reason(
        lambda found: (
            found.n_believed > 0 and found.n_sent == found.n_true == found.n_verdicts == 0
        ),
        "belief differs at {believed}, no command does",
        is_near=True,
    ),
    "sent": Reason(
        lambda found: found.n_sent > 0 and found.n_true == found.n_verdicts == 0,
        "commands differ at {sent}, no robot does anything else",
        is_near=True,
    ),
    "true": Reason(
        lambda found: found.n_true > 0 and found.n_verdicts == 0,
        "truth differs at {true}, no verdict does",
        is_near=True,
    ),
    "verdicts": Reason(
        lambda found: found.n_verdicts > 0,
        "verdicts differ at {verdicts}, but there are as many violations of every goal",
    ),
}
"""By how far a fault comes: of a flight that changes no goal, one is true."""


def reason_of(found: Differences) -> str:
    """Return the name of the reason that is true of a flight which changes no goal."""
    (name,) = (name for name, reason in REASONS.items() if reason.holds(found))
    return name


def in_words(mission: Mission, flights: Sequence[Differences]) -> str:
    """Say why no goal changed in flights that have the same reason.

    Returns
    -------
    str
        Numbers of several flights are the least and the most ticks, and the least margins.
    """
    reason = REASONS[reason_of(flights[0])]
    text = reason.words.format(
        **{
            name: _ticks([getattr(found, f"n_{name}") for found in flights])
            for name in ("true", "believed", "sent", "verdicts")
        }
    )
    return "; ".join([text, *_near(mission, flights)]) if reason.is_near else text


def _ticks(counts: Sequence[int]) -> str:
    least, most = min(counts), max(counts)
    if least == most:
        return f"{most} tick{'s' if most != 1 else ''}"
    return f"{least} to {most} ticks"


def _near(mission: Mission, flights: Iterable[Differences]) -> Iterator[str]:
    """Yield what is left to the limits of the goals that a fault comes near to."""
    spare: dict[_Limit, float] = {}
    alike: set[int] = set()
    for found in flights:
        alike |= found.alike
        for limit, left in found.spare.items():
            spare[limit] = min(left, spare.get(limit, math.inf))
    ids = mission.goal_ids
    named: dict[str, list[str]] = {}
    for (g, what), least in sorted(spare.items()):
        if math.isfinite(least):
            named.setdefault(ids[g], []).append(f"{_at_least(least)} {what}")
    if named:
        words = ", ".join(f"{goal} {' and '.join(margin)}" for goal, margin in named.items())
        yield f"left to limits: {words}"
    if alike:
        yield f"judged alike: {', '.join(ids[g] for g in sorted(alike))}"
    if not spare and not alike:
        yield "no goal is nearer to a limit, or farther from it"


_DIGITS = 3


def _at_least(left: float) -> str:
    """Return a margin with three digits or all of its whole part, rounded down."""
    if left <= 0.0:
        return "0"
    places = max(_DIGITS - 1 - math.floor(math.log10(left)), 0)
    return f"{Decimal(left).quantize(Decimal(1).scaleb(-places), ROUND_FLOOR):,}"
