"""Whether a weakness is detected: every output prints one value, that of all flown variants."""

import csv
import json
import math
import re
import sqlite3
from collections import defaultdict
from contextlib import closing, contextmanager
from itertools import pairwise
from random import Random

import pytest

from m2t.generate import generate
from mrsfi.engines import AS_RECORDED
from mrsfi.explaining import flying_again
from mrsfi_runtime.model.faults import TimedFault
from mrsfi_runtime.record.engine_settings import Workers
from tests.independent.crowd import draw_crowd
from tests.support.cli import mrsfi, mrsfi_json, workspace
from tests.support.models import builder
from tests.support.nodes import PYTHON, SERVICE, yard
from tests.support.rendezvous import NAME as RENDEZVOUS
from tests.support.rendezvous import write_rendezvous
from tests.support.report_page import data_of
from tests.tiers import seeds

CASE = '[search]\nalgorithm = "random"\nfaults = 2\npopulation = 20\n'
SEARCH = ("--case", "case.toml", "--workers", "1")


def planted(place):
    write_rendezvous(place)
    return RENDEZVOUS, ("--evaluations", "60", "--engine", "reference")


def of_the_tree(name):
    def write(place):
        workspace(place, name)
        return name, ("--evaluations", "200")

    return write


def drawn(seed, n_robots):
    def write(place):
        models = builder.write(
            place / "models" / "crowd", *draw_crowd(Random(seed), n_robots, 12.0)
        )
        generate(models, place / "generated" / "crowd")
        return "crowd", ("--evaluations", "100")

    return write


def node(place):
    yard(place)
    return "yard", ("--evaluations", "30", *PYTHON, *SERVICE)


CAMPAIGNS = {
    "rendezvous": planted,
    "uuv_sampling": of_the_tree("uuv_sampling"),
    "tight_margins": of_the_tree("tight_margins"),
    "undersea": of_the_tree("undersea"),
    "crowd of 9": drawn(1, 9),
    "crowd of 16": drawn(2, 16),
    "node": node,
}
"""What writes a mission into a folder, and returns its name and how it is searched on."""


@pytest.mark.parametrize("name", seeds(CAMPAIGNS, 1, 2))
def test_all_outputs_print_what_a_recount_of_all_flights_finds(tmp_path, monkeypatch, name):
    monkeypatch.setenv("COLUMNS", "1000")
    monkeypatch.chdir(tmp_path)  # where a node is started
    mission, options = CAMPAIGNS[name](tmp_path)
    (tmp_path / "case.toml").write_text(CASE, encoding="ascii")
    mrsfi("evolve", mission, *SEARCH, *options, "--out", "run", cwd=tmp_path)
    run = tmp_path / "run"
    rows = mrsfi_json("weaknesses", run, cwd=tmp_path)
    printed = mrsfi("weaknesses", run, "--fmea", run / "fmea.csv", cwd=tmp_path).stdout
    shown = mrsfi("show", run, cwd=tmp_path).stdout
    mrsfi("report", run, "--format", "latex", cwd=tmp_path)
    texts = [(run / name).read_text(encoding="utf-8") for name in ("report.md", "report.tex")]

    cells = {row["number"]: (row["goal"], tuple(row["faults"])) for row in rows}
    gravest = {row["number"]: row["measure"] for row in rows}
    truly = {cells[number] for number, measure in gravest.items() if measure != "believed"}
    with flown_again(run) as (model, fly):
        late = recounted(run, model, fly, truly)
        named = [counts(run, model, fly, row) for row in failure_modes(run)]
        unit = model.units.time
    expected = {number: counted(late.get(cell)) for number, cell in cells.items()}
    words = {number: in_words(late.get(cell), unit) for number, cell in cells.items()}
    unseen = {number for number in cells if words[number].startswith("The CI does not")}

    assert {*late} == truly != set()
    assert {row["number"]: row["detection"] for row in rows} == expected
    assert {row["number"]: row["detection"] for row in summarised(run)} == expected
    assert {int(row["weakness"]): row["detection"] for row in failure_modes(run)} == words
    assert [row["ticks by measure"] for row in failure_modes(run)] == named
    assert on_page(run) == {number: (words[number], number in unseen) for number in cells}
    assert stars(printed) == {cells[number] for number in unseen if len(cells[number][1]) == 1}
    told = sentences(printed)
    assert {cells[number][0] for number in told} == {goal for goal, _ in cells.values()}
    for number, sentence in told.items():
        if "without any fault" in sentence:
            continue
        if cells[number] not in truly:
            assert "(a false alarm)" in sentence
            continue
        assert sentence.endswith(f". {words[number]}.")
        assert all(words[number] in text for text in texts)
        assert re.search(rf"^{number}  .*\n    [^.]*\. {words[number]}\. ", shown, re.M)


def test_what_a_command_flies_to_find_mildest_variants_counts_for_it(tmp_path):
    mission, options = planted(tmp_path)
    (tmp_path / "case.toml").write_text(CASE, encoding="ascii")
    mrsfi("evolve", mission, *SEARCH, *options, "--out", "run", cwd=tmp_path)
    run = tmp_path / "run"

    before = {
        row["number"]: row["detection"] for row in mrsfi_json("weaknesses", run, cwd=tmp_path)
    }
    rows = mrsfi_json("weaknesses", run, "--mildest", cwd=tmp_path)

    judged = [(before[row["number"]], row["detection"]) for row in rows if row["detection"]]
    assert all(now["n_variants"] >= then["n_variants"] for then, now in judged)
    assert any(now["n_variants"] > then["n_variants"] for then, now in judged)
    with flown_again(run) as (model, fly):
        without = fly(())
        for row in rows:
            flight = fly(tuple(timed(fault.values()) for fault in row["witness"]))
            late = ticks_late(flight, without, model.goal_ids.index(row["goal"]))
            if late is not None:
                found = row["detection"]
                assert late <= (math.inf if found["n_never"] else found["latest"])


@contextmanager
def flown_again(run):
    """Yield the model of a campaign, and what records flights of it."""
    with flying_again(run, AS_RECORDED, Workers(1), print) as (campaign, _, engine):
        yield campaign.mission, engine.record


def recounted(run, model, fly, truly):
    """Return how many ticks late each variant is detected, from flights that are flown again.

    These are all specifications in the record that have just the faults of a weakness. Judged is
    tick by tick; what is never detected is infinitely late.
    """
    with closing(sqlite3.connect(run / "campaign.sqlite")) as record:
        ((settings,),) = record.execute("SELECT value FROM meta WHERE key = 'settings'")
        searched = record.execute("SELECT specification FROM evaluation")
        flown = [(json.loads(settings)["mission_seed"], text) for (text,) in searched]
        flown += record.execute("SELECT mission_seed, specification FROM flight").fetchall()
    late = defaultdict(dict)
    without = {seed: fly((), seed) for seed in {seed for seed, _ in flown}}
    for seed, text in dict.fromkeys(flown):
        variant = tuple(sorted(map(timed, json.loads(text))))
        faults = tuple(sorted({each.fault for each in variant}))
        goals = [goal for goal, others in truly if others == faults]
        flight = fly(variant, seed) if goals else None
        for goal in goals:
            ticks = ticks_late(flight, without[seed], model.goal_ids.index(goal))
            if ticks is not None:
                late[goal, faults][variant] = max(ticks, late[goal, faults].get(variant, 0))
    return {cell: [*variants.values()] for cell, variants in late.items()}


def counts(run, model, fly, mode):
    """Return for how many ticks a goal is broken under the variant that a failure mode names."""
    (row, *_) = (row for row in reversed(summarised(run)) if str(row["number"]) == mode["weakness"])
    row = row["mildest"] if mode["mildest variant"] else row
    flight = fly(tuple(timed(fault.values()) for fault in row["witness"]))
    goal = model.goal_ids.index(row["goal"])
    counted = (flight[name][-1, goal] for name in ("believed", "true", "missed"))
    return "believed {}, true {}, failed {}".format(*counted)


def timed(row):
    fault, start, finish, values, *trigger = row
    return TimedFault(fault, start, finish, tuple(values), *trigger)


def ticks_late(flight, without, goal):
    """Return how late a flight shows that a goal is truly broken; nothing if it is not."""
    n_ticks, is_broken = len(flight["is_true"]), False
    for kind in ("true", "missed"):
        before, count = (each[kind][-1, goal] for each in (without, flight))
        is_broken |= count > before + (0.05 * n_ticks if before else 0)
    if not is_broken:
        return None
    judged = zip(*(flight[kind][:, goal] for kind in ("is_true", "missed")), strict=True)
    begin = next(tick for tick, (true, missed) in enumerate(judged) if true or missed)
    seen = [tick for tick in range(begin, n_ticks) if flight["is_believed"][tick, goal]]
    return seen[0] - begin if seen else math.inf


def counted(late):
    if late is None:
        return None
    worst = "never" if max(late) == math.inf else "late" if max(late) else "in time"
    later = [ticks for ticks in late if 0 < ticks < math.inf]
    return {
        "worst": worst,
        "n_variants": len(late),
        "n_never": late.count(math.inf),
        "n_late": len(later),
        "latest": max(later, default=0),
    }


def in_words(late, unit):
    if late is None:
        return "It is a false alarm of the CI"
    found = counted(late)
    variants = f"{len(late)} breaking variant{'s' * (len(late) > 1)}"
    if found["worst"] == "never":
        return f"The CI does not detect it in {found['n_never']} of {variants}"
    if found["worst"] == "late":
        most = f"{found['latest']} {unit or ('ticks' if found['latest'] > 1 else 'tick')}"
        return f"The CI detects it late in {found['n_late']} of {variants}, by up to {most}"
    return f"The CI detects it in time in {len(late)} of {variants}"


def summarised(run):
    summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    return summary["weaknesses"]["found"]


def failure_modes(run):
    with (run / "fmea.csv").open(encoding="utf-8", newline="") as file:
        return [*csv.DictReader(file)]


def on_page(run):
    """Return what the page says of each weakness, and whether its cell is undetected."""
    data = data_of(run / "report.html")
    ways = {each["number"]: each for each in data["first"]["ways"]}
    for goal in data["first"]["goals"]:
        if goal["detection"]:
            assert ways[goal["number"]]["said"].endswith(f". {goal['detection']}")

    def detection(said):
        is_alarm = "(a false alarm)" in said
        return "It is a false alarm of the CI" if is_alarm else said.rpartition(". ")[2]

    return {
        number: (detection(each["said"]), each["class"] == "never") for number, each in ways.items()
    }


def stars(printed):
    """Return the goals and faults whose cell of the matrix has a star."""
    _, _, table = printed.partition("Share of variants in which")
    head, _, *rows = (line.split() for line in table.partition("\n\n")[0].splitlines()[2:])
    goals = head[2 : head.index("target")]
    return {
        (goal, (row[0],))
        for row in rows
        for goal, cell in zip(goals, row[2:], strict=False)
        if cell.endswith("*")
    }


def sentences(printed):
    """Return the first sentences of goals that break, by the number of the weakness."""
    lines = printed.partition("Share of variants in which")[0].splitlines()
    found = [(re.match(r"    weakness (\d+) ", below), line) for line, below in pairwise(lines)]
    return {int(match[1]): line for match, line in found if match}
