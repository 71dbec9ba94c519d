"""Failure modes and effects (FMEA), and fault trees: weaknesses as safety assessors read them.

A row of the FMEA is a weakness in one variant. ``failure_modes`` returns the rows, ``fmea`` the
table that ``FMEA`` writes in four formats, with the same cells in each. A cell that neither models
nor record nor team can fill is empty. False alarms have a row without severity: the severity of a
goal is that of its violation.

``as_open_psa`` and ``as_pfta`` write fault trees: for each goal, the smallest sets of faults that
truly violate it or make it fail, and for each requirement its goals. Sets that break a goal only in
belief are in no tree. No text of a model becomes markup or a formula.

References
----------
Open-PSA Model Exchange Format 2.0d, "Fault Tree Layer". The syntax of ``pfta``, its ``DOCS.md``.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from itertools import chain, count
from operator import itemgetter
from textwrap import fill
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

from mrsfi_runtime.analysis.documents import LATEX_HEAD, in_latex
from mrsfi_runtime.analysis.tables import (
    Cell,
    Table,
    as_csv,
    as_xlsx,
    in_words,
    plain,
    to_markdown,
)
from mrsfi_runtime.analysis.weaknesses import detection, effect_class, evidence
from mrsfi_runtime.causes.chain import chains, effects, struck
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.risk import cut_sets, occurrence
from mrsfi_runtime.causes.weakness import MEASURES
from mrsfi_runtime.engine.recording import Record
from mrsfi_runtime.errors import printable
from mrsfi_runtime.model.faults import Fault, FaultPool, Specification, elements_of
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.project_file import DETECTIONS
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import NONE

HEADS = (
    *("weakness", "item", "function", "failure mode", "local effect", "next effect", "end effect"),
    *("requirement", "effect class", "S", "O", "D", "RPN", "detection", "mildest variant"),
    *("evidence", "recommended action", "owner", "status", "reference", "integrity level"),
    *("faults", "likelihood", "ticks by measure", "most ticks"),
)
"""The columns of an FMEA. Those that docs/find-weaknesses.md does not explain are standard."""


def failure_modes(
    mission: Mission,
    pool: FaultPool,
    weaknesses: Iterable[GoalWeakness],
    record: Record,
    ratings: Mapping[str, Mapping[str, Any]],
    settled: Mapping[int, Mapping[str, str]],
) -> list[dict[str, Cell]]:
    """Return the failure modes of weaknesses: the most severe first, then undetected ones.

    Then come the likeliest, those that make a goal fail, and those that break it for longest.
    A cell is by its column; it describes the mildest known variant, and detection is about all.
    ``settled`` has cells that the team fills, by the numbers of weaknesses.
    """
    fly, units, rated = lru_cache(4)(record), mission.units, ratings.get("occurrence", {})

    @cache
    def flown(variant: Specification) -> tuple[str, str, list[tuple[int, ...]]]:
        by_fault = (effects(mission, each) for each in chains(fly, mission, variant))
        found = zip(*by_fault, strict=True)
        local, following = ("; ".join(each or NONE for each in some) for some in found)
        counts = (fly(variant)[kind][-1].tolist() for kind in MEASURES)
        return local, following, [*zip(*counts, strict=True)]

    def happens(named: NamedFault) -> str:
        window = f"{named.fault.type} from tick {named.timed.start} to {named.timed.finish}"
        return ", ".join(filter(None, (window, named.values_in_words)))

    def mode(weakness: GoalWeakness) -> tuple[tuple[float, ...], dict[str, Cell]]:
        shown, place = weakness.at_least.shown, mission.goal_ids.index(weakness.goal)
        goal, faults = mission.goals[place], named_faults(mission, pool, shown.witness)
        local_effect, next_effect, counts = flown(shown.witness)
        n_ticks = max(counts[place])
        chance, found = occurrence(pool, weakness.faults), weakness.shown.detection
        likely, worst = 1.0 if chance is None else -chance, found.worst if found else ""
        s = None if shown.column.kind == MEASURES[0] else goal.severity or None
        o = max((int(n) for n, least in rated.items() if least <= -likely), default=None)
        d = ratings.get("detection", {}).get(worst)
        required = (each for each in mission.requirements if each.id in goal.requirements)
        measured = map("{} {}".format, ("believed", "true", "failed"), counts[place])
        row: dict[str, Cell] = {
            "weakness": weakness.number,
            "item": _listed(struck(mission, each) for each in faults),
            "function": _listed(goal for each in faults for goal in _served(mission, each.fault)),
            "failure mode": _listed(map(happens, faults)),
            "local effect": local_effect,
            "next effect": next_effect,
            "end effect": mission.label_of(weakness.goal),
            "requirement": _listed(f"{each.id}: {each.text}" for each in required),
            "effect class": effect_class(weakness),
            "S": s,
            "O": o,
            "D": d,
            "RPN": s * o * d if s and o and d else None,
            "detection": detection(weakness, units),
            "mildest variant": weakness.mildest.sentence if weakness.mildest else "",
            "evidence": evidence(weakness.at_least),
            **settled.get(weakness.number, {}),
            "reference": _listed(each.fault.reference for each in faults),
            "integrity level": goal.integrity_level,
            "faults": " ".join(weakness.faults),
            "likelihood": chance,
            "ticks by measure": ", ".join(measured),
            "most ticks": n_ticks,
        }
        late = DETECTIONS.index(worst) if worst else len(DETECTIONS)
        return (-(s or 0), late, likely, shown.column.kind != MEASURES[-1], -n_ticks), row

    return [row for _, row in sorted(map(mode, weaknesses), key=itemgetter(0))]


def _listed(texts: Iterable[str]) -> str:
    return "; ".join(filter(None, dict.fromkeys(texts)))


def _served(mission: Mission, fault: Fault) -> list[str]:
    """Return the goals that name what a fault strikes, or else the robots that it touches."""
    named = {
        goal.id: {*goal.members, *goal.terms.obstacles, goal.terms.sensor}.union(
            each.id for each in goal.messages
        )
        for goal in mission.goals
    }
    struck = [goal for goal, elements in named.items() if fault.target in elements]
    touched = elements_of(mission, fault)
    served = struck or [goal for goal in named if not touched.isdisjoint(named[goal])]
    return [*map(mission.label_of, served)]


def fmea(mission: str, modes: Iterable[Mapping[str, Cell]]) -> Table:
    """Return failure modes of a mission, by its name, as a table whose cells are single lines."""

    def cell(value: Cell) -> Cell:
        if isinstance(value, float):
            return float(f"{value:.15g}")  # openpyxl writes no more digits
        return printable(value) or None if isinstance(value, str) else value

    rows = [[cell(mode.get(head)) for head in HEADS] for mode in modes]
    return Table(f"Failure modes of mission {printable(mission)}", HEADS, rows)


def _as_markdown(table: Table) -> bytes:
    return f"# {plain(table.title)}\n\n{to_markdown(table)}\n".encode()


def _as_latex(table: Table) -> bytes:
    """Return a document with a list of the cells of each failure mode."""
    parts = [LATEX_HEAD, f"\\section*{{{in_latex(table.title)}}}"]
    for number, *cells in table.rows:
        title = in_latex(f"Weakness {number}")
        parts.append(f"\\subsection*{{{title}}}\n\\begin{{description}}")
        named = zip(HEADS[1:], cells, strict=True)
        parts += [f"\\item[{name}] {in_latex(in_words(cell))}" for name, cell in named]
        parts.append("\\end{description}")
    return "\n".join((*parts, "\\end{document}\n")).encode()


FMEA = MappingProxyType(
    {
        ".csv": lambda table: as_csv(table.lines),
        ".xlsx": as_xlsx,
        ".md": _as_markdown,
        ".tex": _as_latex,
    }
)
"""Writers by suffix of the file."""

_COMMENT = (
    "Known minimal sets of faults that truly violate a goal of the mission or make it fail. For a "
    "goal that is not listed, none is known. A requirement is violated with any of its goals."
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
    """Return the gates of each goal and requirement, top gates first, and names of the faults.

    Faults have labels, too.
    """
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
    for each in mission.requirements:
        goals = [goal.id for goal in mission.goals if each.id in goal.requirements]
        if broken := tuple(tops[goal] for goal in goals if goal in tops):
            label = printable(f"{each.id}: {each.text}")
            trees.append([_Gate(named(each.id), f"Violated: {label}", "or", broken)])
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
    gates = {gate.name for tree in trees for gate in tree}
    for tree in trees:
        defined_in = SubElement(root, "define-fault-tree", name=tree[0].name)
        for gate in tree:
            defined = _defined(defined_in, "gate", gate.name, gate.label)
            formula = SubElement(defined, gate.kind) if len(gate.inputs) > 1 else defined
            for name in gate.inputs:
                SubElement(formula, "gate" if name in gates else "basic-event", name=name)
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
    tops = {tree[0].name for tree in trees}
    for gate in (gate for tree in trees for gate in tree):
        kind = gate.kind.upper() if len(gate.inputs) > 1 else "NULL"
        inputs = ", ".join(gate.inputs)
        own = "\n- is_paged: True" * (gate.name in tops)  # a figure, also below a requirement
        parts.append(
            f"Gate: {gate.name}\n- label: {gate.label}{own}\n- type: {kind}\n- inputs: {inputs}"
        )
    for name, label, fault in events:
        chance = "nan" if fault.likelihood is None else fault.likelihood
        model = f"- model_type: Fixed\n- probability: {chance}\n- intensity: nan"
        parts.append(f"Event: {name}\n- label: {label}\n{model}")
    return "\n\n".join((*parts, "")).encode()


FAULT_TREES = MappingProxyType({".xml": as_open_psa, ".txt": as_pfta, ".pft": as_pfta})
"""Writers by suffix of the file."""
