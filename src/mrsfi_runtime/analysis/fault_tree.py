"""Fault trees: for each goal, the least sets of faults that truly break it or let it be missed.

Sets by which a goal is only believed broken are left out: nothing happens to it.

References
----------
Open-PSA Model Exchange Format 2.0d, "Fault Tree Layer". The syntax of ``pfta``, its ``DOCS.md``.
"""

import re
from collections.abc import Iterable, Sequence
from itertools import chain, count
from textwrap import fill
from typing import NamedTuple
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from mrsfi_runtime.analysis.table import printable
from mrsfi_runtime.causes.mildest import Way
from mrsfi_runtime.model.faults import Fault, FaultPool
from mrsfi_runtime.model.mission import Mission

_SAYS = (
    "Least sets of faults that truly break a goal of the mission or let it be missed, as far as is "
    "known. A goal that is not here is broken so by none."
)
_OF_PFTA = (
    "For pfta 0.4 or newer. The probability of an event is the likelihood of the fault in its "
    "pool, nan where that gives none; then nothing is known of what depends on it. That of a gate "
    "is the sum over its sets (order 1), which is never too low; exact ones (all orders) take time "
    "that doubles with each set."
)


def cut_sets(found: Iterable[Way], goal: str) -> list[tuple[str, ...]]:
    """Return the least sets of faults that break a goal truly or let it be missed, by size."""
    real = {way.faults for way in found if way.goal == goal and way.shown.column.kind != "believed"}
    least = (faults for faults in real if not any({*other} < {*faults} for other in real))
    return sorted(least, key=lambda faults: (len(faults), faults))


class _Gate(NamedTuple):
    """A gate that needs one of its inputs (``or``) or all of them (``and``)."""

    name: str
    label: str
    kind: str
    inputs: tuple[str, ...]


def _trees(
    mission: Mission, pool: FaultPool, found: Sequence[Way]
) -> tuple[list[list[_Gate]], list[tuple[str, str, Fault]]]:
    """Return the gates of each goal, its own first; name and label of the faults below them."""
    taken: set[str] = set()

    def named(*words: str) -> str:
        """Return a name of ASCII letters, digits, ``_`` and ``-`` that none has in any case."""
        stem = "-".join(re.sub(r"\W", "_", word, flags=re.ASCII) for word in words)[:100]
        names = chain([stem], (f"{stem}-{number}" for number in count(2)))
        name = next(each for each in names if each.lower() not in taken)
        taken.add(name.lower())
        return name

    sets = {goal.id: cut_sets(found, goal.id) for goal in mission.goals}
    tops = {goal: named(goal) for goal in sets if sets[goal]}
    used = {fault for some in sets.values() for faults in some for fault in faults}
    event = {fault.id: named(fault.id) for fault in pool if fault.id in used}
    trees = []
    for goal in (each for each in mission.goals if each.id in tops):
        below = {
            event[faults[0]] if len(faults) == 1 else named(goal.id, *faults): faults
            for faults in sets[goal.id]
        }
        label = printable(f"{goal.name} ({goal.id}): truly violated or missed")
        joint = [
            _Gate(name, " and ".join(faults), "and", tuple(event[fault] for fault in faults))
            for name, faults in below.items()
            if len(faults) > 1
        ]
        trees.append([_Gate(tops[goal.id], label, "or", tuple(below)), *joint])
    return trees, [
        (event[each.id], printable(f"{each.name} ({each.id}): {each.words}"), each)
        for each in pool
        if each.id in used
    ]


def as_open_psa(mission: Mission, pool: FaultPool, found: Sequence[Way]) -> bytes:
    """Return the fault trees in Open-PSA's exchange format, XML that many tools read."""
    trees, events = _trees(mission, pool, found)
    root = Element("opsa-mef")
    root.append(Comment(f" {_SAYS} "))
    for tree in trees:
        of_goal = SubElement(root, "define-fault-tree", name=tree[0].name)
        joint = {gate.name for gate in tree}
        for gate in tree:
            defined = _defined(of_goal, "gate", gate.name, gate.label)
            formula = SubElement(defined, gate.kind) if len(gate.inputs) > 1 else defined
            for name in gate.inputs:
                SubElement(formula, "gate" if name in joint else "basic-event", name=name)
    known = SubElement(root, "model-data")
    for name, label, fault in events:
        defined = _defined(known, "basic-event", name, label)
        if fault.likelihood is not None:
            SubElement(defined, "float", value=repr(fault.likelihood))
    indent(root)
    content: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _defined(parent: Element, what: str, name: str, label: str) -> Element:
    defined = SubElement(parent, f"define-{what}", name=name)
    SubElement(defined, "label").text = label
    return defined


def as_pfta(mission: Mission, pool: FaultPool, found: Sequence[Way]) -> bytes:
    """Return the fault trees as text for ``pfta``."""
    trees, events = _trees(mission, pool, found)
    said = fill(f"{_SAYS} {_OF_PFTA}", 98, initial_indent="# ", subsequent_indent="# ")
    parts = [said, "- times: nan\n- computational_order: 1"]
    for gate in (gate for tree in trees for gate in tree):
        kind = gate.kind.upper() if len(gate.inputs) > 1 else "NULL"
        inputs = ", ".join(gate.inputs)
        parts.append(
            f"Gate: {gate.name}\n- label: {gate.label}\n- type: {kind}\n- inputs: {inputs}"
        )
    for name, label, fault in events:
        chance = "nan" if fault.likelihood is None else fault.likelihood
        model = f"- model_type: Fixed\n- probability: {chance}\n- intensity: nan"
        parts.append(f"Event: {name}\n- label: {label}\n{model}")
    return "\n\n".join((*parts, "")).encode()
