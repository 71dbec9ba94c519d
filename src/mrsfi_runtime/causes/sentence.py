"""A chain of first differences in one plain sentence."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from mrsfi_runtime.causes.cause import Cause
from mrsfi_runtime.causes.chain import HEADING, Chain, Change, First, FirstVerdicts
from mrsfi_runtime.model.fault_types import Field, Mode, Struck
from mrsfi_runtime.record.named_faults import NamedFault


def sentences(cause: Cause, faults: Sequence[NamedFault]) -> tuple[str, ...]:
    """Return for each fault of a cause set, among all of a specification, what it did, in words."""
    return tuple(
        sentence(faults[place], chain)
        for place, chain in zip(cause.places, cause.chains, strict=True)
    )


def sentence(fault: NamedFault, chain: Chain) -> str:
    """Say what a fault did, what was believed and sent then, what happened, and what was missed."""
    parts = [*(words for _, words in _differences(chain)), *map(_verdict, chain.verdicts)]
    window = f"from tick {fault.timed.start} to {fault.timed.finish}"
    done = f"{fault.name} ({fault.fault.type}) {_deed(fault)} {window}"
    return f"{done}: {'; '.join(parts) or 'nothing differs at any tick'}."


def _deed(fault: NamedFault) -> str:
    kind = fault.fault.kind
    deed = "falsified"
    if kind.mode in {Mode.DELAY, Mode.BLOCK}:
        deed = "held back"
    elif {Field.MOTION, Field.ACTIVATION} & {*kind.properties}:
        deed = "forged"
    where = f" in message {fault.fault.target}" if kind.struck is Struck.MESSAGE else ""
    return f"{deed} {', '.join(fault.touched) or 'nothing'}{where}"


def local_effect(chain: Chain) -> str:
    """Say what a fault changed first of what is believed or sent; empty if it changed neither."""
    told = [*_differences(replace(chain, truth=None))]
    return min(told, key=lambda each: each[0])[1] if told else ""


def _differences(chain: Chain) -> Iterator[tuple[int, str]]:
    """Yield what differs first, each with its tick."""
    for first, words in (
        (chain.belief, "the CI believed"),
        (chain.command, "what was sent was"),
        (chain.truth, "there truly was"),
    ):
        if first is not None:
            yield first.tick, f"at tick {first.tick} {words} {changed(first)}"


def changed(first: First) -> str:
    """Return the first change in words: ``r2 position (3.00, 4.00, 0.00), not (3.00, 5.00, 0.00)``.

    Of several, it is the first in the order of robots, sensors, obstacles and goals. One that is
    too small to be seen in these figures is told by its size: ``r2 heading 90.0 degrees, 1e-14
    off``.
    """
    change = first.changes[0]
    found, otherwise = (_value(change, value) for value in (change.found, change.otherwise))
    apart = f"{change.size:.0e} off" if found == otherwise else f"not {otherwise}"
    return f"{change.owner} {change.quantity} {found}, {apart}"


def _value(change: Change, value: tuple[float, ...]) -> str:
    if change.quantity == HEADING:
        return f"{value[0]:.1f} degrees"
    if len(value) > 1:
        return f"({', '.join(f'{each:.2f}' for each in value)})"
    return f"{value[0]:g}" if value[0] == int(value[0]) else f"{value[0]:.2f}"


def _verdict(first: FirstVerdicts) -> str:
    words = {
        "believed violated": first.believed,
        "truly violated": first.true,
        "certain to be missed": first.missed,
    }
    said = [
        f"{'' if verdict.is_so else 'no longer '}{what} at tick {verdict.tick}"
        for what, verdict in words.items()
        if verdict is not None
    ]
    return f"{first.goal} was {', '.join(said)}"
