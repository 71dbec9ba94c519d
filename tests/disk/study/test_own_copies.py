"""A comparison flies its own copies of what its code imports, and takes no others for them."""

import sys

import pytest

from mrsfi_runtime.errors import RecordError
from mrsfi_runtime.study.runs import only_comparison
from tests.support.edited import edited
from tests.support.tree import ROOT

MISSION = "tight_margins"


def test_a_module_that_was_edited_since_is_refused_and_named(tmp_path, monkeypatch):
    generated = edited(tmp_path, "imports", "import team_of_a_comparison\n", MISSION)
    team = tmp_path / "team_of_a_comparison.py"
    team.write_text("A = 1\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    folders = (tmp_path / "runs", ROOT / "models" / MISSION, generated)

    for _ in range(2):
        with only_comparison(*folders) as made:
            assert (made.generated / "imported" / team.name).read_text() == "A = 1\n"
    team.write_text("A = 2\n", encoding="utf-8")

    with (
        pytest.raises(RecordError, match=r"imported/team_of_a_comparison.py: the comparison's own"),
        only_comparison(*folders),
    ):
        pass
    assert team.stem not in sys.modules
