"""Stateless randomness: a hash of (mission seed, tick, entity, purpose).

No generator state exists, so every order of evaluation draws the same values, and all fault
specifications of one campaign meet the same random events. The arithmetic stays below
64 bits after masking, which makes it identical in the interpreter and in compiled code.

References
----------
The mixing function is ``lowbias32`` of C. Wellons' Hash Prospector (public domain).
"""

from mrsfi_runtime.kernel.state import kernel

MASK = 0xFFFFFFFF
UNIT = 2.0**-32

PURPOSE_HEADING = 1
PURPOSE_SAMPLES = 2
PURPOSE_ROAM = 3
PURPOSE_NOISE = 13  # and 14
"""The purposes of random faults are defined in ``kernel.effects``: 4 to 12."""


@kernel
def mixed(value: int) -> int:
    """Return a 32-bit integer in which every bit depends on every bit of another."""
    value ^= value >> 16
    value = (value * 0x7FEB352D) & MASK
    value ^= value >> 15
    value = (value * 0x846CA68B) & MASK
    return value ^ (value >> 16)


@kernel
def draw(seed: int, tick: int, entity: int, purpose: int) -> int:
    """Return a uniform integer in ``0 … 2**32 - 1``; the same key always draws the same.

    Parameters
    ----------
    seed
        Mission seed as ``seed_key`` returns it.
    tick
        Tick, >= 0.
    entity
        Index of the robot, sensor or obstacle, below 2**24.
    purpose
        One of the ``PURPOSE_…`` numbers, below 256.
    """
    return mixed(mixed(seed ^ tick) ^ ((entity << 8) | purpose))


@kernel
def uniform(seed: int, tick: int, entity: int, purpose: int) -> float:
    """Return a uniform float in [0, 1)."""
    return draw(seed, tick, entity, purpose) * UNIT


@kernel
def choice(n: int, seed: int, tick: int, entity: int, purpose: int) -> int:
    """Return a uniform integer in ``0 … n - 1``, for n below 2**62.

    Notes
    -----
    It is ``draw * n >> 32``, in two parts so that no product leaves 64 bits.
    """
    drawn = draw(seed, tick, entity, purpose)
    return (drawn * (n >> 31) + ((drawn * (n & 0x7FFFFFFF)) >> 31)) >> 1


def seed_key(seed: int) -> int:
    """Return the 32-bit key of a mission seed; any non-negative integer is accepted."""
    key = 0
    while True:
        key = mixed((key ^ seed) & MASK) ^ 0x9E3779B9
        seed >>= 32
        if not seed:
            return key
