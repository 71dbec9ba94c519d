"""Print the results of a campaign: weaknesses, its report, explanations.

``mrsfi evolve``, ``report``, ``weaknesses``, ``show`` and ``explain`` share these functions. With
``--json`` they print the same facts as JSON.
"""

import datetime as dt
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click

from mrsfi.campaign_folders import OpenCampaign, deciding
from mrsfi.explaining import CAUSE_SET, SIMPLEST, harvested, of_goal, untried
from mrsfi.explaining import report as write_report
from mrsfi_runtime.analysis import tables, weaknesses
from mrsfi_runtime.analysis.summary import Summary, as_json
from mrsfi_runtime.analysis.tables import NONE, Table, ticks
from mrsfi_runtime.analysis.weaknesses import State
from mrsfi_runtime.causes.chain import N_SEEDS, First, FirstVerdicts, chain_as_json
from mrsfi_runtime.causes.consequences import estimate, risks
from mrsfi_runtime.causes.explanation import BYSTANDER, Explanation
from mrsfi_runtime.causes.harvest import Harvest
from mrsfi_runtime.causes.mildest import GoalWeakness
from mrsfi_runtime.causes.weakness import MEASURES, Weakness
from mrsfi_runtime.cli.terminal import print_json, print_table, print_words, tell
from mrsfi_runtime.errors import UndecidedWeakness, counted
from mrsfi_runtime.generated_code import MissionCode
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.record.decisions import KINDS
from mrsfi_runtime.record.observers import NamedFault, named_faults
from mrsfi_runtime.record.store import Measure


def print_verdicts(
    campaign: OpenCampaign, known: Harvest, *others: Harvest, goals: Sequence[str] | None = None
) -> None:
    """Print a sentence for each goal: whether it breaks, by which faults, on what evidence."""
    mission, pool = campaign.mission, campaign.pool
    wanted = mission.goal_ids if goals is None else goals
    found = [each for each in weaknesses.verdicts(mission, pool, known) if each.goal in wanted]
    print_words((weaknesses.headline(found), "bold"))
    for fact in weaknesses.facts(mission, pool, found, known, *others):
        print_words(fact)
    click.echo()
    held = [each for each in found if each.state is State.HOLDS]
    for each in found[: len(found) - len(held)]:
        state = (each.words, "bold red" if each.state <= State.VIOLATED else "bold")
        print_words((each.label, "bold"), " ", state, f"{each.because}.")
        if each.stakes:
            print_words(each.stakes, indent=4)
        print_words(" · ".join(each.evidence), indent=4)
    for bound in dict.fromkeys(each.bound for each in held):
        some = ", ".join(each.label for each in held if each.bound == bound)
        print_words(("No known weakness: ", "bold"), f"{some} ({bound})")
    for each in held:
        if each.nearest:
            print_words(f"{each.label}: {each.nearest}", indent=4)
    click.echo()


def print_all(
    campaign: OpenCampaign,
    found: Sequence[GoalWeakness],
    goals: Sequence[str],
    known: Harvest,
    *others: Harvest,
) -> None:
    """Print weaknesses, the bounds on those not found, and how many sets were not tried.

    With other campaigns, print how many weaknesses are estimated; with likelihoods, the risks.
    """
    mission, pool = campaign.mission, campaign.pool
    print_verdicts(campaign, known, *others, goals=goals)
    if found:
        print_table(weaknesses.matrix_table(mission, pool, found))
        title = "How, in one of the variants of each weakness"
        print_table(weaknesses.weakness_table(title, mission, pool, found))
        _print_decisions(campaign, found)
    for each in goals:
        print_words(weaknesses.not_found(known.known, each))
    click.echo()
    print_words(weaknesses.harmless(pool, known))
    print_words(weaknesses.untried_in_words(len(pool), untried(campaign, known, goals), goals))
    _print_estimates(campaign, goals, [each.weaknesses for each in (known, *others)])
    at_risk = risks(pool, goals, [each.goal_weaknesses for each in (known, *others)])
    if at_risk:
        click.echo()
    for goal, value in at_risk.items():
        print_words(weaknesses.risk_in_words(goal, value))


def _print_decisions(campaign: OpenCampaign, found: Sequence[GoalWeakness]) -> None:
    decided = deciding(campaign, dt.date.today())
    words = {each.number: decision for each in found if (decision := decided(each))}
    for number, decision in words.items():
        print_words((f"Weakness {number}: ", "bold"), decision)
    if words:
        click.echo()


def require_decided(campaign: OpenCampaign) -> None:
    """Refuse a campaign with weaknesses that are neither kept nor decided on, and report these."""
    from mrsfi.regressions import settled

    every, run = harvested(campaign).goal_weaknesses, campaign.folder.path
    done = settled(campaign, every, dt.date.today(), is_valid=True)
    found = [each for each in every if each.number not in done]
    for each in found:
        words = weaknesses.sentence(campaign.mission, campaign.pool, each)
        tell(f"undecided  weakness {each.number} ({' and '.join(each.faults)}): {words}")
    if found:
        tell(f"keep it    mrsfi keep {run} --weakness N")
        tell(f"or decide  mrsfi decide {run} N {'|'.join(KINDS)} --because TEXT --by NAME")
        n = counted(len(found), "weaknesses")
        raise UndecidedWeakness(f"{run}: found {n} neither kept nor decided on; expected none")


def _print_estimates(
    campaign: OpenCampaign, goals: Sequence[str], samples: Sequence[Sequence[Weakness]]
) -> None:
    run, store = campaign.folder.path, campaign.store
    click.echo()
    if len(samples) < 2:
        mission = store.manifest.mission or campaign.mission.name
        again = f"mrsfi evolve {mission} … --seed {store.settings.seed + 1}"
        print_words(
            "How many weaknesses there are is not estimated, because that takes campaigns with "
            f"different search seeds: {again}, then mrsfi weaknesses {run} --with RUN2"
        )
        return
    for goal in goals:
        print_words(weaknesses.estimated(goal, estimate(samples, goal), run))
    print_words(
        "The intervals (95 %) do not include weaknesses that a campaign hardly ever finds: each "
        "estimate is a lower bound"
    )


def print_bounds(pool: FaultPool, goals: Sequence[str], campaigns: Sequence[Harvest]) -> None:
    """Print the bounds on unknown weaknesses of goals as JSON, and estimates of their number.

    Rows without a measure have the estimate of a goal by any measure, and its risk.
    """
    known, samples = campaigns[0].known, [each.weaknesses for each in campaigns]
    rows: list[dict[str, Any]] = [
        {"goal": column.goal, "measure": column.kind, "draws": n, "bound": known.bound(column)}
        for column, n in known.n_kept.items()
        if column.goal in goals
    ]
    at_risk = risks(pool, goals, [each.goal_weaknesses for each in campaigns])
    if len(samples) > 1 or at_risk:
        whole = {goal: (found := at_risk.get(goal)) and found._asdict() for goal in goals}
        rows += [{"goal": goal, "measure": None, "risk": found} for goal, found in whole.items()]
    for row in rows if len(samples) > 1 else ():
        measures = MEASURES if row["measure"] is None else [row["measure"]]
        row["estimate"] = estimate(samples, row["goal"], measures).as_json()
    print_json(rows)


def print_found(campaign: OpenCampaign, found: Sequence[GoalWeakness]) -> None:
    """Print weaknesses as JSON, with a row for each measure."""
    decided, mission, pool = deciding(campaign, dt.date.today()), campaign.mission, campaign.pool
    rows = (
        row | {"decision": decided(each), "elsewhere": [one.as_json() for one in each.elsewhere]}
        for each in found
        for row in weaknesses.as_json(mission, pool, each)
    )
    print_json([*rows])


def print_mildest(campaign: OpenCampaign, found: Sequence[GoalWeakness], *, is_json: bool) -> None:
    """Print the mildest variant of each weakness."""
    told = [(each, each.mildest) for each in found if each.mildest is not None]
    if is_json:
        print_json([{"number": weakness.number, **each.as_json()} for weakness, each in told])
        return
    shown = [replace(weakness, by=(each.weakness,)) for weakness, each in told]
    title = "The mildest variant that was found of each weakness"
    print_table(weaknesses.weakness_table(title, campaign.mission, campaign.pool, shown))
    for weakness, each in told:
        click.echo(f"{weakness.number}  {each.sentence} ({counted(each.n_flights, 'flights')}).")


def report(
    campaign: OpenCampaign,
    ratio: str | None,
    *,
    is_json: bool,
    draws: bool = True,
    latex: bool = False,
) -> None:
    """Write the report into a campaign's folder, also figures, and print its summary, or JSON."""

    def show(summary: Summary) -> None:
        if is_json:
            print_json({"folder": str(path), **as_json(summary)})
        else:
            _print_summary(campaign, summary)
        if draws:
            tell(f"drawing figures into {campaign.folder.figures}, and {campaign.folder.page}")
        else:
            tell(f"writing {campaign.folder.page}; figures: mrsfi report {path}")
        if latex:
            tell(f"for LaTeX  {campaign.folder.latex}")

    path = campaign.folder.path
    try:
        today = dt.date.today()
        write_report(campaign, ratio, show, draws=draws, latex=latex, today=today)
    except KeyboardInterrupt:
        tell(f"the report is not complete; write it again with: mrsfi report {path}")
        raise


def _print_summary(campaign: OpenCampaign, summary: Summary) -> None:
    folder, known = campaign.folder.path, summary.harvest
    mission, pool = campaign.mission, campaign.pool
    if known is not None and summary.weaknesses:
        print_table(weaknesses.matrix_table(mission, pool, summary.weaknesses))
    else:
        print_table(tables.critical_table(summary.measure, pool, summary.top, summary.n_distinct))
    if summary.front is not None:
        print_table(tables.front_table(summary.front))
    if summary.harm:
        print_table(tables.harm_table(summary.harm, summary.measure))
    if summary.pick is not None:
        click.echo(f"{summary.pick.in_words(summary.measure)}\n")
    if known is not None:
        print_verdicts(campaign, known)
    failed = f", {summary.n_failures} ended with an error" if summary.n_failures else ""
    click.echo(f"campaign  {folder}: {summary.counted}{failed}")
    click.echo(f"digest    {summary.digest}")
    click.echo(f"page      {campaign.folder.page}")
    if known is None:
        doubt, advice = summary.unrepeated, f"mrsfi explain {folder} --all"
        click.echo(f"caution   {doubt}" if doubt else f"next      {advice}")
    elif summary.weaknesses:
        click.echo(f"next      mrsfi show {folder}")


@dataclass(frozen=True, slots=True)
class Shown:
    """The facts to print of a specification beside its explanation.

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

    def due(self, found: Explanation, place: int) -> Sequence[str | None]:
        """Return what is due to a fault, by column, with half of its interval if it has one."""
        if place not in found.cause.places:
            return [None] * len(found.cause.columns)
        row, n_seeds = found.cause.places.index(place), self.measure.n_seeds
        due = [f"{float(each) / n_seeds:.1f}" for each in found.attribution.shares[row]]
        if found.attribution.margins is None:
            return due
        margins = zip(due, found.attribution.margins[row], strict=True)
        return [f"{each} ±{margin / n_seeds:.1f}" for each, margin in margins]

    def simplest(self, found: Explanation) -> tuple[NamedFault, ...]:
        """Return the faults of the simplest form of its cause set."""
        names = [self.faults[place].name for place in found.cause.places]
        return named_faults(self.code.mission, self.code.pool, found.simplest, names)


def print_explanation(shown: Shown, found: Explanation | None) -> None:
    """Print an explanation, or that there is nothing to explain."""
    n = counted(len(shown.faults), "faults")
    if found is None:
        click.echo(f"{shown.title}: {n}. No goal is violated, so there is nothing to explain")
        return
    click.echo(f"{shown.title}: {_answer(shown, found, n)}")
    if shown.measure.n_seeds > 1:
        click.echo(f"Counts are means of {shown.measure.n_seeds} mission seeds.")
    click.echo()
    if found.cause.places:
        causes = [shown.faults[place] for place in found.cause.places]
        print_table(tables.fault_table("Cause set", causes, found.cause.outcome))
        simple = shown.simplest(found)
        print_table(tables.fault_table("Its simplest variant", simple, found.simplest_outcome))
    print_table(_counts_table(shown, found))
    _print_faults(shown, found)
    for part, n_flown in found.n_flown.items():
        click.echo(f"{n_flown:>6} flights  {part.replace('form', 'variant')}")
    width = max(map(len, shown.paths), default=0)
    for what, path in shown.paths.items():
        click.echo(f"{what:<{width}}  {path}")
    click.echo()


def _print_faults(shown: Shown, found: Explanation) -> None:
    for said in found.cause.sentences(shown.code.mission, shown.faults):
        click.echo(f"{said}\n")
    for table in (_chain_table(shown, found), _fault_table(shown, found)):
        if table.rows:
            print_table(table)
    labels = zip(*(goal.labels for goal in found.goals), strict=True)
    named = zip(shown.faults, labels, strict=True)
    if rest := [fault.name for fault, of in named if {*of} == {BYSTANDER}]:
        click.echo(f"Bystanders to every goal: {' '.join(rest)}\n")


def _answer(shown: Shown, found: Explanation, n: str) -> str:
    words = shown.measure.words
    if shown.measure.kind != "true":
        words = f"{words.removesuffix(' violations')} and true violations"
    kept = f"{100 * shown.keep:g} % of every goal's {words}"
    if not found.cause.places:
        return f"{n}, none of which is the cause: without faults, {kept} remain"
    n_others = len({*found.minima} - {found.cause.places})
    others = f". Other orders of search give {counted(n_others, 'other sets')}" if n_others else ""
    return f"the cause set has {len(found.cause.places)} of {n} and keeps {kept}{others}"


def _counts_table(shown: Shown, found: Explanation) -> Table:
    cause = found.cause
    counts = (cause.counts, cause.kept, found.simplest_counts, cause.fault_free)
    rows = [
        (*column, *map(shown.ticks, some), f"{firm.median:g}", *firm[1:])
        for column, firm, *some in zip(cause.columns, cause.robustness, *counts, strict=True)
        if any(some) or firm.most
    ]
    counted = ("all faults", "cause set", "simplest", "no fault")
    words = ("goal", "violations")
    columns = (*words, *counted, "median", "least", "most", "seeds violated")
    title = f"Violations, in ticks; the last four columns: cause set alone, {N_SEEDS} mission seeds"
    return Table(title, columns, rows, words, is_compact=True)


def _fault_table(shown: Shown, found: Explanation) -> Table:
    """Return what each fault is to each goal, with its counts, unless it is a bystander to it."""
    labels, rows = {goal.goal: goal.labels for goal in found.goals}, []
    for place, fault in enumerate(shown.faults):
        of_fault = (shown.due(found, place), found.alone[place], found.left_out[place])
        for column, due, *counts in zip(found.cause.columns, *of_fault, strict=True):
            label = labels[column.goal][place]
            if label != BYSTANDER or (due and float(due.partition(" ")[0])):
                rows.append((fault.name, *column, label, due, *map(shown.ticks, counts)))
    columns = ("fault", "goal", "violations", "label", "due to it", "alone", "left out")
    title = "Role of each fault for each goal; violations due to it, with it alone, without it"
    return Table(title, columns, rows, columns[:4], is_compact=True)


def _chain_table(shown: Shown, found: Explanation) -> Table:
    rows = [
        (
            shown.faults[place].name,
            *map(_first, (chain.belief, chain.command, chain.truth)),
            " ".join(map(_verdicts, chain.verdicts)),
        )
        for place, chain in zip(found.cause.places, found.cause.chains, strict=True)
    ]
    words, texts = ("fault", "belief", "command", "truth"), ("goal: believed/true/failed",)
    title = "First differences that each fault makes: ticks and sizes"
    return Table(title, (*words, *texts), rows, words, texts)


def _first(first: First | None) -> str:
    if first is None:
        return NONE
    change = first.changes[0]
    return f"{first.tick} {change.owner} {change.quantity}\nby {change.size:.2f}"


def _verdicts(first: FirstVerdicts) -> str:
    cells = (NONE if verdict is None else str(verdict.tick) for verdict in first[1:])
    return f"{first.goal}:{'/'.join(cells)}"


def explanation_as_json(shown: Shown, found: Explanation | None) -> dict[str, Any]:
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
    files = {what: str(path) for what, path in shown.paths.items()}

    def named(places: Iterable[int]) -> list[str]:
        return [shown.faults[place].name for place in places]

    return about | {
        "columns": [column._asdict() for column in cause.columns],
        "counts": list(cause.counts),
        "fault_free": list(cause.fault_free),
        "cause_set": {
            "faults": named(cause.places),
            "counts": list(cause.kept),
            "file": files.get(CAUSE_SET),
            "shuffled": [named(places) for places in found.minima],
        },
        "simplest": {
            "faults": [{"id": each.name, **each.as_json()} for each in shown.simplest(found)],
            "counts": list(found.simplest_counts),
            "file": files.get(SIMPLEST),
        },
        "goals": [
            {"goal": each.goal, "faults": named(each.places), "file": files.get(of_goal(each.goal))}
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
        "firmness": [firm._asdict() for firm in cause.robustness],
        "sentences": list(cause.sentences(shown.code.mission, shown.faults)),
        "n_flown": dict(found.n_flown),
    }
