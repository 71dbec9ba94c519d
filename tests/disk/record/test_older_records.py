"""Records of earlier releases: read, with what they have, and never flown."""

from dataclasses import replace

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.semantics import SEMANTICS
from mrsfi_runtime.record.manifest import Manifest
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from tests.support.older_records import DIGEST_OF_1, recorded_by_1


def test_a_record_of_semantics_1_is_read_and_keeps_its_digest(tmp_path):
    with CampaignStore.open(recorded_by_1(tmp_path / "run")) as store:
        found = tuple(store.evaluations())
        one, digest = store.evaluation(1), store.digest()
        semantics = store.manifest.semantics

    assert semantics == 1
    assert [each.fitness[0] for each in found] == [37.699999999999996, 90.8, 17.299999999999997]
    assert found[1] == one
    assert one.outcome.believed == (0, 0, 171, 127, 0, 0, 0)
    assert one.outcome.missed is None
    assert one.outcome.missed_since(200) is None
    assert one.outcome.changed == (179, 12, 12)
    assert digest == DIGEST_OF_1


def test_a_record_of_semantics_1_is_not_flown_and_names_who_flies_it(tmp_path):
    folder = recorded_by_1(tmp_path / "run")

    with CampaignStore.open(folder) as store, pytest.raises(RecordError) as caught:
        store.require_flyable()

    assert str(caught.value) == (
        f"{folder}: found semantics 1; expected semantics {SEMANTICS}, which this mrsfi flies "
        f"(docs/semantics.md); fly the campaign with mrsfi 0.1, read it with `mrsfi report "
        f"{folder}`, or begin a new one"
    )


def test_a_record_of_later_semantics_names_the_release_that_wrote_it(tmp_path):
    later = replace(Manifest(versions={"mrsfi": "0.9.3"}), semantics=SEMANTICS + 1)
    with (
        CampaignStore.create(tmp_path, CampaignSettings(), later) as store,
        pytest.raises(RecordError, match=r"fly the campaign with mrsfi 0\.9\.3,"),
    ):
        store.require_flyable()


def test_a_record_of_today_can_be_flown(tmp_path):
    with CampaignStore.create(tmp_path, CampaignSettings(), Manifest()) as store:
        store.require_flyable()
