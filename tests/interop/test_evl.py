"""Epsilon finds with the .evl files what we find: constraint by constraint, word by word."""

import keyword
import random
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from m2t.diagnostics import CONSTRAINTS, Diagnostic
from m2t.fixes import FIXES
from m2t.naming import RESERVED
from m2t.validate import validate_folder
from m2t.xmi import dumps
from support_broken import BROKEN
from support_interop import ROOT, Note, harness
from support_model import FAULTS, MISSION, MODELS, copy_models, edit
from support_mutations import mutated
from support_random_models import draw

EVL = ROOT / "metamodels" / "faults.evl"
N_MUTANTS = 100
N_DRAWN = 20

Finding = tuple[str, str, str]
"""Constraint, severity, and message without line numbers, which a loaded model has none of."""


@dataclass(frozen=True, slots=True)
class Judged:
    """A mission folder that both load, and what Epsilon answers about it."""

    folder: Path
    answer: Mapping[str, Any]


@pytest.fixture(scope="module")
def broken_models(tmp_path_factory: pytest.TempPathFactory) -> list[Judged]:
    """Every broken model whose constraint has a twin."""
    folders = []
    for number, broken in enumerate(BROKEN):
        if CONSTRAINTS[broken.constraint].evl:
            folder = copy_models(tmp_path_factory.mktemp(f"broken{number}"))
            edit(folder / broken.file, broken.old, broken.new)
            folders.append(folder)
    return _judged(folders)


def test_both_find_the_same_in_every_broken_model(broken_models: list[Judged], note: Note) -> None:
    compared = _require_same_findings("broken models", broken_models, note)

    assert compared == {name for name, constraint in CONSTRAINTS.items() if constraint.evl}


def test_both_find_the_same_in_randomly_mutated_models(tmp_path: Path, note: Note) -> None:
    rng = random.Random(3)
    folders = []
    for number in range(N_MUTANTS):
        folder = copy_models(tmp_path / str(number))
        mutated(folder, rng)
        folders.append(folder)

    compared = _require_same_findings("mutated models", _judged(folders), note)

    assert len(compared) >= 15


def test_both_find_the_same_in_valid_models(tmp_path: Path, note: Note) -> None:
    folders = [MODELS, MODELS.parent / "tight_margins", *_drawn_folders(tmp_path)]

    judged = _judged(folders)

    assert len(judged) == len(folders)
    _require_same_findings("valid models", judged, note)
    assert _ours(MODELS) == {}


def test_what_has_no_twin_is_refused_or_dropped_by_eclipse(tmp_path: Path) -> None:
    refused = [name for name, found in CONSTRAINTS.items() if "refuses" in found.reason]
    dropped = [name for name, found in CONSTRAINTS.items() if "drops" in found.reason]
    folders, names = [], []
    for number, broken in enumerate(BROKEN):
        if broken.constraint in (*refused, *dropped):
            folder = copy_models(tmp_path / str(number))
            edit(folder / broken.file, broken.old, broken.new)
            folders.append(folder)
            names.append(broken.constraint)

    answers = _evl(folders)

    loaded = {name for name, answer in zip(names, answers, strict=True) if _is_loaded(answer)}
    assert loaded == set(dropped)
    assert set(names) == {*refused, *dropped}


def test_every_twin_is_stated_in_the_file_that_its_entry_names() -> None:
    stated: dict[str, set[tuple[str, str]]] = {}
    for name in ("mission.evl", "faults.evl"):
        text = (EVL.parent / name).read_text(encoding="utf-8")
        for kind, constraint in re.findall(r"^  (constraint|critique) (\w+)", text, re.MULTILINE):
            stated.setdefault(constraint, set()).add((name, kind))

    kinds = {"error": "constraint", "warning": "critique"}
    assert stated == {
        name: {(constraint.evl, kinds[constraint.severity])}
        for name, constraint in CONSTRAINTS.items()
        if constraint.evl
    }


def test_epsilon_offers_the_same_fixes(broken_models: list[Judged]) -> None:
    offered = {
        (found["constraint"], title)
        for model in broken_models
        for found in model.answer["unsatisfied"]
        for title in found["fixes"]
    }

    assert offered == {(name, fix.title) for name, fix in FIXES.items() if CONSTRAINTS[name].evl}


def test_both_reserve_the_same_names() -> None:
    text = (EVL.parent / "mission.evl").read_text(encoding="utf-8")
    (block,) = re.findall(r"var RESERVED = Set \{(.*?)\}", text, re.DOTALL)

    assert set(re.findall(r'"(\w+)"', block)) == {
        *RESERVED,
        *(word for word in keyword.kwlist if word.islower()),
    }


def _drawn_folders(tmp_path: Path) -> Iterator[Path]:
    for seed in range(N_DRAWN):
        folder = tmp_path / str(seed)
        folder.mkdir()
        drawn = draw(seed)
        (folder / MISSION).write_bytes(dumps(drawn.mission, "UTF-8"))
        faults = dumps(drawn.faults, "UTF-8", hrefs={drawn.mission: MISSION})
        (folder / FAULTS).write_bytes(faults)
        yield folder


def _judged(folders: list[Path]) -> list[Judged]:
    """Return the folders that both load and that break nothing but constraints with twins."""
    comparable = [folder for folder in folders if _is_judged_by_evl(validate_folder(folder))]
    answers = zip(comparable, _evl(comparable), strict=True)
    return [Judged(folder, answer) for folder, answer in answers if _is_loaded(answer)]


def _require_same_findings(name: str, models: list[Judged], note: Note) -> set[str]:
    """Compare both; return the constraints that were found somewhere."""
    compared: set[str] = set()
    n_findings = 0
    for model in models:
        ours = _ours(model.folder)
        assert _theirs(model.answer) == ours, model.folder
        compared |= {constraint for constraint, _, _ in ours}
        n_findings += sum(ours.values())
    counts = {"models": len(models), "constraints_found": len(compared), "findings": n_findings}
    note(f"(c) {name}", **counts, differences=0)
    return compared


def _is_judged_by_evl(diagnostics: tuple[Diagnostic, ...]) -> bool:
    return all(CONSTRAINTS[found.constraint].evl for found in diagnostics)


def _ours(folder: Path) -> Mapping[Finding, int]:
    return _counted(
        (found.constraint, found.severity, found.message) for found in validate_folder(folder)
    )


def _theirs(answer: Mapping[str, Any]) -> Mapping[Finding, int]:
    return _counted(
        (found["constraint"], found["severity"], message)
        for found in answer["unsatisfied"]
        for message in found["message"].split("\n")
    )


def _counted(findings: Iterator[Finding]) -> Mapping[Finding, int]:
    counts: dict[Finding, int] = {}
    for constraint, severity, message in findings:
        key = (constraint, severity, _comparable(message))
        counts[key] = counts.get(key, 0) + 1
    return counts


def _comparable(message: str) -> str:
    """Return a message without line numbers, and with numbers spelt in one way."""
    message = re.sub(r" in line \d+| \(line \d+\)", "", message)
    return re.sub(r"'[-+.\dEe]*\d[-+.\dEe]*'", _spelt, message)


def _spelt(match: re.Match[str]) -> str:
    try:
        return repr(float(match[0][1:-1]))
    except ValueError:
        return match[0]


def _evl(folders: list[Path]) -> list[dict[str, Any]]:
    models = [[str(folder / MISSION), str(folder / FAULTS)] for folder in folders]
    answer = harness("evl", {"evl": [str(EVL)], "models": models})
    found: list[dict[str, Any]] = answer["models"]
    return found


def _is_loaded(answer: Mapping[str, Any]) -> bool:
    return not any(error.startswith("load: ") for error in answer["errors"])
