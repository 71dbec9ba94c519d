"""Campaign folders: find, make and open them."""

import platform
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from mrsfi_runtime.cli.missions import MissionFolders
from mrsfi_runtime.cli.versions import installed_version
from mrsfi_runtime.errors import GenerationError, RecordError, UsageError
from mrsfi_runtime.mission import MissionCode, load_code
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder, hashes
from mrsfi_runtime.record.manifest import EngineRecord, Manifest

RUNS = Path("runs")
"""Where campaigns go unless the user says otherwise."""

_VERSIONED = ("mrsfi", "deap", "numpy", "pyecore")


@dataclass(frozen=True, slots=True)
class OpenCampaign:
    """A campaign with its store open and its own copy of the code loaded."""

    folder: CampaignFolder
    store: CampaignStore
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
    """Open a campaign for reading.

    Raises
    ------
    RecordError
        If the folder holds no campaign, or its copy of the generated code is not whole.
    """
    folder = CampaignFolder(path)
    with CampaignStore.open(path) as store:
        try:
            code = load_code(folder.generated)
        except GenerationError as error:
            raise RecordError(
                f"{path}: the campaign's own copy of the generated code is not whole: {error}; "
                "expected the folder as `mrsfi evolve` left it"
            ) from error
        yield OpenCampaign(folder, store, code)
