"""What ``mrsfi explain`` prints of an explanation, and what scripts get in its place."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias

import click
from rich.table import Table
from rich.text import Text

from mrsfi_runtime.causes.chain import Chain, First, FirstVerdicts
from mrsfi_runtime.causes.counts import Counts
from mrsfi_runtime.causes.explanation import Explanation
from mrsfi_runtime.causes.findings import Finding, findings
from mrsfi_runtime.causes.firmness import N_SEEDS
from mrsfi_runtime.causes.labels import BYSTANDER, GoalCauses
from mrsfi_runtime.causes.sentence import sentence
from mrsfi_runtime.cli.console import counted, print_table
from mrsfi_runtime.cli.tables import goals_as_json, plain_table
from mrsfi_runtime.mission import MissionCode
from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.record.measure import NONE, Measure, ticks, violated


@dataclass(frozen=True, slots=True)
class Shown:
    """What is said of a specification beside its explanation.

    Attributes
    ----------
    code, measure
        The mission, and what is counted.
    name, title
        What the specification is, in short, and for people.
    names
        Of its timed faults.
    keep
        Share of the counts that the cause set keeps.
    paths
        Where the cause set was written, and its simplest form; empty if there is none.
    """

    code: MissionCode
    measure: Measure
    name: str
    title: str
    names: tuple[str, ...]
    keep: float
    paths: Sequence[Path]

    def ticks(self, count: float) -> str:
        """Return a sum over the mission seeds as text: a count, or a mean of counts."""
        n_seeds = self.measure.n_seeds
        return ticks(count if n_seeds == 1 else count / n_seeds)


def print_explanation(shown: Shown, found: Explanation | None) -> None:
    """Print an explanation for people, or that there is nothing to explain."""
    n = counted(len(shown.names), "faults")
    if found is None:
        click.echo(f"{shown.title}: {n}, and no goal is violated; there is nothing to explain")
        return
    click.echo(f"{shown.title}: {_answer(shown, found, n)}")
    if shown.measure.n_seeds > 1:
        click.echo(f"Counts are means of {shown.measure.n_seeds} mission seeds.")
    click.echo()
    if found.cause_set:
        print_table("Cause set", _fault_table(shown, found, found.cause))
        print_table("Its simplest form", _fault_table(shown, found, found.simplest))
    print_table("Violations", _counts_table(shown, found))
    if found.cause_set:
        print_table("Due to each fault of the cause set", _share_table(shown, found))
        click.echo(f"{_sentence(shown, found)}\n")
        print_table("First differences that each fault makes", _chain_table(shown, found))
        title = f"Violations under the cause set in {N_SEEDS} mission seeds"
        print_table(title, _firmness_table(found))
    _print_labels(shown, found)
    for part, n_flown in found.n_flown.items():
        click.echo(f"{n_flown:>6} evaluations  {part}")
    for what, path in zip(("cause set", "simplest form"), shown.paths, strict=False):
        click.echo(f"{what:<13}  {path}")
    click.echo()


def _answer(shown: Shown, found: Explanation, n: str) -> str:
    """Return in one sentence what came out for so many faults."""
    words = shown.measure.words
    if shown.measure.kind != "true":
        words = f"{words.removesuffix(' violations')} and true violations"
    kept = f"{100 * shown.keep:g} % of every goal's {words}"
    if not found.cause_set:
        return f"{n}, and none is the cause: without any, {kept} are there as well"
    n_others = len({*found.minima} - {found.cause_set})
    others = f"; shuffled orders give {counted(n_others, 'other sets')}" if n_others else ""
    return f"{len(found.cause_set)} of {n} keep {kept}{others}"


def _fault_table(shown: Shown, found: Explanation, faults: Specification) -> Table:
    pool = shown.code.pool
    rows = []
    for place, timed in zip(found.cause_set, faults, strict=True):
        fault = pool[timed.fault]
        window = timed.start, timed.finish
        values = fault.kind.in_words(timed.values)
        rows.append((shown.names[place], fault.type, fault.target, *window, values))
    return plain_table(("fault", "type", "of"), ("start", "finish"), rows, ("values",))


def _counts_table(shown: Shown, found: Explanation) -> Table:
    """Return what each goal's violations are under all faults, the cause set, and none."""
    rows = [
        (column.goal, column.kind, *map(shown.ticks, counts))
        for column, *counts in zip(
            found.columns,
            found.counts,
            found.kept,
            found.simplest_counts,
            found.fault_free,
            strict=True,
        )
        if any(counts)
    ]
    header = ("all faults", "cause set", "simplest", "no fault")
    return plain_table(("goal", "violations"), header, rows)


def _share_table(shown: Shown, found: Explanation) -> Table:
    """Return what part each fault of the cause set has in the counts."""
    places = [k for k, _ in enumerate(found.columns) if found.kept[k] or found.fault_free[k]]
    shares, margins = found.attribution.shares, found.attribution.margins
    rows = [
        (
            shown.names[place],
            *(
                f"{float(shares[row][k]) / shown.measure.n_seeds:.1f}"
                + (f" ±{margins[row][k] / shown.measure.n_seeds:.1f}" if margins else "")
                for k in places
            ),
        )
        for row, place in enumerate(found.cause_set)
    ]
    header = [f"{found.columns[k].goal}\n{found.columns[k].kind}" for k in places]
    return plain_table(("fault",), header, rows)


def _sentence(shown: Shown, found: Explanation) -> str:
    """Return what the fault did to which most is due, and which faults it needs."""
    shares = [sum(map(abs, of_fault)) for of_fault in found.attribution.shares]
    leading = shares.index(max(shares))
    place = found.cause_set[leading]
    timed = found.specification[place]
    said = sentence(shown.names[place], shown.code.pool[timed.fault], timed, found.chains[leading])
    others = [shown.names[other] for other in found.cause_set if other != place]
    return f"{said} With it: {' '.join(others)}." if others else said


def _chain_table(shown: Shown, found: Explanation) -> Table:
    """Return when and by how much belief, commands, truth and verdicts differ first."""
    rows = [
        (
            shown.names[place],
            *map(_first, (chain.belief, chain.command, chain.truth)),
            " ".join(map(_verdicts, chain.verdicts)),
        )
        for place, chain in zip(found.cause_set, found.chains, strict=True)
    ]
    last = ("goal:believed/true/missed",)
    return plain_table(("fault", "belief", "command", "truth"), (), rows, last)


def _first(first: First | None) -> str:
    if first is None:
        return NONE
    change = first.changes[0]
    return f"{first.tick} {change.owner} {change.quantity}\nby {change.size:.2f}"


def _verdicts(first: FirstVerdicts) -> str:
    cells = (NONE if verdict is None else str(verdict.tick) for verdict in first[1:])
    return f"{first.goal}:{'/'.join(cells)}"


def _firmness_table(found: Explanation) -> Table:
    rows = [
        (*column, f"{firm.median:g}", firm.least, firm.most, firm.n_violated)
        for column, firm in zip(found.columns, found.firmness, strict=True)
        if firm.most
    ]
    header = ("median", "least", "most", "seeds violated")
    return plain_table(("goal", "violations"), header, rows)


def _print_labels(shown: Shown, found: Explanation) -> None:
    """Print what every fault is to each goal, and the counts under it alone and without it."""
    goals = [each for each in found.goals if {*each.labels} != {BYSTANDER}]
    places = range(len(found.specification))
    named = [k for k in places if any(goal.labels[k] != BYSTANDER for goal in goals)]
    if named:
        _print_named(shown, found, goals, named)
    rest = [shown.names[k] for k in places if k not in named]
    if rest:
        click.echo(f"bystanders to every goal: {' '.join(rest)}\n")


def _print_named(
    shown: Shown, found: Explanation, goals: Sequence[GoalCauses], named: Sequence[int]
) -> None:
    """Print what some faults are to some goals."""
    header = [each.goal for each in goals]
    rows = [(shown.names[k], *(goal.labels[k] for goal in goals)) for k in named]
    print_table("What each fault is to each goal", plain_table(("fault", *header), (), rows))
    for title, counts in (("alone", found.alone), ("left out", found.left_out)):
        cells = [
            (shown.names[k], *(_cell(shown, found, goal.goal, counts[k]) for goal in goals))
            for k in named
        ]
        kinds = "/".join(dict.fromkeys(column.kind for column in found.columns))
        print_table(
            f"Violations with each {title}, {kinds}", plain_table(("fault",), header, cells)
        )


def _cell(shown: Shown, found: Explanation, goal: str, counts: Counts) -> str:
    pairs = zip(found.columns, counts, strict=True)
    return "/".join(shown.ticks(count) for column, count in pairs if column.goal == goal)


Explained: TypeAlias = tuple[Shown, Explanation]
"""A specification that violates something, and why."""


def print_findings(explained: Sequence[Explained]) -> None:
    """Print which of several explained specifications are the same finding."""
    groups = _findings(explained)
    n_explained = counted(len(explained), "specifications")
    rows = []
    for number, group in enumerate(groups, 1):
        shown, found = explained[group[0]]
        goals = zip(
            shown.code.mission.goal_ids,
            violated(found.outcome, shown.measure.duration),
            strict=True,
        )
        said = ", ".join(f"{goal} {what}" for goal, what in goals if what != "0/0")
        members = " ".join(explained[member][0].name for member in group)
        faults = " ".join(timed.fault for timed in found.cause)
        rows.append((number, members, faults, said))
    header = ("specifications", "faults", "believed/true")
    print_table(f"{counted(len(groups), 'findings')} in {n_explained}", _wrapping(header, rows))
    for number, group in enumerate(groups, 1):
        click.echo(f"{number}: {_sentence(*explained[group[0]])}\n")


def _findings(explained: Sequence[Explained]) -> tuple[Finding, ...]:
    return findings([found.cause for _, found in explained])


def _wrapping(header: Sequence[str], rows: Sequence[Sequence[object]]) -> Table:
    table = plain_table((), ("#",), (), header)
    for row in rows:
        table.add_row(*(Text(str(cell)) for cell in row))
    return table


def findings_as_json(explained: Sequence[Explained]) -> list[dict[str, Any]]:
    """Return what ``print_findings`` prints, for scripts."""
    return [
        {
            "specifications": [explained[member][0].title for member in group],
            "faults": [timed.fault for timed in explained[group[0]][1].cause],
            "goals": goals_as_json(
                explained[group[0]][0].code.mission, explained[group[0]][1].outcome
            ),
            "sentence": _sentence(*explained[group[0]]),
        }
        for group in _findings(explained)
    ]


def as_json(shown: Shown, found: Explanation | None) -> dict[str, Any]:
    """Return an explanation for scripts; counts are sums over the mission seeds."""
    what = {
        "specification": shown.title,
        "n_faults": len(shown.names),
        "keep": shown.keep,
        "measure": shown.measure.kind,
        "mission_seeds": shown.measure.n_seeds,
        "is_violated": found is not None,
    }
    return what if found is None else what | _found_as_json(shown, found)


def _found_as_json(shown: Shown, found: Explanation) -> dict[str, Any]:
    pool = shown.code.pool
    cause = {place: row for row, place in enumerate(found.cause_set)}
    shares = found.attribution.shares
    return {
        "columns": [column._asdict() for column in found.columns],
        "counts": list(found.counts),
        "fault_free": list(found.fault_free),
        "cause_set": {
            "faults": [shown.names[place] for place in found.cause_set],
            "counts": list(found.kept),
            "file": str(shown.paths[0]) if shown.paths else None,
            "shuffled": [[shown.names[place] for place in places] for places in found.minima],
        },
        "simplest": {
            "faults": [
                {
                    "id": shown.names[place],
                    "start": timed.start,
                    "finish": timed.finish,
                    "values": pool[timed.fault].kind.named(timed.values),
                }
                for place, timed in zip(found.cause_set, found.simplest, strict=True)
            ],
            "counts": list(found.simplest_counts),
            "file": str(shown.paths[1]) if shown.paths else None,
        },
        "goals": [
            {"goal": each.goal, "faults": [shown.names[place] for place in each.places]}
            for each in found.goals
        ],
        "faults": [
            {
                "id": shown.names[place],
                "fault": timed.fault,
                "type": pool[timed.fault].type,
                "target": pool[timed.fault].target,
                "start": timed.start,
                "finish": timed.finish,
                "values": pool[timed.fault].kind.named(timed.values),
                "labels": {each.goal: each.labels[place] for each in found.goals},
                "alone": list(found.alone[place]),
                "left_out": list(found.left_out[place]),
                "chain": _chain_as_json(found.chains[cause[place]]) if place in cause else None,
                "share": [float(x) for x in shares[cause[place]]] if place in cause else None,
            }
            for place, timed in enumerate(found.specification)
        ],
        "firmness": [asdict(firm) for firm in found.firmness],
        "sentence": _sentence(shown, found) if found.cause_set else None,
        "evaluations": dict(found.n_flown),
    }


def _chain_as_json(chain: Chain) -> dict[str, Any]:
    firsts = {"belief": chain.belief, "command": chain.command, "truth": chain.truth}
    return {
        **{
            name: None if first is None else _first_as_json(first) for name, first in firsts.items()
        },
        "verdicts": {
            each.goal: {
                name: None if verdict is None else verdict._asdict()
                for name, verdict in zip(each._fields[1:], each[1:], strict=True)
            }
            for each in chain.verdicts
        },
    }


def _first_as_json(first: First) -> dict[str, Any]:
    changes = [change._asdict() | {"size": change.size} for change in first.changes]
    return {"tick": first.tick, "changes": changes}
