"""The campaign files of the case studies hold the settings of the paper.

References
----------
Source paper, section V-B.
"""

import tomllib

import pytest

from tests.support.models.copies import MODELS


@pytest.mark.parametrize(
    ("case", "fitness"),
    [("a", {"fitness": "weighted"}), ("b", {"fitness": "focused", "goals": ["g1", "g3"]})],
)
def test_case_studies_have_the_settings_of_the_paper(case, fitness):
    settings = tomllib.loads((MODELS / f"case_{case}.toml").read_text(encoding="utf-8"))

    assert settings == {
        "search": {
            "algorithm": "paper",
            "population": 20,
            "generations": 50,
            "faults": 20,
            "crossover": 0.7,
            "mutation": 0.7,
            "selection": "roulette",
            "seed": 1,
            "mission_seed": 1,
            **fitness,
        }
    }
