"""Committed generated code: what the visitors and templates make of the committed models."""

import pytest

from m2t.generate import diff
from tests.support.tree import ROOT


@pytest.mark.parametrize("mission", sorted(path.name for path in (ROOT / "models").iterdir()))
def test_the_models_of_the_repository_generate_what_is_committed(mission):
    assert diff(ROOT / "models" / mission, ROOT / "generated" / mission) == ""
