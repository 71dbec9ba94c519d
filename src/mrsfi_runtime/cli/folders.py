"""The folders of missions, their models and generated code, and of campaigns."""

import platform
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import click

from m2t.generate import fault_loader_text, mission_loader_text, stale
from m2t.load import LoadedModels, load_mission_folder, load_specification
from mrsfi_runtime.cli.versions import installed_version
from mrsfi_runtime.engine.region_lint import require_sound_regions
from mrsfi_runtime.errors import GenerationError, RecordError, UsageError
from mrsfi_runtime.mission import (
    MissionCode,
    load_code,
    mission_from_text,
    pool_from_text,
    require_semantics,
)
from mrsfi_runtime.model.faults import FaultPool
from mrsfi_runtime.model.mission import Mission
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder, hashes
from mrsfi_runtime.record.manifest import EngineRecord, Manifest

mission_argument = click.argument("mission", metavar="MISSION")
"""Gives a command the argument MISSION."""

generated_option = click.option(
    "--generated",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder of the generated code [default: generated/NAME beside models/].",
)
"""Gives a command the option --generated."""

RUNS = Path("runs")
"""Where campaigns go unless the user says otherwise."""

_VERSIONED = ("mrsfi", "deap", "numpy", "pyecore")


_MODELS = Path("models")
_MISSION_FILE = "mission.xmi"
_MISSION_CODE = "mission_loader.py"


@dataclass(frozen=True, slots=True)
class MissionFolders:
    """The folder of a mission's models and that of its generated code."""

    name: str
    models: Path
    generated: Path

    def require_fresh(self) -> None:
        """Refuse generated code that does not follow from the models.

        Raises
        ------
        GenerationError
            Naming the stale files, or saying that there are none yet.
        """
        names = stale(self.models, self.generated)
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

    def load(self) -> MissionCode:
        """Load the generated code, which must be fresh, and whose regions must be sound."""
        self.require_fresh()
        require_sound_regions(self.generated)
        return load_code(self.generated)


def find_mission(mission: str, generated: Path | None = None) -> MissionFolders:
    """Return the folders of a mission.

    Parameters
    ----------
    mission
        Name of a folder under ``models``, or the path of a mission folder.
    generated
        Folder of the generated code, if it is not the usual one.

    Raises
    ------
    UsageError
        If there is no such mission.
    """
    for models in _places(mission):
        folder = models.resolve()
        root = folder.parent.parent if folder.parent.name == _MODELS.name else folder.parent
        usual = root / "generated" / folder.name
        return MissionFolders(folder.name, models, generated or _from_here(usual))
    known = sorted(path.parent.name for path in _MODELS.glob(f"*/{_MISSION_FILE}"))
    raise UsageError(
        f"found no mission '{mission}'; expected the name of a folder in models/ "
        f"({', '.join(known) or 'there is none here'}) or the path of one that holds "
        f"{_MISSION_FILE}"
    )


def is_mission(mission: str) -> bool:
    """Return whether ``find_mission`` would find it."""
    return next(_places(mission), None) is not None


def _places(mission: str) -> Iterator[Path]:
    """Yield the folders of models that a name or path stands for."""
    for models in (_MODELS / mission, Path(mission)):
        if (models / _MISSION_FILE).is_file():
            yield models


def read_specification(path: Path) -> tuple[LoadedModels, FaultPool]:
    """Return a written fault specification, and its faults with windows and values.

    Raises
    ------
    UsageError
        If there is no such file.
    ModelError
        If it cannot be used.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file; expected a fault specification in XMI")
    models = load_specification(path)
    return models, pool_from_text(fault_loader_text(models))


def campaign_file(folders: MissionFolders, case: str) -> Path:
    """Return the campaign file that --case names: ``case_NAME.toml`` of a mission, or any file.

    Raises
    ------
    UsageError
        If there is none.
    """
    named = folders.models / f"case_{case}.toml"
    if named.is_file():
        return named
    if Path(case).is_file():
        return Path(case)
    known = [path.stem.removeprefix("case_") for path in folders.models.glob("case_*.toml")]
    raise UsageError(
        f"--case: found no campaign file '{case}'; expected the path of a TOML file, or one of: "
        f"{', '.join(sorted(known)) or f'(there is no case_*.toml in {folders.models})'}"
    )


def _from_here(path: Path) -> Path:
    """Return a path as short as a user would write it."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


@dataclass(frozen=True, slots=True)
class OpenCampaign:
    """A campaign with its store open, and what its own copy of the models describes."""

    folder: CampaignFolder
    store: CampaignStore
    mission: Mission
    pool: FaultPool


@dataclass(frozen=True, slots=True)
class FlyableCampaign(OpenCampaign):
    """A campaign whose own copy of the code is loaded and flies as it did."""

    code: MissionCode


def free_folder(mission: str, case: str) -> Path:
    """Make and return ``runs/<mission>-<case>-<n>`` with the first number that is free."""
    number = 1
    while True:
        path = RUNS / f"{mission}-{case}-{number}"
        try:
            path.mkdir(parents=True)
        except FileExistsError:
            number += 1
        except OSError as error:
            raise RecordError(
                f"{path}: cannot be made: {error.strerror}; choose a place with --out"
            ) from error
        else:
            return path


def latest_folder() -> Path:
    """Return the campaign in ``runs`` that was written last.

    Raises
    ------
    UsageError
        If there is none.
    """
    databases = {
        folder: CampaignFolder(folder).database
        for folder in RUNS.glob("*")
        if CampaignFolder(folder).database.is_file()
    }
    if not databases:
        raise UsageError(
            f"found no campaign in {RUNS}/; name its folder, or run `mrsfi evolve` first"
        )
    return max(databases, key=lambda folder: databases[folder].stat().st_mtime_ns)


def manifest_of(folders: MissionFolders, case: str, engine: EngineRecord) -> Manifest:
    """Return what a campaign runs on: engine, versions, and the hash of every copied file."""
    return Manifest(
        mission=folders.name,
        case=case,
        engine=engine,
        versions={
            "python": platform.python_version(),
            **{name: installed_version(name) for name in _VERSIONED},
        },
        machine=platform.machine(),
        sha256=hashes(folders.generated) | hashes(folders.models),
    )


@contextmanager
def open_campaign(path: Path) -> Iterator[OpenCampaign]:
    """Open a campaign for reading, one of an earlier mrsfi too.

    It does without the copy of the generated code, which only the mrsfi of its day understands.

    Raises
    ------
    RecordError
        If the folder holds no campaign.
    ModelError
        If its copy of the models cannot be read.
    """
    folder = CampaignFolder(path)
    with CampaignStore.open(path) as store:
        models = load_mission_folder(folder.model)
        mission = mission_from_text(mission_loader_text(models))
        pool = pool_from_text(fault_loader_text(models))
        yield OpenCampaign(folder, store, mission, pool)


@contextmanager
def open_to_fly(path: Path) -> Iterator[FlyableCampaign]:
    """Open a campaign for flying it again or on.

    Raises
    ------
    RecordError
        If the folder holds no campaign, or one of other rules of the world, or its copy of the
        generated code is not whole.
    """
    folder = CampaignFolder(path)
    with CampaignStore.open(path) as store:
        store.require_flyable()
        try:
            code = load_code(folder.generated)
        except GenerationError as error:
            raise RecordError(
                f"{path}: the campaign's own copy of the generated code is not whole: {error}; "
                "expected the folder as `mrsfi evolve` left it"
            ) from error
        yield FlyableCampaign(folder, store, code.mission, code.pool, code)
