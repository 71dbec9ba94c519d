"""A campaign as one file that repeats itself elsewhere: models, code, record, and how to fly it."""

import lzma
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from mrsfi.campaign_folders import fly_all, open_campaign, open_to_fly
from mrsfi.engines import Choice, Tell, opened, silent
from mrsfi_runtime.errors import MrsfiError, RecordError
from mrsfi_runtime.files import whole_file
from mrsfi_runtime.record.folder import CampaignFolder, only_writer

_TOLD = "REPRODUCE.md"
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the same campaign makes the same archive
_MOST_BYTES = 4 * 1024**3
_UNREADABLE = (OSError, zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, RuntimeError)
"""What reading an archive raises; the last if it is encrypted, or compressed in an unknown way."""


def pack(run: Path, out: Path) -> None:
    """Write a campaign into an archive: its folder but for its lock, and how to fly it again."""
    folder = CampaignFolder(run)
    with open_campaign(run) as campaign:
        told = _told(out, campaign.store.manifest.versions, campaign.store.digest())
    with (
        only_writer(folder),
        whole_file(out) as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        archive.writestr(zipfile.ZipInfo(_TOLD, _EPOCH), told, zipfile.ZIP_DEFLATED)
        for path in sorted(path for path in run.rglob("*") if path.is_file()):
            if path != folder.lock:
                info = zipfile.ZipInfo(f"campaign/{path.relative_to(run).as_posix()}", _EPOCH)
                archive.writestr(info, path.read_bytes(), zipfile.ZIP_DEFLATED)


def _told(out: Path, versions: Mapping[str, str], digest: str) -> str:
    listed = "\n".join(f"- {name} {version}" for name, version in versions.items())
    return (
        f"# A campaign of mrsfi\n\nIn `campaign/` are its models, its generated code, its settings "
        f"and every evaluation.\nIt was made with\n\n{listed}\n\nTo repeat all of it:\n\n"
        f"    pip install mrsfi=={versions.get('mrsfi')}\n    mrsfi check {out.name}\n\n"
        f"The digest over all evaluations is `{digest}`.\n"
    )


def repeat(archive: Path, engine: Choice, tell: Tell = silent) -> tuple[int, str]:
    """Fly every evaluation of an archive again; return how many, and their digest."""
    with _unpacked(archive) as run, open_to_fly(run, tell) as campaign:
        store = campaign.store
        seed, settings = store.settings.mission_seed, engine(store.manifest.engine)
        with opened(campaign.code, seed, settings, tell) as flown_by:
            return sum(1 for _ in fly_all(campaign, flown_by)), store.digest()


@contextmanager
def _unpacked(archive: Path) -> Iterator[Path]:
    with TemporaryDirectory() as place:
        try:
            with zipfile.ZipFile(archive) as content:
                if sum(each.file_size for each in content.infolist()) > _MOST_BYTES:
                    raise RecordError(f"{archive}: holds more than {_MOST_BYTES} bytes")
                content.extractall(place)  # which leaves the folder with no name in it
        except _UNREADABLE as error:
            raise RecordError(
                f"{archive}: is no archive of a campaign ({error}); expected one of `mrsfi pack`"
            ) from error
        try:
            yield Path(place) / "campaign"
        except MrsfiError as error:
            error.args = (str(error).replace(place, str(archive)),)
            raise
