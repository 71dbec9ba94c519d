"""An interrupt, wherever it hits a record that writes, loses nothing and writes nothing twice."""

import contextlib
import sys
from collections.abc import Iterator, Sequence
from itertools import count
from types import FrameType
from typing import Any

import pytest

from mrsfi_runtime.model.faults import Specification
from mrsfi_runtime.model.mission import Evaluated, FailedFlight
from mrsfi_runtime.record import database
from mrsfi_runtime.record import store as record_store
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import CampaignStore
from mrsfi_runtime.search import run as search_run
from mrsfi_runtime.search.run import run_campaign
from tests.support.campaigns import store_of
from tests.support.search import paper_mission, pool_of, stand_in_outcome
from tests.tiers import slow

FILES = {str(each.__file__) for each in (search_run, record_store, database, contextlib)}
SETTINGS = CampaignSettings(algorithm="random", population=2, generations=1, faults=2)
CLOCK = (0, 1, 2, 3, 50, 51, *range(52, 99))
"""Lets the first result be written, then three together, and leaves the others for the end."""


class Interruption:
    """Raises KeyboardInterrupt at one step of the record, counted from 0, where Python may."""

    def __init__(self, step: int) -> None:
        self.left = step

    def __call__(self, frame: FrameType, event: str, _: Any) -> Any:
        if frame.f_code.co_filename not in FILES:
            return None
        self.left -= event in ("call", "return") or frame.f_code.co_name == "write"
        if self.left < 0:
            sys.settrace(None)
            raise KeyboardInterrupt
        return self


def run(store: CampaignStore, interruption: Interruption | None = None) -> int:
    """Search until the end or an interrupt, and return how many were evaluated."""
    numbers = count()

    def evaluate(specifications: Sequence[Specification]) -> Iterator[Evaluated]:
        outcomes = map(stand_in_outcome, specifications)
        for specification, found in zip(specifications, outcomes, strict=True):
            next(numbers)
            yield FailedFlight("text: said") if specification[0].start % 3 == 0 else found

    mission, pool, clock = paper_mission(), pool_of(), map(float, CLOCK)
    sys.settrace(interruption)
    try:
        run_campaign(SETTINGS, mission, pool, evaluate, store, clock=clock.__next__)
    except KeyboardInterrupt:
        assert interruption is not None
    sys.settrace(None)
    return next(numbers)


@pytest.mark.parametrize("stride", [19, pytest.param(3, marks=slow)])
def test_what_was_evaluated_before_an_interrupt_is_stored_once_and_resumed(stride):
    with store_of([]) as whole:
        n_whole = run(whole)
        assert 0 < whole.n_failures < n_whole
        for step in count(0, stride):
            interruption = Interruption(step)
            with store_of([]) as store:
                n_evaluated = run(store, interruption)

                n_stored = store.n_evaluations + store.n_failures
                assert n_evaluated - 1 <= n_stored <= n_evaluated, step  # but the one at hand
                n_more = run(store)
                assert n_stored + n_more == n_whole, step
                assert store.digest() == whole.digest(), step
                assert [*store.generations()] == [*whole.generations()], step
                assert store.failures() == whole.failures(), step
            if interruption.left >= 0:
                break
    assert step > 100
