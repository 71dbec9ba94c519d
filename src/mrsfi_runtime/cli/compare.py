"""The commands ``mrsfi compare``, of two campaigns, algorithms or settings, and ``mrsfi history``.

``compare_command`` calls ``_compare_runs`` for two campaigns, a history of two. Everything else
compares searches over many seeds; their tables come last.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from datetime import date
from itertools import groupby
from math import isinf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from mrsfi.engines import Given, chosen
from mrsfi_runtime.analysis.tables import Cell, Table
from mrsfi_runtime.cli import options
from mrsfi_runtime.cli.options import OF_ENGINE
from mrsfi_runtime.cli.terminal import print_json, print_table, print_words, tell, write_file
from mrsfi_runtime.errors import TransportError, time_left
from mrsfi_runtime.record.engine_settings import AUTO, BOTH, Workers

if TYPE_CHECKING:
    from mrsfi.history import History
    from mrsfi_runtime.study.comparison import Comparison, RunResult, Sweep


def print_sweep(comparison: "Comparison", sweep: "Sweep", n_evaluations: int) -> None:
    """Print the median of each value, and which setups are better or worse than the paper's."""
    from mrsfi_runtime.study.comparison import quartiles
    from mrsfi_runtime.study.folder import setting_table

    title = (
        f"{len(comparison.algorithms)} setups, {len(comparison.seeds)} seeds, "
        f"{n_evaluations} evaluations per run: best fitness"
    )
    columns = ("setting", "value", "n_runs", "lower", "median", "upper")
    rows: list[Sequence[Cell]] = []
    for key, values in sweep.values.items():
        for number, value in enumerate(values):
            found = comparison.with_values({key: value})
            head = ("" if number else key, str(value), len(found))
            rows.append((*head, *astuple(quartiles(found))))
    print_table(Table(title, columns, rows, ("setting",)))
    table = setting_table(comparison)
    place, verdict = table.columns.index("a12"), table.columns.index("verdict")
    differ = [row for row in table.rows if row[verdict] in ("better", "worse")]
    if differ:
        differ.sort(key=lambda row: -float(row[place] or 0.0))
        print_table(replace(table, title="Setups that differ from the paper's", rows=differ))
    n_better = sum(row[verdict] == "better" for row in differ)
    result = f"{n_better} better, {len(differ) - n_better} worse" if differ else "none differs"
    n_others = len(comparison.algorithms) - 1
    print_words((f"Of {n_others} setups beside the paper's, {sweep.papers}: {result}", "bold"))


_OF_RUNS = {"targets", "lists_all", "markdown", "html", "is_json", *OF_ENGINE}
_all_option = click.option("--all", "lists_all", is_flag=True, help="List weaknesses that stayed.")


@options.command(name="compare")
@click.pass_context
@click.argument("targets", metavar="MISSION|RUN_A RUN_B", nargs=-1, required=True)
@options.generated_option
@click.option(
    "--case",
    default="a",
    show_default=True,
    metavar="a|b|FILE",
    help="Campaign file: case_NAME.toml beside the models, or any TOML file.",
)
@click.option(
    "--algorithms",
    default="paper,random,drift",
    show_default=True,
    metavar="NAME,NAME,…",
    help="Algorithms, as in a campaign file; with --sweep one [default: paper].",
)
@click.option(
    "--sweep",
    metavar="KEY=VALUES,…",
    help="Vary settings of one algorithm: crossover=0.3:0.9:5 or population=10,20,40.",
)
@click.option(
    "--seeds",
    type=click.IntRange(1),
    default=30,
    show_default=True,
    help="Runs of each algorithm, with seeds 1, 2, …",
)
@click.option(
    "--evaluations", type=click.IntRange(1), default=909, show_default=True, help="For each run."
)
@options.worker_options
@options.engine_options(default=AUTO, sides=(BOTH,))
@options.folder_option(
    "--out", "Folder of the comparison, new or to continue [default: runs/compare-NAME-CASE]."
)
@_all_option
@options.file_option("--markdown", "Write the comparison of two campaigns as Markdown.")
@options.file_option("--html", "Write the comparison of two campaigns as a page.")
@click.option("--json", "is_json", is_flag=True, help="Print the comparison as JSON.")
def compare_command(  # noqa: PLR0913 - one for each option
    ctx: click.Context,
    /,
    *,
    targets: tuple[str, ...],
    lists_all: bool,
    markdown: Path | None,
    html: Path | None,
    generated: Path | None,
    case: str,
    algorithms: str,
    sweep: str | None,
    seeds: int,
    evaluations: int,
    workers: Workers,
    engine: Given,
    out: Path | None,
    is_json: bool,
) -> None:
    """Compare two campaigns of a mission, or search algorithms or their settings on MISSION.

    With two campaign folders, from before and after a fix or an edit of the model, it prints which
    weaknesses are gone, new, or still there. Each is flown in the mission of the other campaign.

    With MISSION, each algorithm searches with several seeds and equally many evaluations. With
    --sweep, every combination of values does, and is compared with the paper's setup; LOW:HIGH:N
    are N values.

    It prints medians with quartiles, and for every two setups the Mann-Whitney U test, its p-value,
    the same adjusted for several tests on one measure (Holm), and A12: the probability that a run
    of the first is better than one of the second.

    \b
    Examples:
      mrsfi compare runs/uuv_sampling-a-1 runs/uuv_sampling-a-2 --markdown change.md
      mrsfi compare uuv_sampling
      mrsfi compare uuv_sampling --seeds 5 --evaluations 200 --out runs/quick
      mrsfi compare uuv_sampling --json | jq '.tests[] | select(.measure == "fitness")'
      mrsfi compare uuv_sampling --sweep crossover=0.3:0.9:5,population=10,20,40 --seeds 20

    The same command continues an interrupted comparison; finished runs are not repeated. This has
    the same digest as a run: mrsfi evolve MISSION --algorithm NAME --seed N --evaluations M.
    """
    if len(targets) > 1:
        _compare_runs(ctx, markdown, html, engine, workers)
        return
    if markdown or html or lists_all:
        raise click.UsageError("--all, --markdown and --html need two campaigns: RUN_A RUN_B")
    (mission,) = targets
    import mrsfi
    from mrsfi.comparing import default_folder
    from mrsfi_runtime.study.comparison import Sweep
    from mrsfi_runtime.study.folder import ComparisonFolder

    flown_by = chosen(engine, AUTO)
    workers.require_sense(flown_by)
    if sweep and ctx.get_parameter_source("algorithms") is ParameterSource.DEFAULT:
        algorithms = "paper"
    names = [name.strip() for name in algorithms.split(",")]
    loaded = mrsfi.load(mission, generated)
    kind = "sweep" if sweep else "compare"
    folder = ComparisonFolder(out or default_folder(loaded.name, case, kind))
    n_variants = len(Sweep.parse(sweep).settings()) if sweep else len(names)
    told = _Progress(folder.path, n_variants * seeds)
    try:
        found = loaded.compare(
            names,
            seeds,
            evaluations,
            sweep=sweep,
            case=case,
            out=folder.path,
            engine=flown_by,
            workers=workers.number,
            dask=workers.dask,
            progress=told.run,
            tell=tell,
            on_reached=told.begin,
        )
    except (KeyboardInterrupt, TransportError):
        if folder.runs.is_dir():
            tell(
                f"finished runs are kept in {folder.runs}; the same command continues with the rest"
            )
        raise
    _tell_fewer(found, evaluations)
    if is_json:
        content = json.loads(folder.summary.read_text(encoding="utf-8"))
        print_json({"folder": str(folder.path), **content})
        return
    if found.sweep is not None:
        print_sweep(found, found.sweep, evaluations)
    else:
        _print(found, evaluations)
    tables = "runs.csv, quartiles.csv, tests.csv"
    click.echo(f"runs         {folder.runs}")
    click.echo(f"tables       {folder.path}/{'settings.csv, ' if found.sweep else ''}{tables}")
    click.echo(f"figures      {folder.figures}")
    click.echo(f"summary      {folder.summary}")


def _compare_runs(
    ctx: click.Context, markdown: Path | None, html: Path | None, engine: Given, workers: Workers
) -> None:
    """Compare the campaigns that the command was given."""
    from mrsfi.history import history

    targets: tuple[str, ...] = ctx.params["targets"]
    for name, value in ctx.params.items():
        is_given = ctx.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if is_given and name not in _OF_RUNS:
            raise click.UsageError(f"--{name} {value}: is for a search, not for two campaigns")
    if len(targets) != 2:
        raise click.UsageError(f"found {len(targets)} campaigns; expected two, RUN_A RUN_B")
    found = history(map(Path, targets), engine, workers, date.today(), tell)
    _show(found, markdown, html, **{name: ctx.params[name] for name in ("lists_all", "is_json")})


def _show(
    found: "History",
    markdown: Path | None,
    html: Path | None,
    *,
    lists_all: bool,
    is_json: bool = False,
    has_runs: bool = False,
) -> None:
    """Print a history and write files of it; what is in all campaigns stands in one line.

    With ``has_runs``, tables of the campaigns come before that of the weaknesses.
    """
    from mrsfi import history
    from mrsfi_runtime.analysis.page import document
    from mrsfi_runtime.analysis.tables import plain, to_markdown

    courses = [each for each in found.courses if lists_all or not each.is_constant]
    rest = history.listed(each for each in found.courses if each not in courses)
    said, stayed = f"{history.sentence(found.courses)}.", f"In all campaigns: {rest or 'none'}."
    runs = history.run_tables(found) if has_runs else ()
    tables = (*runs, history.course_table(found, courses))
    if is_json:
        print_json([each.as_json() for each in found.courses])
    else:
        for table in tables:
            print_table(table)
        print_words(stayed)
        print_words((said, "bold"))
    if markdown is not None:
        text = "\n\n".join((said, plain(stayed), *map(to_markdown, tables)))
        write_file(markdown, f"{text}\n".encode())
    if html is not None:
        write_file(html, document(history.page(found)).encode())


@options.command(name="history")
@click.argument("runs", metavar="[RUN …]", nargs=-1, type=click.Path(path_type=Path))
@options.worker_options
@options.engine_options(default=AUTO, sides=(BOTH,))
@_all_option
@options.file_option("--output", "Draw the number of weaknesses of each goal: .png or .svg.")
@options.file_option("--html", "Write a page: a line for each campaign, a column a weakness.")
def history_command(
    runs: tuple[Path, ...],
    engine: Given,
    workers: Workers,
    lists_all: bool,
    output: Path | None,
    html: Path | None,
) -> None:
    """Print which weaknesses came, went and stayed over campaigns, from the earliest on.

    RUN are campaign folders of one mission, by default all in runs/, in the order of their dates.
    Each campaign also flies the weaknesses that it did not find, in the variant of another one.

    \b
    Examples:
      mrsfi history
      mrsfi history runs/uuv_sampling-a-* --html history.html
      mrsfi history --output history.png
    """
    from mrsfi import history
    from mrsfi.campaign_folders import campaigns_of
    from mrsfi.explaining import MAPS, require_format

    if output is not None:
        require_format(output, MAPS[1:])
    paths = campaigns_of(runs, tell)
    if not paths:
        raise click.UsageError("found no campaign with weaknesses in runs/; expected one: RUN …")
    found = history.history(paths, engine, workers, date.today(), tell)
    if output is not None:
        write_file(output, history.drawn(found, output.suffix))
    _show(found, None, html, lists_all=lists_all, has_runs=True)


@dataclass
class _Progress:
    path: Path
    n_runs: int
    n_new: int = 0
    began: float = 0.0

    def begin(self, who: str) -> None:
        tell(f"comparison {self.path}: {self.n_runs} runs, {who}")
        self.began = monotonic()

    def run(self, run: "RunResult", n_done: int, is_new: bool) -> None:
        place = f"run {n_done}/{self.n_runs}  {run.algorithm} seed {run.seed}"
        if not is_new:
            tell(f"{place}  was finished already")
            return
        self.n_new += 1
        rest = (monotonic() - self.began) / self.n_new * (self.n_runs - n_done)
        tell(
            f"{place}  best {run.best_fitness:.2f}  evaluations {run.n_evaluations}  "
            f"{run.seconds:.1f} s  {time_left(rest)}"
        )


def _tell_fewer(comparison: "Comparison", n_evaluations: int) -> None:
    for name in comparison.algorithms:
        n_fewer = sum(run.n_evaluations < n_evaluations for run in comparison.of(name))
        if n_fewer:
            tell(
                f"warning: {n_fewer} runs of {name} made fewer than {n_evaluations} evaluations, "
                "because some ended with an error or the search made no new specification"
            )


def _print(comparison: "Comparison", n_evaluations: int) -> None:
    title = (
        f"{len(comparison.algorithms)} algorithms, {len(comparison.seeds)} seeds, "
        f"{n_evaluations} evaluations per run"
    )
    words = ("measure", "algorithm")
    columns = (*words, "lower quartile", "median", "upper quartile")
    rows = [
        ("" if number else measure, name, *map(_number, astuple(found)))
        for measure, by_algorithm in comparison.quartiles.items()
        for number, (name, found) in enumerate(by_algorithm.items())
    ]
    print_table(Table(title, columns, rows, words))
    if comparison.tests:
        pair = ("measure", "first", "second")
        found = (*pair, "U", "p", "p (Holm)", "A12", "magnitude")
        title = "Mann-Whitney U test: is the first better than the second?"
        print_table(Table(title, found, [*_test_rows(comparison)], pair))
    _print_legend(comparison)


def _test_rows(comparison: "Comparison") -> Iterator[tuple[str, ...]]:
    for measure, tests in groupby(comparison.tests, lambda test: test.measure):
        of_measure = list(tests)
        if all(test.ranks.a12 == 0.5 for test in of_measure):
            continue
        for number, test in enumerate(of_measure):
            pair = ("" if number else measure, test.first, test.second)
            chances = map(_probability, (test.ranks.p_value, test.holm_p_value))
            yield (*pair, f"{test.ranks.u:g}", *chances, f"{test.ranks.a12:.3f}", test.effect)


def _print_legend(comparison: "Comparison") -> None:
    from mrsfi_runtime.study.comparison import MOST_OBJECTIVES

    names = [criterion.name for criterion in comparison.criteria]
    click.echo("fitness      best of a run")
    if "hypervolume" in names:
        click.echo(
            "hypervolume  share of the largest possible, from a reference point of -1 violations"
        )
    else:
        click.echo(f"hypervolume  not computed: needs 2 to {MOST_OBJECTIVES} goals")
    if "at_once_1" in names:
        click.echo("at_once_k    evaluations until one specification broke k goals")
        click.echo(
            "together_k   evaluations until all specifications so far broke k goals together"
        )


def _number(value: float) -> str:
    """Return a measured number with four to six digits, and ``never`` for infinity."""
    if isinf(value):
        return "never"
    return f"{value:.6g}" if abs(value) >= 1 else f"{value:.4g}"


def _probability(value: float) -> str:
    return f"{value:.3f}" if value >= 0.001 else f"{value:.1e}"
