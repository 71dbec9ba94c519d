import os
import threading
from pathlib import Path

import pytest

from m2t.models.load import load_mission_folder
from tests.support.cli import MISSION, ROOT, edit, mrsfi, mrsfi_json
from tests.support.models.published import published


@pytest.fixture(scope="session")
def text() -> str:
    return published(load_mission_folder(ROOT / "models" / MISSION))


@pytest.fixture
def file(text: str, place: Path) -> Path:
    path = place / "Paper model.xmi"
    path.write_text(text, encoding="ascii")
    return path


def test_an_imported_mission_generates_and_flies(file, place):
    text = mrsfi("import", file, "--out", "models/harbour", cwd=place).stdout

    mrsfi("generate", "harbour", cwd=place)
    flight = mrsfi_json("simulate", "harbour", "--no-faults", cwd=place)
    lines = text.splitlines()
    assert lines[0].split() == ["written", "models/harbour/mission.xmi"]
    assert any(line.startswith("kept          3 robots, 1 server, 8 obsta") for line in lines)
    assert any(line.startswith("dropped       parentID of 15 elements (li") for line in lines)
    assert lines[-1].split(maxsplit=1) == ["next", "mrsfi validate models/harbour"]
    assert not any(goal["believed"] for goal in flight["goals"])


def test_a_file_without_faults_becomes_a_mission_that_flies_and_waits_for_some(file, place):
    text = file.read_text(encoding="ascii")
    begin, end = text.index("<specification"), text.index("</setup:Setup>")
    file.write_text(text[:begin] + text[end:], encoding="ascii")

    told = mrsfi("import", file, "--out", "models/harbour", cwd=place).stdout
    early = mrsfi("validate", "harbour", cwd=place).stderr
    mrsfi("generate", "harbour", cwd=place)
    flight = mrsfi_json("simulate", "harbour", cwd=place)
    refused = mrsfi("evolve", "harbour", cwd=place, expected=5).stderr

    assert "faults.xmi is an empty pool; a search needs faults in it" in told
    assert early == (
        "not flown without faults: generated/harbour: not generated yet; run `mrsfi generate "
        "models/harbour`\n"
    )
    assert not any(goal["believed"] for goal in flight["goals"])
    assert "fault pool 'faults' is empty; a search needs at least one fault" in refused
    assert not (place / "runs").exists()


def test_the_folder_is_named_after_the_file(file, place):
    mrsfi("import", file, cwd=place)

    assert "no difference" in mrsfi("diff", MISSION, "Paper_model", cwd=place).stdout
    assert mrsfi("validate", "Paper_model", cwd=place).stdout.startswith("ok: Paper_model: ")


def test_import_as_json_lists_every_note(file, place):
    edit(file, 'ID="s2" parentID="r1"', 'ID="s2" parentID="r3"')

    result = mrsfi_json("import", file, "--out", "models/harbour", cwd=place)

    found = [note for note in result["notes"] if note["kind"] == "inconsistent"]
    assert [(note["element"], note["feature"]) for note in found] == [("sensors 's2'", "parentID")]
    assert result["folder"] == "models/harbour"
    assert result["counts"]["faults"] == 30


def test_import_of_a_model_of_ours_says_that_it_needs_none(place, approved):
    path = f"models/{MISSION}/mission.xmi"

    approved(mrsfi("import", path, cwd=place, expected=3).stderr)


def test_diff_reads_files_and_pipes(place):
    model = place / "models" / MISSION / "mission.xmi"
    old, pipe = place / "old.xmi", place / "old"
    old.write_bytes(model.read_bytes())
    edit(model, 'name="JEN" speed="4.0"', 'name="JEN" speed="6.0"')
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(old.read_bytes(),), daemon=True)
    writer.start()

    for given in (pipe, old):
        assert mrsfi("diff", given, MISSION, cwd=place).stdout == "robot r2: speed 4.0 → 6.0\n"
    writer.join(10)
    assert mrsfi("diff", old, old, cwd=place).stdout == "no difference\n"
    (change,) = mrsfi_json("diff", "old.xmi", model, cwd=place)["changes"]
    assert (change["element"], change["old"], change["new"]) == ("robot r2", "4.0", "6.0")


def test_diff_of_nothing_ends_with_2_and_of_no_model_with_3(place):
    (place / "text.xmi").write_text("text")

    assert "nowhere" in mrsfi("diff", "nowhere", MISSION, cwd=place, expected=2).stderr
    assert "text.xmi:1" in mrsfi("diff", "text.xmi", MISSION, cwd=place, expected=3).stderr
