"""The folders of missions (models, generated code, campaign files), and the code that is loaded.

Begin with ``find_mission``. ``load_fresh`` loads generated code only if it follows from the models
and its regions are sound. To find out, code is generated and compared. A mark in the cache says
that it was so, until a file changes on which it depends. The cache also has the generated texts of
models that stay as they are (``rendered``). So most commands start without the libraries that check
regions, or without those that read models and fill templates.
"""

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from time import time
from typing import TYPE_CHECKING

import m2t
import mrsfi_runtime
from mrsfi.engines import from_here, project
from mrsfi_runtime.engine.compiled.machine_code import remembered
from mrsfi_runtime.errors import GenerationError, UsageError, expected
from mrsfi_runtime.files import settle
from mrsfi_runtime.generated_code import MissionCode, load_code, require_semantics
from mrsfi_runtime.project_file import CHOSEN, MISSION_XMI, project_metamodels, root

if TYPE_CHECKING:
    from m2t.models.load import LoadedModels


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

    def require_fresh(self, loaded: "LoadedModels | None" = None) -> None:
        """Refuse generated code that is older than the models, and name the stale files."""
        from m2t.emit import plan_files  # noqa: PLC0415 - slow

        texts = rendered(self.models, models=(lambda: loaded) if loaded else None)
        names = plan_files(self.generated, texts, {}).stale
        if names and not (self.generated / "mission_loader.py").is_file():
            what = f"{self.generated}: not generated yet"
            raise GenerationError(f"{what}; run `mrsfi generate {self.models}`")
        if names:
            require_semantics(self.generated)  # says more than that the manifest is stale
            raise GenerationError(
                f"{self.generated}: stale, because the models or templates changed: "
                f"{', '.join(names)}; run `mrsfi generate {self.models}` and review the diff"
            )


_OURS = [Path(each.__path__[0]) for each in (m2t, mrsfi_runtime)]


def fingerprint(sources: Iterable[Path]) -> str:
    """Return a key of files by their content, of the metamodels, and of this mrsfi."""
    places = [Path(each, "metamodels") for each in (_OURS[0], _OURS[0].parent)]
    own = os.environ.get(CHOSEN) or project_metamodels()
    metamodels = (
        path for place in ([Path(own)] if own else places) for path in place.glob("*.ecore")
    )
    key = sha256(os.fsencode(_version()))
    for path in sorted({*sources, *metamodels}):
        if path.is_file():
            key.update(os.fsencode(f"{path}\n{sha256(path.read_bytes()).hexdigest()}\n"))
    return key.hexdigest()


@cache
def _version() -> str:
    """Return the version of Python, and that of each file of this mrsfi."""
    files = sorted(path for each in _OURS for path in each.rglob("*.[pj][y2]"))
    about = ((path, path.stat()) for path in files)
    lines = (f"{path} {stat.st_size} {stat.st_mtime_ns}" for path, stat in about)
    return "\n".join((sys.version, *lines))


def rendered(
    path: Path, *names: str, models: "Callable[[], LoadedModels] | None" = None
) -> Mapping[str, str]:
    """Return generated files, by default all, of a mission folder or a written specification.

    They are as their templates render them. The cache keeps them beside the hashes of the files
    that were read; those of a specification only if its mission is one file. Of several, the first
    is looked for in folders, so that a new file could change the result. A file of the last second
    may have changed while it was read. ``models`` returns the models, by default those of the
    folder.
    """
    began, sources = time(), sorted(path.glob("*.xmi")) if path.is_dir() else [path]

    def made() -> bytes:
        from m2t.generate import VISITORS, rendered_file  # noqa: PLC0415 - slow
        from m2t.models.load import load_mission_folder  # noqa: PLC0415 - slow

        loaded = models() if models else load_mission_folder(path)
        files = [file.path.resolve() for file in loaded.files]
        is_kept = (path.is_dir() or len(files) == _N_FILES) and all(
            each.stat().st_mtime < began - 1.0 for each in files
        )
        texts = {name: rendered_file(name, loaded) for name in names or VISITORS}
        return json.dumps([{str(each): _hash(each) for each in files if is_kept}, texts]).encode()

    def is_current(content: bytes) -> bool:
        known: dict[str, str] = json.loads(content)[0]
        return bool(known) and all(_hash(Path(name)) == known[name] for name in known)

    key = fingerprint(each.resolve() for each in sources) + "".join(names)
    texts: dict[str, str] = json.loads(remembered(key, made, is_current))[1]
    return texts


_N_FILES = 2  # of a specification whose mission is one file


def _hash(path: Path) -> str:
    return sha256(path.read_bytes()).hexdigest() if path.is_file() else ""


def _sources(models: Path, generated: Path) -> set[Path]:
    """Return all files that decide whether generated code is fresh, and its regions sound."""
    sources: set[Path] = set()
    with suppress(OSError, ValueError, KeyError, TypeError):
        manifest = json.loads((generated / "manifest.json").read_bytes())
        sources = {models / name for name in manifest["sources"]}
    return {*sources, *models.glob("*.xmi"), *generated.glob("*")}


def load_fresh(folders: MissionFolders, loaded: "LoadedModels | None" = None) -> MissionCode:
    """Load the generated code of a mission, which must be fresh, with sound regions."""

    def check() -> bytes:
        from mrsfi_runtime.engine.region_lint import (  # noqa: PLC0415 - brings pyflakes
            require_sound_regions,
        )

        folders.require_fresh(loaded)
        require_sound_regions(folders.generated)
        return b"sound"

    if loaded is None:
        remembered(fingerprint(_sources(folders.models, folders.generated)), check)
    else:
        check()
    return load_code(folders.generated)


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
