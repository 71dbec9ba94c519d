"""What ``mrsfi explain`` prints of an explanation, and what scripts get in its place."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click

from mrsfi.explaining import CAUSE_SET, SIMPLEST, of_goal
from mrsfi_runtime.analysis.campaign_tables import fault_table
from mrsfi_runtime.analysis.table import Table
from mrsfi_runtime.causes.cause import N_SEEDS
from mrsfi_runtime.causes.chain import First, FirstVerdicts, chain_as_json
from mrsfi_runtime.causes.counts import Counts
from mrsfi_runtime.causes.explanation import BYSTANDER, Explanation
from mrsfi_runtime.cli.terminal import print_table
from mrsfi_runtime.errors import counted
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.record.measure import NONE, Measure, ticks
from mrsfi_runtime.record.named_faults import NamedFault, named_faults


@dataclass(frozen=True, slots=True)
class Shown:
    """What is said of a specification beside its explanation.

    ``keep`` is the share of the counts that its cause set keeps; ``paths`` say where cause sets
    were written, by what they are.
    """

    code: MissionCode
    measure: Measure
    title: str
    faults: tuple[NamedFault, ...]
    keep: float
    paths: Mapping[str, Path]

    def ticks(self, count: float) -> str:
        """Return a sum over the mission seeds as text: a count, or a mean of counts."""
        n_seeds = self.measure.n_seeds
        return ticks(count if n_seeds == 1 else count / n_seeds)

    def simplest(self, found: Explanation) -> tuple[NamedFault, ...]:
        """Return the faults of the simplest form of its cause set."""
        names = [self.faults[place].name for place in found.cause.places]
        return named_faults(self.code.mission, self.code.pool, found.simplest, names)


def print_explanation(shown: Shown, found: Explanation | None) -> None:
    """Print an explanation for people, or that there is nothing to explain."""
    n = counted(len(shown.faults), "faults")
    if found is None:
        click.echo(f"{shown.title}: {n}, and no goal is violated; there is nothing to explain")
        return
    click.echo(f"{shown.title}: {_answer(shown, found, n)}")
    if shown.measure.n_seeds > 1:
        click.echo(f"Counts are means of {shown.measure.n_seeds} mission seeds.")
    click.echo()
    if found.cause.places:
        causes = [shown.faults[place] for place in found.cause.places]
        print_table(fault_table("Cause set", causes, found.cause.outcome))
        simple = shown.simplest(found)
        print_table(fault_table("Its simplest form", simple, found.simplest_outcome))
    print_table(_counts_table(shown, found))
    if found.cause.places:
        print_table(_share_table(shown, found))
        for said in found.cause.sentences(shown.faults):
            click.echo(f"{said}\n")
        print_table(_chain_table(shown, found))
        print_table(_robustness_table(found))
    _print_goals(shown, found)
    for part, n_flown in found.n_flown.items():
        click.echo(f"{n_flown:>6} flights  {part}")
    width = max(map(len, shown.paths), default=0)
    for what, path in shown.paths.items():
        click.echo(f"{what:<{width}}  {path}")
    click.echo()


def _answer(shown: Shown, found: Explanation, n: str) -> str:
    words = shown.measure.words
    if shown.measure.kind != "true":
        words = f"{words.removesuffix(' violations')} and true violations"
    kept = f"{100 * shown.keep:g} % of every goal's {words}"
    if not found.cause.places:
        return f"{n}, and none is the cause: without any, {kept} are there as well"
    n_others = len({*found.minima} - {found.cause.places})
    others = f"; shuffled orders give {counted(n_others, 'other sets')}" if n_others else ""
    return f"cause set {len(found.cause.places)} of {n}, which keeps {kept}{others}"


def _counts_table(shown: Shown, found: Explanation) -> Table:
    rows = [
        (column.goal, column.kind, *map(shown.ticks, counts))
        for column, *counts in zip(
            found.cause.columns,
            found.cause.counts,
            found.cause.kept,
            found.simplest_counts,
            found.cause.fault_free,
            strict=True,
        )
        if any(counts)
    ]
    words = ("goal", "violations")
    columns = (*words, "all faults", "cause set", "simplest", "no fault")
    return Table("Violations", columns, rows, words)


def _share_table(shown: Shown, found: Explanation) -> Table:
    places = [
        k
        for k, _ in enumerate(found.cause.columns)
        if found.cause.kept[k] or found.cause.fault_free[k]
    ]
    shares, margins = found.attribution.shares, found.attribution.margins
    rows = [
        (
            shown.faults[place].name,
            *(
                f"{float(shares[row][k]) / shown.measure.n_seeds:.1f}"
                + (f" ±{margins[row][k] / shown.measure.n_seeds:.1f}" if margins else "")
                for k in places
            ),
        )
        for row, place in enumerate(found.cause.places)
    ]
    header = [f"{found.cause.columns[k].goal}\n{found.cause.columns[k].kind}" for k in places]
    return Table("Due to each fault of the cause set", ("fault", *header), rows, ("fault",))


def _chain_table(shown: Shown, found: Explanation) -> Table:
    rows = [
        (
            shown.faults[place].name,
            *map(_first, (chain.belief, chain.command, chain.truth)),
            " ".join(map(_verdicts, chain.verdicts)),
        )
        for place, chain in zip(found.cause.places, found.cause.chains, strict=True)
    ]
    words, texts = ("fault", "belief", "command", "truth"), ("goal:believed/true/missed",)
    return Table("First differences that each fault makes", (*words, *texts), rows, words, texts)


def _first(first: First | None) -> str:
    if first is None:
        return NONE
    change = first.changes[0]
    return f"{first.tick} {change.owner} {change.quantity}\nby {change.size:.2f}"


def _verdicts(first: FirstVerdicts) -> str:
    cells = (NONE if verdict is None else str(verdict.tick) for verdict in first[1:])
    return f"{first.goal}:{'/'.join(cells)}"


def _robustness_table(found: Explanation) -> Table:
    rows = [
        (*column, f"{firm.median:g}", firm.least, firm.most, firm.n_violated)
        for column, firm in zip(found.cause.columns, found.cause.robustness, strict=True)
        if firm.most
    ]
    words = ("goal", "violations")
    columns = (*words, "median", "least", "most", "seeds violated")
    return Table(f"Violations under the cause set in {N_SEEDS} mission seeds", columns, rows, words)


def _print_goals(shown: Shown, found: Explanation) -> None:
    goals = [each for each in found.goals if {*each.labels} != {BYSTANDER}]
    columns = ("fault", *(each.goal for each in goals))
    named = {
        k: fault.name
        for k, fault in enumerate(shown.faults)
        if any(goal.labels[k] != BYSTANDER for goal in goals)
    }
    if named:
        rows = [(name, *(goal.labels[k] for goal in goals)) for k, name in named.items()]
        print_table(Table("What each fault is to each goal", columns, rows, words=columns))
        kinds = "/".join(dict.fromkeys(column.kind for column in found.cause.columns))
        for title, counts in (("alone", found.alone), ("left out", found.left_out)):
            cells = [
                (name, *(_cell(shown, found, goal.goal, counts[k]) for goal in goals))
                for k, name in named.items()
            ]
            print_table(Table(f"Violations with each {title}, {kinds}", columns, cells, ("fault",)))
    rest = [fault.name for k, fault in enumerate(shown.faults) if k not in named]
    if rest:
        click.echo(f"bystanders to every goal: {' '.join(rest)}\n")


def _cell(shown: Shown, found: Explanation, goal: str, counts: Counts) -> str:
    pairs = zip(found.cause.columns, counts, strict=True)
    return "/".join(shown.ticks(count) for column, count in pairs if column.goal == goal)


def as_json(shown: Shown, found: Explanation | None) -> dict[str, Any]:
    """Return an explanation for scripts; counts are sums over the mission seeds."""
    about = {
        "specification": shown.title,
        "n_faults": len(shown.faults),
        "keep": shown.keep,
        "measure": shown.measure.kind,
        "mission_seeds": shown.measure.n_seeds,
        "is_violated": found is not None,
    }
    if found is None:
        return about
    cause = found.cause
    rows = {place: row for row, place in enumerate(cause.places)}
    shares = found.attribution.shares

    def named(places: Iterable[int]) -> list[str]:
        return [shown.faults[place].name for place in places]

    def file(what: str) -> str | None:
        return str(shown.paths[what]) if what in shown.paths else None

    return about | {
        "columns": [column._asdict() for column in cause.columns],
        "counts": list(cause.counts),
        "fault_free": list(cause.fault_free),
        "cause_set": {
            "faults": named(cause.places),
            "counts": list(cause.kept),
            "file": file(CAUSE_SET),
            "shuffled": [named(places) for places in found.minima],
        },
        "simplest": {
            "faults": [{"id": each.name, **each.as_json()} for each in shown.simplest(found)],
            "counts": list(found.simplest_counts),
            "file": file(SIMPLEST),
        },
        "goals": [
            {"goal": each.goal, "faults": named(each.places), "file": file(of_goal(each.goal))}
            for each in found.goals
        ],
        "faults": [
            {
                "id": fault.name,
                "fault": fault.fault.id,
                **fault.as_json(),
                "labels": {each.goal: each.labels[place] for each in found.goals},
                "alone": list(found.alone[place]),
                "left_out": list(found.left_out[place]),
                "chain": chain_as_json(cause.chains[rows[place]]) if place in rows else None,
                "share": [float(x) for x in shares[rows[place]]] if place in rows else None,
            }
            for place, fault in enumerate(shown.faults)
        ],
        "firmness": [asdict(firm) for firm in cause.robustness],
        "sentences": list(cause.sentences(shown.faults)),
        "n_flown": dict(found.n_flown),
    }
