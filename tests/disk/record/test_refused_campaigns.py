import os
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation

NOBODY = 65534


@pytest.fixture
def guest_folder() -> Iterator[Path]:
    """A folder that every user may enter, as pytest's own are not when root runs it."""
    with tempfile.TemporaryDirectory(dir="/tmp") as name:
        Path(name).chmod(0o755)
        yield Path(name)
        Path(name).chmod(0o755)


@pytest.fixture
def as_guest() -> Iterator[None]:
    """Run the rest of the test without root's right to write anywhere."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(NOBODY)
    yield
    os.seteuid(0)


def test_a_second_campaign_in_one_folder_is_refused(store, tmp_path):
    store.append([evaluation(0, (1,))])

    with pytest.raises(RecordError, match=r"run.campaign\.sqlite: found a campaign there already"):
        CampaignStore.create(tmp_path / "run", CampaignSettings(), Manifest())

    assert store.n_evaluations == 1


def test_a_folder_without_a_campaign_is_refused_and_left_alone(tmp_path):
    with pytest.raises(RecordError, match=r"found no campaign\.sqlite; expected the folder"):
        CampaignStore.open(tmp_path)

    assert list(tmp_path.iterdir()) == []


def test_another_programs_database_is_refused(tmp_path):
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other:
        other.execute("CREATE TABLE meta (key, value)")

    with pytest.raises(RecordError, match="SQLite file that is not a campaign"):
        CampaignStore.open(tmp_path)


def test_a_newer_version_is_refused_with_both_numbers(tmp_path):
    CampaignStore.create(tmp_path, CampaignSettings(), Manifest()).close()
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as newer:
        newer.execute("PRAGMA user_version = 3")

    with pytest.raises(RecordError, match=r"found a campaign of version 3; expected at most 2"):
        CampaignStore.open(tmp_path)


def test_a_file_of_noise_is_refused(tmp_path):
    (tmp_path / "campaign.sqlite").write_bytes(b"no database at all, " * 100)

    with pytest.raises(RecordError, match=r"campaign\.sqlite: the record is damaged"):
        CampaignStore.open(tmp_path)


def test_a_truncated_file_is_refused(tmp_path):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(i, (i,) * 50) for i in range(200)])
    path = tmp_path / "campaign.sqlite"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])

    with pytest.raises(RecordError, match="the record is damaged"):
        CampaignStore.open(tmp_path)


@pytest.mark.parametrize(
    ("column", "text"),
    [
        ("specification", '[["f1",1]]'),
        ("specification", "[3]"),
        ("fitness", "[null]"),
        ("believed", "[1.5]"),
        ("believed", "{}"),
        ("samples", "[1,"),
    ],
)
def test_a_damaged_row_is_refused(tmp_path, column, text):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other:
        other.execute(f"UPDATE evaluation SET {column} = ?", (text,))
        other.commit()

    with (
        CampaignStore.open(tmp_path) as store,
        pytest.raises(RecordError, match="the record is damaged"),
    ):
        tuple(store.evaluations())


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"poplation":4}', "found unknown key 'poplation'"),
        ('{"population":0}', "population: found 0; expected a whole number >= 1"),
        ("[]", r"found \[\]; expected an object"),
    ],
)
def test_settings_that_make_no_sense_are_a_damaged_record(tmp_path, text, reason):
    CampaignStore.create(tmp_path, CampaignSettings(), Manifest()).close()
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other:
        other.execute("UPDATE meta SET value = ? WHERE key = 'settings'", (text,))
        other.commit()

    with pytest.raises(RecordError, match=f"the record is damaged: .*{reason}"):
        CampaignStore.open(tmp_path)


def test_missing_settings_are_refused(tmp_path):
    CampaignStore.create(tmp_path, CampaignSettings(), Manifest()).close()
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other:
        other.execute("DELETE FROM meta WHERE key = 'settings'")
        other.commit()

    with pytest.raises(RecordError, match="the record is damaged"):
        CampaignStore.open(tmp_path)


def test_a_folder_that_cannot_be_written_is_refused(guest_folder, request):
    guest_folder.chmod(0o555)
    request.getfixturevalue("as_guest")

    for folder in (guest_folder, guest_folder / "run"):
        with pytest.raises(RecordError, match=r"campaign\.sqlite: cannot be opened or written"):
            CampaignStore.create(folder, CampaignSettings(), Manifest())


def test_a_folder_that_cannot_be_written_can_be_read(guest_folder, request):
    with CampaignStore.create(guest_folder, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    (guest_folder / "campaign.sqlite").chmod(0o444)
    guest_folder.chmod(0o555)
    request.getfixturevalue("as_guest")

    with CampaignStore.open(guest_folder) as store:
        assert tuple(store.evaluations()) == (evaluation(0, (1,)),)
        with pytest.raises(RecordError, match="cannot be opened or written"):
            store.append([evaluation(1, (1,))])
