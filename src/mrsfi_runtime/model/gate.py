"""The one gate that every timed fault passes: of models, scripts, search, users' code and records.

Within its limits the reference and the compiled engine agree to the last bit: windows and whole
values are those of an ``EInt``, other values at most ``MOST``, as in models.

Two faults conflict when they touch the same property of the same target: one would
disable the other. Conflicting faults never overlap in one specification.

References
----------
Source paper, sections III-C b), III-E b) and c). The paper says *same message* in one
place and *same class* in another; this key serves the purpose it states.
"""

from collections.abc import Container, Iterable, Mapping, Sequence
from numbers import Integral, Real
from operator import attrgetter
from typing import Any

from mrsfi_runtime.errors import SpecificationError, expected
from mrsfi_runtime.model.fault_types import FaultType, Mode, Parameter, Range, Units
from mrsfi_runtime.model.faults import Event, FaultPool, Specification, TimedFault, original
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.model.targets import Target, describe, touched

MOST = 1e12
"""The largest magnitude of a value."""

LAST = 2**31 - 1
"""The largest tick of a window, and the largest whole value."""


def plain(timed: TimedFault) -> TimedFault:
    """Return a timed fault in Python's own numbers, values as floats; refuse what is not one."""
    if type(timed) is TimedFault and _is_plain(*timed):
        return timed
    try:
        fault, start, finish, values, *more = timed
        values, (trigger,) = tuple(values), more or [""]
    except (TypeError, ValueError):
        wanted = "a timed fault: its ID, start, finish, values, and its trigger if it has one"
        raise SpecificationError(f"found {timed!r}; expected {wanted}") from None
    for name, found in (("fault", fault), ("trigger", trigger)):
        if not isinstance(found, str):
            raise SpecificationError(f"found {name} {found!r}; expected its ID, as text")
    if not _are(Integral, start, finish) or not 0 <= start <= finish <= LAST:
        wanted = f"whole numbers, 0 <= start <= finish <= {LAST}"
        raise _misfit(fault, f"window {start!r} … {finish!r}", wanted)
    if not _are(Real, *values) or not all(-MOST <= value <= MOST for value in values):
        raise _misfit(fault, f"values {values!r}", f"numbers from {-MOST:.0f} to {MOST:.0f}")
    return TimedFault(str(fault), int(start), int(finish), tuple(map(float, values)), str(trigger))


def _is_plain(
    fault: object, start: int, finish: int, values: Sequence[float], trigger: object
) -> bool:
    """Return whether nothing is to be done, quickly: search has timed faults by the million."""
    if not (type(start) is type(finish) is int and type(fault) is type(trigger) is str):
        return False
    if type(values) is not tuple:
        return False
    for value in values:
        if type(value) is not float or not -MOST <= value <= MOST:
            return False
    return 0 <= start <= finish <= LAST


def _are(kind: type[Any], *found: object) -> bool:
    """Return whether all are numbers of a kind, which truth and text are not."""
    return all(isinstance(each, kind) and not isinstance(each, bool) for each in found)


def _misfit(fault: str, found: str, wanted: str) -> SpecificationError:
    return SpecificationError(f"fault '{fault}' has {found}; expected {wanted}", (fault,))


def at_work(
    fault: str, kind: FaultType, start: int, finish: int, values: Mapping[str, float]
) -> TimedFault:
    """Return a timed fault of a type, its values given by parameter; refuse what does not fit."""
    names = [parameter.name for parameter in kind.parameters]
    for name in values:
        if name not in names:
            what = f"fault '{fault}' ({kind.name}) has no parameter '{name}'"
            raise SpecificationError(f"{what}; {expected(name, names)}", (fault,))
    timed = TimedFault(fault, start, finish, tuple(values[name] for name in names))
    return fitting(kind, plain(timed))


def limits(parameter: Parameter) -> tuple[float, float]:
    """Return the lowest and the highest value that a parameter may ever have."""
    if parameter.is_integer:
        return 0.0 if parameter.range is Range.TICKS else -LAST - 1.0, float(LAST)
    return -MOST, MOST


def fitting(kind: FaultType, timed: TimedFault) -> TimedFault:
    """Return a plain timed fault whose values fit its type; refuse others."""
    parameters, values = kind.parameters, timed.values
    if len(values) != len(parameters):
        names = ", ".join(parameter.name for parameter in parameters) or "it takes none"
        raise _misfit(timed.fault, f"{len(values)} values", f"{len(parameters)} values ({names})")
    for parameter, value in zip(parameters, values, strict=True):
        if parameter.is_integer and not (
            value.is_integer() and limits(parameter)[0] <= value <= LAST
        ):
            low, high = limits(parameter)
            wanted = f"a whole number from {low:.0f} to {high:.0f}"
            raise _misfit(timed.fault, f"{parameter.name} {value}", wanted)
    if kind.mode is Mode.RANDOM and values and values[0] > values[1]:
        raise _misfit(timed.fault, kind.in_words(values, Units()), "the lower one first")
    return timed


class Gate(dict[str, tuple[FaultType, int, tuple[Target | str, ...]]]):
    """Admits fault specifications to one mission and pool; what it finds out, it remembers.

    By ID of a fault it has its type, the number of its values if no more is asked of them, and what
    no other may touch at the same time: itself, and its targets. The faults of a written
    specification may be copies of ``originals``, by ID.
    """

    def __init__(
        self, mission: Mission, pool: FaultPool, originals: Container[str] | None = None
    ) -> None:
        super().__init__()
        self.mission = mission
        self.pool = pool
        self._originals = pool.by_id if originals is None else originals

    def __missing__(self, fault_id: str) -> tuple[FaultType, int, tuple[Target | str, ...]]:
        fault = self.pool[fault_id]
        itself = f"{original(fault_id, self._originals)}: {fault.words}"
        keys: tuple[Target | str, ...] = (itself, *touched(self.mission, fault))
        parameters = fault.kind.parameters
        is_any = fault.kind.mode is not Mode.RANDOM and not any(p.is_integer for p in parameters)
        self[fault_id] = found = fault.kind, len(parameters) if is_any else -1, keys
        return found

    def admitted(self, specification: Iterable[TimedFault]) -> Specification:
        """Return a specification in Python's own numbers.

        A fault or a trigger that is unknown, or about what the mission has not, a fault whose
        window or values make no sense, or two that conflict and overlap, are a
        ``SpecificationError``.
        """
        try:
            asked = tuple(specification)
        except TypeError:
            wanted = "timed faults, in a list or tuple"
            raise SpecificationError(f"found {specification!r}; expected {wanted}") from None
        found = tuple(map(plain, asked))
        for timed in found:
            kind, n_values, _ = self[timed.fault]
            if len(timed.values) != n_values:
                fitting(kind, timed)
            if timed.trigger:
                self._require_trigger(timed)
        newest: dict[Target | str, TimedFault] = {}
        for timed in sorted(found, key=attrgetter("start")):
            for key in self[timed.fault][2]:
                before = newest.get(key)
                if before is not None and before.finish >= timed.start:
                    raise self._overlap(before, timed)
                newest[key] = timed
        return found

    def conflicts(self) -> Mapping[str, frozenset[str]]:
        """Return for every fault ID the IDs of the faults that it may not overlap, itself included.

        A fault that touches nothing conflicts with itself only: twice at once would be pointless.
        """
        keys = {fault.id: frozenset(self[fault.id][2]) for fault in self.pool}
        return {
            fault_id: frozenset(other for other, others in keys.items() if key & others)
            for fault_id, key in keys.items()
        }

    def _require_trigger(self, timed: TimedFault) -> None:
        """Refuse a trigger that the pool does not have, or the mission nothing for."""
        known, mission = self.pool.triggers_by_id, self.mission
        what, found, there = "trigger", timed.trigger, tuple(known)
        if found in known and known[found].event is not Event.EFFECT:
            what = f"trigger '{found}', which is about"
            (found,) = known[found].of
            is_robot = known[timed.trigger].area is not None
            there = tuple(mission.robot_index) if is_robot else mission.goal_ids
        if found not in there:
            text = f"fault '{timed.fault}' has {what} '{found}'; {expected(found, there)}"
            raise SpecificationError(text, (timed.fault,))

    def _overlap(self, first: TimedFault, second: TimedFault) -> SpecificationError:
        others = {*self[second.fault][2]}
        shared = (key for key in self[first.fault][2] if key in others and not isinstance(key, str))
        what = ", ".join(describe(self.mission, key) for key in shared) or "nothing"
        return SpecificationError(
            f"faults '{first.fault}' ({first.start} … {first.finish}) and '{second.fault}' "
            f"({second.start} … {second.finish}) overlap and both touch {what}; "
            "conflicting faults must not be active at the same tick",
            (first.fault, second.fault),
        )
