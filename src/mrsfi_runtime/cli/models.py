"""Commands that make, check and change models: new, import, requirements, diff and others.

A command declares its options, calls ``mrsfi``, and prints. It imports what it needs when it runs,
so that ``mrsfi --help`` loads no toolchain.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click

from mrsfi_runtime.cli import options
from mrsfi_runtime.cli.terminal import print_changes, print_json, tell
from mrsfi_runtime.errors import EvaluationError, GenerationError, ModelError, UsageError, counted

if TYPE_CHECKING:
    from mrsfi.folders import MissionFolders
    from mrsfi.loading import Validated
    from mrsfi.models import Note


@click.command(name="new")
@click.argument("name", metavar="NAME")
@click.option("--from", "source", metavar="MISSION", help="Begin with the models of this mission.")
@click.option(
    "--import",
    "published",
    type=click.Path(path_type=Path, exists=True, dir_okay=False),
    metavar="FILE",
    help="Begin with a model published for the paper's prototype.",
)
@click.option(
    "--node", metavar="ws://…", help="Also write [node], the topics of your node, from a server."
)
@click.option(
    "--install",
    type=click.Choice(["wheel", "index", "git"]),
    default="wheel",
    show_default=True,
    help="Source from which build servers install mrsfi: a wheel in vendor/, pip's index, or the "
    "git repository of this mrsfi.",
)
def new_command(
    name: str, source: str | None, published: Path | None, node: str | None, install: str
) -> None:
    """Make the folder NAME: a project, ready for git, with a mission NAME that flies.

    It holds the metamodels, for Eclipse and for extensions; a small mission and its pool of faults;
    a campaign file; generated code; a Makefile; mrsfi.toml, by which commands work from any folder
    inside; and files for two common build servers, which fly the kept weaknesses on each change. If
    this mrsfi was installed from a wheel, vendor/ has a copy of it for them.

    \b
    Examples:
      mrsfi new demo && cd demo && make evolve
      mrsfi new harbour --from models/uuv_sampling      begin with an existing mission
      mrsfi new harbour --import published.xmi          begin with a model of the paper's prototype
      mrsfi new harbour --node ws://127.0.0.1:9090      begin with the topics of your robots
    """
    from mrsfi.starting import start, wheel_of

    if source is not None and published is not None:
        raise click.UsageError("--from and --import exclude each other")
    folder = start(name, source, published, node, install)
    click.echo(f"made       {folder}/, with the mission models/{name}")
    if install == "wheel" and not wheel_of(folder).exists():
        click.echo(f"needed     {wheel_of(folder)} for build servers: `make wheel` builds it")
    click.echo(f"next       cd {folder} && make evolve")
    click.echo(f"then       mrsfi keep runs/{name}-a-1 --weakness 1 && make regressions")


@click.command(name="import")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path, exists=True))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Mission folder to make [default: models/ and the name of FILE].",
)
@click.option("--force", is_flag=True, help="Replace the models of an existing mission folder.")
@click.option("--json", "is_json", is_flag=True, help="Print the result as JSON.")
def import_command(file: Path, out: Path | None, force: bool, is_json: bool) -> None:
    """Turn FILE, a model published for the paper's prototype, into a mission folder.

    FILE has a root Setup of namespace acs_project_setup, with a mission and its fault
    specifications. Every number and reference is kept. Readable IDs replace xmi:id: the element's
    own where possible, else one from its place, such as g1_area. If the result has an error, import
    prints the line of FILE, ends with exit code 3, and makes no folder.

    \b
    Examples:
      mrsfi import ~/downloads/mission.model
      mrsfi import published.xmi --out models/harbour
      mrsfi import published.xmi --out models/harbour --force     replace its models
      mrsfi import published.xmi --json | jq '.notes[] | select(.kind == "inconsistent")'

    \b
    What it lists, with the line of FILE:
      renamed       an ID that was missing, unusable or taken
      dropped       what the models here do not have: parentID, goal_ID, values of Zero types
      default       what the old format lacks or leaves out: the period of Patrol (a tenth of the
                    mission), the deadline of Visit (the last tick) and its tolerance (1.0), the
                    tolerance of Track (10.0) and of FixedDistanceBetweenRobots (1.0); an absent
                    number is 0, an absent sensor type GPS_POSITION
      inconsistent  what contradicts the rest of FILE, and every warning of `mrsfi validate`

    Without fault specifications in FILE, faults.xmi is empty; add faults before you search. Also
    written: case_a.toml, and case_b.toml if there are goals for it, unless they exist.
    """
    from mrsfi.engines import project
    from mrsfi.models import import_published

    usual = re.sub(r"[^A-Za-z0-9_.-]+", "_", file.stem).strip("_.-") or "imported"
    result = import_published(file, out or project().models / usual, is_forced=force)
    if is_json:
        print_json({**asdict(result), "folder": str(result.folder)})
        return
    for name in result.files:
        click.echo(f"written       {result.folder / name}")
    counts = ", ".join(counted(n, noun) for noun, n in result.counts.items())
    click.echo(f"kept          {counts}")
    click.echo(f"renamed       {counted(result.n_xmi_ids, 'xmi:ids')}, now IDs or places")
    _print_notes(result.notes)
    click.echo(f"next          mrsfi validate {result.folder}")


def _print_notes(notes: "Iterable[Note]") -> None:
    """Print the changes to a model, in one line if several elements changed alike."""
    alike: defaultdict[tuple[str, str, str], list[Note]] = defaultdict(list)
    for note in notes:
        alike[note.kind, note.feature, note.message].append(note)
    for (kind, feature, message), same in alike.items():
        if len(same) == 1:
            where = f"line {same[0].line}, {same[0].element}: {feature}"
        else:
            lines = ", ".join(str(note.line) for note in same[:8])
            more = ", ..." if len(same) > 8 else ""
            where = f"{feature} of {len(same)} elements (lines {lines}{more})"
        click.echo(f"{kind:<12}  {where} {message}")


@click.command(name="diff")
@click.argument("old", metavar="OLD")
@click.argument("new", metavar="NEW")
@click.option("--json", "is_json", is_flag=True, help="Print the changes as JSON.")
def diff_command(old: str, new: str, is_json: bool) -> None:
    """Print how model NEW differs from model OLD, element by element.

    OLD and NEW are mission folders, or files of a mission or of faults. Elements are matched by ID,
    and by content where one was renamed. Differences of notation (order of attributes, comments, 4
    for 4.0) do not count. The models need not be valid.

    \b
    Examples:
      mrsfi diff uuv_sampling tight_margins
      git show HEAD:models/uuv_sampling/mission.xmi > old.xmi
      mrsfi diff old.xmi models/uuv_sampling/mission.xmi
      mrsfi diff old.xmi uuv_sampling --json | jq '.changes[].element'

    \b
    What it prints:
      robot r2: speed 4.0 → 6.0
      goal g3: members r2 r3 r1 → r2 r3
      goal g7 added (Patrol)
      robot r1 renamed scout
      fault f9: NEW_X 200.0 → 250.0

    The order is that of NEW, mission before faults. Equal models give `no difference`. The exit
    code is 0 in both cases.
    """
    from mrsfi.models import difference

    with TemporaryDirectory(prefix="mrsfi-diff-") as kept:
        changes = difference(_model(old, Path(kept) / "old"), _model(new, Path(kept) / "new"))
    if is_json:
        print_json({"old": old, "new": new, "changes": [asdict(change) for change in changes]})
        return
    for change in changes:
        click.echo(change.text)
    if not changes:
        click.echo("no difference")


def _model(name: str, kept: Path) -> Path:
    from mrsfi.engines import project
    from mrsfi.models import piped

    for path in (Path(name), project().models / name):
        if path.is_fifo():
            return piped(path, kept)
        if path.exists():
            return path
    raise UsageError(
        f"found no model '{name}'; expected a mission folder, its name, or an .xmi file"
    )


def _names(_: click.Context, __: click.Parameter, words: tuple[str, ...]) -> dict[str, str]:
    names: dict[str, str] = {}
    for word in words:
        old, _equals, new = word.partition("=")
        if not old or not new or old in names:
            message = f"found '{word}'; expected OLD=NEW, such as r1=scout_1, each OLD once"
            raise click.BadParameter(message)
        names[old] = new
    return names


@click.command(name="rename")
@options.mission_argument
@click.argument("names", metavar="OLD=NEW...", nargs=-1, required=True, callback=_names)
@options.generated_option
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
def rename_command(
    mission: str, names: Mapping[str, str], generated: Path | None, diff: bool
) -> None:
    """Give elements of MISSION other IDs, in all files at once.

    OLD is the ID of any element. It changes in the models, in every fault specification below their
    folder, in campaign files, limits of kept weaknesses, decisions, and generated code,
    also in its protected regions. Strings, comments and display names do not change, nor does the
    source of a kept weakness. The mission flies to the same digest.

    \b
    Examples:
      mrsfi rename uuv_sampling r1=scout_1 r2=scout_2 --diff
      mrsfi rename uuv_sampling r1=scout_1 r2=scout_2
      mrsfi rename uuv_sampling g1=g2 g2=g1       two IDs change places

    Either all files are written or none. A script beside the models that names an old ID, such as
    build.py, is not edited: rename prints its line.
    """
    from mrsfi.folders import find_mission
    from mrsfi.generating import rename, renaming

    options.print_metamodels()
    renamed = (renaming if diff else rename)(find_mission(mission, generated), names)
    if diff:
        print_changes(renamed.respelt, renamed.difference)
    else:
        for path in renamed.paths:
            click.echo(f"written    {path}")
    for path, line, name in renamed.scripts:
        tell(f"{path}:{line}: contains {name}; rename it also in this script")


@click.command(name="validate")
@options.mission_argument
@options.generated_option
@click.option("--json", "is_json", is_flag=True, help="Print the diagnostics as JSON.")
@click.option(
    "--fix", "is_fix", is_flag=True, help="Repair what has one remedy; show a diff first."
)
@click.option("--yes", "is_agreed", is_flag=True, help="With --fix: write without asking.")
@click.option("--strict", "is_strict", is_flag=True, help="Treat warnings as errors.")
@click.pass_context
def validate_command(
    ctx: click.Context,
    /,
    mission: str,
    generated: Path | None,
    *,
    is_json: bool,
    is_fix: bool,
    is_agreed: bool,
    is_strict: bool,
) -> None:
    """Check the models of MISSION and print every defect.

    MISSION is the name of a folder in models/, the path of one, or a fault specification
    (.xmi), written by hand or found by search.

    \b
    Examples:
      mrsfi validate uuv_sampling
      mrsfi validate runs/uuv_sampling-a-1/critical/01.xmi
      mrsfi validate uuv_sampling --json | jq '.diagnostics[].constraint'
      mrsfi validate uuv_sampling --fix

    Each defect is one line: file, line, severity, what was found and what was expected, and the
    constraint. Errors in models end with exit code 3, errors only in regions of the generated code
    with 6. Warnings alone end with 0; --strict treats them as errors. If there is no error and the
    generated code is fresh, the mission is flown twice without faults: a flight that ends with an
    error or differs is an error too, a goal that is violated is a warning. So is code in a region
    that the compiled engine cannot compile, or would compile to something else.

    --fix first repairs each defect that has one sensible remedy: it shows the change as a diff, and
    writes it once you agree (--yes agrees in advance), as Eclipse writes files. If an element was
    deleted, it also removes references to it and all that is incomplete without it.
    """
    from mrsfi.loading import n_errors, validate

    if is_fix and is_json:
        raise UsageError("--fix shows a diff and --json does not; give one of them")
    if is_agreed and not is_fix:
        raise UsageError("--yes agrees to what --fix would change; give both")
    options.print_metamodels()
    if is_fix:
        _fix(mission, generated, is_agreed=is_agreed)
    found = validate(mission, generated, tell)
    if is_strict:
        found = found.strict()
    n_found = n_errors(found.diagnostics)
    n_warnings = len(found.diagnostics) - n_found
    if is_json:
        diagnostics = [{**each._asdict(), "path": str(each.path)} for each in found.diagnostics]
        counts = {"n_errors": n_found, "n_warnings": n_warnings}
        print_json({"mission": found.name, **counts, "diagnostics": diagnostics})
    else:
        _print_lines(found, n_found, n_warnings)
    if n_found:
        ctx.exit(ModelError.exit_code if n_errors(found.models) else EvaluationError.exit_code)


def _fix(mission: str, generated: Path | None, *, is_agreed: bool) -> None:
    from mrsfi.loading import mending, write_mended

    inspection, mended = mending(mission, generated)
    if mended is None:
        why = "" if inspection.draft else ": correct the errors of structure by hand first"
        click.echo(f"nothing to fix{why}")
        return
    for found, title in mended.fixed:
        click.echo(f"{found.path}:{found.line}: fix: {title} [{found.constraint}]")
    print_changes(mended.respelt, mended.difference)
    if not is_agreed and not click.confirm("Write these changes?"):
        click.echo("nothing written")
        return
    write_mended(mended)
    for path in mended.contents:
        click.echo(f"fixed      {path}")


def _print_lines(found: "Validated", n_found: int, n_warnings: int) -> None:
    for each in found.diagnostics:
        click.echo(f"{each.path}:{each.line}: {each.severity}: {each.message} [{each.constraint}]")
    warnings = counted(n_warnings, "warnings")
    if n_found:
        click.echo(f"{found.name}: {counted(n_found, 'errors')}, {warnings}")
    else:
        held = (counted(number, nouns) for nouns, number in found.counts.items())
        click.echo(f"ok: {found.name}: {', '.join((*held, warnings))}")


@click.command(name="generate")
@options.mission_argument
@options.generated_option
@click.option("--check", is_flag=True, help="Write nothing; exit code 4 if a file is stale.")
@click.option("--diff", is_flag=True, help="Write nothing; print what would change.")
@click.option("--force", is_flag=True, help="Overwrite edits made outside protected regions.")
def generate_command(
    mission: str, generated: Path | None, check: bool, diff: bool, force: bool
) -> None:
    """Generate the middleware of MISSION into generated/NAME/.

    What you write between `# protected region … begin` and `… end` is kept, also when robots
    are renamed or goals are added. If generation would lose hand-written code, it stops with exit
    code 4 and changes nothing. A second run changes nothing. A user-defined goal task has empty
    regions: generate writes them, and lists them with exit code 4 until you fill them.

    \b
    Examples:
      mrsfi generate uuv_sampling
      mrsfi generate uuv_sampling --diff      what would a changed model change?
      mrsfi generate uuv_sampling --check     for continuous integration
    """
    from mrsfi.folders import find_mission
    from mrsfi.generating import diff as difference

    folders = find_mission(mission, generated)
    if sum((check, diff, force)) > 1:
        raise click.UsageError("--check, --diff and --force exclude each other")
    options.print_metamodels()
    if check:
        folders.require_fresh()
        click.echo(f"fresh: {folders.generated}")
    elif diff:
        click.echo(difference(folders.models, folders.generated), nl=False)
    else:
        _write(folders, force=force)


def _write(folders: "MissionFolders", *, force: bool) -> None:
    from mrsfi.generating import generate
    from mrsfi_runtime.generated_code import unfilled_regions

    result = generate(folders.models, folders.generated, force=force)
    for verb in ("written", "removed", "unchanged"):
        for name in getattr(result, verb):
            click.echo(f"{verb:<9}  {folders.generated / name}")
    unfilled = unfilled_regions(folders.generated)
    if unfilled:
        raise GenerationError("\n".join(each.words for each in unfilled))


@click.command(name="requirements")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.argument("target", metavar="MISSION|CAMPAIGN")
@click.option("--text", metavar="NAME", default="ReqIF.Text", help="Name of the value with a text.")
@click.option("--id", metavar="NAME", default="ReqIF.ForeignID", help="Name of the one with an ID.")
@options.file_option("--output", "Where FILE is written with the results of CAMPAIGN.")
def requirements_command(file: Path, target: str, text: str, id: str, output: Path | None) -> None:
    """Read the requirements of FILE, in ReqIF, into the model of MISSION, or write their results.

    Each SPEC-OBJECT of FILE that has a text becomes a Requirement. --text and --id name the values
    that have text and ID [default: ReqIF.Text, ReqIF.ForeignID]; without such an ID, its identifier
    is used. Characters that no ID may have become _. Requirements that only the model has are kept.

    With --output, a copy of FILE gets one more value for each requirement that was read, Result of
    mrsfi: undetected, late, in time, none found, or not searched. It is the gravest of the goals of
    CAMPAIGN that name the requirement.

    \b
    Examples:
      mrsfi requirements models/undersea/requirements.reqif undersea
      mrsfi requirements harbour.reqif harbour --text Description --id ID
      mrsfi requirements harbour.reqif runs/harbour-a-1 --output out.reqif
    """
    from mrsfi.folders import find_mission
    from mrsfi.models import ReqifFile, import_requirements

    if output is None:
        done = import_requirements(find_mission(target).models, ReqifFile(file, text, id))
    else:
        from mrsfi.explaining import export_results

        done = export_results(ReqifFile(file, text, id), Path(target), output)
    for what, names in done.items():
        if names:
            click.echo(f"{what:12} {', '.join(names)}")
    if output is None and done["written"]:
        click.echo(f"next         name them in goals, then mrsfi generate {target}")
