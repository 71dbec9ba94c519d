"""Import a model that was published for the paper's prototype as a mission folder.

The folder gets campaign files to begin with: the paper's two cases.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from m2t.check.attribute_values import MAX_NAME_LENGTH
from m2t.constraints.fault_rules import check_faults
from m2t.constraints.mission_rules import check_mission
from m2t.diagnostics import Report, shown
from m2t.importing.identities import give_ids
from m2t.importing.notes import KINDS, Note, Notes
from m2t.importing.reading import ROOT, SETUP_NAMESPACE, PublishedReader
from m2t.load import FAULTS_XMI, MISSION_XMI, Objects
from m2t.metamodels import load_metamodels
from m2t.read.nodes import Node, read_root
from m2t.write.xmi import dumps
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import changing, whole_folder

_COUNTED = ("robots", "servers", "obstacles", "goals")

_CASE = """\
# Written by `mrsfi import`. {about}

[search]
algorithm = "paper"      # paper | random | drift
population = 20
generations = 50
faults = 20
crossover = 0.7
mutation = 0.7
selection = "roulette"
{fitness}
seed = 1
mission_seed = 1
"""
_ABOUT_A = "Case study A of the paper (section V-B 1): fitness function (1)."
_FITNESS_A = """\
fitness = "weighted"     # equation (1): 0.3 x all violations + 0.7 x distinct violated goals"""
_ABOUT_B = """\
Case study B of the paper (section V-B 1): fitness function (2)
# on one collision-focused and one energy-focused goal."""
_FITNESS_B = """\
fitness = "focused"      # equation (2): violations of the chosen goals
goals = [{goals}]"""


@dataclass(frozen=True, slots=True)
class Imported:
    """What an import wrote, and what a reader of it should know.

    ``n_xmi_ids`` elements were identified by xmi:id. ``counts`` has the number of elements of the
    result by what they are, ``notes`` what was renamed, dropped, filled in or found inconsistent.
    """

    folder: Path
    files: tuple[str, ...]
    counts: Mapping[str, int]
    n_xmi_ids: int
    notes: tuple[Note, ...]


def import_published(path: Path, folder: Path, *, is_forced: bool = False) -> Imported:
    """Turn a published file, one ``Setup`` with mission and fault specifications, into a folder.

    The first specification becomes ``faults.xmi``, an empty pool if there is none, any other
    ``faults_<ID>.xmi``. ``is_forced`` replaces the models of a mission folder that exists; its
    other files stay. A file that cannot be read or a model that is not valid is a ``ModelError``
    with all errors, one a line, and nothing is written; a folder that must not be replaced or
    cannot be written is a ``UsageError``.
    """
    _require_free(folder, is_forced=is_forced)
    origins: dict[Any, Node] = {}
    report = Report(origins)
    notes = Notes(report)
    setup = read_root(path, report)
    if (setup.namespace, setup.tag) != (SETUP_NAMESPACE, ROOT):
        finding = (
            f"of namespace {shown(setup.namespace)} is the root; expected {ROOT} of namespace "
            f"{SETUP_NAMESPACE}, as in the files published for the paper's prototype; models of "
            "mrsfi need no import"
        )
        report.add(setup, "RootElement", finding)
        report.require_no_errors()
    reader = PublishedReader(setup, origins, report, notes)
    roots = _roots(setup, reader, report)
    if not roots[0].attributes.get("name"):
        roots[0].attributes["name"] = folder.name[:MAX_NAME_LENGTH]
        notes.add("default", roots[0], "name", f"is absent; set to {folder.name}")
    for root in roots:
        give_ids(root, notes)
    trees = [reader.checked(root) for root in roots]
    report.require_no_errors()
    objects = Objects()
    mission, *specifications = map(objects.root, trees)
    origins.update((element, origins[node]) for element, node in objects.nodes.items())
    if not specifications:
        specifications.append(load_metamodels().faults_class(ID="faults"))
        origins[specifications[0]] = setup
        # A pool for the team to fill, so that the folder is that of a whole mission.
        said = f"is absent; {FAULTS_XMI} is an empty pool: it flies, a search needs faults in it"
        notes.add("default", setup, "specification", said)
    check_mission(mission, report)
    for pool in specifications:
        check_faults(pool, mission.duration, report)
    report.require_no_errors()
    notes += [
        Note("inconsistent", found.line, found.element, found.constraint, found.message)
        for found in report
    ]
    files = _write(_models(mission, specifications), folder)
    return Imported(
        folder=folder,
        files=files,
        n_xmi_ids=len(reader.by_xmi_id),
        counts=_counts(mission, specifications),
        notes=tuple(sorted(notes, key=lambda note: (KINDS.index(note.kind), note.line))),
    )


def _require_free(folder: Path, *, is_forced: bool) -> None:
    if not folder.exists() and not folder.is_symlink():
        return
    if not is_forced:
        message = f"{folder}: exists already; name another folder with --out, or replace its "
        raise UsageError(f"{message}models with --force")
    if not (folder / MISSION_XMI).is_file():
        message = f"{folder}: exists and holds no {MISSION_XMI}, so that it is no mission folder; "
        raise UsageError(f"{message}name another with --out")


def _roots(setup: Node, reader: PublishedReader, report: Report) -> list[Node]:
    """Return the mission and the specifications of a file, as nodes of our metamodels."""
    missions = setup.tagged("mission")
    if len(missions) != 1:
        finding = f"has {len(missions) or 'no'} mission; expected one; import one file a mission"
        report.add(setup, "RequiredFeature" if not missions else "SingleValue", finding)
        report.require_no_errors()
    known = load_metamodels()
    roots = [reader.model(missions[0], known.mission_class)]
    roots += [reader.model(child, known.faults_class) for child in setup.tagged("specification")]
    reader.drop_rest()
    reader.copy_elsewhere(roots[0])
    report.require_no_errors()
    return roots


def _models(mission: Any, specifications: list[Any]) -> dict[str, Any]:
    models = {MISSION_XMI: mission}
    for number, root in enumerate(specifications, 1):
        name = FAULTS_XMI if number == 1 else f"faults_{root.ID}.xmi"
        if name in models:
            name = f"faults_{number}_{root.ID}.xmi"
        models[name] = root
    return models


def _write(models: Mapping[str, Any], folder: Path) -> tuple[str, ...]:
    """Write all files or none; campaign files only where there are none."""
    mission = models[MISSION_XMI]
    contents = {
        name: dumps(root, hrefs={} if root is mission else {mission: MISSION_XMI})
        for name, root in models.items()
    }
    cases = _campaign_files(mission)
    contents |= {name: text for name, text in cases.items() if not (folder / name).exists()}
    if folder.exists():
        with changing(folder) as change:
            change.replace({folder / name: content for name, content in contents.items()})
    else:
        with whole_folder(folder) as new:
            for name, content in contents.items():
                (new / name).write_bytes(content)
    return tuple(contents)


def _counts(mission: Any, specifications: list[Any]) -> dict[str, int]:
    counts = {kind: len(getattr(mission, kind)) for kind in _COUNTED}
    counts["messages"] = sum(len(goal.messages) for goal in mission.goals)
    counts["faults"] = sum(len(root.faults) for root in specifications)
    return counts


def _campaign_files(mission: Any) -> dict[str, bytes]:
    """Return the campaign files of a mission by name: ``case_a.toml``, and maybe ``case_b.toml``.

    Case b takes both a goal that avoids collisions and one about energy; it names the first each.
    """
    files = {"case_a.toml": _CASE.format(about=_ABOUT_A, fitness=_FITNESS_A)}
    firsts = {goal.task.eClass.name: goal.ID for goal in reversed(mission.goals)}
    energy, collisions = map(firsts.get, ("SufficientEnergy", "AvoidCollision"))
    if collisions and energy:
        fitness = _FITNESS_B.format(goals=f'"{collisions}", "{energy}"')  # IDs need no quoting
        files["case_b.toml"] = _CASE.format(about=_ABOUT_B, fitness=fitness)
    return {name: text.encode("ascii") for name, text in files.items()}
