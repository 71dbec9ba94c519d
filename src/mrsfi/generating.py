"""Generate the code of a mission, and give elements other IDs in all its files.

``renaming`` gives elements other IDs in models, code, campaign files, kept limits and decisions. It
computes all new contents before anything is written: all files change or none.
"""

import ast
import re
import tokenize
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from m2t.generate import WithNewIds, with_new_ids
from m2t.generate import diff as diff  # noqa: PLC0414 - for importers, as the next
from m2t.generate import generate as generate  # noqa: PLC0414
from m2t.models.write import unified_difference
from mrsfi.folders import MissionFolders
from mrsfi_runtime.errors import UsageError
from mrsfi_runtime.files import changing
from mrsfi_runtime.record.decisions import decisions_of
from mrsfi_runtime.record.settings import folder_of


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a TOML file names elements: patterns of the text around and of a name, and a reader."""

    around: re.Pattern[str]
    name: re.Pattern[str]
    read: Callable[[dict[str, Any]], Sequence[str]]


_GOALS = _Place(
    re.compile(r"^\s*goals\s*=\s*\[[^\]]*\]", re.MULTILINE),
    re.compile(r"""(?P<quote>["'])(?P<id>[^"'\n]*)(?P=quote)"""),
    lambda document: document.get("search", {}).get("goals", ()),
)
_LIMITS = _Place(
    re.compile(r"^\s*\[max\](?:.*\n?)*", re.MULTILINE),
    re.compile(r"""^(?P<quote>["']?)(?P<id>[^"'\s=]+)(?P=quote)(?=\s*=)""", re.MULTILINE),
    lambda document: [*document.get("max", ())],
)


@dataclass(frozen=True, slots=True)
class Renaming(WithNewIds):
    """The changes that other IDs make, also in campaign files, limits and decisions.

    ``scripts`` has the places where Python files beside the models name an old ID. ``gone`` are the
    files of decisions, which are named by IDs.
    """

    scripts: tuple[tuple[Path, int, str], ...]
    gone: tuple[Path, ...]

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files that change."""
        code = self.code
        written = () if code is None else (code.target / name for name in code.written)
        return (*self.contents, *written)

    @property
    def changes(self) -> dict[Path, bytes | None]:
        """New content of all files that change, by path."""
        return {
            **dict.fromkeys(self.gone),
            **self.contents,
            **({} if self.code is None else self.code.changes),
        }


def rename(folders: MissionFolders, names: Mapping[str, str]) -> Renaming:
    """Give elements other IDs as ``renaming`` does, in all files or in none."""
    with changing(folders.models) as change:
        found = renaming(folders, names)
        change.replace(found.changes)
    return found


def renaming(folders: MissionFolders, names: Mapping[str, str]) -> Renaming:
    """Return the changes of new IDs, given by old ones, all at once; write nothing."""
    if folders.generated.is_dir():
        folders.require_fresh()
    found = with_new_ids(folders.models, folders.generated, names)
    contents = dict(found.contents)
    lines = [*found.difference]
    for folder, place in ((folders.models, _GOALS), (folder_of(folders.models), _LIMITS)):
        for path in sorted(folder.glob("*.toml")):
            old, new = _edited(path, place, names)
            if new != old:
                contents[path] = new.encode()
                named = str(path)
                lines += unified_difference(old.splitlines(), new.splitlines(), named, named, "")
    gone = []
    for before in decisions_of(folders.models):
        after = before.renamed(names)
        if after != before:
            contents[after.path] = after.text().encode()
            gone.append(before.path)
            texts = before.text().splitlines(), after.text().splitlines()
            lines += unified_difference(*texts, str(before.path), str(after.path), "")
    scripts = tuple(_named(folders.models, names))
    return Renaming(contents, found.respelt, found.code, tuple(lines), scripts, tuple(gone))


def _edited(path: Path, place: _Place, names: Mapping[str, str]) -> tuple[str, str]:
    """Return the text of a TOML file, and the same text with new IDs and the same layout."""

    def exchanged(found: re.Match[str]) -> str:
        new = names.get(found["id"], found["id"])
        quote = found["quote"] or ("" if re.fullmatch(r"[A-Za-z0-9_-]*", new) else '"')
        return f"{quote}{new}{quote}"

    try:
        old = path.read_bytes().decode("utf-8")
        new = place.around.sub(lambda part: place.name.sub(exchanged, part[0]), old)
        before, after = (place.read(tomllib.loads(text)) for text in (old, new))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{path}: cannot be read: {error}; expected TOML") from error
    if [*after] != [names.get(name, name) for name in before]:
        raise UsageError(
            f"{path}: found {', '.join(before)} in a layout that cannot be edited; expected a list "
            'such as goals = ["g1"], or a table [max] with a line for each goal'
        )
    return old, new


def _named(models: Path, names: Mapping[str, str]) -> Iterator[tuple[Path, int, str]]:
    for path in sorted(models.glob("*.py")):
        with suppress(OSError, SyntaxError), tokenize.open(path) as file:
            for node in ast.walk(ast.parse(file.read())):
                if isinstance(node, ast.Constant) and node.value in names:
                    yield path, node.lineno, str(node.value)
