"""A chain of first differences in one plain sentence."""

from collections.abc import Iterator

from mrsfi_runtime.causes.chain import HEADING, Chain, Change, First, FirstVerdicts
from mrsfi_runtime.model.fault_types import Field, Mode, Struck
from mrsfi_runtime.model.faults import Fault, TimedFault


def sentence(name: str, fault: Fault, timed: TimedFault, chain: Chain) -> str:
    """Say what a fault did, what was believed and sent then, what happened, and what was missed.

    Parameters
    ----------
    name
        Of the timed fault.
    fault
        Its pool fault.
    timed
        Its window.
    chain
        What it changed first.
    """
    parts = [*_differences(chain), *map(_verdict, chain.verdicts)]
    done = f"{name} ({fault.type}) {_deed(fault)} from tick {timed.start} to {timed.finish}"
    return f"{done}: {'; '.join(parts) or 'nothing differs at any tick'}."


def _deed(fault: Fault) -> str:
    kind, target = fault.kind, fault.target
    if kind.mode in {Mode.DELAY, Mode.BLOCK}:
        return f"held back message {target}"
    if Field.MOTION in kind.properties:
        return f"forged the speed command of {target}"
    if Field.ACTIVATION in kind.properties:
        return f"forged the activation of {target}"
    if kind.struck is Struck.MESSAGE:
        return f"falsified message {target}"
    return f"falsified what is believed of {target}"


def _differences(chain: Chain) -> Iterator[str]:
    if chain.belief is not None:
        yield f"at tick {chain.belief.tick} the CI believed {changed(chain.belief)}"
    if chain.command is not None:
        yield f"at tick {chain.command.tick} what was sent was {changed(chain.command)}"
    if chain.truth is not None:
        yield f"at tick {chain.truth.tick} there truly was {changed(chain.truth)}"


def changed(first: First) -> str:
    """Return the first change in words: ``r2 position (3.00, 4.00, 0.00), not (3.00, 5.00, 0.00)``.

    Of several, it is the first in the order of robots, sensors, obstacles and goals.
    """
    change = first.changes[0]
    found, otherwise = (_value(change, value) for value in (change.found, change.otherwise))
    return f"{change.owner} {change.quantity} {found}, not {otherwise}"


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
