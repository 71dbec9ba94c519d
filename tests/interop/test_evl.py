"""Epsilon finds with the .evl files what we find: constraint by constraint, word by word."""

import keyword
import re
from collections import Counter
from collections.abc import Mapping
from itertools import chain
from pathlib import Path
from random import Random

import pytest

from m2t.metaclasses import RESERVED
from m2t.models.fixes import FIXES
from m2t.models.load import inspect_folder
from m2t.models.write import dumps
from tests.interop.evl import (
    EVL,
    TWINS,
    Judged,
    epsilon,
    folder_files,
    judged,
    offered_fixes,
    require_same_findings,
    require_same_fixes,
    stated_fixes,
)
from tests.support.broken_models import BROKEN, Broken
from tests.support.constraints import LISTED, REASONS
from tests.support.models.copies import FAULTS, MISSION, MODELS, copy_models, edit
from tests.support.models.random_models import draw
from tests.support.models.split import PARTS, Parts, split_folder, write_split

TIGHT = MODELS.parent / "tight_margins"
RATED = MODELS.parent / "undersea"  # requirement R2 and goal r2
N_MIXED = 160
N_DRAWN = 20
_BROKEN_TWINS = [entry for entry in BROKEN if entry.constraint in TWINS]


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, list[Judged]]:
    """Models made here, by part, judged by both at once: Java needs time to warm up."""
    made = {
        "valid models": _valid(tmp_path_factory.mktemp("valid")),
        "broken models": _broken(tmp_path_factory.mktemp("broken")),
        "broken models in several files": _split(tmp_path_factory.mktemp("split")),
        "mixed models": _mixed(tmp_path_factory.mktemp("mixed")),
    }
    by_path = {model.path: model for model in judged([*chain(*made.values())])}
    return {
        name: [by_path[path] for path in part if path in by_path] for name, part in made.items()
    }


def test_both_find_the_same_in_valid_models(models, note):
    valid = models["valid models"]

    require_same_findings("valid models", valid, note)

    assert len(valid) == N_DRAWN + 3
    assert [sum(model.ours.values()) for model in valid[:3]] == [0, 0, 0]


def test_both_find_the_same_in_every_broken_model(models, note):
    found = require_same_findings("broken models", models["broken models"], note)

    assert found == TWINS


def test_both_find_the_same_in_missions_in_several_files(models, note):
    part = "broken models in several files"

    found = require_same_findings(part, models[part], note)

    assert found == TWINS


def test_both_find_the_same_in_models_of_several_defects(models, note):
    found = require_same_findings("mixed models", models["mixed models"], note)

    assert len(found) >= len(TWINS) * 0.65


def test_both_write_the_same_when_they_fix_models(models, note):
    judged_models = [*chain(*models.values())]

    fixed = require_same_fixes(judged_models, note)

    assert offered_fixes(judged_models) == stated_fixes()
    assert fixed == {name for name, _ in stated_fixes()}


def test_what_has_no_twin_is_refused_or_dropped_by_eclipse(tmp_path):
    (refused,) = (names for reason, names in REASONS.items() if "refuses" in reason)
    (dropped,) = (names for reason, names in REASONS.items() if "drops" in reason)
    broken = [entry for entry in BROKEN if entry.constraint in (*refused, *dropped)]
    folders = [copy_models(tmp_path / str(number)) for number in range(len(broken))]
    for folder, entry in zip(folders, broken, strict=True):
        edit(folder / entry.file, entry.old, entry.new)

    answers = epsilon([folder_files(folder) for folder in folders])

    models = zip(broken, folders, answers, strict=True)
    loaded = {e.constraint for e, folder, answer in models if Judged(folder, (), answer).is_loaded}
    assert loaded == set(dropped)
    assert {entry.constraint for entry in broken} == {*refused, *dropped}


def test_every_twin_is_stated_in_the_file_that_its_entry_names():
    stated: dict[str, set[tuple[str, str]]] = {}
    for name in ("mission.evl", "faults.evl"):
        text = (EVL / name).read_text(encoding="utf-8")
        for kind, constraint in re.findall(r"^  (constraint|critique) (\w+)", text, re.MULTILINE):
            stated.setdefault(constraint, set()).add((name, kind))

    kinds = {"error": "constraint", "warning": "critique"}
    assert stated == {
        name: {(each.evl, kinds[each.severity])}
        for name, each in LISTED.items()
        if each.evl != "none"
    }


def test_both_reserve_the_same_names():
    text = (EVL / "constraints" / "limits.evl").read_text(encoding="utf-8")
    (block,) = re.findall(r"var RESERVED = Set \{(.*?)\}", text, re.DOTALL)

    assert set(re.findall(r'"(\w+)"', block)) == {
        *RESERVED,
        *(word for word in keyword.kwlist if word.islower()),
    }


def _valid(folder: Path) -> list[Path]:
    drawn = [_drawn(folder / str(seed), seed) for seed in range(N_DRAWN)]
    return [MODELS, TIGHT, RATED, *drawn]


def _broken(folder: Path) -> list[Path]:
    """Return every broken model whose constraint has a twin."""
    folders = [copy_models(folder / str(number)) for number in range(len(_BROKEN_TWINS))]
    for copy, entry in zip(folders, _BROKEN_TWINS, strict=True):
        edit(copy / entry.file, entry.old, entry.new)
    return folders


def _split(folder: Path) -> list[Path]:
    """Return the broken models in several files: what can be fixed in every way to split it.

    The models of a constraint begin with different ways.
    """
    folders: list[Path] = []
    before: Counter[str] = Counter()
    for number, entry in enumerate(_BROKEN_TWINS):
        first = before[entry.constraint] % len(PARTS)
        before[entry.constraint] += 1
        ways = [*list(PARTS)[first:], *list(PARTS)[:first]]
        split = (_broken_parts(folder / f"{number}-{way}", entry, PARTS[way]) for way in ways)
        found = (path for path in split if path is not None)
        folders += list(found) if entry.constraint in FIXES else [next(found)]
    return folders


def _broken_parts(folder: Path, entry: Broken, parts: Parts) -> Path | None:
    """Return a mission split once it is broken; if that leaves no model, broken once split.

    ``None`` if the split leaves nothing to break in this way.
    """
    whole = copy_models(folder / "whole")
    edit(whole / entry.file, entry.old, entry.new)
    models = inspect_folder(whole).draft
    if models is not None:
        write_split(whole, models, parts(models))
        return whole
    copy = split_folder(folder / "split", parts)
    for path in sorted(copy.rglob("*.xmi")):
        if entry.old in path.read_text(encoding="utf-8"):
            edit(path, entry.old, entry.new)
            return copy
    return None


def _mixed(folder: Path) -> list[Path]:
    """Return models with several defects: of the table, and exchanged values in drawn ones."""
    rng, folders = Random(3), []
    for number in range(N_MIXED // 2):
        broken = copy_models(folder / f"broken-{number}")
        for entry in rng.sample(_BROKEN_TWINS, 3):
            if entry.old in (broken / entry.file).read_text(encoding="utf-8"):
                edit(broken / entry.file, entry.old, entry.new)
        drawn = _drawn(folder / f"drawn-{number}", N_DRAWN + number)
        for path in folder_files(drawn):
            path.write_text(_exchanged(path.read_text(encoding="utf-8"), rng), encoding="utf-8")
        folders += [broken, drawn]
    return folders


def _exchanged(text: str, rng: Random) -> str:
    """Give a few attributes the value that another element has there, or one below 0."""
    for _ in range(3):
        found = rng.choice([*re.finditer(r' (?!ID|xmlns)(\w+)="([^"]*)"', text)])
        others = [*re.findall(rf' {found[1]}="([^"]*)"', text), "-1"]
        text = f"{text[: found.start(2)]}{rng.choice(others)}{text[found.end(2) :]}"
    return text


def _drawn(folder: Path, seed: int) -> Path:
    folder.mkdir()
    drawn = draw(seed)
    (folder / MISSION).write_bytes(dumps(drawn.mission, "UTF-8"))
    (folder / FAULTS).write_bytes(dumps(drawn.faults, "UTF-8", hrefs={drawn.mission: MISSION}))
    return folder
