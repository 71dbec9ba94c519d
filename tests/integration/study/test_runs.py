"""Runs of a comparison: their own copies of what their code imports, and how long they take."""

import pytest

import mrsfi
from mrsfi import engines
from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.record.store import CampaignStore
from tests.support.edited import edited
from tests.support.tree import ROOT

MISSION = "tight_margins"
SEARCH = """
from mrsfi_runtime.search.algorithms import ALGORITHMS

begin = ALGORITHMS["random"]
"""


def test_a_module_that_was_edited_since_is_refused_and_named(tmp_path, monkeypatch):
    generated = edited(tmp_path, "imports", "import team_of_a_comparison\n", MISSION)
    files = {"team_of_a_comparison": "A = 1\n", "search_of_a_comparison": SEARCH}
    for module, text in files.items():
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    mission = mrsfi.load(ROOT / "models" / MISSION, generated)
    algorithm = "search_of_a_comparison:begin"
    settings = {"out": tmp_path / "compared", "engine": "reference", "workers": 1}

    for _ in range(2):
        found = mission.compare([algorithm], 1, 2, **settings)
        copies = found.folder / "runs" / f"{algorithm}-1" / "generated" / "imported"
        for module, text in files.items():
            assert (copies / f"{module}.py").read_text(encoding="utf-8") == text

    for module, text in files.items():
        (tmp_path / f"{module}.py").write_text(f"{text}B = 2\n", encoding="utf-8")
        with pytest.raises(RecordError, match=rf"found a run with other imported/{module}.py: "):
            mission.compare([algorithm], 1, 2, **settings)
        (tmp_path / f"{module}.py").write_text(text, encoding="utf-8")


def test_a_run_notes_how_long_it_has_taken(tmp_path, monkeypatch):
    monkeypatch.setattr(engines, "_EVERY", 0.0)
    mission = mrsfi.load(ROOT / "models" / MISSION, ROOT / "generated" / MISSION)

    found = mission.compare(
        ["random"], 1, 40, out=tmp_path / "compared", engine="reference", workers=1
    )

    with CampaignStore.open(found.folder / "runs" / "random-1") as store:
        noted = store.kept("seconds", float)
    assert noted is not None
    assert 0.0 < noted < found.runs[0].seconds
