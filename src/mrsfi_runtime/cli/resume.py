"""Beginning a campaign and continuing one, by one writer at a time."""

import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from mrsfi_runtime.cli.campaigns import manifest_of
from mrsfi_runtime.cli.console import tell
from mrsfi_runtime.cli.engines import EngineOptions, recorded_engine
from mrsfi_runtime.cli.missions import MissionFolders
from mrsfi_runtime.cli.versions import installed_version
from mrsfi_runtime.cli.workers import WorkerOptions
from mrsfi_runtime.engine.settings import EngineSettings
from mrsfi_runtime.errors import RecordError, UsageError
from mrsfi_runtime.record.campaign import CampaignStore
from mrsfi_runtime.record.folder import CampaignFolder, hashes
from mrsfi_runtime.record.lock import only_writer
from mrsfi_runtime.record.settings import CampaignSettings

_FREE = frozenset(
    {"resume", "ratio", "is_json"}
    | {option.name for options in (EngineOptions, WorkerOptions) for option in fields(options)}
)
"""Parameters of ``mrsfi evolve`` that do not decide what a campaign finds."""


@contextmanager
def begun(
    path: Path,
    folders: MissionFolders,
    settings: CampaignSettings,
    case: str,
    engine: EngineSettings,
) -> Iterator[None]:
    """Make a campaign without evaluations and be its writer while the body runs.

    Raises
    ------
    RecordError
        If the folder is in use, or cannot be written.
    """
    folder = CampaignFolder.reserve(path)
    with only_writer(folder):
        folder.fill(folders.models, folders.generated)
        content = manifest_of(folders, case, recorded_engine(engine))
        CampaignStore.create(path, settings, content).close()
        yield


@contextmanager
def resumed(path: Path, ctx: click.Context) -> Iterator[None]:
    """Be the writer of a campaign from before while the body runs.

    Parameters
    ----------
    ctx
        Call of ``mrsfi evolve``; what it gives must be what the campaign was begun with.

    Raises
    ------
    RecordError
        If the folder holds no campaign, a changed one, or one that another process runs.
    UsageError
        If an option contradicts the campaign.
    """
    with CampaignStore.open(path) as store:  # first: a lock makes no sense where no campaign is
        manifest, settings = store.manifest, store.settings
    begun_with = {"mission": manifest.mission, "case": manifest.case, **settings.as_json()}
    _require_same_options(path, ctx, begun_with)
    folder = CampaignFolder(path)
    with only_writer(folder):
        _require_same_files(folder, manifest.sha256)
        _tell_other_versions(manifest.versions)
        with CampaignStore.open(path) as store:
            tell(
                f"resuming {path}: {store.n_generations} generations, {store.n_evaluations} "
                f"evaluations and {len(store.failures())} failures are recorded"
            )
        yield


def _require_same_options(path: Path, ctx: click.Context, recorded: Mapping[str, Any]) -> None:
    for parameter in ctx.command.params:
        name = str(parameter.name)
        if name in _FREE or ctx.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        given = ctx.params[name]
        label = parameter.opts[0] if isinstance(parameter, click.Option) else "MISSION"
        if name not in recorded:
            raise UsageError(
                f"{label} {given}: makes no sense with --resume; {path} goes on in its own folder, "
                "on its own copies of models and code; leave it out"
            )
        found = Path(given).name if name == "mission" else given
        if found != recorded[name]:
            raise UsageError(
                f"{label}: found {given}; {path} was begun with {recorded[name]} and goes on with "
                "it; leave the option out, or begin a new campaign without --resume"
            )


def _require_same_files(folder: CampaignFolder, sha256: Mapping[str, str]) -> None:
    """Refuse copies that are not those that the campaign was begun on."""
    found = hashes(folder.generated) | hashes(folder.model)
    for name, recorded in sha256.items():
        if recorded != found.get(name):
            what = "another one than it was begun on" if name in found else "gone"
            raise RecordError(
                f"{folder.path}: the campaign's own copy of {name} is {what}; expected the folder "
                "as `mrsfi evolve` left it; restore the file, or begin a new campaign"
            )


def _tell_other_versions(recorded: Mapping[str, str]) -> None:
    for name, version in recorded.items():
        now = platform.python_version() if name == "python" else installed_version(name)
        if now != version:
            tell(
                f"warning: begun with {name} {version}, going on with {now}: "
                "the result may differ from that of one run"
            )
