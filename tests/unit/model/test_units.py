"""Quantities are told in the units that a model names, and else as ever."""

import pytest

from mrsfi_runtime.model.fault_types import Range, Units

NAMED = Units("m", "s", "J")


@pytest.mark.parametrize(
    ("measured", "unnamed", "named"),
    [
        (Range.TICKS, "12 ticks", "12 s"),
        (Range.PERCENT, "12 percent", "12 percent"),
        (Range.SHARE, "12", "12"),
        (Range.SPEED, "12 units per tick", "12 m per s"),
        (Range.ENERGY, "12 energy units", "12 J"),
        (Range.COUNT, "12 samples", "12 samples"),
        (Range.RATE, "12 samples per tick", "12 samples per s"),
        (Range.COST, "12 energy per sample", "12 J per sample"),
        (Range.X, "12", "12 m"),
        (Range.Z, "12", "12 m"),
    ],
)
def test_a_quantity_is_told_with_its_unit(measured, unnamed, named):
    assert Units().told(12.0, measured) == unnamed
    assert NAMED.told(12.0, measured) == named


def test_how_long_ticks_last_is_told_in_the_unit_of_time():
    assert [Units().ticks(n) for n in (1, 2)] == ["1 tick", "2 ticks"]
    assert [NAMED.ticks(n) for n in (1, 2)] == ["1 s", "2 s"]
