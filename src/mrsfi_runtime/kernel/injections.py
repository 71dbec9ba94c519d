"""Faults at work: every timed fault laid out as injections, one per property it touches.

References
----------
Source paper, sections III-B b) and III-G; DESIGN of the fault effects in docs/semantics.md.
"""

from dataclasses import dataclass

from mrsfi_runtime.model.fault_types import Field, Mode
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, TimedFault
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import Target, touched


@dataclass(slots=True)
class InjectionState:
    """One property of one target under one fault, active for ``start <= tick <= finish``.

    ``affected`` and ``mode`` are numbers of ``Field`` and ``Mode``; ``a``, ``b``, ``c`` the
    fault's values. A delay of ``n_held`` ticks keeps what is under way in a ring of ``Plan.held``
    from ``first_held`` on, three entries a tick; 0 means that nothing arrives in the window.
    ``kept_…`` is what was believed before this tick's delivery.
    """

    fault: int
    affected: int
    mode: int
    target: int
    start: int
    finish: int
    a: float
    b: float
    c: float
    first_held: int
    n_held: int
    kept_a: float
    kept_b: float
    kept_c: float


@dataclass(slots=True)
class FaultTally:
    """At how many ticks a timed fault was active, and at how many it changed a value."""

    applied: int
    changed: int
    last_applied: int
    last_changed: int


@dataclass(slots=True)
class Plan:
    """All injections of one fault specification, by what they act on, each list by start.

    ``messages`` are delayed and blocked ones, ``reports`` falsify what is believed,
    ``commands`` are forged. ``held`` is room for delayed messages; ``tallies`` has one entry
    for each timed fault.
    """

    messages: list[InjectionState]
    reports: list[InjectionState]
    commands: list[InjectionState]
    held: list[float]
    tallies: list[FaultTally]


def plan(mission: Mission, pool: FaultPool, specification: Specification) -> Plan:
    """Lay a fault specification out for the kernel.

    Raises
    ------
    SpecificationError
        If a fault is not in the pool, or refers to what the mission does not have.
    """
    laid_out = Plan([], [], [], [], [FaultTally(0, 0, -1, -1) for _ in specification])
    for number, timed in enumerate(specification):
        fault = pool[timed.fault]
        for target in touched(mission, fault):
            injection = _injection(number, timed, fault, target)
            if injection.mode <= BLOCK:
                _reserve(laid_out, injection)
                laid_out.messages.append(injection)
            elif injection.affected <= OBSTACLE:
                laid_out.reports.append(injection)
            else:
                laid_out.commands.append(injection)
    for injections in (laid_out.messages, laid_out.reports, laid_out.commands):
        injections.sort(key=_start)
    return laid_out


def _start(injection: InjectionState) -> int:
    return injection.start


def _injection(number: int, timed: TimedFault, fault: Fault, target: Target) -> InjectionState:
    mode = fault.kind.mode
    a, b, c = (*(float(value) for value in timed.values), 0.0, 0.0, 0.0)[:3]
    finish = timed.finish
    if mode is Mode.BLOCK:
        finish = min(finish, timed.start + round(a) - 1)
    return InjectionState(
        fault=number,
        affected=int(target[0]),
        mode=int(mode),
        target=target[1],
        start=timed.start,
        finish=finish,
        a=a,
        b=b,
        c=c,
        first_held=0,
        n_held=0,
        kept_a=0.0,
        kept_b=0.0,
        kept_c=0.0,
    )


def _reserve(laid_out: Plan, injection: InjectionState) -> None:
    """Make room for what a delay holds back; a delay below one tick never becomes active."""
    if injection.mode == BLOCK:
        return
    delay = round(injection.a)
    if delay < 1:
        injection.finish = injection.start - 1
    elif delay <= injection.finish - injection.start:
        injection.first_held = len(laid_out.held)
        injection.n_held = delay
        laid_out.held.extend([0.0] * (3 * delay))


POSITION, SPEED, ENERGY, COUNT, RATE, COST, OBSTACLE, MOTION, ACTIVATION = (
    int(affected) for affected in Field
)
"""Numbers of ``Field`` as plain integers, for the kernel."""

(
    DELAY,
    BLOCK,
    RANDOM,
    ZERO,
    FIXED,
    INCREMENT,
    DECREMENT,
    INCREMENT_PERCENT,
    DECREMENT_PERCENT,
    STOP,
    START,
    DEACTIVATE,
    ACTIVATE,
) = (int(mode) for mode in Mode)
"""Numbers of ``Mode`` as plain integers, for the kernel."""
