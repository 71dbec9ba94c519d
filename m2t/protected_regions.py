"""Protected regions: the parts of a generated file that belong to the user.

A region is what stands between the lines ``# protected region ID on begin`` and
``# protected region ID end``, as Epsilon's EGL writes them. Everything else of a file is its
skeleton and belongs to the template.

Notes
-----
Stricter than EGL, which loses code silently: markers that do not pair up are errors, a
region that is no longer generated may only go if nobody edited it, and an edited skeleton is
noticed.
"""

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from io import StringIO
from itertools import zip_longest

from mrsfi_runtime.errors import ProtectedRegionError
from mrsfi_runtime.files import MARKER

_ALMOST_MARKER = re.compile(r"\s*#+\s*protected\s+region\b.*\b(begin|end)\s*", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Region:
    """A protected region, whose ID is built from a model ID: ``g1.check``.

    ``is_on`` says whether hand-written code in it is kept; one that is off is always generated.
    The marker lines and the body between them have their line ends; ``line`` is of ``begin``.
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
        """The file with empty regions, all of them on: what the template is answerable for."""
        return "".join(
            part
            if isinstance(part, str)
            else f"# protected region {part.id} on begin\n# protected region {part.id} end\n"
            for part in self.parts
        )


@dataclass(frozen=True, slots=True)
class FileRecord:
    """What the manifest remembers of a generated file: hashes of skeleton and region bodies."""

    skeleton: str
    regions: Mapping[str, str]


def text_hash(text: str) -> str:
    """Return the SHA-256 of a text in UTF-8."""
    return hashlib.sha256(text.encode()).hexdigest()


def record_of(file: GeneratedFile) -> FileRecord:
    """Return what the manifest is to remember of a file as generated, before any merge."""
    regions = {region.id: text_hash(region.body) for region in file.regions.values()}
    return FileRecord(text_hash(file.skeleton), regions)


def parse(text: str, name: str) -> GeneratedFile:
    r"""Cut a file, with line ends ``\n``, into skeleton and regions; messages name it ``name``.

    Unbalanced, nested, doubled or misspelt markers are a ``ProtectedRegionError``.
    """
    _require_spelling(text, name)
    markers = [*MARKER.finditer(text)]
    parts: list[str | Region] = []
    seen: dict[str, int] = {}
    at = 0
    for begin, end in zip_longest(markers[::2], markers[1::2]):
        line = _line(begin)
        wrong = _what_is_wrong(begin, end, seen)
        if wrong is not None:
            raise ProtectedRegionError(f"{name}:{wrong}")
        seen[begin["id"]] = line
        body = text[begin.end() : end.start()]
        region = Region(begin["id"], begin["state"] == "on", begin[0], body, end[0], line)
        parts += [text[at : begin.start()], region]
        at = end.end()
    parts.append(text[at:])
    return GeneratedFile(name, tuple(part for part in parts if part))


def _require_spelling(text: str, name: str) -> None:
    """Refuse lines that look like markers and are none."""
    for number, line in enumerate(text_lines(text), start=1):
        content = line.removesuffix("\n")
        if _ALMOST_MARKER.fullmatch(content) and not MARKER.fullmatch(line):
            raise ProtectedRegionError(
                f"{name}:{number}: found the marker {content.strip()!r}; expected "
                "'# protected region ID on begin' or '# protected region ID end'; "
                "mend it or word the comment differently"
            )


def _what_is_wrong(
    begin: re.Match[str], end: re.Match[str] | None, seen: Mapping[str, int]
) -> str | None:
    """Return line and defect of two markers that make no region; ``seen`` has those before."""
    region, line = begin["id"], _line(begin)
    if not begin["state"]:
        return _unexpected_end(begin, "no end")
    if region in seen:
        return (
            f"{line}: protected region '{region}' stands here for the second time, first in line "
            f"{seen[region]}; keep one of the two"
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

    What is equal to the manifest's ``record`` of the existing file was generated; without one, all
    counts as edited. If hand-written code would be lost, in a region that is off or no
    longer generated or, unless ``force``, in the skeleton, it is a ``ProtectedRegionError``.
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
    """Return whether anything in a file was edited since it was generated."""
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
    """Refuse to drop a region that holds code; one that was emptied may go."""
    orphans = [
        region
        for region in existing.regions.values()
        if region.id not in generated.regions and region.body.strip() and _is_edited(region, record)
    ]
    if orphans:
        raise ProtectedRegionError(
            "\n".join(
                f"{existing.name}:{region.line}: protected region '{region.id}' holds hand-written "
                f"code, but element '{region.id.partition('.')[0]}' is gone from the model; "
                "bring the element back, or move the code elsewhere and empty the region"
                for region in orphans
            )
        )


def _require_generated_skeleton(
    existing: GeneratedFile, record: FileRecord | None, text: str
) -> None:
    """Refuse to overwrite a skeleton that was not generated; ``text`` is what would replace it."""
    place = f"{existing.name}:{_first_difference(existing.text, text)}"
    if record is None:
        raise ProtectedRegionError(
            f"{place}: differs here from what would be generated, and no manifest says whether "
            "by hand; move your edits into protected regions, then generate with --force"
        )
    if record.skeleton != text_hash(existing.skeleton):
        raise ProtectedRegionError(
            f"{place}: the file was edited outside its protected regions, and this is the first "
            "line that generation would change; move the edits into a region, then generate "
            "with --force, which overwrites what stands outside"
        )


def _first_difference(old: str, new: str) -> int:
    pairs = zip_longest(text_lines(old), text_lines(new))
    return next((number for number, (a, b) in enumerate(pairs, start=1) if a != b), 1)
