"""Import a model that was published for the paper's prototype as a mission folder."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from m2t.diagnostics import Diagnostic, Report
from m2t.elements import contained
from m2t.importing.campaign_files import campaign_files
from m2t.importing.identities import give_ids
from m2t.importing.notes import Note, Notes
from m2t.importing.published import ROOT, SETUP_NAMESPACE
from m2t.importing.reading import PublishedReader
from m2t.load import FAULTS_XMI, MISSION_XMI
from m2t.metamodels import load_metamodels
from m2t.read.nodes import Node, read_xml
from m2t.validate import validate_folder, validate_specification
from m2t.write.xmi import dumps, write_atomically
from mrsfi_runtime.errors import ModelError, UsageError


@dataclass(frozen=True, slots=True)
class Imported:
    """What an import wrote, and what a reader of it should know.

    Attributes
    ----------
    folder
        The mission folder.
    files
        Names of the files in it that were written.
    n_xmi_ids
        Number of elements that were identified by xmi:id.
    counts
        Number of elements of the result by what they are.
    notes
        What was renamed, dropped, filled in or found inconsistent.
    """

    folder: Path
    files: tuple[str, ...]
    n_xmi_ids: int
    counts: Mapping[str, int]
    notes: tuple[Note, ...]


def import_published(path: Path, folder: Path, *, is_forced: bool = False) -> Imported:
    """Turn a published file into a mission folder.

    Parameters
    ----------
    path
        The file: one ``Setup`` with a mission and fault specifications.
    folder
        Mission folder to make, such as ``models/harbour``.
    is_forced
        Whether to replace the models of a mission folder that exists; its other files stay.

    Returns
    -------
    Imported
        What was written.

    Raises
    ------
    ModelError
        With all errors, one a line, if the file cannot be read or if its model is not valid;
        then nothing is written.
    UsageError
        If the folder exists and must not be replaced, or cannot be written.

    Notes
    -----
    The first fault specification becomes ``faults.xmi``, any other ``faults_<ID>.xmi``. Where
    there is none, ``faults.xmi`` is an empty pool.
    """
    _require_free(folder, is_forced=is_forced)
    report, notes = Report(), Notes()
    xml = read_xml(path, report)
    report.require_no_errors()
    setup = None if xml is None else xml.root
    if setup is None or (setup.namespace, setup.tag) != (SETUP_NAMESPACE, ROOT):
        raise _wrong_root(path, setup)
    reader = PublishedReader(setup, _duration(setup), report, notes)
    mission, specifications = _roots(setup, reader, report)
    reader.resolve()
    report.require_no_errors()
    if not mission.name:
        mission.name = folder.name
        notes.add("default", reader.origins[mission], "name", f"is absent; set to {folder.name}")
    for root in (mission, *specifications):
        give_ids(root, reader, notes)
    if not specifications:
        specifications.append(_empty_pool(setup, reader, notes))
    models = _models(mission, specifications)
    files = _write(models, folder, _Origins(path, reader.origins, notes))
    return Imported(
        folder=folder,
        files=files,
        n_xmi_ids=reader.n_xmi_ids,
        counts=_counts(mission, specifications),
        notes=tuple(notes),
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


def _wrong_root(path: Path, root: Node | None) -> ModelError:
    found = "nothing" if root is None else f"{root.tag} of namespace '{root.namespace}'"
    line = 1 if root is None else root.line
    return ModelError(
        f"{path}:{line}: the root is {found}; expected {ROOT} of namespace '{SETUP_NAMESPACE}', as "
        "in the files published for the paper's prototype; models of mrsfi need no import "
        "[RootElement]"
    )


def _duration(setup: Node) -> int:
    """Return the duration that defaults depend on; a wrong one is reported when it is read."""
    missions = setup.tagged("mission")
    text = missions[0].attributes.get("duration", "") if missions else ""
    whole = text.partition(".")[0]
    return int(whole) if whole.isdecimal() and whole.isascii() and len(whole) < 10 else 1


def _roots(setup: Node, reader: PublishedReader, report: Report) -> tuple[Any, list[Any]]:
    """Read the mission and all fault specifications."""
    missions = setup.tagged("mission")
    if len(missions) != 1:
        finding = f"has {len(missions) or 'no'} mission; expected one; import one file a mission"
        report.add(setup, "RequiredFeature" if not missions else "SingleValue", finding)
        report.require_no_errors()
    known = load_metamodels()
    mission = reader.element(missions[0], known.mission_class)
    found = setup.tagged("specification")
    specifications = [reader.element(child, known.faults_class) for child in found]
    reader.drop_rest(setup, ("mission", "specification"))
    return mission, specifications


def _empty_pool(setup: Node, reader: PublishedReader, notes: Notes) -> Any:
    """Return a pool for the team to fill, so that the folder is that of a whole mission."""
    pool = load_metamodels().faults_class(ID="faults")
    reader.origins[pool] = setup
    message = f"is absent; {FAULTS_XMI} is an empty pool: it flies, a search needs faults in it"
    notes.add("default", setup, "specification", message)
    return pool


def _models(mission: Any, specifications: list[Any]) -> dict[str, Any]:
    """Return the root objects of the models by file name."""
    models = {MISSION_XMI: mission}
    for number, root in enumerate(specifications, 1):
        name = FAULTS_XMI if number == 1 else f"faults_{root.ID}.xmi"
        if name in models:
            name = f"faults_{number}_{root.ID}.xmi"
        models[name] = root
    return models


def _write(models: Mapping[str, Any], folder: Path, origins: "_Origins") -> tuple[str, ...]:
    """Validate the models where nobody looks, then write each file as a whole."""
    mission = models[MISSION_XMI]
    with TemporaryDirectory() as place:
        stage = Path(place)
        for name, root in models.items():
            hrefs = {} if root is mission else {mission: MISSION_XMI}
            (stage / name).write_bytes(dumps(root, hrefs=hrefs))
        origins.require_valid(stage, models)
        contents = {name: (stage / name).read_bytes() for name in models}
    cases = campaign_files(mission)
    contents |= {name: text for name, text in cases.items() if not (folder / name).exists()}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            write_atomically(folder / name, content)
    except OSError as error:
        message = f"{folder}: cannot be written: {error.strerror or error}; name another with --out"
        raise UsageError(message) from error
    return tuple(contents)


def _counts(mission: Any, specifications: list[Any]) -> dict[str, int]:
    return {
        "robots": len(mission.robots),
        "servers": len(mission.servers),
        "obstacles": len(mission.obstacles),
        "goals": len(mission.goals),
        "messages": sum(len(goal.messages) for goal in mission.goals),
        "faults": sum(len(root.faults) for root in specifications),
    }


@dataclass(frozen=True, slots=True)
class _Origins:
    """Leads from the result back to the published file."""

    path: Path
    nodes: Mapping[Any, Node]
    notes: Notes

    def require_valid(self, stage: Path, models: Mapping[str, Any]) -> None:
        """Validate the result; errors are raised, warnings noted, both by line of the file."""
        found = list(validate_folder(stage))
        for name in models:
            if name not in (MISSION_XMI, FAULTS_XMI):
                of_file = stage / name
                found += [each for each in validate_specification(of_file) if each.path == of_file]
        lines = {stage / name: _lines(stage / name, root) for name, root in models.items()}
        placed = [(each, self._origin(each, lines.get(each.path, {}))) for each in found]
        errors = [
            replace(each, path=self.path, line=origin.line)
            for each, origin in placed
            if each.severity == "error"
        ]
        if errors:
            raise ModelError("\n".join(str(each) for each in errors))
        for each, origin in placed:
            self.notes.add("inconsistent", origin, each.constraint, each.message)

    def _origin(self, found: Diagnostic, lines: Mapping[int, Any]) -> Node:
        """Return the node that a finding about the result is about; the mission if none is."""
        element = lines.get(found.line)
        return next(iter(self.nodes.values())) if element is None else self.nodes[element]


def _lines(path: Path, root: Any) -> dict[int, Any]:
    """Return the object that each line of a written file begins."""
    xml = read_xml(path, Report())
    nodes = () if xml is None else (n for n in xml.root.walk() if "href" not in n.attributes)
    return {node.line: element for node, element in zip(nodes, contained(root), strict=False)}
