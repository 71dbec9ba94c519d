"""Commands that keep weaknesses and check them, and their output.

First come the outputs of a check: tables, JSON, JUnit's XML and annotations for GitHub; then
``keep_command`` and ``check_command``. A ``Checked`` is the verdict on one kept weakness.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date, datetime
from functools import partial
from os.path import normpath
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mrsfi.engines import Given, again, chosen
from mrsfi_runtime.cli import options
from mrsfi_runtime.cli.terminal import print_json, print_table, tell, write_file
from mrsfi_runtime.errors import LimitExceeded, UsageError
from mrsfi_runtime.record.decisions import KINDS
from mrsfi_runtime.record.engine_settings import AUTO, Workers

if TYPE_CHECKING:
    from mrsfi.regressions import Checked
    from mrsfi_runtime.record.settings import Regression


_CAME_BACK, _UNKNOWN, _HOLDS = "came back", "cannot be judged", "holds"  # as in JSON
_IN_WORDS = {_CAME_BACK: "exceeds its limit", _HOLDS: "within its limit"}
_NO_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML does not allow: control characters, lone surrogates."""


def print_annotations(checked: "Iterable[Checked]") -> None:
    """Annotate, for GitHub, the lines of what exceeds its limit, expired, or cannot be judged."""
    for each in checked:
        kind, message = "error", f"{each.regression.name}: "
        if each.exceeded:
            message += " ".join((f"{each.excess.partition(': ')[2]}.", *each.why, *each.about))
        elif each.failure is not None:
            message += str(each.failure)
        elif each.warning:
            kind, message = "warning", message + each.warning
        else:
            continue
        for path, line in each.places or ((each.regression.specification, 1),):
            file = _escaped(normpath(path), ":,")
            click.echo(f"::{kind} file={file},line={line}::{_escaped(message)}")


def _escaped(text: str, more: str = "") -> str:
    for letter in ("%", "\r", "\n", *more):
        text = text.replace(letter, f"%{ord(letter):02X}")
    return text


def _print_tables(found: "Mapping[str, Sequence[Checked]]") -> None:
    for name, every in found.items():
        checked = [each for each in every if not each.is_decision]
        if checked:
            _print(name, checked)
        for each in every[len(checked) :]:
            click.echo(f"{name}: {' '.join(each.about) or f'cannot be judged: {each.failure}'}")
            if each.warning and each.failure is None:
                tell(f"warning: {each.warning}")


def _print(name: str, checked: "Sequence[Checked]") -> None:
    """Print the verdicts on a mission, and why a weakness exceeds its limit."""
    from mrsfi_runtime.analysis.tables import Table

    judged = [each for each in checked if each.counts]
    n_within = sum(_state(each) == _HOLDS for each in checked)
    within = "is within its limit" if n_within == 1 else "are within their limits"
    title = f"{name}: {n_within} of {len(checked)} kept weaknesses {within}"
    if judged:
        n_kept = _range(len(each.regression.mission_seeds) for each in judged)
        n_flown = _range(len(each.seeds) for each in judged)
        title += f" (mission seeds: {n_kept} with limits, {n_flown} flown)"
    words = ("kept", "violations", "goal")
    columns = (*words, "allowed", "now", "verdict")
    print_table(Table(title, columns, [*_rows(checked)], words, ("verdict",)))
    failed: dict[str, list[str]] = defaultdict(list)
    for each in checked:
        if each.gone:
            gone = ", ".join(each.gone)
            click.echo(f"{each.regression.name}: not in the pool: {gone} (flown as kept)\n")
        if each.regression.accepted:
            click.echo(f"{each.regression.name}: accepted because {each.regression.accepted}\n")
        if each.exceeded:
            click.echo(f"{each.regression.name} exceeds its limit. From {each.regression.found}")
            sentences = (*each.why, *each.about)
            click.echo("\n".join(f"  {sentence}" for sentence in sentences) + "\n")
        elif each.failure is not None:
            failed[str(each.failure)].append(each.regression.name)
    for message, names in failed.items():
        click.echo(f"{', '.join(names)} cannot be judged: {message}\n")


def _range(numbers: Iterable[int]) -> str:
    """Return ``5``, or ``1 to 5``."""
    found = sorted({*numbers})
    return " to ".join(map(str, dict.fromkeys((found[0], found[-1]))))


def _rows(checked: "Sequence[Checked]") -> Iterator[tuple[str | int, ...]]:
    from mrsfi_runtime.analysis.tables import NONE

    for each in checked:
        regression = each.regression
        head = (regression.name, regression.violations)
        if each.error is not None:
            yield (*head, NONE, NONE, NONE, _UNKNOWN)
            continue
        counts = ((goal, regression.limits[goal], now) for goal, now in each.now.items())
        for goal, most, now in [row for row in counts if any(row[1:])] or [(NONE, 0, 0)]:
            worse = _CAME_BACK if goal in each.exceeded else _UNKNOWN
            state = _HOLDS if now <= most else worse
            yield (*head, goal, most, now, _IN_WORDS.get(state, state))
            head = ("", "")


def _state(each: "Checked") -> str:
    if each.exceeded:
        return _CAME_BACK
    return _HOLDS if each.failure is None else _UNKNOWN


def verdict_as_json(each: "Checked") -> dict[str, Any]:
    """Return a verdict as plain values."""
    regression = each.regression
    return {
        "name": regression.name,
        "state": _state(each),
        "violations": regression.violations,
        "mission_seeds": list(each.seeds),
        "kept_seeds": list(regression.mission_seeds),
        "max": dict(regression.limits),
        "now": each.now,
        "exceeded": list(each.exceeded),
        "error": None if each.failure is None else str(each.failure),
        "not_in_pool": list(each.gone),
        "why": list(each.why),
        "found": regression.found,
        "accepted": regression.accepted,
        "about": list(each.about),
        "warning": each.warning,
    }


def write_junit(path: Path, found: "Mapping[str, Sequence[Checked]]") -> None:
    """Write all verdicts as JUnit's XML, which build servers read."""
    from xml.etree import ElementTree as ET

    root = ET.Element("testsuites")
    for name, checked in found.items():
        states = [*map(_state, checked)]
        counts = {"failures": states.count(_CAME_BACK), "errors": states.count(_UNKNOWN)}
        suite = ET.SubElement(root, "testsuite", name=name, tests=str(len(checked)))
        suite.attrib |= {kind: str(n) for kind, n in counts.items()}
        suite.set("time", f"{sum(each.seconds for each in checked):.3f}")
        for each in checked:
            about = {"classname": f"mrsfi.{name}", "name": each.regression.name}
            case = ET.SubElement(suite, "testcase", about, time=f"{each.seconds:.3f}")
            if each.exceeded:
                failure = ET.SubElement(case, "failure", message=each.excess)
                failure.text = "\n".join((f"Found in {each.regression.found}", *each.why))
            elif each.failure is not None:
                ET.SubElement(case, "error", message=str(each.failure))
            if each.about:
                ET.SubElement(case, "system-out").text = " ".join(each.about)
    for element in root.iter():
        element.text = element.text and _legal(element.text)
        element.attrib.update({key: _legal(value) for key, value in element.attrib.items()})
    ET.indent(root)
    write_file(path, ET.tostring(root, "utf-8", xml_declaration=True) + b"\n")


def _legal(text: str) -> str:
    """Return a text in which characters that XML does not allow are escaped."""
    return _NO_XML.sub(lambda found: ascii(found[0])[1:-1], text)


def _limits(_: click.Context, __: click.Parameter, text: str | None) -> dict[str, int] | None:
    if text is None:
        return None
    limits = {}
    for part in text.split(","):
        goal, _equals, ticks = part.strip().partition("=")
        if not goal or not ticks.isdecimal() or len(ticks) > 99:
            message = f"found '{part.strip()[:99]}'; expected GOAL=TICKS, such as g2=0"
            raise click.BadParameter(message)
        limits[goal] = int(ticks)
    return limits


@options.command(name="keep")
@click.argument("target", metavar="CAMPAIGN|MISSION")
@click.option("--weakness", type=click.IntRange(1), metavar="N", help="Number of the weakness.")
@click.option("--name", metavar="NAME", help="Name of its files [default: CAMPAIGN-weakness-N].")
@click.option(
    "--max", "limits", metavar="G=N,…", callback=_limits, help="Limit these goals only, to N ticks."
)
@options.seeds_option(
    "Limits are maxima over N mission seeds [default with --update: the seeds of each so far]."
)
@click.option(
    "--because", "accepted", default="", metavar="TEXT", help="Why these limits are accepted."
)
@click.option("--update", is_flag=True, help="Replace the limits of MISSION by today's counts.")
@options.engine_options(default=AUTO)
def keep_command(
    target: str,
    weakness: int | None,
    name: str | None,
    limits: Mapping[str, int] | None,
    n_seeds: int | None,
    accepted: str,
    update: bool,
    engine: Given,
) -> None:
    """Keep a weakness of CAMPAIGN with limits that mrsfi check compares.

    N is its number in mrsfi weaknesses. The faults are written to models/NAME/regressions/ as XMI,
    and beside them the limit: for how many ticks the goal may be violated. It is today's number
    unless --max gives another; with 0 the check fails until it is gone. Commit both files.
    After an intended change, --update replaces limits by today's counts, and prints the difference.

    \b
    Examples:
      mrsfi keep runs/uuv_sampling-a-1 --weakness 1
      mrsfi keep runs/uuv_sampling-a-1 --weakness 2 --name surfacing --max g2=0,g4=10
      mrsfi keep runs/uuv_sampling-a-1 --weakness 3 --seeds 5
      mrsfi keep uuv_sampling --update
      mrsfi keep uuv_sampling --update --name surfacing --because "the mast is lowered from v2 on"
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.regressions import keep

    if update:
        if weakness is not None or limits is not None:
            raise click.UsageError(
                "--update is for all kept weaknesses; leave out --weakness and --max"
            )
        _update(target, name, n_seeds, engine, accepted)
        return
    if weakness is None:
        raise click.UsageError("--weakness N is missing: the number of the weakness to keep")
    with open_campaign(Path(target)) as campaign:
        if engine:
            again(engine, campaign.store.manifest.engine)  # also where nothing is flown
        regression = keep(campaign, weakness, name, limits, n_seeds or 1, engine, accepted)
        for oddity in regression.idle(campaign.mission.duration):
            tell(oddity)
    tell(f"kept       {regression.specification}")
    tell(f"limits     {regression.path}")


def _update(
    mission: str, name: str | None, n_seeds: int | None, engine: Given, accepted: str
) -> None:
    from mrsfi.folders import find_mission
    from mrsfi.regressions import update

    settings = chosen(engine, AUTO)
    changed = update(find_mission(mission), settings, tell, n_seeds, name, accepted)
    for before, new in changed:
        _print_change(before, new)
    if not changed:
        click.echo("no difference")


def _print_change(before: "Regression", new: "Regression") -> None:
    click.echo(before.name)
    if new.mission_seeds != before.mission_seeds:
        click.echo(f"  mission seeds: {len(before.mission_seeds)} → {len(new.mission_seeds)}")
    if new.accepted != before.accepted:
        click.echo(f"  accepted because {new.accepted}")
    for goal, ticks in new.limits.items():
        if ticks != before.limits[goal]:
            click.echo(f"  {goal}: {before.limits[goal]} → {ticks}")


@click.command(name="decide")
@click.argument("run", metavar="RUN", type=click.Path(path_type=Path))
@click.argument("number", metavar="N", type=click.IntRange(1))
@click.argument("kind", type=options.OneOf(KINDS), metavar="|".join(KINDS))
@click.option("--of", type=click.IntRange(1), metavar="M", help="Weakness that it duplicates.")
@click.option("--because", required=True, metavar="TEXT", help="The reason.")
@click.option("--by", required=True, metavar="NAME", help="Who decides.")
@click.option("--until", type=click.DateTime(["%Y-%m-%d"]), metavar="DATE", help="Last valid day.")
def decide_command(run: Path, number: int, until: datetime | None, **given: Any) -> None:
    """Decide on weakness N of RUN: it is accepted, to be mitigated, or a duplicate.

    N is its number in mrsfi weaknesses. The decision is a file in models/NAME/decisions/ that names
    goal, measure and faults, so that it also holds for later campaigns; commit it. A weakness that
    becomes graver needs a new decision. Deciding again replaces the file.

    \b
    Examples:
      mrsfi decide runs/uuv_sampling-a-1 11 accept --because "KAL has a tether" --by "A. Rivera"
      mrsfi decide runs/uuv_sampling-a-1 2 mitigate --because "see T-7" --by Li --until 2027-03-01
      mrsfi decide runs/uuv_sampling-a-1 3 duplicate --of 2 --because "same sensor" --by Li
    """
    from mrsfi.campaign_folders import open_campaign
    from mrsfi.regressions import decide

    day = until and until.date()
    with open_campaign(run) as campaign:
        decision = decide(campaign, number, today=date.today(), until=day, **given)
    tell(f"decided    {decision.path}: {decision.in_words(decision.date)}")


@options.command(name="check")
@click.argument("mission", metavar="[MISSION|ARCHIVE]", required=False)
@options.generated_option
@options.seeds_option(
    "Fly in N mission seeds: first those of the limits, then others, in which more violations "
    "than the limit cannot be judged."
)
@click.option(
    "--digest", metavar="HEX", help="Refuse ARCHIVE unless mrsfi pack printed this digest for it."
)
@options.engine_options(default=AUTO)
@options.worker_options
@options.file_option("--junit", "Write the verdicts to FILE as JUnit's XML, for a build server.")
@click.option("--github", is_flag=True, help="Also annotate lines of models, for GitHub Actions.")
@click.option("--strict", "is_strict", is_flag=True, help="Treat expired decisions as errors.")
@click.option("--json", "is_json", is_flag=True, help="Print the verdicts as JSON.")
def check_command(  # noqa: PLR0913, PLR0917 - its options
    mission: str | None,
    generated: Path | None,
    engine: Given,
    workers: Workers,
    n_seeds: int | None,
    junit: Path | None,
    digest: str | None,
    github: bool,
    is_strict: bool,
    is_json: bool,
) -> None:
    """Fly every kept weakness of MISSION with today's models and code, and check its limits.

    Without MISSION it checks all of models/. If a goal has more violations than its limit allows,
    check prints why and ends with exit code 10. A weakness that cannot be judged any more, because
    a robot is gone, say, is an error: the others are flown all the same, and the exit code is the
    lowest of such errors. If nothing is kept, that is an error, too.

    It also prints the decisions of mrsfi decide. One that names a goal or a fault that is gone is
    an error; one that has expired is a warning, and with --strict an error with exit code 11.

    With an ARCHIVE of mrsfi pack, check compares its files with the list of their hashes, repeats
    the campaign with its own code, and compares the results with the record. Whoever changes a file
    and the list also changes the digest that mrsfi pack printed; --digest compares it.

    \b
    Examples:
      mrsfi check
      mrsfi check uuv_sampling --junit regressions.xml
      mrsfi check uuv_sampling --engine reference --seeds 5
      mrsfi check uuv_sampling --json | jq '.uuv_sampling[].state'
      mrsfi check for-the-paper.zip --digest 3f0c…
    """
    from mrsfi.folders import find_mission
    from mrsfi.regressions import check_mission, missions_with_kept

    if mission is not None and mission.endswith(".zip"):
        is_of_kept = bool(generated or n_seeds or junit or github)
        _repeat(Path(mission), engine, digest, is_of_kept=is_of_kept, is_json=is_json)
        return
    if digest is not None:
        raise click.UsageError("--digest needs an archive of mrsfi pack; expected ARCHIVE")
    if mission is None and generated is not None:
        raise click.UsageError("--generated needs MISSION")
    settings = chosen(engine, AUTO)
    places = [*missions_with_kept()] if mission is None else [find_mission(mission, generated)]
    if not places:
        raise UsageError(
            "found no kept weakness in models/*/regressions/; expected at least one; keep one "
            "with: mrsfi keep CAMPAIGN --weakness 1"
        )
    check = partial(check_mission, is_strict=is_strict, workers=workers)
    found = {each.name: check(each, settings, tell, n_seeds, date.today()) for each in places}
    if junit is not None:
        write_junit(junit, found)
    every = [each for checked in found.values() for each in checked]
    if is_json:
        print_json({name: [*map(verdict_as_json, some)] for name, some in found.items()})
    else:
        _print_tables(found)
    if github:
        print_annotations(every)
    _end(every)


def _repeat(
    archive: Path, engine: Given, digest: str | None, *, is_of_kept: bool, is_json: bool
) -> None:
    from mrsfi.campaign import repeat

    if is_of_kept:
        raise click.UsageError(
            f"{archive} is an archive, flown as recorded: --generated, --seeds, --junit and "
            "--github are for kept weaknesses"
        )
    numbers, campaign, found = repeat(archive, engine, digest, tell)
    if is_json:
        print_json({"is_same": True, "digest": campaign, "archive": found, "numbers": numbers})
        return
    same = ", ".join(f"{n} of {n} {kind}" for kind, n in numbers.items())
    click.echo(f"same: {same}")
    click.echo(f"campaign digest {campaign}")
    wanted = "as given" if digest else "compare it with the one that mrsfi pack printed"
    click.echo(f"archive digest {found}: {wanted}")


def _end(every: "Sequence[Checked]") -> None:
    failures = [each.failure for each in every if each.failure is not None]
    unknown = f"; {len(failures)} cannot be judged" if failures else ""
    back = [each.excess for each in every if each.exceeded]
    if back:
        raise LimitExceeded(f"{'; '.join(back)}{unknown}")
    if failures:
        raise min(failures, key=lambda error: error.exit_code)
