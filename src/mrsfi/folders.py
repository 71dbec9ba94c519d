"""The folders of missions: models, generated code, campaign files."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from m2t.generate import diff as diff  # noqa: PLC0414 - for importers, as the next
from m2t.generate import generate as generate  # noqa: PLC0414
from m2t.generate import stale
from m2t.load import MISSION_XMI, LoadedModels
from mrsfi.project import from_here, project
from mrsfi_runtime.errors import GenerationError, UsageError, expected
from mrsfi_runtime.files import settle
from mrsfi_runtime.generated_code import require_semantics
from mrsfi_runtime.project_file import root

_MODELS, _GENERATED = "models", "generated"
_MISSION_CODE = "mission_loader.py"


@dataclass(frozen=True, slots=True)
class MissionFolders:
    """The folder of a mission's models and that of its generated code."""

    name: str
    models: Path
    generated: Path

    @property
    def place(self) -> str:
        """Where the models lie from the root of the project on; empty if their name says so."""
        folder = self.models.resolve()
        is_usual = folder.parent == project().models.resolve()
        return "" if is_usual else Path(os.path.relpath(folder, root())).as_posix()

    @property
    def named(self) -> str:
        """What names the mission in a command of the working folder."""
        return str(from_here(self.models.resolve())) if self.place else self.name

    def require_fresh(self, loaded: LoadedModels | None = None) -> None:
        """Refuse generated code that does not follow from the models, and name the stale files."""
        names = stale(loaded or self.models, self.generated)
        if names and not (self.generated / _MISSION_CODE).is_file():
            raise GenerationError(
                f"{self.generated}: not generated yet; run `mrsfi generate {self.models}`"
            )
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
    """Return the folders of the mission whose models are, or were, in a folder, settled first."""
    folder = models.resolve()
    folders = MissionFolders(folder.name, models, generated or _generated(folder))
    settle(models, folders.generated)
    return folders


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


def _generated(folder: Path) -> Path:
    """Return where the code of a mission goes: beside the folder ``models`` that it is in."""
    ours = project()
    if folder.parent == ours.models.resolve():
        return ours.generated / folder.name
    root = folder.parent.parent if folder.parent.name == _MODELS else folder.parent
    return from_here(root / _GENERATED / folder.name)
