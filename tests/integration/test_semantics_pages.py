"""What docs/semantics.md and docs/faults.md print in tables is what the code does."""

from m2t.metamodels import load_metamodels
from mrsfi_runtime.kernel.effects import PURPOSES
from mrsfi_runtime.kernel.flight import sample_chances
from mrsfi_runtime.kernel.randomness import (
    PURPOSE_HEADING,
    PURPOSE_NOISE,
    PURPOSE_ROAM,
    PURPOSE_SAMPLES,
    choice,
    draw,
    mixed,
    seed_key,
    uniform,
)
from mrsfi_runtime.model.fault_types import FaultType, Field
from tests.support.tree import ROOT

SEMANTICS = ROOT / "docs" / "semantics.md"
FAULTS = ROOT / "docs" / "faults.md"


def _table(page, heading):
    """Return the rows of the only table of a page with this heading, as texts."""
    _, _, after = page.read_text(encoding="utf-8").partition(f"\n| {heading} |\n")
    lines = after.splitlines()[1:]
    end = next(number for number, line in enumerate(lines) if not line.startswith("|"))
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[:end]]


def _parameters(kind: FaultType) -> str:
    """Return the parameters of a fault type as the page prints them."""
    printed = ""
    for parameter in kind.parameters:
        is_whole = parameter.is_integer and parameter.range.name != "TICKS"
        remarks = ["fixed"] * (not parameter.evolves) + ["whole"] * is_whole
        joined = f"({', '.join([parameter.range.name, *remarks])})"
        printed = printed.replace(joined, "").rstrip() + f", {parameter.name} {joined}"
    return printed.removeprefix(", ") or "–"


def test_the_hash_mixes_as_printed():
    rows = _table(SEMANTICS, "v | mixed(v)")

    assert len(rows) >= 5
    assert [(value, str(mixed(int(value)))) for value, _ in rows] == [*map(tuple, rows)]


def test_keys_draw_what_is_printed():
    heading = "seed | key | tick | entity | purpose | draw | uniform | choice of 360 | choice of 7"
    rows = _table(SEMANTICS, heading)
    drawn = []
    for row in rows:
        seed, _, *rest = map(int, row[:5])
        key = seed_key(seed), *rest
        drawn.append(
            [seed, *key, draw(*key), uniform(*key), choice(360, *key), choice(7, *key)],
        )

    assert {"0", "4294967303"} <= {seed for seed, *_ in rows}
    assert [[*map(repr, row)] for row in drawn] == rows


def test_chances_of_samples_are_those_printed():
    rows = _table(SEMANTICS, "n | bounds")

    assert len(rows) >= 4
    for n, bounds in rows:
        assert ", ".join(map(str, sample_chances(int(n)))) == bounds


def test_all_draws_are_listed_under_their_purpose():
    listed = {
        row[0]: int(row[3])
        for row in _table(SEMANTICS, "What is drawn | Tick | Entity | Purpose | As")
    }
    words = {
        Field.POSITION: "position: distance",
        Field.SPEED: "random speed",
        Field.ENERGY: "random energy",
        Field.COUNT: "random count",
        Field.RATE: "random rate",
        Field.COST: "random cost",
        Field.OBSTACLE: "obstacle: distance",
    }
    expected = {word: PURPOSES[field] for field, word in words.items()} | {
        "position: direction": PURPOSES[Field.POSITION] + 1,
        "obstacle: direction": PURPOSES[Field.OBSTACLE] + 1,
        "first heading": PURPOSE_HEADING,
        "valid samples": PURPOSE_SAMPLES,
        "roaming": PURPOSE_ROAM,
        "noise of a report: distance": PURPOSE_NOISE,
        "noise of a report: direction": PURPOSE_NOISE + 1,
    }

    found = {word: number for word in expected for text, number in listed.items() if word in text}

    assert found == expected
    assert sorted(listed.values()) == sorted(expected.values())


def test_all_fault_types_are_listed_as_the_metamodel_says():
    heading = "Type | strikes | mode | property | parameters | while active"

    expected = [
        [
            kind.name,
            kind.struck.value,
            kind.mode.name,
            kind.properties[0].name if kind.properties else "–",
            _parameters(kind),
        ]
        for kind in load_metamodels().fault_types.values()
    ]

    assert [row[:5] for row in _table(FAULTS, heading)] == expected
