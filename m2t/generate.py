"""Generate the middleware of a mission, and rename elements in models, code and regions.

``generate`` has one task per file: a visitor computes the template's context, the template renders
the text, and ``emit`` merges the text with hand-written code. Begin with ``plan``.

``with_new_ids`` finds the names of renamed elements in code by rendering it twice, with the old IDs
and with the new ones. Names that differ are then replaced in regions.

References
----------
Source paper, section III-D, the model-to-text transformations.
"""

import ast
import hashlib
import os
import tokenize
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import Any

from m2t import visitors
from m2t.emit import GenerationPlan, parse, plan_files, remark, template_environment, text_lines
from m2t.metaclasses import contained, identifier, is_kind, slots
from m2t.metamodels import FAULTS_FILE, MISSION_FILE, load_metamodels, metamodel_folder
from m2t.models.constraints import defects_of_id
from m2t.models.load import LoadedModels, edited, load_mission_folder, load_specification
from m2t.models.write import unified_difference
from m2t.read import ModelFiles, Report
from mrsfi_runtime.errors import GenerationError, ProtectedRegionError, UsageError, expected
from mrsfi_runtime.files import MARKER, changing, lines_in_regions

VISITORS: Mapping[str, Callable[[LoadedModels], Mapping[str, Any]]] = {
    "mission_loader.py": visitors.visit_mission_loader,
    "fault_loader.py": visitors.visit_fault_loader,
    "fault_effects.py": visitors.visit_fault_effects,
    "topics.py": visitors.visit_topics,
    "sim_interface.py": lambda _: {},  # uses the rows of topics.py, like the next one
    "simulation.py": lambda _: {},
    "collective_intelligence.py": visitors.visit_collective_intelligence,
}
"""The visitor of each generated file, whose template has the name of the file.

It computes the context of the template, without metamodel objects.
"""


def generate(models: Path, target: Path, *, force: bool = False) -> GenerationPlan:
    """Bring the generated code of a mission up to date; return the files written and removed.

    Edits outside protected regions are refused unless forced. Errors of the models raise a
    ``ModelError``; hand-written code that would be lost, or a file that cannot be written, raises a
    ``GenerationError``. If the folder of models is read-only, the folder of the code is locked.
    """
    place = models if os.access(models, os.W_OK) else target
    with changing(place) as change:
        planned = plan(models, target, force=force)
        try:
            change.replace(planned.changes)
        except UsageError as error:
            raise GenerationError(f"{error}; correct the cause and generate again") from error
    return planned


def plan(models: Path | LoadedModels, target: Path, *, force: bool = False) -> GenerationPlan:
    """Return the plan of ``generate`` for a mission folder, or for models loaded from one."""
    loaded = load_mission_folder(models) if isinstance(models, Path) else models
    return plan_files(target, rendered(loaded), sources(loaded), force=force)


def diff(models: Path, target: Path) -> str:
    """Return the changes by ``generate`` as a unified diff, without the manifest.

    File names are relative to the target folder, old ones below ``a/``, new ones below ``b/``.
    """
    planned, lines = plan(models, target), list[str]()
    for name in (*planned.written, *planned.removed):
        old, new = planned.existing.get(name), planned.contents.get(name)
        lines += unified_difference(
            text_lines(old or ""),
            text_lines(new or ""),
            "/dev/null" if old is None else f"a/{name}",
            "/dev/null" if new is None else f"b/{name}",
        )
    end = "\\ No newline at end of file\n"
    return "".join(line if line.endswith("\n") else f"{line}\n{end}" for line in lines)


def rendered(loaded: LoadedModels) -> dict[str, str]:
    """Return the text of every generated file by name, as its template renders it."""
    return {name: rendered_file(name, loaded) for name in VISITORS}


def rendered_file(name: str, loaded: LoadedModels) -> str:
    """Return the text of one file; ``fault_loader.py`` also serves written specifications."""
    template = template_environment().get_template(f"{name}.j2")
    mission = remark(loaded.mission_path.resolve().parent.name)
    header = f"# Generated from mission {mission} by {template.name}.\n"
    header += "# Edit inside protected regions only.\n"
    return header + template.render(VISITORS[name](loaded))


def sources(
    loaded: LoadedModels, contents: Mapping[Path, bytes] = MappingProxyType({})
) -> dict[str, str]:
    """Return the SHA-256 of all files of models and of metamodels, regardless of line ends.

    ``contents`` replace the present contents of files.
    """
    folder, metamodels = loaded.mission_path.parent, metamodel_folder()
    paths = {file.seen_from(folder): file.path for file in loaded.files}
    paths |= {name: metamodels / name for name in (MISSION_FILE, FAULTS_FILE)}
    return {
        name: hashlib.sha256(content.replace(b"\r\n", b"\n")).hexdigest()
        for name, path in paths.items()
        for content in (contents.get(path) or path.read_bytes(),)
    }


@dataclass(frozen=True, slots=True)
class WithNewIds:
    """Changes by new IDs: content by path of models and specifications, and code.

    Files in ``respelt`` change beyond their IDs, because Eclipse would spell them differently.
    ``code`` is ``None`` if no code is generated; ``difference`` is the unified diff of all changes.
    """

    contents: Mapping[Path, bytes]
    respelt: tuple[Path, ...]
    code: GenerationPlan | None
    difference: tuple[str, ...]


def with_new_ids(models: Path, target: Path, names: Mapping[str, str]) -> WithNewIds:
    """Return the changes by new IDs, given by old ones, all at once; write nothing.

    Fault specifications below the mission folder are renamed too. Generated code in ``target`` must
    be up to date. An unknown old ID, or a new one that is invalid, taken or a name in a region,
    raises a ``UsageError``; a region that is not Python a ``ProtectedRegionError``; unsound models
    or specifications a ``ModelError``.
    """
    loaded = load_mission_folder(models)
    _require_ids(loaded, names)
    before = rendered(loaded)
    edits = [edited(loaded, partial(_rename, names))]
    own = frozenset(file.path.resolve() for file in loaded.files)
    for path in sorted(models.rglob("*.xmi")):
        file = None if path.resolve() in own else ModelFiles(Report()).read(path)
        if file is not None and file.roots_of(load_metamodels().faults_class):
            specification = load_specification(path)
            if specification.mission_path.resolve() in own:
                rename = partial(_rename, _numbered(specification, names))
                edits.append(edited(specification, rename, without=own))
    contents = {path: new for edit in edits for path, new in edit.contents.items()}
    lines = [line for edit in edits for line in edit.difference]
    code = None
    if target.is_dir():
        after = rendered(loaded)
        rewrite = partial(_rewritten, target, before, after)
        code = plan_files(target, after, sources(loaded, contents), force=True, rewrite=rewrite)
        for name in code.written:
            named, old, new = str(target / name), code.existing.get(name, ""), code.contents[name]
            lines += unified_difference(old.splitlines(), new.splitlines(), named, named, "")
    respelt = tuple(path for edit in edits for path in edit.respelt)
    return WithNewIds(contents, respelt, code, tuple(lines))


def _rename(names: Mapping[str, str], models: LoadedModels) -> None:
    for element in (*_identified(models.mission), *_identified(models.faults)):
        element.ID = names.get(element.ID, element.ID)


def _identified(root: Any) -> Iterator[Any]:
    for element in () if root is None else contained(root):
        if "ID" in slots(element.eClass) and element.ID:
            yield element


def _numbered(specification: LoadedModels, names: Mapping[str, str]) -> Mapping[str, str]:
    """Return new IDs also for faults that a search numbered: ``f9.1`` follows ``f9``."""
    numbered = dict(names)
    for fault in specification.pool:
        base, dot, number = fault.ID.rpartition(".")
        if dot and base in names:
            numbered.setdefault(fault.ID, f"{names[base]}.{number}")
    return numbered


def _require_ids(models: LoadedModels, names: Mapping[str, str]) -> None:
    files = [[*_identified(root)] for root in (models.mission, models.faults)]
    known = dict.fromkeys(element.ID for own in files for element in own)
    for old in names:
        if old not in known:
            raise UsageError(f"found '{old}', but no element has this ID; {expected(old, known)}")
    for own in files:
        taken: dict[str, str] = {}
        for element in own:
            old, new = element.ID, names.get(element.ID, element.ID)
            is_named = own is files[0] and not is_kind(element.eClass, "Requirement")
            for defect in defects_of_id(new, becomes_name=is_named) if old in names else ():
                raise UsageError(f"{old}={new}: {defect.finding}")
            for name in (new, f"{identifier(new)} in Python")[: 1 + is_named]:
                if (other := taken.setdefault(name, old)) != old:
                    what = f"{other} and {old} would both be named {name}"
                    raise UsageError(f"{what}; expected an ID that no other element has")


def _rewritten(
    target: Path, before: Mapping[str, str], after: Mapping[str, str], name: str, text: str
) -> str:
    """Return a generated file with the names of a newer rendering instead of an older one's.

    Attributes, strings and comments stay, except the markers of regions. A file that is no longer
    generated stays as it is.
    """
    if name not in before:
        return text
    path, old, new = target / name, before[name], after[name]
    try:
        ast.parse(text, str(path))
    except SyntaxError as error:
        what = f"{path}:{error.lineno}: is not Python: {error.msg}"
        raise ProtectedRegionError(f"{what}; correct the region first") from error
    pairs = zip(_names_in(old), _names_in(new), strict=True)
    names = {earlier: later for earlier, later in pairs if earlier != later}
    ids = dict(zip(parse(old, "").regions, parse(new, "").regions, strict=True))
    tokens, lines, regions = [*_tokens(text)], text_lines(text), lines_in_regions(text)
    for token in tokens:
        row = token.start[0]
        if row in regions and token.string in {*names.values()} - {*names}:
            raise UsageError(
                f"{path}:{row}: region {regions[row]} uses the name {token.string}, which an "
                "element would get; expected another ID, or another name in the region"
            )
    for token in reversed(tokens):
        (row, begin), (_, end) = token.start, token.end
        word = names.get(token.string, token.string)
        marker = MARKER.fullmatch(token.string) if token.type == tokenize.COMMENT else None
        if marker is not None:
            at = slice(*marker.span("id"))
            word = token.string[: at.start] + ids.get(marker["id"], marker["id"])
            word += token.string[at.stop :]
        line = lines[row - 1]
        lines[row - 1] = line[:begin] + word + line[end:]
    return "".join(lines)


def _names_in(text: str) -> Iterator[str]:
    return (token.string for token in _tokens(text) if token.type == tokenize.NAME)


def _tokens(text: str) -> Iterator[tokenize.TokenInfo]:
    """Yield the comments of a text, and its names except attributes."""
    previous = ""
    for token in tokenize.generate_tokens(StringIO(text).readline):
        is_name = token.type == tokenize.NAME and previous != "."
        if is_name or token.type == tokenize.COMMENT:
            yield token
        previous = token.string
