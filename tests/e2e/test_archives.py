"""Archives of campaigns: what was changed in one is found, and what was not passes anywhere."""

import json
import os
import shutil
import tempfile
import zipfile
from hashlib import sha256
from pathlib import Path

import pytest

from mrsfi_runtime.record import engine_settings
from tests.e2e.conftest import made_once
from tests.support.cli import contents, edit, execute, mrsfi, mrsfi_json, mrsfi_process
from tests.support.edited import indented, write_body
from tests.support.rendezvous import NAME, write_rendezvous
from tests.tiers import seeds, slow

LISTED, TOLD = "SHA256SUMS", "REPRODUCE.md"
SEARCH = ("--population", "8", "--generations", "4", "--faults", "2", "--workers", "1")
FLY = ("--engine", "reference")
FAILING = """if ci.mission.tick == 55 and abs(ci.robots[A].x) > 50.0:
    raise ValueError(f"a is far off: {__file__}")
return goal_tasks.visit.violated(ci, G1)"""


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """Let one worker evaluate, in this process: others begin slowly."""
    monkeypatch.setattr(engine_settings, "_N_PROCESSORS", 1)


@pytest.fixture(scope="session")
def campaign(tmp_path_factory):
    """Folder of a finished campaign with failures, weaknesses and a report; only to be read."""

    def make(folder):
        generated = write_rendezvous(folder)
        write_body(generated / "collective_intelligence.py", "g1.check", indented(FAILING))
        (folder / "search.toml").write_text("[search]\n", encoding="utf-8")
        words = ("evolve", NAME, "--case", "search.toml", *SEARCH, *FLY, "--out", "runs/it")
        mrsfi_process(*words, cwd=folder)

    return made_once(tmp_path_factory, "archived", make) / "runs" / "it"


@pytest.fixture
def archive(campaign, tmp_path):
    """An archive of it, in a folder of its own, and the digest that is printed of it."""
    path = tmp_path / "it.zip"
    done = mrsfi("pack", campaign, "--out", path, cwd=tmp_path)
    return path, done.stdout.split()[-1]


def unpacked(archive, place):
    with zipfile.ZipFile(archive) as content:
        content.extractall(place)
    return place


def packed(place, archive, forged):
    """Pack what was unpacked as it is now; if forged, with a list and a digest that fit it."""
    files = [path for path in sorted(place.rglob("*")) if path.is_file()]
    names = [path.relative_to(place).as_posix() for path in files]
    if forged:
        before = sha256((place / LISTED).read_bytes()).hexdigest()
        rows = [
            f"{sha256((place / name).read_bytes()).hexdigest()}  {name}\n"
            for name in names
            if name not in (LISTED, TOLD)
        ]
        (place / LISTED).write_text("".join(rows), encoding="utf-8")
        edit(place / TOLD, before, sha256((place / LISTED).read_bytes()).hexdigest())
    with zipfile.ZipFile(archive, "w") as content:
        for path, name in zip(files, names, strict=True):
            content.write(path, name)
    return archive


DATABASE = "campaign/campaign.sqlite"


def recorded(*statements):
    return DATABASE, lambda run: execute(run, *statements)


def replaced(name, before, after):
    return f"campaign/{name}", lambda run: edit(run / name, before, after)


def appended(name, content=b"\n"):
    def append(run):
        with (run / name).open("ab") as file:
            file.write(content)

    return f"campaign/{name}", append


def summarised(key, value):
    def change(run):
        path = run / "summary.json"
        told = json.loads(path.read_text())
        assert told[key] != value
        path.write_text(json.dumps(told | {key: value}))

    return "campaign/summary.json", change


def meta(key, before, after):
    return recorded(
        f"UPDATE meta SET value = replace(value, '{before}', '{after}') WHERE key = '{key}'"
    )


LAST = "WHERE idx = (SELECT max(idx) FROM evaluation)"
TURNED = (
    f"INSERT INTO failure SELECT 33, generation, specification, 'no' FROM evaluation {LAST}",
    f"DELETE FROM evaluation {LAST}",
)
FLIGHT = "WHERE idx = (SELECT max(idx) FROM flight WHERE found LIKE '[{%')"

RESULTS = {
    "all evaluations deleted": recorded("DELETE FROM evaluation"),
    "everything deleted": recorded(
        *(f"DELETE FROM {name}" for name in ("evaluation", "failure", "generation", "flight"))
    ),
    "the last rows cut": recorded("DELETE FROM evaluation WHERE idx >= 12"),
    "a row in the middle cut": recorded("DELETE FROM evaluation WHERE idx = 5"),
    "a row turned into a failure": recorded(*TURNED),
    "a failure deleted": recorded("DELETE FROM failure WHERE idx = (SELECT min(idx) FROM failure)"),
    "counts": recorded("UPDATE evaluation SET believed = '[1,0,0]' WHERE idx = 3"),
    "fitness": recorded("UPDATE evaluation SET fitness = '[9999.0]' WHERE idx = 3"),
    "a specification": recorded(
        "UPDATE evaluation SET specification = '[[\"stop_b\",1,2,[]]]' WHERE idx = 3"
    ),
    "settings": meta("settings", '"faults":2', '"faults":1'),
    "the seed": meta("settings", '"seed":1', '"seed":2'),
    "a population": recorded("UPDATE generation SET population = '[0,0,0]' WHERE idx = 2"),
    "a random state": recorded(
        "UPDATE generation SET random_state = (SELECT random_state FROM generation WHERE idx = 1) "
        "WHERE idx = 2"
    ),
    "flights deleted": recorded("DELETE FROM flight"),
    "a flight deleted": recorded(f"DELETE FROM flight {FLIGHT}"),
    "counts of a flight": recorded(
        f"""UPDATE flight SET found = replace(found, '"digest":"', '"digest":"0') {FLIGHT}"""
    ),
    "the specification of a flight": recorded(
        f"""UPDATE flight SET specification = '[["stop_b",1,2,[]]]' {FLIGHT}"""
    ),
    "a flight of no fault of the mission": recorded(
        f"""UPDATE flight SET specification = '[["none",1,2,[]]]' {FLIGHT}"""
    ),
    "weaknesses": meta("weaknesses", '"goal":"g2"', '"goal":"g1"'),
    "weaknesses deleted": recorded("DELETE FROM meta WHERE key = 'weaknesses'"),
    "the summary": summarised("n_failures", 0),
    "the weaknesses of the summary": summarised("weaknesses", None),
    "a critical specification": replaced("critical/01.xmi", "start=", "start ="),
    "a critical specification deleted": (
        "campaign/critical/01.xmi",
        lambda run: (run / "critical" / "01.xmi").unlink(),
    ),
}
"""Changes of what a campaign found: the member that they change, and how."""

OTHERS = {
    "versions": meta("manifest", '"mrsfi":"', '"mrsfi":"9'),
    "the kind of processor": meta("manifest", '"machine":"', '"machine":"x'),
    "a model": appended("model/mission.xmi"),
    "a region": appended("generated/collective_intelligence.py"),
    "the page": appended("report.html"),
    "a table": appended("tables/evaluations.csv"),
    "the text for people": (TOLD, lambda run: edit(run.parent / TOLD, "To repeat", "To copy")),
    "a member added": appended("notes.txt"),
    "a member missing": ("campaign/report.md", lambda run: (run / "report.md").unlink()),
}
"""Changes of what nothing flies."""


def changed(archive, change, tmp_path, forged=False):
    """Return an archive of which something was changed, and which member that is."""
    place = unpacked(archive, tmp_path / "unpacked")
    before = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    member, apply = change
    apply(place / "campaign")
    after = {path: path.read_bytes() for path in place.rglob("*") if path.is_file()}
    assert before != after
    return packed(place, tmp_path / "changed.zip", forged), member


@pytest.mark.parametrize("name", RESULTS | OTHERS)
def test_a_member_that_is_not_as_it_was_packed_is_named_and_nothing_runs(name, archive, tmp_path):
    path, member = changed(archive[0], (RESULTS | OTHERS)[name], tmp_path)

    done = mrsfi("check", path, *FLY, cwd=tmp_path, expected=9)

    what = {"a member added": "was added", "a member missing": "is missing"}
    what["a critical specification deleted"] = "is missing"
    assert f"{path}: {member} {what.get(name, 'was changed')}; expected" in done.stderr
    assert "runs the code" not in done.stderr


FIRST = ("fitness", "flights deleted", "the summary")


@pytest.mark.parametrize("name", seeds(sorted(RESULTS, key=lambda name: name not in FIRST), 3, 7))
def test_a_changed_result_differs_where_the_list_was_rewritten_with_it(name, archive, tmp_path):
    path, _ = changed(archive[0], RESULTS[name], tmp_path, forged=True)

    done = mrsfi("check", path, *FLY, cwd=tmp_path, expected=7)

    assert done.stdout == ""


@pytest.mark.parametrize("name", RESULTS | OTHERS)
def test_whatever_was_changed_with_the_list_has_another_digest(name, archive, tmp_path):
    archive, digest = archive
    path, _ = changed(archive, (RESULTS | OTHERS)[name], tmp_path, forged=True)

    done = mrsfi("check", path, *FLY, "--digest", digest, cwd=tmp_path, expected=9)

    told = f"{TOLD} was changed" if name == "the text for people" else f"expected {digest}"
    assert told in done.stderr
    assert "runs the code" not in done.stderr


def test_what_differs_is_named_with_how_many_do_not(archive, tmp_path):
    path, _ = changed(archive[0], RESULTS["counts"], tmp_path, forged=True)

    done = mrsfi("check", path, *FLY, cwd=tmp_path, expected=7)

    assert f"{path}/campaign: evaluation 3 differs from its record: found " in done.stderr
    assert "as recorded are 28 of 29 evaluations, 5 of 5 failures, 5 of 5 generations, 76 " in (
        done.stderr
    )


def test_an_archive_as_it_was_packed_passes_elsewhere(
    archive, campaign, tmp_path, monkeypatch, approved
):
    path, digest = archive
    place = tmp_path / "elsewhere"
    (place / "temporary").mkdir(parents=True)
    shutil.move(path, place / "other name.zip")
    monkeypatch.setattr(tempfile, "tempdir", str(place / "temporary"))
    before = os.umask(0o77)

    try:
        done = mrsfi("check", "other name.zip", *FLY, "--digest", digest.upper(), cwd=place)
        told = mrsfi_json("check", "other name.zip", *FLY, cwd=place)
    finally:
        os.umask(before)

    found = json.loads((campaign / "summary.json").read_text())["digest"]
    numbers = {"evaluations": 29, "failures": 5, "generations": 5, "flights": 76}
    parts = {"parts of the report": 19}
    same = ", ".join(f"{n} of {n} {kind}" for kind, n in (numbers | parts).items())
    assert done.stdout == (
        f"same: {same}\ncampaign digest {found}\narchive digest {digest}: as given\n"
    )
    approved(done.stderr)
    assert told == {
        "is_same": True,
        "digest": found,
        "archive": digest,
        "numbers": numbers | parts,
    }
    assert [*(place / "temporary").iterdir()] == []


@slow
def test_several_workers_and_a_report_with_a_ratio_make_no_difference(tmp_path, monkeypatch):
    write_rendezvous(tmp_path)
    (tmp_path / "search.toml").write_text('[search]\ngoals = ["g1", "g2"]\n', encoding="utf-8")
    words = ("--population", "6", "--generations", "2", "--workers", "2", "--ratio", "g1:g2=2:1")
    mrsfi("evolve", NAME, "--case", "search.toml", *words, *FLY, "--out", "it", cwd=tmp_path)
    mrsfi("pack", "it", cwd=tmp_path)
    monkeypatch.setattr(engine_settings, "_N_PROCESSORS", 2)

    assert mrsfi("check", "it.zip", cwd=tmp_path).stdout.startswith("same: ")


def test_two_packs_are_the_same_bytes_and_nothing_is_written_to_the_campaign(campaign, tmp_path):
    run = Path(shutil.copytree(campaign, tmp_path / "runs" / "it"))
    (run / "campaign.lock").unlink()
    before = contents(run)

    mrsfi("pack", "runs/it", "--out", "elsewhere.zip", cwd=tmp_path)
    assert contents(run) == before
    mrsfi("replay", "runs/it", cwd=tmp_path)
    for out in ("inside.zip", "tables/inside.zip"):
        for _ in range(2):
            mrsfi("pack", ".", "--out", out, cwd=run)
            assert (run / out).read_bytes() == (tmp_path / "elsewhere.zip").read_bytes()
        (run / out).unlink()
    with zipfile.ZipFile(tmp_path / "elsewhere.zip") as content:
        texts = {each: content.read(each) for each in content.namelist() if "sqlite" not in each}
    assert not [name for name, text in texts.items() if str(campaign.parent).encode() in text]


@pytest.mark.parametrize("is_there", [True, False])
def test_a_summary_that_is_missing_or_older_than_the_record_is_told(
    is_there, campaign, tmp_path, approved
):
    path = Path(shutil.copytree(campaign, tmp_path / "it")) / "summary.json"
    if is_there:
        os.utime(path, (0, 0))
    else:
        path.unlink()

    done = mrsfi("pack", "it", cwd=tmp_path)

    approved(done.stderr)


@pytest.mark.parametrize("side", ["ci", "injector"])
def test_what_an_external_part_flew_is_compared_and_never_called_the_same(side, campaign, tmp_path):
    run = Path(shutil.copytree(campaign, tmp_path / "it"))
    bus = f'"engine":"rosbridge","bus":{{"url":"ws://localhost:9","client":"ours","side":"{side}"}}'
    execute(
        run,
        'UPDATE meta SET value = replace(value, \'"engine":"reference"\', '
        f"'{bus}') WHERE key = 'manifest'",
    )
    digest = mrsfi("pack", "it", cwd=tmp_path).stdout.split()[-1]

    done = mrsfi("check", "it.zip", cwd=tmp_path, expected=9)

    assert done.stdout == ""
    assert (
        f"it.zip: members are as packed (digest {digest}); flights are not repeated" in done.stderr
    )


@pytest.mark.parametrize("option", ["--github", "--seeds=2", "--junit=x.xml", "--generated=x"])
def test_what_is_of_kept_weaknesses_makes_no_sense_for_an_archive(
    option, archive, tmp_path, approved
):
    path, _ = archive

    approved(mrsfi("check", path, option, cwd=tmp_path, expected=2).stderr)


def test_a_digest_makes_no_sense_for_kept_weaknesses(tmp_path, approved):
    done = mrsfi("check", "mission", "--digest", "0", cwd=tmp_path, expected=2)

    approved(done.stderr)
