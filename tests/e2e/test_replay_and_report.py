import re

import pytest
from PIL import Image

from mrsfi_runtime.model.mission import RESULTS
from tests.support.cli import execute, mrsfi, mrsfi_json


def test_replay_of_the_best_is_the_same_as_recorded(campaign, tmp_path):
    text = mrsfi("replay", campaign, cwd=tmp_path).stdout

    assert "same as recorded, digest " in text
    assert "AvoidCollision" in text


def test_replay_of_one_evaluation_writes_log_and_trace(campaign, tmp_path):
    arguments = ("replay", campaign, "--evaluation", "0", "--log", "a.log", "--trace", "a.csv")

    assert mrsfi_json(*arguments, cwd=tmp_path)["evaluation"] == 0
    assert (tmp_path / "a.log").read_text(encoding="utf-8").startswith("tick 0\n")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").startswith("tick,")


def test_a_forged_digest_ends_with_7(campaign, tmp_path):
    execute(campaign, "UPDATE evaluation SET digest = 'forged' WHERE idx = 2")

    error = mrsfi("replay", campaign, "--evaluation", "2", cwd=tmp_path, expected=7).stderr

    assert "evaluation 2" in error
    assert "digest" in error
    mrsfi("replay", campaign, "--all", cwd=tmp_path, expected=7)
    mrsfi("replay", campaign, "--evaluation", "1", cwd=tmp_path)
    missing = mrsfi("replay", campaign, "--evaluation", "99999", cwd=tmp_path, expected=9).stderr
    assert "99999" in missing


def test_report_takes_the_latest_campaign_writes_the_same_bytes_and_picks_by_ratio(
    flown, campaign, tmp_path
):
    found = mrsfi_json("report", "--ratio", "g3:g1=2:1", cwd=tmp_path)

    assert found["folder"] == "runs/copy"
    assert found["pick"]["ratio"] == "g3:g1=2:1"
    assert found["pick"]["evaluation"] in [p["evaluation"] for p in found["front"]["points"]]
    for name in ("critical/01.xmi", "tables/evaluations.csv"):
        assert (campaign / name).read_bytes() == (flown / name).read_bytes()


def test_replay_report_and_summary_name_the_same_faults(campaign, tmp_path):
    found = mrsfi_json("replay", campaign, "--best", "--log", "best.log", cwd=tmp_path)
    printed = mrsfi("replay", campaign, "--best", cwd=tmp_path).stdout
    best = mrsfi_json("report", campaign, cwd=tmp_path)["best"]

    for count in RESULTS:
        assert {goal["id"]: goal[count] for goal in found["goals"]} == best[count]
    log = (tmp_path / "best.log").read_text(encoding="utf-8")
    report = (campaign / "report.md").read_text(encoding="utf-8")
    _, section = report.split(f"### Specification 1, evaluation {best['evaluation']}\n")
    for fault, summed in zip(found["faults"], best["specification"], strict=True):
        told = {key: fault[key] for key in summed if key != "fault"}
        assert {"fault": fault["id"], **told} == summed
        name = f"event fault {fault['id']} {fault['type']} on "
        assert (name in log) is (fault["start"] < 1000)
        assert f"| {fault['id']} | {fault['type']} | {fault['start']} | " in section
        assert all(target in section and target in log for target in fault["touched"])
        assert all(parameter in printed for parameter in fault["values"])
    changed = [fault for fault in found["faults"] if fault["changed"]]
    assert log.count(": has its first effect\n") == len(changed) > 0


@pytest.mark.parametrize("words", [("report",), ("replay",), ("evolve", "--resume"), ("explain",)])
def test_a_folder_without_a_campaign_ends_with_9_and_stays_as_it_is(words, tmp_path):
    (tmp_path / "empty").mkdir()

    for name in ("empty", "nowhere"):
        assert name in mrsfi(*words, name, cwd=tmp_path, expected=9).stderr
    assert [entry.name for entry in tmp_path.rglob("*")] == ["empty"]


def test_a_broken_campaign_ends_with_9(campaign, tmp_path):
    (campaign / "generated" / "simulation.py").unlink()
    assert "simulation.py" in mrsfi("replay", campaign, cwd=tmp_path, expected=9).stderr

    (campaign / "campaign.sqlite").write_bytes(b"not a database at all" * 100)
    assert "campaign.sqlite" in mrsfi("report", campaign, cwd=tmp_path, expected=9).stderr


def test_a_finished_campaign_that_is_resumed_keeps_its_figures(campaign):
    figures = {path.name for path in (campaign / "figures").glob("figure_*")}

    mrsfi("evolve", "--resume", campaign, cwd=campaign.parents[1])

    assert {path.name for path in (campaign / "figures").glob("figure_*")} == figures != set()


def test_a_report_for_a_paper_has_its_sentences_tables_and_figures(campaign, tmp_path):
    mrsfi("report", campaign, "--format", "latex", cwd=tmp_path)

    text = (campaign / "report.tex").read_text(encoding="utf-8")
    assert text.count("\\begin{table*}") == text.count("\\toprule") == 2
    figures = re.findall(r"\\includegraphics\[width=\\columnwidth\]\{(.*?)\}", text)
    assert len(figures) >= 4
    assert all((campaign / figure).read_bytes().startswith(b"%PDF-") for figure in figures)

    mrsfi("report", campaign, cwd=tmp_path)
    assert not [*campaign.rglob("*.pdf"), *campaign.rglob("*.tex")]


def test_a_flight_is_written_as_a_picture_that_moves(campaign, tmp_path):
    mrsfi("replay", campaign, "--evaluation", "0", "--gif", "a.gif", cwd=tmp_path)

    with Image.open(tmp_path / "a.gif") as picture:
        assert picture.n_frames == 100
        first = picture.convert("RGB").tobytes()
        picture.seek(50)
        assert picture.convert("RGB").tobytes() != first
