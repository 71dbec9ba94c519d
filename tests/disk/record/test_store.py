"""The folder of a campaign: its store, lock, files, archive, and what was flown afterwards."""

import hashlib
import json
import math
import os
import sqlite3
import stat
import struct
import zipfile
from contextlib import closing
from dataclasses import asdict, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mrsfi.campaign import pack, repeat
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.model.faults import MOST, TimedFault
from mrsfi_runtime.model.mission import FailedFlight
from mrsfi_runtime.record import database
from mrsfi_runtime.record.database import COUNTS, CampaignFolder, no_writer, only_writer
from mrsfi_runtime.record.engine_settings import EngineSettings, Manifest
from mrsfi_runtime.record.store import CampaignStore, FailedEvaluation, Generation, RecordedFlight
from tests.support.campaigns import SETTINGS, evaluation, outcome
from tests.support.cli import execute
from tests.tiers import law

MANIFEST = Manifest(
    mission="uuv_sampling",
    case="b",
    engine=EngineSettings(
        "rosbridge", "ws://127.0.0.1:9090", client="twisted", side="ci", is_bundled=True
    ),
    versions={"python": "3.11.2"},
    machine="x86_64",
    sha256={"mission.xmi": "00ff"},
)
STATISTICS = {"n_evaluations": 2, "mean": 0.1 + 0.2, "std": 1e-300, "min": -0.0, "max": 5.0}
FAULTS = (TimedFault("f1", 1, 9, (0.1, 2.0)), TimedFault("f2", 3, 7))
FLOWN = RecordedFlight(7, FAULTS, outcome((5, 0, 9), 2))
FAILED = RecordedFlight(8, (), FailedFlight("Traceback of “this”:\n"))
LOCAL, CENTRAL = b"PK\3\4", b"PK\1\2"


def bits(number: float) -> bytes:
    return struct.pack("<d", number)


def test_what_was_appended_is_read_back_after_reopening(tmp_path):
    folder = tmp_path / "run"
    written = [evaluation(i, (i, 2, 3), generation=i // 2) for i in range(4)]
    generation = Generation(0, STATISTICS, (0, 1, 1), '{"state":[3,[1,2],null]}')
    failed = FailedEvaluation(3, 1, (TimedFault("f2", 0, 5, (1.5,)),), "Traceback …\nZeroDivision")

    with CampaignStore.create(folder, SETTINGS, MANIFEST) as store:
        store.append(written[:3])
        store.append(iter(written[3:]), [failed])
        store.append(generations=[generation])

    with CampaignStore.open(folder) as store:
        assert tuple(store.evaluations()) == tuple(written)
        assert store.evaluation(2) == written[2]
        assert store.n_evaluations == 4
        assert tuple(store.generations()) == (generation,)
        assert store.failures() == (failed,)
        assert store.settings == SETTINGS
        assert store.manifest == MANIFEST


def test_a_specification_is_stored_as_canonical_json():
    specification = (TimedFault("f9", 100, 900, (200, -450.0)), TimedFault("f1", 0, 1))

    assert (
        database.specification_text(specification)
        == '[["f9",100,900,[200.0,-450.0]],["f1",0,1,[]]]'
    )


@given(st.lists(st.floats(-MOST, MOST), max_size=4))
def test_floats_survive_bit_for_bit(values):
    specification = (TimedFault("f9", 1, 2, tuple(values)),)

    (rows,) = database.lists([database.specification_text(specification)])
    (back,) = database.specification(rows)

    assert [bits(value) for value in back.values] == [bits(value) for value in values]


def test_fitness_survives_bit_for_bit(store):
    fitness = (0.1 + 0.2, -0.0, 5e-324, 1.7976931348623157e308)
    store.append([replace(evaluation(0, (1,)), fitness=fitness)])

    read = store.evaluation(0).fitness

    assert [bits(value) for value in read] == [bits(value) for value in fitness]


def test_numpy_numbers_become_plain_ones(store):
    plain = evaluation(0, (3, 4))
    store.append(
        [
            replace(
                plain,
                index=np.int64(0),
                fitness=tuple(np.array(plain.fitness)),
                outcome=replace(plain.outcome, believed=tuple(np.array([3, 4]))),
            )
        ]
    )
    numpy_statistics = {"n_evaluations": np.int64(2), "mean": np.float64(0.5)}
    store.append(generations=[Generation(0, numpy_statistics, tuple(np.array([0, 0])), "[]")])

    assert store.evaluation(0) == plain
    assert next(store.generations()).statistics == {"n_evaluations": 2, "mean": 0.5}
    assert type(next(store.generations()).statistics["n_evaluations"]) is int


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_that_is_not_finite_is_refused_and_nothing_is_stored(store, value):
    with pytest.raises(ValueError, match="JSON compliant"):
        store.append([evaluation(0, (1,)), evaluation(1, (1,), fitness=value)])

    assert tuple(store.evaluations()) == ()


@pytest.mark.parametrize("index", [0, 3])
def test_an_index_that_does_not_follow_is_refused_and_nothing_is_stored(store, index, refused):
    store.append([evaluation(0, (1,))])

    with refused(ValueError):
        store.append([evaluation(1, (1,)), evaluation(index, (1,))])

    assert store.n_evaluations == 1


def test_a_generation_is_closed_once(store, refused):
    generation = Generation(0, STATISTICS, (), "[]")
    store.append(generations=[generation])

    with refused(ValueError):
        store.append(generations=[generation])


def test_an_unknown_evaluation_is_named_with_those_there_are(store, refused):
    with refused(RecordError):
        store.evaluation(0)

    store.append([evaluation(i, (1,)) for i in range(3)])

    with refused(RecordError):
        store.evaluation(9)


def digest_of(folder: Path, *chunks: list) -> str:
    with CampaignStore.create(folder, SETTINGS, Manifest()) as store:
        for chunk in chunks:
            store.append(chunk)
        return store.digest()


def test_the_digest_is_that_of_the_texts_in_the_file_as_the_page_says(tmp_path):
    """docs/semantics.md, Digest, last paragraph."""
    found = [evaluation(i, (i, 2)) for i in range(3)]
    digest = digest_of(tmp_path / "run", found[:1], [], found[1:])
    counts = 'believed, "true", phantom, masked, missed, samples, applied, changed'
    query = f"SELECT specification, {counts}, digest, fitness FROM evaluation ORDER BY idx"
    with closing(sqlite3.connect(tmp_path / "run" / "campaign.sqlite")) as file:
        rows = file.execute(query).fetchall()

    lines = [json.dumps(row, separators=(",", ":"), ensure_ascii=False) + "\n" for row in rows]
    assert hashlib.sha256("".join(lines).encode()).hexdigest() == digest


def test_failures_are_stored_with_the_evaluations_beside_them_or_not_at_all(store):
    failed = FailedEvaluation(1, 0, (TimedFault("f2", 0, 5, (1.5,)),), "Traceback")
    store.append([evaluation(0, (1,))], [failed])

    with pytest.raises(RecordError):
        store.append([evaluation(1, (1,))], [failed])

    assert store.n_evaluations == 1
    assert store.failures() == (failed,)


def test_a_part_of_the_evaluations_can_be_read(store):
    found = tuple(evaluation(i, (i,)) for i in range(5))
    store.append(found)

    assert tuple(store.evaluations(2)) == found[2:]
    assert tuple(store.evaluations(1, 2)) == found[1:3]
    assert tuple(store.evaluations(5, 1)) == ()


def test_one_generation_can_be_read(store):
    generation = Generation(0, STATISTICS, (0, 1), "[]")
    store.append(generations=[generation])

    assert store.generation(0) == generation
    assert store.generation(1) is None
    assert store.n_generations == 1


def test_a_creation_that_was_killed_is_begun_anew(tmp_path):
    for name in ("campaign.sqlite.new", "campaign.sqlite.new-journal"):
        (tmp_path / name).write_bytes(b"half")

    CampaignStore.create(tmp_path, SETTINGS, Manifest()).close()

    assert [entry.name for entry in tmp_path.iterdir()] == ["campaign.sqlite"]


def test_a_running_campaign_can_be_read(store, tmp_path):
    store.append([evaluation(0, (1,))])

    with CampaignStore.open(tmp_path / "run") as reader:
        assert reader.n_evaluations == 1
        store.append([evaluation(1, (1,))])
        assert reader.n_evaluations == 2


def test_an_outcome_keeps_each_count_in_its_place(store):
    distinct = replace(
        outcome((1, 2)),
        true=(3, 4),
        phantom=(5, 6),
        masked=(7, 8),
        missed=(13, 14),
        samples=(9, 10),
        applied=(11,),
        changed=(12,),
        margins=((0.1 + 0.2, 412), None),
        detection=((588, 3), (0, 0)),
    )
    store.append([replace(evaluation(0, (1, 2)), outcome=distinct)])

    assert store.evaluation(0).outcome == distinct
    assert list(store.margins()) == [(0, [3, 4], distinct.margins)]


def test_columns_that_a_record_lacks_are_none(store):
    store.append([evaluation(0, (1,))])
    digest = store.digest()
    for name in ("margins", "detection"):
        execute(store.path.parent, f"ALTER TABLE evaluation DROP COLUMN {name}")

    with CampaignStore.open(store.path.parent) as read:
        (found,) = read.evaluations()
        assert (found.outcome.margins, found.outcome.detection) == (None, None)
        assert read.evaluation(0) == found
        assert [each.outcome for each in read.flown(1)] == [found.outcome]
        assert [*read.margins()] == []
        assert read.digest() == digest


@pytest.fixture
def sources(tmp_path: Path) -> tuple[Path, Path]:
    models, generated = tmp_path / "models", tmp_path / "generated"
    (generated / "__pycache__").mkdir(parents=True)
    models.mkdir()
    (models / "mission.xmi").write_bytes(b"<mission/>\r\n")
    (models / "case_a.toml").write_text("seed = 1\n")
    (generated / "simulation.py").write_text("x = 1\n")
    (generated / "__pycache__" / "simulation.pyc").write_bytes(b"old")
    return models, generated


def test_models_and_generated_code_are_copied_byte_for_byte_without_caches(sources, tmp_path):
    folder = CampaignFolder.reserve(tmp_path / "runs" / "first")
    folder.fill(*sources)

    files = {
        file.relative_to(folder.path).as_posix(): file.read_bytes()
        for file in folder.path.rglob("*")
        if file.is_file()
    }
    assert files == {
        "model/mission.xmi": b"<mission/>\r\n",
        "model/case_a.toml": b"seed = 1\n",
        "generated/simulation.py": b"x = 1\n",
    }


def test_an_empty_folder_is_used(sources, tmp_path):
    (tmp_path / "run").mkdir()

    folder = CampaignFolder.reserve(tmp_path / "run")
    folder.fill(*sources)

    assert folder.model.is_dir()


@pytest.mark.parametrize("name", ["run/note.txt", "run"])
def test_what_is_there_already_is_refused_and_left_alone(tmp_path, name, refused):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")

    with refused(RecordError):
        CampaignFolder.reserve(tmp_path / "run")

    assert (tmp_path / name).read_text() == "mine"


def test_what_a_killed_start_left_is_replaced(sources, tmp_path):
    path = tmp_path / "run"
    (path / "model").mkdir(parents=True)
    for name in ("model/mission.xmi", "campaign.lock", "campaign.sqlite.new"):
        (path / name).write_text("half")

    CampaignFolder.reserve(path).fill(*sources)

    assert (path / "model" / "mission.xmi").read_bytes() == b"<mission/>\r\n"
    assert (path / "generated" / "simulation.py").is_file()


@pytest.mark.parametrize("name", ["campaign.sqlite", "notes.txt"])
def test_a_folder_that_somebody_filled_since_it_was_reserved_is_left_alone(
    sources, tmp_path, name, refused
):
    folder = CampaignFolder.reserve(tmp_path / "run")
    (folder.path / "campaign.lock").touch()
    (folder.path / name).write_text("theirs")

    with refused(RecordError):
        folder.fill(*sources)

    assert sorted(entry.name for entry in folder.path.iterdir()) == ["campaign.lock", name]


def test_missing_models_are_refused_with_the_path(tmp_path, refused):
    with refused(RecordError):
        CampaignFolder.reserve(tmp_path / "run").fill(tmp_path / "nowhere", tmp_path)


def test_the_lock_is_free_again_after_the_body_and_its_file_stays(tmp_path):
    folder = CampaignFolder(tmp_path)

    for _ in range(2):
        with only_writer(folder):
            assert folder.lock.read_text(encoding="ascii") == f"{os.getpid()}\n"

    assert stat.S_ISREG(folder.lock.stat().st_mode)


def test_a_second_writer_is_refused_with_the_process_of_the_first(tmp_path):
    folder = CampaignFolder(tmp_path)
    message = rf"{tmp_path.name}: another process \({os.getpid()}\) is running this campaign"

    with only_writer(folder), pytest.raises(RecordError, match=message), only_writer(folder):
        pass


def test_nobody_writes_while_somebody_reads_and_the_other_way_round(tmp_path):
    folder = CampaignFolder(tmp_path)
    message = "another process"
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


def damage(store, column, content):
    """Store something else about the first flight."""
    with closing(sqlite3.connect(store.path)) as other, other:
        other.execute(f"UPDATE flight SET {column} = ? WHERE idx = 1", (content,))


def test_flights_are_read_back_in_order(store):
    store.append_flights([FLOWN, FAILED])
    store.append_flights([FLOWN])

    with CampaignStore.open(store.path.parent) as again:
        assert again.flights() == (FLOWN, FAILED, FLOWN)


def test_flights_change_neither_evaluations_nor_digest(store):
    store.append([evaluation(0, (1, 2))])
    before = tuple(store.evaluations()), store.digest()

    store.append_flights([FLOWN])

    assert (tuple(store.evaluations()), store.digest()) == before


@pytest.mark.parametrize(
    ("column", "content"),
    [
        *(
            ("found", text)
            for text in ("", "{", "[]", "[{}]", "[1]", '["a","b"]', None, b"\xff", 7)
        ),
        ("found", json.dumps([asdict(FLOWN.found) | {"more": 1}])),
        ("found", json.dumps([{"digest": ""} | {name: ["1"] for name in COUNTS}])),
        ("specification", "[[1]]"),
        ("specification", None),
    ],
)
def test_what_makes_no_sense_is_damage(store, column, content):
    store.append_flights([FLOWN])
    damage(store, column, content)

    with pytest.raises(RecordError, match="the record is damaged"):
        store.flights()


@given(st.data())
@law(100)
def test_a_text_with_another_character_is_damage_or_still_a_flight(data):
    seed, specification, text = FLOWN.row()
    place = data.draw(st.integers(0, len(text) - 1))
    drawn = data.draw(st.characters(codec="ascii"))

    try:
        found = RecordedFlight.from_row(
            (seed, specification, text[:place] + drawn + text[place + 1 :])
        )
    except (ValueError, TypeError):
        return

    assert RecordedFlight.from_row(found.row()) == found


def with_entries(content, flags, method):
    """Return an archive whose only entry says other flags and another way of compression."""
    for signature, place in ((LOCAL, 6), (CENTRAL, 8)):
        start = content.index(signature) + place
        told = flags.to_bytes(2, "little") + method.to_bytes(2, "little")
        content = content[:start] + told + content[start + 4 :]
    return content


SPOILED = {
    "no archive": lambda _: b"PK nothing",
    "cut": lambda content: content[:-40],
    "noise inside": lambda content: content[:60] + b"\xff" * 40 + content[100:],
    "encrypted": lambda content: with_entries(content, 1, 8),
    "compressed in no known way": lambda content: with_entries(content, 0, 99),
    "compressed by something else": lambda content: with_entries(content, 0, 14),
    "with a name that is no UTF-8": lambda content: with_entries(
        content.replace(b".sqlite", b".\xffqlite"), 0x800, 8
    ),
}


@pytest.mark.parametrize("name", SPOILED)
def test_what_is_no_archive_is_refused_by_its_name(name, tmp_path, refused):
    path = tmp_path / "run.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("campaign/campaign.sqlite", bytes(range(256)) * 20)
    path.write_bytes(SPOILED[name](path.read_bytes()))

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))


def listed(**members):
    """Return members of an archive with a list that fits them."""
    lines = [f"{sha256(content).hexdigest()}  {name}\n" for name, content in members.items()]
    return members | {"SHA256SUMS": "".join(lines).encode(), "REPRODUCE.md": b""}


def write(path, members):
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members:
            archive.writestr(name, content)


@pytest.mark.parametrize("name", ["campaign/mission.xmi", "../campaign/campaign.sqlite"])
def test_an_archive_of_something_else_is_refused_and_nothing_lands_beside_it(
    name, tmp_path, refused
):
    path = tmp_path / "run.zip"
    write(path, listed(**{name: b"something else"}).items())

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))

    assert [each.name for each in tmp_path.iterdir()] == ["run.zip"]


def test_an_archive_without_a_list_of_hashes_is_none_of_a_campaign(tmp_path, refused):
    path = tmp_path / "run.zip"
    write(path, [("campaign/campaign.sqlite", b"")])

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_member_that_is_there_twice_is_refused(tmp_path, refused):
    path, members = tmp_path / "run.zip", listed(x=b"")
    write(path, [*members.items(), ("x", b"")])

    with refused(RecordError):
        repeat(path, lambda _: pytest.fail("nothing is flown"))
