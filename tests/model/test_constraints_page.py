from pathlib import Path

from docs.constraints import constraints_page
from m2t.diagnostics import CONSTRAINTS

PAGE = Path(__file__).parent.parent.parent / "docs" / "constraints.md"


def test_the_page_lists_all_constraints_as_they_are():
    page = PAGE.read_text(encoding="utf-8")
    names = [line.split("`")[1] for line in page.splitlines() if line.startswith("| `")]

    assert page == constraints_page(page)
    assert names == [*CONSTRAINTS]
    assert all(constraint.reason[1:] in page for constraint in CONSTRAINTS.values())


def test_every_constraint_is_stated_in_evl_or_has_a_reason_not_to_be():
    for name, constraint in CONSTRAINTS.items():
        assert bool(constraint.evl) != bool(constraint.reason), name
