"""The recipes of the README's "Extend": as few files as it says, and alike on both engines."""

import pytest

from tests.recipes.performed import RECIPES, perform
from tests.recipes.tree import ENGINES
from tests.tiers import seeds

N_EDITED = {
    "fault type": 1,
    "own effect": 2,
    "goal task": 2,
    "fitness function": 1,
    "algorithm": 1,
    "transport": 2,
}


@pytest.mark.parametrize("name", seeds(RECIPES, 0, 2))
def test_a_recipe_edits_few_files_and_flies_alike_on_both_engines(name, tmp_path):
    done = perform(name, tmp_path / "tree")

    assert len(done.edited) == N_EDITED[name], done.edited
    for what, digests in done.digests.items():
        assert {*ENGINES} <= {*digests}, what
        assert len({*digests.values()}) == 1, (what, digests)
