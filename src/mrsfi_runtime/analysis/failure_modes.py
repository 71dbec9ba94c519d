"""Failure modes and effects (FMEA), and fault trees: weaknesses as safety assessors read them.

A row of the FMEA is a weakness in one variant. ``failure_modes`` returns the rows, ``modes_as_csv``
and ``modes_as_markdown`` write them. ``as_open_psa`` and ``as_pfta`` write fault trees: for each
goal, the smallest sets of faults that truly violate it or make it fail. Sets that break a goal only
in belief are in the FMEA and in no tree. No text of a model becomes markup or a formula.

References
----------
Open-PSA Model Exchange Format 2.0d, "Fault Tree Layer". The syntax of ``pfta``, its ``DOCS.md``.
"""

import re
from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import chain, count
from textwrap import fill
from typing import NamedTuple
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from mrsfi_runtime.analysis.tables import Table, as_csv, plain, to_markdown
from mrsfi_runtime.analysis.weaknesses import detection
from mrsfi_runtime.causes.chain import chains, local_effect
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.risk import cut_sets, occurrence
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import printable
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import NONE


class FailureMode(NamedTuple):
    """A row of the table: a weakness, in a variant that breaks the goal by the gravest measure.

    ``form`` says whether the variant is the mildest one or the listed one. ``measures`` has the
    ticks at which it breaks the goal by each measure, ``ticks`` the most of these. ``detected`` is
    about all variants. ``occurrence`` is the chance that all faults occur, 0 … 1, as if they were
    independent; ``None`` if not recorded.
    """

    number: int
    faults: str
    form: str
    item: str
    failure_mode: str
    local_effect: str
    end_effect: str
    measures: str
    detected: str
    severity: str
    ticks: int
    occurrence: float | None


_FMEA_HEADS = (
    *("weakness", "faults", "variant", "item", "failure mode", "local effect", "end effect"),
    *("ticks by measure", "detection", "severity", "most ticks", "occurrence"),
)


def failure_modes(
    mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness], record: Record
) -> list[FailureMode]:
    """Return the failure modes of weaknesses, by occurrence if recorded, then by severity.

    Goals that fail come first, then those that are broken for longest.
    """
    fly, units = lru_cache(4)(record), mission.units

    @cache
    def flown(variant: Specification) -> tuple[str, list[tuple[int, ...]]]:
        effects = (local_effect(mission, chain) or NONE for chain in chains(fly, mission, variant))
        counts = (fly(variant)[kind][-1].tolist() for kind in MEASURES)
        return "; ".join(effects), [*zip(*counts, strict=True)]

    def happens(named: NamedFault) -> str:
        window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
        return ", ".join(filter(None, (window, named.values_in_words)))

    def mode(weakness: GoalWeakness) -> FailureMode:
        shown, place = weakness.at_least.shown, mission.goal_ids.index(weakness.goal)
        faults = named_faults(mission, pool, shown.witness)
        effect, counts = flown(shown.witness)
        return FailureMode(
            number=weakness.number,
            faults=" ".join(weakness.faults),
            form="listed" if weakness.mildest is None else "mildest",
            item="; ".join(dict.fromkeys(each.target for each in faults)),
            failure_mode="; ".join(map(happens, faults)),
            local_effect=effect,
            end_effect=mission.label_of(weakness.goal),
            measures=", ".join(map("{} {}".format, MEASURES, counts[place])),
            detected=detection(weakness, units),
            severity="missed" if shown.column.kind == "missed" else "violated",
            ticks=max(counts[place]),
            occurrence=occurrence(pool, weakness.faults),
        )

    def rank(mode: FailureMode) -> tuple[float, bool, int]:
        chance = 1.0 if mode.occurrence is None else -mode.occurrence
        return chance, mode.severity != "missed", -mode.ticks

    return sorted(map(mode, weaknesses), key=rank)


def modes_as_csv(_: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes as CSV."""
    return as_csv([FailureMode._fields, *modes])


def modes_as_markdown(mission: str, modes: Sequence[FailureMode]) -> bytes:
    """Return failure modes of a mission, by its name, as a page in Markdown."""
    title = f"Failure modes of mission {mission}"
    rows = [
        each._replace(
            measures=each.measures.replace("missed", "failed"),
            severity=each.severity.replace("missed", "fails"),
        )
        for each in modes
    ]
    return f"# {plain(title)}\n\n{to_markdown(Table(title, _FMEA_HEADS, rows))}\n".encode()


_COMMENT = (
    "Known minimal sets of faults that truly violate a goal of the mission or make it fail. For a "
    "goal that is not listed, none is known."
)
_PFTA_COMMENT = (
    "For pfta 0.4 or newer. The probability of an event is the likelihood of the fault in its "
    "pool, or nan if the pool gives none; then probabilities that depend on it are unknown. That "
    "of a gate is the sum over its sets (order 1), an upper bound; an exact one (all orders) takes "
    "time that doubles with each set."
)


class _Gate(NamedTuple):
    """A gate that needs one of its inputs (``or``) or all of them (``and``)."""

    name: str
    label: str
    kind: str
    inputs: tuple[str, ...]


def _trees(
    mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]
) -> tuple[list[list[_Gate]], list[tuple[str, str, Fault]]]:
    """Return the gates of each goal, the top gate first, and names and labels of the faults."""
    taken: set[str] = set()

    def named(*words: str) -> str:
        """Return a new name of ASCII letters, digits, ``_`` and ``-``, whatever the case."""
        stem = "-".join(re.sub(r"\W", "_", word, flags=re.ASCII) for word in words)[:100]
        names = chain([stem], (f"{stem}-{number}" for number in count(2)))
        name = next(each for each in names if each.lower() not in taken)
        taken.add(name.lower())
        return name

    sets = {goal.id: cut_sets(weaknesses, goal.id) for goal in mission.goals}
    tops = {goal: named(goal) for goal in sets if sets[goal]}
    used = {fault for some in sets.values() for faults in some for fault in faults}
    event = {fault.id: named(fault.id) for fault in pool if fault.id in used}
    trees = []
    for goal in (each for each in mission.goals if each.id in tops):
        below = {
            event[faults[0]] if len(faults) == 1 else named(goal.id, *faults): faults
            for faults in sets[goal.id]
        }
        label = printable(f"{goal.name} ({goal.id}): truly violated or failed")
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


def as_open_psa(mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]) -> bytes:
    """Return the fault trees in Open-PSA's exchange format, an XML that many tools read."""
    trees, events = _trees(mission, pool, weaknesses)
    root = Element("opsa-mef")
    root.append(Comment(f" {_COMMENT} "))
    for tree in trees:
        of_goal = SubElement(root, "define-fault-tree", name=tree[0].name)
        joint = {gate.name for gate in tree}
        for gate in tree:
            defined = _defined(of_goal, "gate", gate.name, gate.label)
            formula = SubElement(defined, gate.kind) if len(gate.inputs) > 1 else defined
            for name in gate.inputs:
                SubElement(formula, "gate" if name in joint else "basic-event", name=name)
    data = SubElement(root, "model-data")
    for name, label, fault in events:
        defined = _defined(data, "basic-event", name, label)
        if fault.likelihood is not None:
            SubElement(defined, "float", value=repr(fault.likelihood))
    indent(root)
    content: bytes = tostring(root, encoding="utf-8", xml_declaration=True)
    return content + b"\n"


def _defined(parent: Element, what: str, name: str, label: str) -> Element:
    defined = SubElement(parent, f"define-{what}", name=name)
    SubElement(defined, "label").text = label
    return defined


def as_pfta(mission: Mission, pool: FaultPool, weaknesses: Sequence[GoalWeakness]) -> bytes:
    """Return the fault trees as text for ``pfta``."""
    trees, events = _trees(mission, pool, weaknesses)
    comment = fill(f"{_COMMENT} {_PFTA_COMMENT}", 98, initial_indent="# ", subsequent_indent="# ")
    parts = [comment, "- times: nan\n- computational_order: 1"]
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
