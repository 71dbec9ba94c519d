"""The counter hash draws the same for the same key, and evenly over keys."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from mrsfi_runtime.kernel.randomness import choice, draw, seed_key, uniform


@given(
    seed=st.integers(0, 2**64),
    tick=st.integers(0, 10_000_000),
    entity=st.integers(0, 2**16),
    purpose=st.integers(0, 255),
)
def test_a_draw_is_a_32_bit_integer_and_repeats(seed, tick, entity, purpose):
    key = seed_key(seed)

    value = draw(key, tick, entity, purpose)

    assert 0 <= value < 2**32
    assert draw(key, tick, entity, purpose) == value
    assert 0.0 <= uniform(key, tick, entity, purpose) < 1.0


def test_neighbouring_keys_draw_evenly():
    """Chi-square with 15 degrees of freedom stays below its 0.9999 quantile, for each key part."""
    series = {
        "seed": [choice(16, seed_key(n), 5, 3, 2) for n in range(16_000)],
        "tick": [choice(16, seed_key(1), n, 3, 2) for n in range(16_000)],
        "entity": [choice(16, seed_key(1), 5, n, 2) for n in range(16_000)],
        "both": [choice(16, seed_key(1), n % 40, n // 40, 2) for n in range(16_000)],
    }

    for part, values in series.items():
        counts = Counter(values)
        chi_square = sum((counts[value] - 1000) ** 2 / 1000 for value in range(16))
        assert chi_square < 44.26, part


def test_different_parts_of_a_key_draw_differently():
    draws = {
        draw(seed_key(seed), tick, entity, purpose)
        for seed in range(10)
        for tick in range(10)
        for entity in range(10)
        for purpose in range(10)
    }

    assert len(draws) > 9_990


def test_seeds_beyond_32_bits_differ_from_their_low_half():
    assert len({seed_key(7), seed_key(7 + 2**32), seed_key(7 + 2**64)}) == 3
