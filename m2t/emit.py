"""Write generated files: model text in code, protected regions, and merging with edits.

Model text enters code only through filters: ``literal`` makes a Python literal, ``expression`` a
formatted expression from a tree of calls, ``remark`` safe text for a comment, and ``docstring`` a
docstring.

A region stands between the lines ``# protected region ID on begin`` and ``# protected region ID
end``, as in Epsilon's EGL, and belongs to the user. The rest of a file is its skeleton, which
belongs to the template. Hand-written code is never lost: unpaired markers are errors, an edited
region never disappears, and an edited skeleton is detected. EGL loses such code silently.

The manifest, ``manifest.json``, stands beside the generated files. It has hashes of the sources and
of the generated text, so that edits are detected, and the version of the semantics. Hashes inside
the files would change with every model and clutter every review.

Read in the order of the file: filters, regions, merging, and ``plan_files``, which uses all three.
"""

import hashlib
import json
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cache, cached_property
from io import StringIO
from itertools import zip_longest
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, TypeAlias

from mrsfi_runtime.errors import GenerationError, ProtectedRegionError
from mrsfi_runtime.files import MARKER, not_a_manifest
from mrsfi_runtime.model.fault_types import SEMANTICS

if TYPE_CHECKING:
    from jinja2 import Environment

LINE_LENGTH = 100
_EXCHANGED_QUOTES = str.maketrans("'\"", "\"'")
"""Python prefers single quotes, formatters prefer double ones."""

Scalar: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Call:
    """A call with keyword arguments; those without a name are positional.

    ``is_flat`` asks for one line if it fits; otherwise there is one argument per line, so that a
    changed value changes one line.
    """

    function: str
    arguments: tuple[tuple[str, "Expression"], ...] = ()
    is_flat: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A dictionary literal with text keys."""

    entries: tuple[tuple[str, "Expression"], ...]


@dataclass(frozen=True, slots=True)
class Name:
    """A name in code, never a text of a model; the part before a dot is imported."""

    text: str


Expression: TypeAlias = Scalar | Call | Table | Name | tuple["Expression", ...]


def literal(value: Scalar | tuple[object, ...]) -> str:
    """Return the Python literal of a scalar or tuple, in ASCII and as a formatter would write it.

    A number that is not finite raises a ``ValueError``, another type a ``TypeError``.
    """
    if value is None or isinstance(value, bool):
        return repr(value)
    if isinstance(value, str):
        if value.count('"') > value.count("'"):
            return ascii(value)
        return ascii(value.translate(_EXCHANGED_QUOTES)).translate(_EXCHANGED_QUOTES)
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"no literal for the number {value!r}; expected a finite one")
        return float.__repr__(value).replace("e+", "e")
    if isinstance(value, tuple):
        entries = ", ".join(literal(entry) for entry in value)  # type: ignore[arg-type]
        return f"({entries},)" if len(value) == 1 else f"({entries})"
    raise TypeError(f"no literal for a value of type {type(value).__name__}")


def remark(text: str) -> str:
    """Return free text as it may stand in a comment: one line of ASCII, 40 characters.

    A plain word stays as it is; everything else is quoted, escaped and cut.
    """
    if re.fullmatch(r"(?ai)(?!noqa|nosec)[A-Za-z0-9_.-]{1,40}", text):
        return text
    return ascii(text[:40])[:40].replace("#", "?")


def docstring(text: str) -> str:
    """Return free text as a docstring, in ASCII."""
    escaped = text.encode("unicode_escape").decode("ascii").replace('"', '\\"')
    return f'"""{escaped}"""'


def expression(value: Expression, indent: int = 0, used: int = 0) -> str:
    """Return a Python expression, laid out as a formatter would leave it.

    ``indent`` is the indentation of its first line, on which the surrounding code takes ``used``
    columns.
    """
    flat = _flat(value)
    opening, entries, closing = _parts(value)
    if flat is not None and (not entries or indent + used + len(flat) <= LINE_LENGTH):
        return flat
    inner = indent + 4
    lines = [
        f"{' ' * inner}{prefix}{expression(entry, inner, len(prefix) + 1)},\n"
        for prefix, entry in entries
    ]
    return f"{opening}\n{''.join(lines)}{' ' * indent}{closing}"


def _parts(value: Expression) -> tuple[str, list[tuple[str, Expression]], str]:
    """Return the opening of an expression, its entries with their prefixes, and its closing."""
    if isinstance(value, Call):
        arguments = [(f"{name}=" if name else "", entry) for name, entry in value.arguments]
        return f"{value.function}(", arguments, ")"
    if isinstance(value, Table):
        return "{", [(f"{literal(name)}: ", entry) for name, entry in value.entries], "}"
    return "(", [("", entry) for entry in value] if isinstance(value, tuple) else [], ")"


def _flat(value: Expression) -> str | None:
    """Return an expression on one line, or ``None`` if it has one entry per line.

    A tuple of one entry is always flat, because formatters join it if it fits.
    """
    if isinstance(value, Name):
        return value.text
    if not isinstance(value, Call | Table | tuple):
        return literal(value)
    if isinstance(value, tuple):
        is_short = len(value) < 2 or not any(
            isinstance(each, Call | Table | tuple) for each in value
        )
    else:
        is_short = isinstance(value, Table) or value.is_flat or not value.arguments
    opening, entries, closing = _parts(value)
    flat = [(prefix, _flat(entry)) for prefix, entry in entries] if is_short else []
    if not is_short or any(text is None for _, text in flat):
        return None
    joined = ", ".join(f"{prefix}{text}" for prefix, text in flat)
    comma = "," if isinstance(value, tuple) and len(flat) == 1 else ""
    return f"{opening}{joined}{comma}{closing}"


@cache
def template_environment(folder: str = "templates") -> "Environment":
    """Return the environment that renders a folder of ``m2t``; an undefined name is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # noqa: PLC0415 - slow

    environment = Environment(
        loader=PackageLoader("m2t", folder),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    filters = (literal, expression, remark, docstring)
    environment.filters |= {each.__name__: each for each in filters}
    return environment


_ALMOST_MARKER = re.compile(r"\s*#+\s*protected\s+region\b.*\b(begin|end)\s*", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Region:
    """A protected region, whose ID is built from a model ID: ``g1.check``.

    If ``is_on``, hand-written code in it is kept; otherwise it is always generated. The marker
    lines and the body between them include their line ends; ``line`` is that of ``begin``.
    """

    id: str
    is_on: bool
    begin: str
    body: str
    end: str
    line: int

    @property
    def text(self) -> str:
        """The region as it stands in the file."""
        return self.begin + self.body + self.end


@dataclass(frozen=True)
class GeneratedFile:
    """A generated file, cut into skeleton text and regions, in order."""

    name: str
    parts: tuple[str | Region, ...]

    @cached_property
    def regions(self) -> Mapping[str, Region]:
        """Regions by ID, in order."""
        return {part.id: part for part in self.parts if isinstance(part, Region)}

    @property
    def text(self) -> str:
        """The whole file."""
        return "".join(part if isinstance(part, str) else part.text for part in self.parts)

    @cached_property
    def skeleton(self) -> str:
        """The file with all regions empty and on: the part that belongs to the template."""
        return "".join(
            part
            if isinstance(part, str)
            else f"# protected region {part.id} on begin\n# protected region {part.id} end\n"
            for part in self.parts
        )


@dataclass(frozen=True, slots=True)
class FileRecord:
    """The manifest's record of a generated file: hashes of skeleton and region bodies."""

    skeleton: str
    regions: Mapping[str, str]


def text_hash(text: str) -> str:
    """Return the SHA-256 of a text in UTF-8."""
    return hashlib.sha256(text.encode()).hexdigest()


def record_of(file: GeneratedFile) -> FileRecord:
    """Return the manifest's record of a file as generated, before any merge."""
    regions = {region.id: text_hash(region.body) for region in file.regions.values()}
    return FileRecord(text_hash(file.skeleton), regions)


def parse(text: str, name: str) -> GeneratedFile:
    r"""Cut a file, with line ends ``\n``, into skeleton and regions; messages name it ``name``.

    Unbalanced, nested, repeated or misspelt markers raise a ``ProtectedRegionError``.
    """
    for number, line in enumerate(text_lines(text), start=1):
        content = line.removesuffix("\n")
        if _ALMOST_MARKER.fullmatch(content) and not MARKER.fullmatch(line):
            raise ProtectedRegionError(
                f"{name}:{number}: found the marker {content.strip()!r}; expected "
                "'# protected region ID on begin' or '# protected region ID end'; "
                "correct it or word the comment differently"
            )
    markers = [*MARKER.finditer(text)]
    parts: list[str | Region] = []
    lines: dict[str, int] = {}
    at = 0
    for begin, end in zip_longest(markers[::2], markers[1::2]):
        wrong = _marker_defect(begin, end, lines)
        if wrong is not None:
            raise ProtectedRegionError(f"{name}:{wrong}")
        at_line = lines[begin["id"]] = _line(begin)
        body = text[begin.end() : end.start()]
        region = Region(begin["id"], begin["state"] == "on", begin[0], body, end[0], at_line)
        parts += [text[at : begin.start()], region]
        at = end.end()
    parts.append(text[at:])
    return GeneratedFile(name, tuple(part for part in parts if part))


def _marker_defect(
    begin: re.Match[str], end: re.Match[str] | None, lines: Mapping[str, int]
) -> str | None:
    """Return line and defect of two markers that make no region; ``lines`` are of earlier ones."""
    region, line = begin["id"], _line(begin)
    if not begin["state"]:
        return _unexpected_end(begin, "no end")
    if region in lines:
        return (
            f"{line}: protected region '{region}' stands here for the second time, first in line "
            f"{lines[region]}; keep one of the two"
        )
    if end is None:
        return f"{line}: protected region '{region}' has no end; put its end marker back"
    if end["state"]:
        return (
            f"{_line(end)}: protected region '{end['id']}' begins inside '{region}' of line "
            f"{line}; put the missing end marker back"
        )
    return None if end["id"] == region else _unexpected_end(end, f"the end of '{region}'")


def _unexpected_end(end: re.Match[str], expected: str) -> str:
    return (
        f"{_line(end)}: protected region '{end['id']}' ends here, {expected} was expected; "
        "put the missing marker back"
    )


def _line(marker: re.Match[str]) -> int:
    return marker.string.count("\n", 0, marker.start()) + 1


def text_lines(text: str) -> list[str]:
    r"""Return the lines with their ends; unlike ``splitlines``, only ``\n`` ends a line."""
    return StringIO(text).readlines()


def merge(
    generated: GeneratedFile,
    existing: GeneratedFile,
    record: FileRecord | None,
    *,
    force: bool = False,
) -> str:
    """Return the generated file with the hand-written code of the existing one.

    Text equal to the manifest's ``record`` of the existing file was generated; without a record,
    all text counts as edited. If hand-written code would be lost (in a region that is off or no
    longer generated or, unless ``force``, in the skeleton), this raises a ``ProtectedRegionError``.
    """
    _require_no_orphans(generated, existing, record)
    text = "".join(
        part if isinstance(part, str) else _merged(part, existing, record)
        for part in generated.parts
    )
    if not force and existing.skeleton != generated.skeleton:
        _require_generated_skeleton(existing, record, text)
    return text


def is_hand_written(existing: GeneratedFile, record: FileRecord | None) -> bool:
    """Return whether a file was edited since it was generated."""
    return (
        record is None
        or record.skeleton != text_hash(existing.skeleton)
        or any(_is_edited(region, record) for region in existing.regions.values())
    )


def _merged(region: Region, existing: GeneratedFile, record: FileRecord | None) -> str:
    old = existing.regions.get(region.id)
    if old is None:
        return region.text
    if old.body == region.body or not _is_edited(old, record):
        return old.begin + region.body + old.end
    if not old.is_on:
        raise ProtectedRegionError(
            f"{existing.name}:{old.line}: protected region '{old.id}' was edited although it is "
            "off; write 'on' into its first line to keep the code, or undo the edit"
        )
    return old.text


def _is_edited(region: Region, record: FileRecord | None) -> bool:
    return record is None or record.regions.get(region.id) != text_hash(region.body)


def _require_no_orphans(
    generated: GeneratedFile, existing: GeneratedFile, record: FileRecord | None
) -> None:
    """Refuse to drop a region that holds code; an empty region may be dropped."""
    orphans = [
        region
        for region in existing.regions.values()
        if region.id not in generated.regions and region.body.strip() and _is_edited(region, record)
    ]
    if orphans:
        raise ProtectedRegionError(
            "\n".join(
                f"{existing.name}:{region.line}: protected region '{region.id}' holds hand-written "
                f"code, but element '{region.id.partition('.')[0]}' is no longer in the model; "
                "restore the element, or move the code elsewhere and empty the region"
                for region in orphans
            )
        )


def _require_generated_skeleton(
    existing: GeneratedFile, record: FileRecord | None, text: str
) -> None:
    """Refuse to overwrite, with ``text``, a skeleton that was not generated."""
    pairs = enumerate(zip_longest(text_lines(existing.text), text_lines(text)), start=1)
    place = f"{existing.name}:{next((number for number, (a, b) in pairs if a != b), 1)}"
    if record is None:
        raise ProtectedRegionError(
            f"{place}: differs here from the text to generate, and without a manifest this "
            "counts as an edit; move your edits into protected regions, then generate with --force"
        )
    if record.skeleton != text_hash(existing.skeleton):
        raise ProtectedRegionError(
            f"{place}: the file was edited outside its protected regions, and this is the first "
            "line that generation would change; move the edits into a region, then generate "
            "with --force, which overwrites what stands outside"
        )


MANIFEST = "manifest.json"
SCHEMA = 1
GENERATOR = "1"
"""Version of visitors and templates; increased when generated text changes."""


@dataclass(frozen=True, slots=True)
class GenerationPlan:
    """A plan to generate: present and new texts of the files in the folder, by name.

    ``existing`` has only files that are or were generated; ``contents`` include hand-written code.
    ``removed`` are files of earlier generations.
    """

    target: Path
    existing: Mapping[str, str]
    contents: Mapping[str, str]
    removed: tuple[str, ...]
    manifest: str

    @property
    def written(self) -> tuple[str, ...]:
        """Files that are missing or have another text."""
        return tuple(
            name for name, text in self.contents.items() if self.existing.get(name) != text
        )

    @property
    def unchanged(self) -> tuple[str, ...]:
        """Files that already have their text."""
        return tuple(name for name in self.contents if name not in self.written)

    @property
    def stale(self) -> tuple[str, ...]:
        """Files that differ from the models' meaning, the manifest included."""
        recorded, coming = self.existing.get(MANIFEST), self.manifest
        is_recorded = recorded is not None and _but_sources(recorded) == _but_sources(coming)
        return self.written + self.removed + (() if is_recorded else (MANIFEST,))

    @property
    def changes(self) -> dict[Path, bytes | None]:
        """New content of all changed files by path; ``None`` for removed ones."""
        texts = {**self.contents, MANIFEST: self.manifest}
        new = {name: text for name, text in texts.items() if self.existing.get(name) != text}
        contents = {self.target / name: text.encode() for name, text in new.items()}
        return {**contents, **{self.target / name: None for name in self.removed}}


def plan_files(
    target: Path,
    rendered: Mapping[str, str],
    sources: Mapping[str, str],
    *,
    force: bool = False,
    rewrite: Callable[[str, str], str] = lambda _, text: text,
) -> GenerationPlan:
    """Merge rendered files, by name, with the existing ones of a folder; write nothing.

    ``sources`` are the SHA-256 of every model and metamodel by file name. Edits outside protected
    regions are refused unless forced; the loss of hand-written code is always refused. ``rewrite``
    changes an existing text, given its name, before the merge.
    """
    recorded = _read(target / MANIFEST)
    known = {} if recorded is None else loads(recorded, str(target / MANIFEST))
    texts = {name: _read(target / name) for name in (*rendered, *known)}
    existing = {name: text for name, text in texts.items() if text is not None}
    standing = {
        name: parse(rewrite(name, text), str(target / name)) for name, text in existing.items()
    }
    contents: dict[str, str] = {}
    coming: dict[str, FileRecord] = {}
    for name, text in rendered.items():
        generated = parse(text, f"{target / name} (as generated)")
        coming[name] = record_of(generated)
        old = standing.get(name)
        contents[name] = merge(generated, old, known.get(name), force=force) if old else text
    removed = tuple(name for name in known if name in standing and name not in rendered)
    for name in removed:
        if is_hand_written(standing[name], known[name]):
            what = f"{target / name}: is no longer generated but holds hand-written code"
            raise ProtectedRegionError(f"{what}; move the code elsewhere and delete the file")
    existing |= {} if recorded is None else {MANIFEST: recorded}
    return GenerationPlan(target, existing, contents, removed, dumps(sources, coming))


def _read(path: Path) -> str | None:
    """Return the text of a file with plain line ends, or ``None`` if it does not exist."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        what = f"{path}: cannot be read as text in UTF-8 ({error})"
        raise GenerationError(f"{what}; correct or remove it") from error
    return text.replace("\r\n", "\n")


def dumps(sources: Mapping[str, str], files: Mapping[str, FileRecord]) -> str:
    """Return a manifest as JSON: the SHA-256 of the sources and the records of the files."""
    document = {
        "schema": SCHEMA,
        "generator": GENERATOR,
        "semantics": SEMANTICS,
        "sources": dict(sources),
        "files": {name: asdict(record) for name, record in files.items()},
    }
    return json.dumps(document, indent=2, sort_keys=True) + "\n"


def loads(text: str, name: str) -> dict[str, FileRecord]:
    """Return the records of files in a manifest, by name.

    An invalid manifest, or one of a newer mrsfi, raises a ``GenerationError`` about ``name``.
    """
    try:
        document = json.loads(text)
        schema = int(document["schema"])
        if schema > SCHEMA:
            found = f"{name}: has schema {schema}, written by a newer mrsfi"
            raise GenerationError(f"{found}; this one reads {SCHEMA}; generate with the newer one")
        return {
            _file_name(path): FileRecord(str(entry["skeleton"]), dict(entry["regions"].items()))
            for path, entry in document["files"].items()
        }
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        counts = "then everything in the generated files counts as edited"
        raise GenerationError(f"{not_a_manifest(name, error)}: {counts}") from error


def _but_sources(text: str) -> dict[str, Any]:
    """Return a manifest without its sources, whose spelling may differ without a meaning."""
    return {**json.loads(text), "sources": None}


def _file_name(name: str) -> str:
    if name != PurePath(name).name:
        raise ValueError(f"found {name!r} where a file name was expected")
    return name
