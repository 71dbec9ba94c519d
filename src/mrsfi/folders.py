"""The folders of missions (models, generated code, campaign files), and other IDs for elements.

Begin with ``find_mission``. ``renaming`` gives elements other IDs in models, code, campaign files,
kept limits and decisions. It computes all new contents before anything is written: all files change
or none.
"""

import ast
import os
import re
import tokenize
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from m2t.generate import WithNewIds, stale, with_new_ids
from m2t.generate import diff as diff  # noqa: PLC0414 - for importers, as the next
from m2t.generate import generate as generate  # noqa: PLC0414
from m2t.models.load import MISSION_XMI, LoadedModels
from m2t.models.write import unified_difference
from mrsfi.engines import from_here, project
from mrsfi_runtime.errors import GenerationError, UsageError, expected
from mrsfi_runtime.files import changing, settle
from mrsfi_runtime.generated_code import require_semantics
from mrsfi_runtime.project_file import root
from mrsfi_runtime.record.decisions import decisions_of
from mrsfi_runtime.record.settings import folder_of


@dataclass(frozen=True, slots=True)
class MissionFolders:
    """The folder of a mission's models and that of its generated code."""

    name: str
    models: Path
    generated: Path

    @property
    def place(self) -> str:
        """Path of the models from the root of the project; empty in the usual folder."""
        folder = self.models.resolve()
        is_usual = folder.parent == project().models.resolve()
        return "" if is_usual else Path(os.path.relpath(folder, root())).as_posix()

    @property
    def named(self) -> str:
        """The mission as a command in the working folder names it."""
        return str(from_here(self.models.resolve())) if self.place else self.name

    def require_fresh(self, loaded: LoadedModels | None = None) -> None:
        """Refuse generated code that is older than the models, and name the stale files."""
        names = stale(loaded or self.models, self.generated)
        if names and not (self.generated / "mission_loader.py").is_file():
            what = f"{self.generated}: not generated yet"
            raise GenerationError(f"{what}; run `mrsfi generate {self.models}`")
        if names:
            require_semantics(self.generated)  # says more than that the manifest is stale
            raise GenerationError(
                f"{self.generated}: stale, because the models or templates changed: "
                f"{', '.join(names)}; run `mrsfi generate {self.models}` and review the diff"
            )


def find_mission(mission: str, generated: Path | None = None) -> MissionFolders:
    """Return the folders of a mission, by its name or path; a ``UsageError`` if there is none."""
    for models in _places(mission):
        return folders_at(models, generated)
    place = project().models
    known = sorted(path.parent.name for path in place.glob(f"*/{MISSION_XMI}"))
    what = f"the path of a folder that holds {MISSION_XMI}, or the name of one in {place}/:"
    raise UsageError(f"found no mission '{mission}'; {expected(mission, known, what)}")


def folders_at(models: Path, generated: Path | None = None) -> MissionFolders:
    """Return the folders of the mission of a models folder; first complete pending changes."""
    folder, ours = models.resolve(), project()
    if generated is None and folder.parent == ours.models.resolve():
        generated = ours.generated / folder.name
    elif generated is None:  # beside the folder ``models`` that the mission is in
        root = folder.parent.parent if folder.parent.name == "models" else folder.parent
        generated = from_here(root / "generated" / folder.name)
    settle(models, generated)
    return MissionFolders(folder.name, models, generated)


def is_mission(mission: str) -> bool:
    """Return whether ``find_mission`` would find it."""
    return next(_places(mission), None) is not None


def _places(mission: str) -> Iterator[Path]:
    for models in (project().models / mission, Path(mission)):
        if (models / MISSION_XMI).is_file():
            yield models


def campaign_file(folders: MissionFolders, case: str) -> Path:
    """Return the campaign file that --case names: ``case_NAME.toml`` of a mission, or any file."""
    named = folders.models / f"case_{case}.toml"
    if named.is_file():
        return named
    if Path(case).is_file():
        return Path(case)
    files = sorted(folders.models.glob("case_*.toml"))
    names = [path.stem.removeprefix("case_") for path in files]
    what = f"the path of a TOML file, or one of {folders.models}/case_*.toml:"
    raise UsageError(f"--case: found no campaign file '{case}'; {expected(case, names, what)}")


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
