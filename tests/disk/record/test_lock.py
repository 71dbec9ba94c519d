import os
import stat

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.folder import CampaignFolder, only_writer


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


def test_a_folder_that_cannot_be_written_is_refused(guest_folder, shut):
    shut()
    folder = CampaignFolder(guest_folder)

    with pytest.raises(RecordError, match="cannot be opened or written"), only_writer(folder):
        pass

    assert list(guest_folder.iterdir()) == []
