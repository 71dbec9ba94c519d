import os
import stat

import pytest

from mrsfi.campaign import pack
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.database import CampaignFolder, no_writer, only_writer
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import SETTINGS


def test_the_lock_is_free_again_after_the_body_and_its_file_stays(tmp_path):
    folder = CampaignFolder(tmp_path)

    for _ in range(2):
        with only_writer(folder):
            assert folder.lock.read_text(encoding="ascii") == f"{os.getpid()}\n"

    assert stat.S_ISREG(folder.lock.stat().st_mode)


def test_a_second_writer_is_refused_with_the_process_of_the_first(tmp_path):
    folder = CampaignFolder(tmp_path)
    message = rf"{tmp_path.name}: found another process \({os.getpid()}\) running this campaign"

    with only_writer(folder), pytest.raises(RecordError, match=message), only_writer(folder):
        pass


def test_nobody_writes_while_somebody_reads_and_the_other_way_round(tmp_path):
    folder = CampaignFolder(tmp_path)
    message = "found another process"
    with only_writer(folder), pytest.raises(RecordError, match=message), no_writer(folder):
        pass

    with (
        no_writer(folder),
        no_writer(folder),
        pytest.raises(RecordError, match=message),
        only_writer(folder),
    ):
        pass


@pytest.mark.parametrize("has_lock", [True, False])
def test_a_campaign_that_cannot_be_written_is_packed_elsewhere(has_lock, guest_folder, shut):
    folder, out = CampaignFolder(guest_folder / "run"), guest_folder / "out" / "it.zip"
    CampaignStore.create(folder.path, SETTINGS, Manifest()).close()
    if has_lock:
        folder.lock.touch()
    out.parent.mkdir()
    out.parent.chmod(0o777)
    folder.path.chmod(0o555)
    shut()

    pack(folder.path, out)

    assert b"campaign/campaign.sqlite" in out.read_bytes()


def test_a_folder_that_cannot_be_written_is_refused(guest_folder, shut):
    shut()
    folder = CampaignFolder(guest_folder)

    with pytest.raises(RecordError, match="cannot be opened or written"), only_writer(folder):
        pass

    assert list(guest_folder.iterdir()) == []
