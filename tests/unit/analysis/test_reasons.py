"""Of all that a flight can show beside its twin, exactly one reason is true."""

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.analysis.reasons import REASONS, Differences, _at_least
from tests.tiers import law

NUMBERS = st.integers(0, 3)


@given(*[NUMBERS] * 6)
@law(300)
def test_exactly_one_reason_is_true_of_a_flight(n_targets, applied, true, believed, sent, verdicts):
    differs = true or believed or sent
    found = Differences(
        n_targets, applied, true, believed, sent, verdicts if differs else 0, {}, frozenset()
    )

    assert sum(reason.holds(found) for reason in REASONS.values()) == 1


@given(st.floats(1e-9, 1e9))
@law(300)
def test_what_is_left_is_never_said_to_be_more_and_hardly_less(left):
    said = Fraction(_at_least(left).replace(",", ""))

    assert said <= Fraction(left)
    assert said >= Fraction(left) * Fraction(99, 100)
