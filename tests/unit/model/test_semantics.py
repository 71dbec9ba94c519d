"""The version of the world's rules: what says none, and what an error says of another."""

from mrsfi_runtime.model.semantics import RELEASES, SEMANTICS, flown_by
from mrsfi_runtime.record.manifest import Manifest


def test_a_campaign_of_today_says_todays_version_and_one_without_is_of_version_1():
    manifest = Manifest(mission="x")

    assert manifest.as_json()["semantics"] == SEMANTICS
    assert Manifest.from_json(manifest.as_json()) == manifest
    assert Manifest.from_json({"mission": "x"}).semantics == 1


def test_every_version_until_today_has_a_release():
    assert [*RELEASES] == [*range(1, SEMANTICS + 1)]


def test_the_release_of_a_known_version_is_ours_to_say_and_of_a_later_one_the_records():
    assert flown_by(1, "0.1.7") == "mrsfi 0.1"
    assert flown_by(99, "7.2.0") == "mrsfi 7.2.0"
    assert flown_by(99) == "a later mrsfi"
