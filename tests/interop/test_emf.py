"""Eclipse EMF loads what we write without complaint, and saves the same bytes."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import pytest

from m2t.models.load import load_mission_folder, saved, write_specification
from m2t.models.write import dumps
from mrsfi_runtime.model.faults import TimedFault
from tests.interop.eclipse import (
    METAMODELS,
    ROOT,
    Note,
    Saved,
    require_harness,
    require_same,
    resave,
)
from tests.interop.spellings import respelt
from tests.support.cli import MISSION, SMALL, mrsfi, workspace
from tests.support.models.copies import copy_models, edit
from tests.support.models.random_models import coverage, draw, everything
from tests.support.triggers import in_xmi, with_triggers
from tests.support.world import paper_code

N_DRAWN = 150
"""Drawn missions, each with faults: 300 files."""

ENCODINGS = ("ASCII", "UTF-8", "ISO-8859-1")
MISSION_FILE = "mission.xmi"
FAULTS_FILE = "faults.xmi"


@dataclass(frozen=True, slots=True)
class DrawnFolder:
    """A mission folder with random models."""

    path: Path
    encoding: str
    seed: int

    @property
    def files(self) -> tuple[Path, Path]:
        return self.path / MISSION_FILE, self.path / FAULTS_FILE


@pytest.fixture(scope="module")
def counts() -> Counter[str]:
    """How often the drawn models use each class and give each feature."""
    return Counter()


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory, counts: Counter[str]) -> list[DrawnFolder]:
    """Random models, written by us."""
    require_harness()
    place = tmp_path_factory.mktemp("drawn")
    folders = []
    for seed in range(N_DRAWN):
        models = draw(seed)
        counts.update(coverage(models.mission) + coverage(models.faults))
        folder = DrawnFolder(place / str(seed), ENCODINGS[seed % len(ENCODINGS)], seed)
        _write(folder, models.mission, models.faults)
        folders.append(folder)
    return folders


@pytest.fixture(scope="module")
def emf(drawn: list[DrawnFolder], tmp_path_factory: pytest.TempPathFactory) -> list[Saved]:
    """What EMF makes of the drawn models in other spellings."""
    place = tmp_path_factory.mktemp("respelt")
    paths = []
    for folder in drawn:
        for file in folder.files:
            path = place / folder.path.name / file.name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(respelt(file.read_bytes(), folder.seed))
            paths.append(path)
    return resave(paths, tmp_path_factory.mktemp("emf"))


def _write(folder: DrawnFolder, mission: object, faults: object) -> None:
    folder.path.mkdir(parents=True)
    mission_file, faults_file = folder.files
    mission_file.write_bytes(dumps(mission, folder.encoding))
    faults_file.write_bytes(dumps(faults, folder.encoding, hrefs={mission: MISSION_FILE}))


def _require_equal(part: str, files: Sequence[Saved], note: Note) -> None:
    """Note the figures, then require that EMF found nothing and changed nothing."""
    equal = sum(file.is_equal for file in files)
    complaints = [f"{file.path}: {found}" for file in files for found in file.problems]
    note(
        part,
        files_checked=len(files),
        with_equal_bytes=equal,
        differences=len(files) - equal,
        complaints_of_EMF=len(complaints),
    )
    assert files
    assert complaints[:9] == []
    assert [file.difference for file in files if not file.is_equal] == []


def test_emf_validates_metamodels_and_models_and_saves_the_same_bytes(tmp_path, note):
    paths = [*map(Path, METAMODELS), *sorted((ROOT / "models").glob("*/*.xmi"))]

    files = resave(paths, tmp_path)

    _require_equal("(a) metamodels and models", files, note)


def test_emf_validates_specifications_of_scripts_and_saves_the_same_bytes(tmp_path, note):
    folder, pool = copy_models(tmp_path), paper_code().pool
    every = tuple(TimedFault(e.id, 3 * n, 900 + n, e.values) for n, e in enumerate(pool))
    f9 = TimedFault("f9", 0, 0, (1e-5, -1e9, *pool["f9"].values[2:]))
    odd = (f9, TimedFault("f14", 5, 9, (12.0,)))
    write_specification(folder, pool, every, folder / "every.xmi", identifier="every")
    write_specification(folder, pool, odd, tmp_path / "odd.xmi", identifier="odd")
    write_specification(folder, pool, (), folder / "none.xmi", identifier="none")
    triggers = with_triggers(paper_code()).pool.triggers
    edit(folder / FAULTS_FILE, "</faults:F", f"{in_xmi(triggers)}</faults:F")
    waits = zip(pool, cycle(trigger.id for trigger in triggers), strict=False)
    waiting = tuple(TimedFault(e.id, 3, 900, e.values, trigger) for e, trigger in waits)
    write_specification(folder, pool, waiting, folder / "waiting.xmi", identifier="waiting")

    names = ("every.xmi", "none.xmi", "waiting.xmi")
    files = resave([tmp_path / "odd.xmi", *(folder / name for name in names)], tmp_path / "out")

    _require_equal("(b) specifications of scripts", files, note)


def test_emf_validates_what_search_found_and_saves_the_same_bytes(tmp_path, note):
    require_harness()
    place = workspace(tmp_path)
    mrsfi("evolve", MISSION, "--case", "b", *SMALL, "--out", "runs/small", cwd=place)
    mrsfi("explain", "runs/small", cwd=place)

    files = resave(sorted((place / "runs" / "small").rglob("*.xmi")), tmp_path / "out")

    assert any(file.path.parent.name == "critical" for file in files)
    for kind in ("cause", "simplest"):
        assert any(file.path.stem.endswith(f"-{kind}") for file in files)
    _require_equal("(b) specifications of search", files, note)


def test_drawn_models_cover_every_class_and_every_feature(drawn, counts, note):
    names = sorted(everything())

    missing = [name for name in names if not counts[name]]

    assert drawn
    note(
        "(b) drawn models, coverage",
        classes_covered=sum("." not in name and bool(counts[name]) for name in names),
        features_covered=sum("." in name and bool(counts[name]) for name in names),
        uncovered=len(missing),
    )
    assert missing == []


def test_emf_validates_drawn_models_and_saves_the_same_bytes(drawn, tmp_path, note):
    files = resave([file for folder in drawn for file in folder.files], tmp_path)

    _require_equal("(b) drawn models, from us to EMF", files, note)


def test_what_emf_saves_we_load_and_write_with_the_same_bytes(drawn, emf, tmp_path, note):
    for file in emf:
        target = tmp_path / file.path.parent.name / file.path.name
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(file.content)

    ours = [content for folder in drawn for content in _saved(tmp_path / folder.path.name)]

    require_same("(b) drawn models, from EMF to us", emf, ours, note)


def test_other_spellings_are_saved_by_emf_and_us_with_the_same_bytes(emf, note):
    folders = dict.fromkeys(file.path.parent for file in emf)

    ours = [content for folder in folders for content in _saved(folder)]

    require_same("(b) drawn models in other spellings", emf, ours, note)


def _saved(folder: Path) -> tuple[bytes, bytes]:
    """Return what we save of the mission and the faults of a folder."""
    contents = saved(load_mission_folder(folder))
    return contents[folder / MISSION_FILE], contents[folder / FAULTS_FILE]
