import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation
from tests.support.cli import execute


def test_a_second_campaign_in_one_folder_is_refused(store, tmp_path, refused):
    store.append([evaluation(0, (1,))])

    with refused(RecordError):
        CampaignStore.create(tmp_path / "run", CampaignSettings(), Manifest())

    assert store.n_evaluations == 1


def test_a_folder_without_a_campaign_is_refused_and_left_alone(tmp_path, refused):
    with refused(RecordError):
        CampaignStore.open(tmp_path)

    assert list(tmp_path.iterdir()) == []


def test_another_programs_database_is_refused(tmp_path, refused):
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other:
        other.execute("CREATE TABLE meta (key, value)")

    with refused(RecordError):
        CampaignStore.open(tmp_path)


def test_a_file_of_noise_is_refused(tmp_path, refused):
    (tmp_path / "campaign.sqlite").write_bytes(b"no database at all, " * 100)

    with refused(RecordError):
        CampaignStore.open(tmp_path)


def test_a_truncated_file_is_refused(tmp_path, refused):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(i, (i,) * 50) for i in range(200)])
    path = tmp_path / "campaign.sqlite"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])

    with refused(RecordError):
        CampaignStore.open(tmp_path)


def test_a_folder_that_cannot_be_written_is_refused(guest_folder, shut, refused):
    shut()

    for folder in (guest_folder, guest_folder / "run"):
        with refused(RecordError):
            CampaignStore.create(folder, CampaignSettings(), Manifest())


def test_a_folder_that_cannot_be_written_can_be_read(guest_folder, shut, refused):
    with CampaignStore.create(guest_folder, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    (guest_folder / "campaign.sqlite").chmod(0o444)
    shut()

    with CampaignStore.open(guest_folder) as store:
        assert tuple(store.evaluations()) == (evaluation(0, (1,)),)
        with refused(RecordError):
            store.append([evaluation(1, (1,))])


@pytest.mark.parametrize(
    "change",
    [
        *(
            f"UPDATE evaluation SET {column} = '{text}'"
            for column, text in (
                ("specification", '[["f1",1]]'),
                ("specification", "[3]"),
                ("fitness", "[null]"),
                ("margins", "[[1.5]]"),
                ("margins", '[["a",2]]'),
                ("believed", "[1.5]"),
                ("believed", "{}"),
                ("samples", "[1,"),
            )
        ),
        "ALTER TABLE evaluation DROP COLUMN masked",
        "DELETE FROM meta WHERE key = 'settings'",
    ],
)
def test_a_record_that_makes_no_sense_is_refused(tmp_path, change):
    read_damaged(tmp_path, change, pytest.raises(RecordError))


@pytest.mark.parametrize(
    "change",
    [
        "PRAGMA user_version = 5",
        *(
            f"UPDATE meta SET value = '{text}' WHERE key = 'settings'"
            for text in ('{"poplation":4}', '{"population":0}', "[]")
        ),
    ],
)
def test_settings_and_versions_that_make_no_sense_are_named(tmp_path, change, refused):
    read_damaged(tmp_path, change, refused(RecordError))


def read_damaged(folder, change, expected):
    with CampaignStore.create(folder, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    execute(folder, change)

    with expected, CampaignStore.open(folder) as store:
        tuple(store.evaluations())


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize("manifest", ['{"versions": {"mrsfi": "0.1.7"}}', "{}", ""])
def test_a_record_of_before_0_3_is_refused_with_who_wrote_it(tmp_path, version, manifest, refused):
    CampaignStore.create(tmp_path, CampaignSettings(), Manifest()).close()
    change = f"UPDATE meta SET value = '{manifest}' WHERE key = 'manifest'"
    execute(tmp_path, f"PRAGMA user_version = {version}", change)

    with refused(RecordError):
        CampaignStore.open(tmp_path)


def test_a_record_of_other_semantics_is_not_flown_and_names_who_wrote_it(tmp_path, refused):
    later = replace(Manifest(versions={"mrsfi": "0.9.3"}), semantics=SEMANTICS + 1)
    store = CampaignStore.create(tmp_path, CampaignSettings(), later)

    with store, refused(RecordError):
        store.require_flyable()
