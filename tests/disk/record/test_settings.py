"""Settings, kept findings and recorded campaigns that are read or refused."""

import json
import os
import sqlite3
import tomllib
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.errors import RecordError, UsageError
from mrsfi_runtime.model.fault_types import SEMANTICS
from mrsfi_runtime.record.engine_settings import Manifest
from mrsfi_runtime.record.settings import (
    VIOLATIONS,
    CampaignSettings,
    Regression,
    kept,
    require_seed,
    require_whole,
)
from mrsfi_runtime.record.store import CampaignStore
from tests.support.campaigns import evaluation
from tests.support.cli import execute
from tests.tiers import law

CASE = """
[search]
algorithm = "paper"
population = 20
generations = 50
faults = 20
crossover = 0.7
mutation = 1
selection = "roulette"
fitness = "focused"
goals = ["g1", "g3"]
seed = 3
mission_seed = 4
"""
SOUND = {
    "found": '"here"',
    "accepted": '"known"',
    "side": '"ci"',
    "violations": '"true"',
    "mission_seeds": "[1, 2]",
    "goals": "1",
    "max": "{g1 = 3}",
}
TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=40)
COUNTS = st.integers(0, 2**63 - 1)


def test_a_campaign_file_is_read(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")

    settings = CampaignSettings.load(path)

    assert settings == CampaignSettings(
        mutation=1.0, fitness="focused", goals=("g1", "g3"), seed=3, mission_seed=4
    )
    assert type(settings.mutation) is float
    assert settings.source == str(path)


def test_what_a_file_leaves_out_has_the_papers_value():
    settings = CampaignSettings.parse("[search]", "case.toml")

    assert (settings.population, settings.generations, settings.faults) == (20, 50, 20)
    assert (settings.crossover, settings.mutation, settings.selection) == (0.7, 0.7, "roulette")


def test_overrides_replace_the_files_values_unless_none():
    settings = CampaignSettings.parse(CASE, "case.toml", seed=9, evaluations=100, algorithm=None)

    assert (settings.seed, settings.evaluations, settings.algorithm) == (9, 100, "paper")


def test_generations_given_beside_a_file_replace_its_evaluations():
    text = CASE + "evaluations = 300\n"

    assert CampaignSettings.parse(text, "case.toml").evaluations == 300
    settings = CampaignSettings.parse(text, "case.toml", generations=5)
    assert (settings.generations, settings.evaluations) == (5, None)
    settings = CampaignSettings.parse(text, "case.toml", generations=5, evaluations=200)
    assert settings.evaluations == 200


def test_settings_survive_json():
    settings = CampaignSettings.parse(CASE, "case.toml", evaluations=7)

    text = json.dumps(settings.as_json())

    assert "case.toml" not in text
    assert CampaignSettings.from_json(json.loads(text)) == settings
    assert CampaignSettings.from_json(CampaignSettings().as_json()) == CampaignSettings()


@pytest.mark.parametrize(
    "line",
    [
        "poplation = 20",
        "population = 0",
        "population = true",
        "population = 20.0",
        "generations = -1",
        "crossover = 1.5",
        "mutation = nan",
        "mutation = true",
        'mutation_share = "x"',
        "algorithm = 3",
        'goals = "g1"',
        'goals = ["g1", "g1"]',
        "goals = [1]",
        "seed = -1",
        "evaluations = 0",
        "max_failures = 0",
        "seed = 1\nseed = 2",
        "[engine]",
        "violations = 'phantom'",
        "violations = ['true']",
        "minimise = 'ticks'",
        "replications = 0",
        "offspring = 0",
        "mutation_operator = ''",
    ],
)
def test_wrong_settings_name_file_key_found_and_expected(line, refused):
    with refused(UsageError):
        CampaignSettings.parse(f"[search]\n{line}\n", "case.toml")


@pytest.mark.parametrize("text", ["", "search = 3"])
def test_a_file_without_its_table_is_refused(text, refused):
    with refused(UsageError):
        CampaignSettings.parse(text, "case.toml")


def test_a_wrong_override_is_refused(refused):
    with refused(UsageError):
        CampaignSettings.parse(CASE, "case.toml", seed="x")


def test_a_missing_or_unreadable_file_is_refused(tmp_path, refused):
    (tmp_path / "latin.toml").write_bytes(b"[search]\n# \xe9\n")

    for name in ("none.toml", "latin.toml"):
        with refused(UsageError):
            CampaignSettings.load(tmp_path / name)


def test_replications_fly_on_the_mission_seeds_that_follow():
    settings = CampaignSettings(mission_seed=2**63 - 2, replications=3)

    assert settings.mission_seeds == (2**63 - 2, 2**63 - 1, 0)


def test_a_number_of_things_is_at_least_one_and_a_mission_seed_at_least_zero(refused):
    assert (require_whole("workers", 1), require_seed(0)) == (1, 0)
    with refused(UsageError):
        require_whole("workers", 0)
    with refused(UsageError):
        require_seed(-1)


def written(path, **changed):
    lines = (f"{key} = {value}\n" for key, value in {**SOUND, **changed}.items() if value)
    path.write_text("".join(lines), encoding="utf-8")
    return path


def test_nothing_is_kept_where_there_is_no_folder_or_none_in_it(tmp_path):
    assert kept(tmp_path) == ()
    (tmp_path / "regressions").mkdir()
    (tmp_path / "regressions" / "notes.txt").write_text("not kept", encoding="utf-8")
    assert kept(tmp_path) == ()


def test_what_is_kept_is_read_by_name(tmp_path):
    folder = tmp_path / "regressions"
    folder.mkdir()
    for name in ("b", "a"):
        (folder / f"{name}.xmi").write_text("<faults/>", encoding="utf-8")
        written(folder / f"{name}.toml")

    found = kept(tmp_path)

    sound = [
        Regression(folder / f"{n}.toml", "here", "true", (1, 2), {"g1": 3}, None, "known", "ci")
        for n in "ab"
    ]
    assert found == tuple(sound)


def test_a_file_that_cannot_be_read_is_a_defect_of_its_own(tmp_path, approved):
    folder = tmp_path / "regressions"
    folder.mkdir()
    os.mkfifo(folder / "pipe.toml")
    (folder / "folder.xmi").mkdir()
    (folder / "lonely.xmi").write_text("<faults/>", encoding="utf-8")
    written(folder / "sound.toml")

    said = {each.name: str(each.defect) for each in kept(tmp_path)}

    approved(said["pipe"])
    approved(said["folder"])
    approved(said["lonely"])
    assert said["sound"] == "None"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("found", "3"),
        ("found", ""),
        ("accepted", "3"),
        ("violations", '"seen"'),
        ("mission_seeds", "[]"),
        ("mission_seeds", "[-1]"),
        ("mission_seeds", "[true]"),
        ("goals", "-1"),
        ("goals", ""),
        ("goals", "2"),
        ("max", "{}"),
        ("max", "{g1 = 0.5}"),
        ("more", "1"),
    ],
)
def test_limits_that_make_no_sense_are_refused(key, value, tmp_path, refused):
    path = written(tmp_path / "a.toml", **{key: value})

    with refused(UsageError):
        Regression.load(path)


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


@law(100)
@given(
    TEXTS,
    st.sampled_from(VIOLATIONS),
    st.lists(COUNTS, min_size=1).map(tuple),
    st.dictionaries(TEXTS, COUNTS, min_size=1),
)
def test_any_text_and_any_name_of_a_goal_are_read_as_written(found, violations, seeds, limits):
    written = Regression(Path("it.toml"), found, violations, seeds, limits).text()

    assert tomllib.loads(written) == {
        "found": found,
        "violations": violations,
        "mission_seeds": list(seeds),
        "goals": len(limits),
        "max": limits,
    }
