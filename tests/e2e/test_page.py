"""Pages that commands write: of one flight, and of a campaign."""

import json
import re

from tests.support.cli import MISSION, mrsfi, mrsfi_json, stop_specification


def data_of(path):
    """Return what a page shows, as its script reads it."""
    found = re.search('<script type="application/json" id="data">(.*?)</script>', path.read_text())
    return json.loads(found[1])


def test_a_flight_is_written_as_a_page_that_says_how_to_fly_it_again(place):
    stop = f"models/{MISSION}/stop.xmi"
    stop_specification(place / stop, [(100, 200)])
    words = ("simulate", MISSION, "--faults", stop, "--seed", "7")

    printed = mrsfi_json(*words, "--html", "page.html", "--json", cwd=place)

    data = data_of(place / "page.html")
    (flown,) = data["shown"]
    assert ["digest", printed["digest"]] in data["record"]
    assert flown["command"] == f"mrsfi simulate {MISSION} --faults {stop} --seed 7"
    assert flown["xmi"] == (place / stop).read_text()
    assert [fault["window"] for fault in flown["flight"]["faults"]] == [[100, 200]]
    assert "written    page.html" in mrsfi(*words, "--html", "page.html", cwd=place).stderr


def test_an_evaluation_of_a_campaign_is_written_as_a_page(flown, tmp_path):
    printed = mrsfi_json("replay", flown, "--html", tmp_path / "page.html", "--json", cwd=tmp_path)

    data = data_of(tmp_path / "page.html")
    assert ["digest", printed["digest"]] in data["record"]
    names = [row[0] for row in data["shown"][0]["faults"]["rows"]]
    assert len(names) == len(printed["faults"])


def test_a_campaign_has_a_page_with_flights_that_break_its_goals(found):
    run = found / "runs" / "it"
    data = data_of(run / "report.html")
    summary = json.loads((run / "summary.json").read_text())

    assert ["digest", summary["digest"]] in data["record"]
    assert len(data["evaluations"]["rows"]) == summary["n_evaluations"]
    told = [each["sentences"] for each in summary["weaknesses"]["found"] if each["sentences"]]
    first, ways = data["first"], {each["number"]: each for each in data["first"]["ways"]}
    assert len(first["matrix"]["faults"]) == len(
        {fault for each in summary["weaknesses"]["found"] for fault in each["faults"]}
    )
    assert {*ways} == {each["number"] for each in summary["weaknesses"]["found"]}
    assert [each["state"] for each in first["goals"]] == ["fails"] * 3
    assert all(ways[goal["number"]]["goal"] == goal["id"] for goal in first["goals"])
    assert {cell for row in first["matrix"]["rows"] for cell in row["cells"]} - {None} == {*ways}
    assert [each["title"] for each in data["shown"]] == ["g1", "g2", "g3"]
    for shown in data["shown"]:
        assert [row[-1] for row in shown["faults"]["rows"]] in told
        n = len(shown["faults"]["rows"])
        assert [each["without"] for each in shown["flight"]["flights"]] == [None, *range(n)]


def test_what_flies_many_times_writes_no_file_of_a_flight(flown, tmp_path):
    wanted = ("--html", "page.html", "--mcap", "b.mcap")

    done = mrsfi("replay", flown, "--all", *wanted, cwd=tmp_path, expected=2)

    assert "--html, --gif write one flight" in done.stderr
    assert not [*tmp_path.iterdir()]
