import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.semantics import SEMANTICS
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation
from tests.support.cli import execute

DAMAGED = "the record is damaged"


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


def test_a_folder_that_cannot_be_written_is_refused(guest_folder, shut):
    shut()

    for folder in (guest_folder, guest_folder / "run"):
        with pytest.raises(RecordError, match=r"campaign\.sqlite: cannot be opened or written"):
            CampaignStore.create(folder, CampaignSettings(), Manifest())


def test_a_folder_that_cannot_be_written_can_be_read(guest_folder, shut):
    with CampaignStore.create(guest_folder, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    (guest_folder / "campaign.sqlite").chmod(0o444)
    shut()

    with CampaignStore.open(guest_folder) as store:
        assert tuple(store.evaluations()) == (evaluation(0, (1,)),)
        with pytest.raises(RecordError, match="cannot be opened or written"):
            store.append([evaluation(1, (1,))])


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("PRAGMA user_version = 5", "found a campaign of version 5; expected at most 4"),
        *(
            (f"UPDATE evaluation SET {column} = '{text}'", DAMAGED)
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
        ("ALTER TABLE evaluation DROP COLUMN masked", DAMAGED),
        ("DELETE FROM meta WHERE key = 'settings'", DAMAGED),
        *(
            (f"UPDATE meta SET value = '{text}' WHERE key = 'settings'", f"{DAMAGED}: .*{reason}")
            for text, reason in (
                ('{"poplation":4}', "found unknown key 'poplation'"),
                ('{"population":0}', "population: found 0; expected a whole number >= 1"),
                ("[]", r"found \[\]; expected an object"),
            )
        ),
    ],
)
def test_a_record_that_makes_no_sense_is_refused(tmp_path, change, reason):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.append([evaluation(0, (1,))])
    with closing(sqlite3.connect(tmp_path / "campaign.sqlite")) as other, other:
        other.execute(change)

    with pytest.raises(RecordError, match=reason), CampaignStore.open(tmp_path) as store:
        tuple(store.evaluations())


@pytest.mark.parametrize("version", [1, 2, 3])
@pytest.mark.parametrize(
    ("manifest", "writer"),
    [
        ('{"versions": {"mrsfi": "0.1.7"}}', "mrsfi 0.1.7"),
        ("{}", "a mrsfi whose version is not recorded"),
        ("", "a mrsfi whose version is not recorded"),
    ],
)
def test_a_record_of_before_0_3_is_refused_with_who_wrote_it(tmp_path, version, manifest, writer):
    path = tmp_path / "campaign.sqlite"
    CampaignStore.create(tmp_path, CampaignSettings(), Manifest()).close()
    change = f"UPDATE meta SET value = '{manifest}' WHERE key = 'manifest'"
    execute(tmp_path, f"PRAGMA user_version = {version}", change)

    with pytest.raises(RecordError) as caught:
        CampaignStore.open(tmp_path)

    assert str(caught.value) == (
        f"{path}: found a campaign of version {version}, written by {writer}; expected version 4 "
        "or later, as mrsfi writes it from 0.3.0 on; open the campaign with the mrsfi that wrote "
        "it, or fly it anew with `mrsfi evolve`"
    )


def test_a_record_of_other_semantics_is_not_flown_and_names_who_wrote_it(tmp_path):
    later = replace(Manifest(versions={"mrsfi": "0.9.3"}), semantics=SEMANTICS + 1)
    store = CampaignStore.create(tmp_path, CampaignSettings(), later)

    with store, pytest.raises(RecordError) as caught:
        store.require_flyable()

    assert str(caught.value) == (
        f"{tmp_path}: found semantics {SEMANTICS + 1}; expected semantics {SEMANTICS}, which this "
        "mrsfi flies (docs/semantics.md); fly the campaign with mrsfi 0.9.3, read it with `mrsfi "
        f"report {tmp_path}`, or begin a new one"
    )
