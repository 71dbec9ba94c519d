"""Laws of causes, by brute force: every subset of a drawn specification is flown."""

from contextlib import ExitStack
from functools import cache
from itertools import chain, combinations
from math import comb

import pytest

from mrsfi_runtime.causes.cause_set import Flights
from mrsfi_runtime.causes.explanation import explain
from mrsfi_runtime.engine.opening import open_engine
from mrsfi_runtime.record.engine_settings import EngineSettings
from mrsfi_runtime.record.settings import CampaignSettings
from mrsfi_runtime.record.store import Measure
from tests.support.world import code_of, specification
from tests.tiers import seeds, slow

DRAWN = seeds(
    [(mission, seed) for seed in range(10) for mission in ("tight_energy", "tight_margins")], 3, 4
)
KEEP = 0.95


@pytest.fixture(scope="module", params=[1, 2], ids=["1 worker", "2 workers"])
def engines(request):
    """Return an engine of a mission, the same each time."""
    with ExitStack() as stack:
        yield cache(
            lambda mission: stack.enter_context(
                open_engine(EngineSettings("compiled"), code_of(mission), 1, request.param)
            )
        )


def flights(engine):
    measure = Measure.of(CampaignSettings(), engine.code.mission)
    return Flights(engine.evaluate_many, measure, (1,))


def subsets(n):
    return chain.from_iterable(combinations(range(n), size) for size in range(n + 1))


def counted(engine, drawn):
    """Return the counts under every subset, flown one by one."""
    flown = flights(engine)
    return {
        places: flown.counts(tuple(drawn[place] for place in places))
        for places in subsets(len(drawn))
    }


def is_kept(counts, whole, columns):
    return all(20 * counts[k] >= 19 * whole[k] for k in columns)


@slow
@pytest.mark.parametrize("case", DRAWN, ids=str)
def test_causes_are_what_every_subset_flown_says(case, engines):
    mission, seed = case
    engine = engines(mission)
    drawn = specification(engine.code, seed, 7)
    of = counted(engine, drawn)
    everyone = tuple(range(len(drawn)))
    whole = of[everyone]

    found = explain(flights(engine), engine, drawn, KEEP)

    if found is None:
        assert not any(whole)
        return
    columns = range(len(whole))
    cause = found.cause
    assert (cause.counts, cause.fault_free, cause.kept) == (whole, of[()], of[cause.places])
    _require_minimal(of, cause.places, whole, columns)
    for goal in found.goals:
        own = [k for k, column in enumerate(found.cause.columns) if column.goal == goal.goal]
        _require_minimal(of, goal.places, whole, own)
        for place in everyone:
            assert goal.labels[place] == _label(of, goal.places, place, own)
    _require_shares(of, found)
    assert found.alone == tuple(of[place,] for place in everyone)
    lacking = (tuple(k for k in everyone if k != place) for place in everyone)
    assert found.left_out == tuple(map(of.__getitem__, lacking))


def _require_minimal(of, places, whole, columns):
    assert is_kept(of[places], whole, columns)
    for place in places:
        assert not is_kept(of[tuple(k for k in places if k != place)], whole, columns)


def _label(of, places, place, columns):
    everyone = max(of, key=len)
    whole = of[everyone]
    if place in places:
        return "sole" if is_kept(of[place,], whole, columns) else "joint"
    for member in places:
        swapped = tuple(sorted({*places, place} - {member}))
        if is_kept(of[swapped], whole, columns):
            return "redundant"
    without = of[tuple(k for k in everyone if k != place)]
    if any(20 * without[k] > 21 * whole[k] for k in columns):
        return "masking"
    return "lesser" if any(of[place,][k] > of[()][k] for k in columns) else "bystander"


def _require_shares(of, found):
    """Hold shares to the sum over subsets that defines them."""
    cause, n = found.cause.places, len(found.cause.places)
    for row, place in enumerate(cause):
        others = [k for k in cause if k != place]
        for column, share in enumerate(found.attribution.shares[row]):
            expected = sum(
                (of[tuple(sorted((*some, place)))][column] - of[some][column]) / comb(n - 1, size)
                for size in range(n)
                for some in combinations(others, size)
            )
            assert float(share) == pytest.approx(expected / n, abs=1e-9)
    for column, total in enumerate(map(sum, zip(*found.attribution.shares, strict=True))):
        assert total == found.cause.kept[column] - found.cause.fault_free[column]
