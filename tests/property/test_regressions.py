"""Limits of kept findings are read as they were written."""

import tomllib
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.record.settings import VIOLATIONS, Regression
from tests.tiers import law

TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=40)
COUNTS = st.integers(0, 2**63 - 1)


@law(100)
@given(
    TEXTS,
    st.sampled_from(VIOLATIONS),
    st.lists(COUNTS, min_size=1).map(tuple),
    st.dictionaries(TEXTS, COUNTS, min_size=1),
)
def test_any_text_and_any_name_of_a_goal_are_read_as_written(found, violations, seeds, limits):
    written = Regression(Path("it.toml"), found, violations, seeds, limits).text()

    assert tomllib.loads(written) == {
        "found": found,
        "violations": violations,
        "mission_seeds": list(seeds),
        "goals": len(limits),
        "max": limits,
    }
