"""Committed digests of fixed seeds, and committed generated code."""

import json

import pytest

from m2t.generate import diff
from mrsfi_runtime.engine.flights import ReferenceEngine
from mrsfi_runtime.generated_code import load_code
from mrsfi_runtime.kernel.state import state_bytes
from tests.golden import frozen
from tests.golden.flights import FLIGHTS, MISSIONS, flights
from tests.support.tree import ROOT


def test_missions_fly_as_they_were_recorded():
    assert flights() == json.loads(FLIGHTS.read_text(encoding="utf-8"))


@pytest.mark.parametrize("mission", MISSIONS)
def test_states_are_still_written_as_at_first(mission):
    def compare(world, belief, *_):
        for state in (world, belief):
            assert state_bytes(state) == frozen.state_bytes(state)

    code = load_code(ROOT / "generated" / mission)
    ReferenceEngine(code, 1).evaluate((), observer=compare)


@pytest.mark.parametrize("mission", sorted(path.name for path in (ROOT / "models").iterdir()))
def test_the_models_of_the_repository_generate_what_is_committed(mission):
    assert diff(ROOT / "models" / mission, ROOT / "generated" / mission) == ""
