"""What the lint of regions says of the bodies that ``tests/conformance`` measures."""

import pytest

from mrsfi_runtime.engine.region_lint import COMPILES_ALIKE, lint_regions
from tests.support import lint_cases
from tests.support.edited import REGION
from tests.support.lint_cases import named, written
from tests.support.tree import ROOT


@pytest.mark.parametrize("case", **named([*lint_cases.DIFFERENT, lint_cases.SUMS]))
def test_what_differs_is_warned_of(tmp_path, case):
    line = written(tmp_path, case)

    found = lint_regions(tmp_path)

    assert [(one.line, one.place, one.constraint) for one in found[:1]] == [
        (line, f"region '{REGION}'", COMPILES_ALIKE)
    ]
    assert {one.line for one in found} <= {line, line + 1}


@pytest.mark.parametrize("case", **named(lint_cases.CALLS))
def test_every_name_that_differs_is_known(tmp_path, case):
    line = written(tmp_path, case)

    found = lint_regions(tmp_path)

    assert [(one.line, one.constraint) for one in found] == [(line, COMPILES_ALIKE)]


@pytest.mark.parametrize("case", **named(lint_cases.ALIKE))
def test_what_is_alike_is_not_warned_of(tmp_path, case):
    written(tmp_path, case)

    assert lint_regions(tmp_path) == ()


def test_generated_code_has_nothing_to_warn_of():
    missions = [path.parent for path in ROOT.glob("generated/*/collective_intelligence.py")]

    assert len(missions) >= 3
    assert [lint_regions(mission) for mission in missions] == [()] * len(missions)
