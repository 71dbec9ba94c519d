"""Pages that commands write: of one flight, and of a campaign."""

import json
import shutil
from dataclasses import replace
from datetime import date

from mrsfi_runtime.analysis import report
from mrsfi_runtime.record.database import canonical
from mrsfi_runtime.record.store import CampaignStore
from tests.support.cli import MISSION, mrsfi, mrsfi_json, stop_specification
from tests.support.report_page import data_of, unpacked


def test_a_flight_is_written_as_a_page_that_says_how_to_fly_it_again(place):
    stop = f"models/{MISSION}/stop.xmi"
    stop_specification(place / stop, [(100, 200)])
    words = ("simulate", MISSION, "--faults", stop, "--seed", "7")

    printed = mrsfi_json(*words, "--html", "page.html", "--json", cwd=place)

    data = data_of(place / "page.html")
    flown = unpacked(*data["shown"])
    assert ["digest", printed["digest"]] in data["record"]
    assert flown["command"] == f"mrsfi simulate {MISSION} --faults {stop} --seed 7"
    assert flown["xmi"] == (place / stop).read_text()
    assert [fault["window"] for fault in flown["flight"]["faults"]] == [[100, 200]]
    assert "written    page.html" in mrsfi(*words, "--html", "page.html", cwd=place).stderr


def test_an_evaluation_of_a_campaign_is_written_as_a_page(flown, tmp_path):
    printed = mrsfi_json("replay", flown, "--html", tmp_path / "page.html", "--json", cwd=tmp_path)

    data = data_of(tmp_path / "page.html")
    assert ["digest", printed["digest"]] in data["record"]
    names = [row[0] for row in unpacked(*data["shown"])["faults"]["rows"]]
    assert len(names) == len(printed["faults"])


def test_a_campaign_has_a_page_with_the_flight_of_each_weakness(found):
    run = found / "runs" / "it"
    data = data_of(run / "report.html")
    summary = json.loads((run / "summary.json").read_text())

    assert ["digest", summary["digest"]] in data["record"]
    assert len(data["evaluations"]["rows"]) == summary["n_evaluations"]
    first, ways = data["first"], {each["number"]: each for each in data["first"]["ways"]}
    assert len(first["matrix"]["faults"]) == len(
        {fault for each in summary["weaknesses"]["found"] for fault in each["faults"]}
    )
    assert {*ways} == {each["number"] for each in summary["weaknesses"]["found"]}
    assert [each["state"] for each in first["goals"]] == ["fails"] * 3
    assert all(ways[goal["number"]]["goal"] == goal["id"] for goal in first["goals"])
    assert {cell for row in first["matrix"]["rows"] for cell in row["cells"]} - {None} == {*ways}
    witnesses = {each["number"]: each["witness"] for each in summary["weaknesses"]["found"]}
    assert {*map(int, data["shown"])} == {*witnesses}
    for number, text in data["shown"].items():
        shown = unpacked(text)
        faults = [(row[0], *row[2:4], row[-1][:5]) for row in shown["faults"]["rows"]]
        kept = witnesses[int(number)]
        assert faults == [(t["fault"], t["start"], t["finish"], t["fault"][:5]) for t in kept]
        flights = shown["flight"]["flights"]
        assert [each["without"] for each in flights] == [None, *range(len(kept))]
        is_there = ["packed" in each for each in flights]
        assert is_there == [True, *[len(kept) > 1] * len(kept)]
    assert unpacked(data["fault_free"])["packed"].keys() == flights[0]["packed"].keys()


def test_a_page_without_room_has_the_flight_of_the_main_weakness_of_each_goal(
    found, tmp_path, monkeypatch
):
    run = shutil.copytree(found, tmp_path, dirs_exist_ok=True) / "runs" / "it"
    monkeypatch.setattr(report, "MOST_BYTES", 0)

    mrsfi("report", run, cwd=tmp_path)

    data = data_of(run / "report.html")
    assert {*map(int, data["shown"])} == {goal["number"] for goal in data["first"]["goals"]}
    assert len(data["shown"]) < len(data["first"]["ways"])


def test_a_page_has_the_faults_of_each_evaluation(flown):
    mrsfi("report", flown, cwd=flown.parent)

    found = data_of(flown / "report.html")["evaluations"]

    faults = unpacked(found["faults"])
    with CampaignStore.open(flown) as store:
        for each, row, places in zip(store.evaluations(), found["rows"], faults["of"], strict=True):
            named = [
                (name, *window)
                for name, _, *window, _, _ in map(faults["rows"].__getitem__, places)
            ]
            assert row[0] == each.index
            assert named == [(t.fault, t.start, t.finish) for t in each.specification]
    assert found["command"].startswith("mrsfi replay ")


def test_a_broken_goal_says_what_breaks_it_undetected_since_when_and_who_decided(found, tmp_path):
    place = shutil.copytree(found, tmp_path, dirs_exist_ok=True)
    run = place / "runs" / "it"
    shutil.copytree(run, place / "runs" / "later")

    def first_screen(**created):
        for name, time in created.items():
            with CampaignStore.open(place / "runs" / name) as store:
                manifest = replace(store.manifest, created=time)
                store.keep("manifest", canonical(manifest.as_json()))
        mrsfi("report", "runs/later", cwd=place)
        return data_of(place / "runs" / "later" / "report.html")["first"]

    undated = first_screen(it="", later="2026-04-01T09:00:00+00:00")
    before = first_screen(it="2026-03-01T09:00:00+00:00")
    number = before["goals"][0]["number"]
    words = ("accept", "--because", "<b>it floats</b>", "--by", "A. Rivera")
    mrsfi("decide", "runs/later", str(number), *words, cwd=place)

    after = first_screen()

    assert undated["goals"][0]["known"][0] == "Known since 2026-04-01 or earlier, no decision."
    assert all(
        "nown since 2026-03-01, no decision." in each["known"][0] for each in before["goals"]
    )
    (way,) = (each for each in after["ways"] if each["number"] == number)
    accepted = f"accepted by A. Rivera on {date.today()}: <b>it floats</b>"
    assert way["status"] == f"known since 2026-03-01, {accepted}"
    assert any(f"{accepted}." in line for line in after["goals"][0]["known"])


def test_what_flies_many_times_writes_no_file_of_a_flight(flown, tmp_path):
    wanted = ("--html", "page.html", "--mcap", "b.mcap")

    done = mrsfi("replay", flown, "--all", *wanted, cwd=tmp_path, expected=2)

    assert "--html, --gif write one flight" in done.stderr
    assert not [*tmp_path.iterdir()]
